use super::long::over_budget;
use super::scenes::{Case, Enough, Setting, cases, long as long_cases};
use super::{EXPLICIT, FILM, LADDER, LARGE_LADDER, first_forms, rungs};
use crate::methods::runs::{Film, Substeps, Variant};
use crate::studies::animation::facts::{Facts, Origin, Run, Scene};
use crate::studies::clocked::REPETITIONS;
use crate::studies::filmed::Stage as _;
use crate::studies::{Context, Progress};
use crate::{HarnessError, Journal, Source, Unfinished};
use drape_report::Verdict;
use std::path::Path;
use std::time::Instant;

fn film(method: &'static str, substeps: Substeps) -> Film {
    Film { form: Variant::new("a", method), substeps }
}

#[test]
fn every_cloth_begins_without_stress() {
    for case in cases().into_iter().filter(Case::is_quick) {
        let setting = Setting::new(&case).expect("a valid scene");
        assert!(
            setting.scene.prestress < 1e-12,
            "{}: {}",
            setting.scene.id,
            setting.scene.prestress
        );
    }
}

/// The small sheet distinguishes runs that stand still, that explode and that follow the motion.
#[test]
fn a_method_that_follows_is_told_from_one_that_locks_and_one_that_explodes() {
    let case = cases().into_iter().find(Case::is_quick).expect("a quick case");
    let setting = Setting::new(&case).expect("a valid scene");
    let scene = &setting.scene;
    assert!(scene.shape_floor_m > 0.0 && scene.shape_floor_m < 1e-3, "{scene:?}");
    assert!(scene.reference_error_m < 1e-3, "{scene:?}");
    let runs = |method, substeps| setting.runs(&film(method, substeps)).expect("runs");
    let locked = &runs("imex-euler", Substeps::Ladder)[0];
    assert_eq!((locked.verdict, locked.substeps), (Verdict::Locked, 1), "{locked:?}");
    let euler = runs("symplectic-euler", Substeps::Limit);
    let [fails, holds, after] = &euler[..] else { panic!("{euler:?}") };
    assert!(!fails.is_sound() && holds.is_sound() && after.is_sound(), "{euler:?}");
    assert!(holds.is_good(scene) && after.shape_error_m < holds.shape_error_m, "{euler:?}");
    assert!(holds.substeps <= 2 * scene.limit_substeps, "{euler:?}");
    let mut brief = case;
    brief.ends_when_enough = true;
    let brief = Setting::new(&brief).expect("a valid scene");
    let once = brief.runs(&film("symplectic-euler", Substeps::Limit)).expect("runs");
    assert_eq!(once.last().map(|run| run.substeps), Some(holds.substeps), "{once:?}");
    let implicit = runs("bdf2", Substeps::Ladder);
    let finest = implicit.last().expect("a run");
    assert!(finest.is_good(scene), "{finest:?}");
    let timing = setting.time(holds).expect("times");
    assert!(timing.frame_s > 0.0 && timing.samples_s.len() <= REPETITIONS);
}

/// Rings do work on a curtain. What a run gains beside it is its own.
#[test]
fn a_led_run_that_gains_energy_beside_the_work_of_its_rings_is_not_sound() {
    let setting = Setting::new(&Case::led_quick()).expect("a valid scene");
    let scene = &setting.scene;
    let runs = |method, substeps| setting.runs(&film(method, substeps)).expect("runs");
    let truth = runs("leapfrog:damping=explicit", Substeps::Limit);
    let finest = truth.last().expect("a run");
    assert!(finest.is_good(scene) && finest.gain < 0.01, "{finest:?}");
    let [coarse, middle, fine, ..] = &runs("xpbd:substeps=10", Substeps::Ladder)[..] else {
        panic!("three runs and more")
    };
    // Their kinetic energy, less than the true one, hides the gain.
    for run in [coarse, middle] {
        assert_eq!(run.verdict, Verdict::Marginal, "{run:?}");
        assert!(run.gain > 0.02 && run.kinetic.is_some_and(|kept| kept < 1.0), "{run:?}");
    }
    assert!(fine.is_sound() && fine.gain < 0.02, "{fine:?}");
}

/// If a ring moved evenly over a whole frame, each frame would start with a kick.
#[test]
fn rings_move_without_kicks() {
    let case = Case::led_quick();
    let (system, _) = case.spec().expect("a scene").build().expect("a system");
    let ring = &system.moving_pins()[0];
    let frame = 1.0 / f64::from(FILM);
    let speed = |t: f64| (ring.position(t + 1e-5) - ring.position(t - 1e-5)).norm() / 2e-5;
    let fastest = (1..100).map(|k| speed(1e-2 * f64::from(k))).fold(0.0, f64::max);
    for frames in 1..20 {
        let at = f64::from(frames) * frame;
        let kick = (speed(at + 1e-4) - speed(at - 1e-4)).abs();
        assert!(kick < 0.05 * fastest, "{kick} m/s of {fastest}");
    }
}

/// The largest cloth has the budget of the next smaller one, in which explicit methods still reach
/// twice their limit.
#[test]
fn the_budget_of_a_frame_grows_up_to_a_mesh_and_has_room_for_explicit_methods() {
    let sweeps: Vec<_> = long_cases().iter().map(Case::sweeps_a_frame).collect();
    assert_eq!(sweeps, [500.0, 1250.0, 500.0, 500.0, 1250.0, 2500.0, 2500.0, 2500.0]);
    // A frame of a film is longer, and a coarse mesh needs fewer sweeps.
    assert_eq!(Case::led_quick().sweeps_a_frame(), 500.0 * (60.0 / 24.0) * (10.0 / 20.0));
    for case in long_cases() {
        let setting = Setting::staged(&case).expect("a valid scene");
        let limit = f64::from(setting.scene.limit_substeps);
        assert!(2.0 * limit <= case.sweeps_a_frame(), "{}: {limit}", case.id());
        assert_eq!(case.ends_when_enough, setting.scene.particles > 10_000, "{}", case.id());
    }
}

/// A method whose calls have parts is tuned like an explicit one: it tries several numbers of
/// parts, in every scene.
#[test]
fn the_parts_of_a_call_are_tried_in_several_numbers_in_every_scene() {
    for case in cases().into_iter().chain(long_cases()) {
        let setting = Setting::staged(&case).expect("a valid scene");
        let films = setting.films();
        let lines = films.iter().find(|film| film.form.label == "xpbd-lines").expect("its form");
        let is_large = setting.scene.particles >= 2500;
        assert_eq!(
            case.ladder,
            if is_large { &LARGE_LADDER[..] } else { &LADDER },
            "{}",
            case.id()
        );
        let once = rungs(lines, case.ladder).into_iter().filter(|(calls, _)| *calls == 1);
        let numbers: Vec<_> = once.filter_map(|(_, inside)| Some(inside?.1)).collect();
        assert_eq!(numbers, [4, 6, 8, 10, 15, 20], "{}", case.id());
        for film in films {
            let rungs = rungs(&film, case.ladder);
            assert!(rungs.len() <= EXPLICIT.len(), "{}: {rungs:?}", film.form.label);
        }
    }
    let case = cases().into_iter().find(Case::is_quick).expect("a quick case");
    let setting = Setting::new(&case).expect("a valid scene");
    let film = Film::ladder("xpbd-lines", "xpbd-lines");
    let runs = setting.runs(&film).expect("runs");
    let coarsest = &runs[0];
    assert_eq!(coarsest.calls(&setting.scene), "1 call of 4 substeps", "{coarsest:?}");
}

/// The same scene that another machine computed is the same fact.
#[test]
fn where_a_scene_was_computed_is_no_fact() {
    let case = cases().into_iter().find(Case::is_quick).expect("a quick case");
    let scene = Setting::staged(&case).expect("a valid scene").scene;
    let origin = Origin { commit: "0123".to_owned(), cpu: "a processor".to_owned() };
    let apart = Scene { computed: Some(origin), ..scene.clone() };
    let of = |scene: &Scene| {
        let facts = Facts { scenes: vec![scene.clone()], runs: Vec::new(), missing: Vec::new() };
        super::comparable(&facts)[0].values.clone()
    };
    assert_eq!(of(&scene), of(&apart));
    assert_ne!(of(&scene), of(&Scene { particles: 1, ..scene.clone() }));
}

/// The largest cloth over 5 s has no time for forms that exceed the budget over 0.4 s. All other
/// forms run there, also those that gain energy over 0.4 s.
#[test]
fn the_dearest_scene_leaves_out_what_exceeds_the_budget_over_a_shorter_span() {
    let cases = long_cases();
    let setting = Setting::new(&Case::dearest_quick()).expect("a valid scene");
    let any = setting.runs(&film("imex-euler", Substeps::Ladder)).expect("runs").remove(0);
    let [.., short, dearest] = &cases[..] else { panic!("{cases:?}") };
    assert!(dearest.leaves_out(short) && !short.leaves_out(dearest), "{cases:?}");
    let runs = |scene: &Case| {
        let run = |label: &str, verdict| Run {
            scene: scene.id(),
            label: label.to_owned(),
            verdict,
            ..any.clone()
        };
        vec![
            run("dear", Verdict::Diverged),
            run("dear", Verdict::OverBudget),
            run("dear from two calls", Verdict::Stable),
            run("dear from two calls", Verdict::OverBudget),
            run("wild", Verdict::Diverged),
            run("dear twice", Verdict::OverBudget),
            run("dear twice", Verdict::OverBudget),
        ]
    };
    assert_eq!(over_budget(dearest, &cases, &runs(short)), ["dear", "dear twice"]);
    for other in cases.iter().filter(|other| *other != short) {
        assert!(over_budget(dearest, &cases, &runs(other)).is_empty(), "{}", other.id());
    }
    for other in cases.iter().filter(|other| *other != dearest) {
        assert!(over_budget(other, &cases, &runs(short)).is_empty(), "{}", other.id());
    }
}

struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &str, _: usize) {}
    fn done(&self) {}
    fn end(&self) {}
}

/// Energies and films of a large scene take minutes each, so both look at the clock.
#[test]
fn the_energy_and_the_films_of_a_true_motion_end_with_the_time() {
    let case = cases().into_iter().find(Case::is_quick).expect("a quick case");
    let mut setting = Setting::staged(&case).expect("a valid scene");
    setting.deadline = Some(Instant::now());
    let none = Journal::none();
    assert!(matches!(setting.find_true_motion(&none), Err(HarnessError::Late)));
    assert!(matches!(setting.released(), Err(HarnessError::Late)));
    setting.deadline = None;
    setting.find_true_motion(&none).expect("a true motion");
    assert_eq!(setting.released().expect("energies"), setting.scene.released_j);
}

/// In the dearest scene no method runs on after a good run; in others it runs on until it is finer.
#[test]
fn in_the_dearest_scene_the_first_good_run_of_a_method_is_its_last() {
    let case = Case::dearest_quick();
    let mut fuller = case;
    fuller.enough = Enough::Fine;
    let number_of_good = |case: &Case, film: &Film| {
        let setting = Setting::new(case).expect("a valid scene");
        let runs = setting.runs(film).expect("runs");
        let good = runs.iter().filter(|run| run.is_good(&setting.scene)).count();
        assert!(runs.last().is_some_and(|run| run.is_good(&setting.scene)), "{runs:?}");
        good
    };
    for film in [film("symplectic-euler", Substeps::Limit), film("bdf2", Substeps::Ladder)] {
        assert_eq!(number_of_good(&case, &film), 1, "{film:?}");
    }
    assert!(number_of_good(&fuller, &film("bdf2", Substeps::Ladder)) > 1);
}

/// Films of the largest cloth take half an hour each. A later run takes those that are whole from
/// the journal.
#[test]
fn a_later_run_does_not_shoot_the_films_of_a_true_motion_again() {
    let case = Case::dearest_quick();
    let folder = tempfile::tempdir().expect("a folder");
    let find = |deadline| {
        let unfinished = Unfinished::enter(folder.path(), false).expect("a folder");
        let journal = unfinished.journal("animation-long", false).expect("a journal");
        let mut setting = Setting::staged(&case).expect("a valid scene");
        setting.deadline = deadline;
        setting.find_true_motion(&journal).map(|()| setting.scene)
    };
    assert!(matches!(find(Some(Instant::now())), Err(HarnessError::Late)));
    let first = find(None).expect("a true motion");
    assert_eq!(find(Some(Instant::now())).expect("the kept films"), first);
    // The looks of the true motion show nearly all of the energy that is set free.
    let mut fuller = case;
    fuller.is_truth_coarse = false;
    let setting = Setting::new(&fuller).expect("a true motion");
    let share = first.released_j / setting.scene.released_j;
    assert!((0.9..=1.0).contains(&share), "{share}");
    assert_eq!(2 * first.reference_substeps, setting.scene.reference_substeps);
}

/// Without time the study names all forms of all scenes and runs nothing: the energies of the
/// largest scene alone take minutes.
#[test]
fn a_long_study_without_time_names_what_is_missing() {
    let journal = Journal::none().until(Some(Instant::now()));
    let (out, source) = (Path::new(""), &Source { commit: None, dirty: None });
    let progress = &Silent;
    let context = Context {
        out,
        quick: false,
        long: true,
        progress,
        journal: &journal,
        allocated: None,
        source,
    };
    let facts = super::long(&context).expect("a record").facts;
    let named: Vec<_> = facts.missing.iter().map(|missing| missing.scene.clone()).collect();
    assert_eq!(named, long_cases().iter().map(Case::id).collect::<Vec<_>>());
    assert!(facts.missing.iter().all(|missing| missing.not_run.len() == first_forms().len()));
    assert!(facts.scenes.is_empty() && facts.runs.is_empty());
    assert_eq!(journal.missing().len(), 2 * named.len());
}
