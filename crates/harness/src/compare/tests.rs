use super::deadline::Deadline;
use super::facts::{End, Facts, Form, Metric, Run, Scene, Truth};
use super::forms::Entry;
use super::memory::Memory;
use super::race::{Limits, Track as _};
use super::stage::Stage;
use super::truth::Found;
use super::{Checked, Clock, Course, Options, advise, compare, held, journal_name, lines, resume};
use crate::judgement::Judge;
use crate::methods::Choice;
use crate::record::Judged;
use crate::{Journal, OrderedSimulation, Unfinished};
use drape_model::TimeSpan;
use drape_report::Verdict;
use std::time::{Duration, Instant};

fn run(form: usize, substeps: u32, verdict: Verdict, error_m: f64, frame_s: f64) -> Run {
    Run {
        form,
        substeps,
        verdict,
        error_m: Some(error_m).filter(|error| error.is_finite()),
        retained: Some(1.0),
        gain: Some(0.0),
        force_evaluations: 0,
        matvecs: 0,
        factorisations: 0,
        cg_iterations: 0,
        unconverged_steps: 0,
        frame_s,
        repetitions: 1,
        holds_when_pushed: None,
        pushed_m: None,
        foreseen: None,
    }
}

fn form(label: &str, method: &str, end: End, refusal: Option<&str>) -> Form {
    let method = Choice::parse(method, &[]).expect("a method").full_id();
    Form { label: label.to_owned(), method, end, refusal: refusal.map(str::to_owned) }
}

/// Nine forms: a winner, a tie, a slower form, and six others. One explodes, one locks, and one is
/// refused. One is cheaper for an easier target, one never meets the target, and one is predicted
/// to be too slow for a run.
fn synthetic() -> Facts {
    use Verdict::{Diverged, Locked, Stable};
    Facts {
        scene: Scene {
            name: "my shirt.json".to_owned(),
            particles: 100,
            springs: 300,
            frames: 30,
            frame_s: 0.02,
            size_m: 1.0,
            metric: Metric::Shape,
            target_m: 0.01,
            budget_s: 60.0,
            limit_substeps: 20,
            is_driven: false,
        },
        truth: Truth {
            method: Some("leapfrog:damping=explicit".to_owned()),
            substeps: 80,
            error_m: Some(1e-4),
            members: 3,
            floor_m: Some(1e-3),
            pushed_floor_m: None,
            path_m: Some(0.5),
            moves: true,
            released_j: Some(1.0),
            gain_j: 0.0,
            is_trusted: true,
            remark: None,
        },
        forms: vec![
            form("winner", "bdf2", End::Good, None),
            form("tie", "midpoint", End::Good, None),
            form("slow", "dirk", End::Good, None),
            form("explodes", "leapfrog", End::Dominated, None),
            form("locks", "imex-euler", End::Exhausted, None),
            form("refused", "desbrun", End::Refused, Some("friction (`obstacles[0]`)")),
            form("coarse", "xpbd", End::Dominated, None),
            form("never", "vbd", End::Exhausted, None),
            form("unseen", "backward-euler", End::Dominated, None),
        ],
        runs: vec![
            run(0, 1, Stable, 0.02, 0.003),
            run(0, 2, Stable, 0.008, 0.004),
            run(1, 4, Stable, 0.002, 0.0059),
            run(2, 1, Stable, 0.001, 0.0061),
            run(3, 14, Diverged, f64::INFINITY, 0.002),
            run(3, 20, Diverged, f64::INFINITY, 0.003),
            run(4, 8, Locked, 0.005, 0.001),
            run(6, 1, Stable, 0.03, 0.001),
            run(7, 256, Stable, 0.5, 0.9),
        ],
        seconds: 50.0,
    }
}

#[test]
fn the_advice_names_winner_ties_runner_up_and_what_fails() {
    let facts = synthetic();
    let advice = advise(&facts);
    assert_eq!(advice.take.map(|pick| pick.run), Some(1));
    assert_eq!(advice.ties.iter().map(|pick| pick.run).collect::<Vec<_>>(), [2]);
    assert_eq!(advice.runner_up.map(|pick| pick.run), Some(3), "1.525 times is no tie");
    assert_eq!(advice.explodes, [("explodes".to_owned(), 20)]);
    assert_eq!(advice.locks, [("locks".to_owned(), 8)]);
    assert_eq!(advice.refused.len(), 1);
    // Four times as hard: the tie is the cheapest within 2.5 mm. Four times as easy: the coarse
    // one.
    let others: Vec<_> = advice.other_targets.iter().map(|(_, run)| *run).collect();
    assert_eq!(others, [2, 7]);
    let text = lines(&facts, &advice);
    assert!(text.len() <= 12, "{text:#?}");
    let line = |word: &str| {
        let found = text.iter().find(|line| line.starts_with(word));
        found.cloned().unwrap_or_else(|| panic!("{word} is missing: {text:#?}"))
    };
    assert!(line("take").contains("2 steps a frame") && line("take").contains("bdf2"), "{text:?}");
    assert!(line("expect").contains("8.0 mm") && line("expect").contains("4.0 ms"), "{text:?}");
    assert!(line("ties").contains("tie, 4 steps"), "{text:?}");
    assert!(line("runner-up").contains("slow, 1 step"), "{text:?}");
    // The advice names every form that took part.
    assert!(
        line("runner-up").contains("time. Slower: coarse; unseen. Never within the target: never")
    );
    for form in facts.forms.iter().skip(1) {
        assert!(text.iter().any(|line| line.contains(&form.label)), "{} {text:#?}", form.label);
    }
    let forms = &super::page::forms(&facts).rows;
    assert_eq!(forms.len(), facts.forms.len(), "{forms:?}");
    assert_eq!(forms.last().map(|row| row[0].as_str()), Some("unseen"));
    assert!(line("refused").contains("friction"), "{text:?}");
    // Where a gain of energy is not known, the advice says so.
    assert!(!line("expect").contains("gains energy"), "{text:?}");
    let mut open = facts.clone();
    open.runs[1].verdict = Verdict::Open;
    let expect = lines(&open, &advise(&open)).into_iter().find(|line| line.starts_with("expect"));
    let told = "whether it gains energy beyond the work of pins, obstacles and wind is not known";
    assert!(expect.is_some_and(|line| line.contains(told)));
    // Where theory says that the advised run locks, so may `drape run`.
    assert!(!line("expect").contains("locked"), "{text:?}");
    let mut slow = facts.clone();
    slow.runs[1].foreseen = Some(0.17);
    let expect = lines(&slow, &advise(&slow)).into_iter().find(|line| line.starts_with("expect"));
    assert!(expect.is_some_and(|line| line.contains("keeps 17 %") && line.contains("`locked`")));
    let command = line("run it");
    assert!(command.contains("'my shirt.json'") && command.contains("--dt 0.01 "), "{command}");
}

/// Of the runs of one form that meet the target the fastest counts, wherever it stands.
#[test]
fn a_form_is_ranked_by_its_fastest_good_run() {
    let mut facts = synthetic();
    facts.runs.push(run(0, 4, Verdict::Stable, 0.001, 0.0045));
    assert_eq!(advise(&facts).take.map(|pick| pick.run), Some(1));
    facts.runs.push(run(0, 3, Verdict::Stable, 0.002, 0.0035));
    assert_eq!(advise(&facts).take.map(|pick| pick.run), Some(10));
}

/// A run that explodes when pushed is not advised, and both the advice and the page say why.
#[test]
fn a_fragile_run_is_passed_over() {
    let mut facts = synthetic();
    facts.runs[1].holds_when_pushed = Some(false);
    let advice = advise(&facts);
    assert_eq!(advice.take.map(|pick| pick.run), Some(2), "the tie is next");
    assert_eq!(advice.fragile, [("winner".to_owned(), 2)]);
    let text = lines(&facts, &advice);
    assert!(text.len() <= 12, "{text:#?}");
    let said = "so many steps: explodes 20; when pushed, up to so many steps: winner 2";
    assert!(text.iter().any(|line| line.contains(said)), "{text:#?}");
    let rows = super::page::forms(&facts).rows;
    let winner = rows.iter().find(|row| row[0] == "winner").expect("a row");
    assert_eq!(winner[1], "stable, gains energy when pushed", "{winner:?}");
}

/// A run whose error is too great once the cloth is pushed is not advised for this target, but is
/// advised for an easier one. Noise of the pushed cloth counts as noise on the scene does.
#[test]
fn a_run_that_strays_when_pushed_is_passed_over() {
    let mut facts = synthetic();
    let target = facts.scene.target_m;
    facts.runs[1].holds_when_pushed = Some(true);
    facts.runs[1].pushed_m = Some(1.5 * target);
    let advice = advise(&facts);
    assert_eq!(advice.take.map(|pick| pick.run), Some(2), "the tie is next");
    assert_eq!(advice.strays, ["winner"]);
    let text = lines(&facts, &advice);
    assert!(text.iter().any(|line| line.contains("ithin the target until pushed: winner")));
    let rows = super::page::forms(&facts).rows;
    let winner = rows.iter().find(|row| row[0] == "winner").expect("a row");
    assert_eq!(winner[1], "stable, errs too much when pushed", "{winner:?}");
    assert!(facts.truth.is_met(2.0 * target, &facts.runs[1]));
    facts.truth.pushed_floor_m = Some(target);
    assert_eq!(advise(&facts).take.map(|pick| pick.run), Some(1));
}

/// On the hanging sheet, explicit Euler with 3 steps a frame keeps its energy for half a second.
/// Once the sheet is pushed it explodes, while 4 steps hold. The journal keeps the result of a
/// push.
#[test]
fn a_step_at_the_edge_of_stability_gives_way_to_a_shorter_one() {
    let input = drape_model::load("hanging-textile-1e4").expect("a bundled scene");
    let (clock, budget) = (Clock::Modelled, Duration::from_secs(600));
    let methods = Some("explicit-euler".to_owned());
    let options = Options { methods, clock, budget, ..Options::default() };
    let folder = tempfile::tempdir().expect("a folder");
    let unfinished = Unfinished::enter(folder.path(), false).expect("a folder of its own");
    let asked = || {
        let journal = unfinished.journal("edge", false).expect("a journal");
        let found = resume("sheet", input.spec(), 0.5, &options, &journal, &|_| ());
        found.expect("a comparison").facts
    };
    let facts = asked();
    let take = &facts.runs[advise(&facts).take.expect("an advice").run];
    assert_eq!((take.substeps, take.holds_when_pushed), (4, Some(true)));
    let edge = facts.runs.iter().find(|run| run.substeps == 3).expect("a run at the edge");
    assert!(edge.is_sound() && edge.is_fragile(), "{edge:?}");
    assert_eq!(asked().runs, facts.runs);
}

/// The rings of a curtain do work. A run that gains energy beyond it is not advised, and the run
/// that is gains none by the check of `drape run`, either.
#[test]
fn a_run_that_gains_energy_beyond_the_work_of_its_pins_gives_way() {
    let input = drape_model::load("curtain").expect("a bundled scene");
    let options = Options {
        methods: Some("xpbd-lines:substeps=6,symplectic-euler".to_owned()),
        clock: Clock::Modelled,
        budget: Duration::from_secs(600),
        rate: 24.0,
        ..Options::default()
    };
    let found = compare("curtain", input.spec(), 1.5, &options, &|_| ());
    let facts = &found.expect("a comparison").facts;
    assert!(facts.scene.is_driven);
    let of = |id: &'static str| {
        facts.runs.iter().filter(move |run| facts.form_of(run).method.starts_with(id))
    };
    let once = of("xpbd-lines").find(|run| run.substeps == 1).expect("one step a frame");
    assert!(matches!(once.verdict, Verdict::Marginal | Verdict::Unstable), "{once:?}");
    assert!(once.gain.is_some_and(|gain| gain > 0.02), "{once:?}");
    let take = &facts.runs[advise(facts).take.expect("an advice").run];
    assert_eq!(take.verdict, Verdict::Stable, "{take:?}");
    assert!(take.gain.is_some_and(|gain| gain < 0.02), "{take:?}");
    assert!(of("symplectic-euler").any(|run| run.verdict == Verdict::Stable));
    let kinds = [once, take].map(|run| {
        let choice = Choice::parse(&facts.form_of(run).method, &[]).expect("a method");
        let mut simulation = OrderedSimulation::new(input.spec(), &choice).expect("a scene");
        let step_s = facts.scene.frame_s / f64::from(run.substeps);
        let time = TimeSpan { step_s, duration_s: f64::from(facts.scene.frames) / 24.0 };
        let mut judge = Judge::of(&simulation, &choice, time);
        let outcome = simulation
            .simulate(time, |runner| runner.series().ledger().observe(|moment| judge.look(moment)))
            .expect("a run");
        let gain = judge.gain(&simulation, &choice, &outcome);
        judge.verdict(&simulation, &outcome, gain.as_ref()).kind
    });
    assert_eq!(kinds[0], Judged::GainedEnergy);
    assert_ne!(kinds[1], Judged::GainedEnergy);
}

/// The target lies between the error of a run on the scene and its error on the pushed cloth. Then
/// the run gives way to one with more steps.
#[test]
fn a_run_that_barely_meets_the_target_gives_way_to_shorter_steps() {
    let input = drape_model::load("hanging-textile-1e4").expect("a bundled scene");
    let asked = |target_m: Option<f64>| {
        let options = Options {
            methods: Some("imex-updated".to_owned()),
            clock: Clock::Modelled,
            budget: Duration::from_secs(600),
            target_m,
            // With this seed the error grows when the cloth is pushed.
            seed: 1,
            ..Options::default()
        };
        let found = compare("sheet", input.spec(), 0.5, &options, &|_| ());
        found.expect("a comparison").facts
    };
    let facts = asked(None);
    let take = &facts.runs[advise(&facts).take.expect("an advice").run];
    let (here, pushed) = (take.error_m.expect("held"), take.pushed_m.expect("held when pushed"));
    assert!(pushed > 1.01 * here, "{here} {pushed}");
    let facts = asked(Some(0.5 * (here + pushed)));
    let first = facts.runs.iter().find(|run| run.substeps == take.substeps).expect("it runs again");
    assert!(facts.strays(first), "{first:?}");
    let take = &facts.runs[advise(&facts).take.expect("an advice").run];
    assert!(take.substeps > first.substeps && facts.is_met(take), "{take:?}");
    assert!(take.pushed_m.is_some_and(|error| error < facts.scene.target_m), "{take:?}");
}

#[test]
fn where_nothing_meets_the_target_the_closest_is_named() {
    let mut facts = synthetic();
    facts.scene.target_m = 1e-4;
    facts.truth.floor_m = None;
    let advice = advise(&facts);
    assert!(advice.take.is_none() && advice.ties.is_empty());
    assert_eq!(advice.closest.map(|pick| pick.run), Some(3));
    assert!(lines(&facts, &advice)[2].contains("none meets the target"));
    // Pushed, that run is off by more than the next one.
    facts.runs[3].pushed_m = Some(0.003);
    assert_eq!(advise(&facts).closest.map(|pick| pick.run), Some(2));
    facts.runs.clear();
    let text = lines(&facts, &advise(&facts));
    assert!(text[2].contains("none: the time"), "{text:?}");
    // Where some runs failed and the time was over, the time is named.
    let mut facts = synthetic();
    facts.runs.retain(|run| !run.is_sound());
    let text = lines(&facts, &advise(&facts));
    assert!(text[2].contains("none: no run was stable"), "{text:?}");
    facts.forms[0].end = End::OutOfTime;
    let text = lines(&facts, &advise(&facts));
    assert!(text[2].contains("none in this time: no run was stable"), "{text:?}");
}

/// Errors below the noise are all alike: an error up to twice the noise counts as met.
#[test]
fn noise_raises_the_target() {
    let mut facts = synthetic();
    facts.truth.floor_m = Some(0.02);
    assert_eq!(facts.good_m(), 0.04);
    assert_eq!(advise(&facts).take.map(|pick| pick.run), Some(7));
}

/// Where only the winner meets the target, the advice names the others without a runner-up.
#[test]
fn others_are_told_where_there_is_no_runner_up() {
    let mut facts = synthetic();
    facts.runs.retain(|run| ![1, 2].contains(&run.form));
    let text = lines(&facts, &advise(&facts));
    let others = text.iter().find(|line| line.starts_with("others")).map_or("", |line| &line[11..]);
    assert!(others.starts_with("slower: tie; slow; coarse; unseen. Never"), "{text:#?}");
}

fn sheet(pins: &str) -> String {
    format!(
        r#"{{ "format": "drape-scene/1", "name": "sheet",
        "cloth": {{ "grid": {{ "rows": 6, "columns": 6, "size_m": [1, 1], "center_m": [0, 0, 0],
            "mass_kg": 0.2 }} }},
        "effects": {{ "tension": {{ "stiffness_n_per_m": 200, "damping_n_s_per_m": 0.01 }},
            "shear": {{ "stiffness_n_per_m": 20, "damping_n_s_per_m": 0.001 }}
            {pins},
        "time": {{ "step_s": 0.01, "duration_s": 0.4 }} }}"#
    )
}

fn compared(scene: &str, methods: &str) -> super::Comparison {
    let input = drape_model::parse("sheet", scene).unwrap_or_else(|error| panic!("{error}"));
    let options = Options {
        methods: Some(methods.to_owned()),
        budget: Duration::from_secs(300),
        ..Options::default()
    };
    compare("sheet", input.spec(), 0.4, &options, &|_| ()).unwrap_or_else(|error| panic!("{error}"))
}

/// `imex-euler` stands still on this stiff cloth at long steps, and agrees with itself at half the
/// steps. Without a true motion, a check beside a reference finds this.
#[test]
fn a_run_that_stands_still_is_not_sound_without_a_true_motion() {
    let input = drape_model::load("hanging-wool").expect("bundled");
    let stage = Stage::new("wool", input.spec(), 0.5, &Options::default()).expect("valid");
    let remark = Some("not looked for".to_owned());
    let found = Found::none(remark);
    let entry = |id: &str| Entry::of(&Choice::parse(id, &[]).expect("a method"));
    let entries = [entry("imex-euler"), entry("imex-updated")];
    let deadline = Deadline::new(Instant::now() + Duration::from_secs(3600), None);
    let journal = Journal::none();
    let memory = Memory::new(&journal, None);
    let mut course = Course::new((&stage, &entries), &found, memory, deadline, &|_, _| ());
    for form in 0..2 {
        for substeps in [1, 2] {
            course.lap(form, substeps, Limits::NONE).expect("supported");
        }
    }
    let [still, moving] = [1, 3].map(|n| course.runs[n].clone());
    assert_eq!(still.verdict, Verdict::Locked, "{still:?}");
    assert!(still.error_m.is_some_and(|error| error < 0.01), "it agrees with itself: {still:?}");
    assert!(still.retained.is_some_and(|share| share < 0.35), "{still:?}");
    assert!(!found.truth.is_met(1.0, &still) && !course.runs[0].is_sound());
    assert!(moving.is_sound() && moving.retained.is_some_and(|share| share > 0.75), "{moving:?}");
}

const HANGING: &str = r#", "gravity": { "m_s2": [0, 0, -9.81] } },
    "pins": [{ "row": 0, "column": 0 }, { "row": 0, "column": 5 }]"#;

/// A comparison with enough time gives the same results again, apart from times. The advised run
/// also meets the target against a true motion with another seed.
#[test]
fn the_advice_on_a_small_sheet_holds_when_it_is_measured_again() {
    let methods = "leapfrog,bdf2,imex-euler:forcing_term=1e-6";
    let first = compared(&sheet(HANGING), methods);
    let facts = &first.facts;
    assert!(facts.truth.is_trusted && facts.truth.members == 4, "{:?}", facts.truth);
    let pick = advise(facts).take.expect("a method meets 1 cm");
    let run = &facts.runs[pick.run];
    let again = compared(&sheet(HANGING), &facts.form_of(run).method);
    let same = again.facts.runs.iter().find(|other| other.substeps == run.substeps);
    let same = same.expect("it runs again with as many steps");
    assert!(again.facts.is_met(same), "{same:?}");
    assert_eq!((same.error_m, same.verdict), (run.error_m, run.verdict));
    // With fewer steps than its limit requires, the explicit method explodes, and the record says
    // so.
    assert!(facts.runs.iter().any(|run| run.explodes()) || facts.scene.limit_substeps == 1);
}

#[test]
fn a_scene_at_rest_moves_nothing_and_is_no_failure() {
    let comparison = compared(&sheet("}"), "leapfrog,bdf2");
    let facts = &comparison.facts;
    assert!(!facts.truth.moves, "{:?}", facts.truth);
    let advice = advise(facts);
    assert!(advice.take.is_some(), "{:?}", facts.runs);
    assert!(lines(facts, &advice).iter().any(|line| line.contains("nothing moves")));
}

#[test]
fn what_a_method_refuses_is_named() {
    let ball = r#", "gravity": { "m_s2": [0, 0, -9.81] } },
        "obstacles": [{ "sphere": { "center_m": [0, 0, -0.6], "radius_m": 0.3, "friction": 0.3 } }]"#;
    let comparison = compared(&sheet(ball), "exponential,bdf2");
    let facts = &comparison.facts;
    let refused = advise(facts).refused;
    assert!(!refused.is_empty(), "{:?}", facts.forms);
    assert!(refused.iter().all(|(_, why)| why.contains("obstacles")), "{refused:?}");
    let is_refused = |run: &Run| facts.form_of(run).method.starts_with("exponential");
    assert!(!facts.runs.iter().any(is_refused), "it was not run");
    assert!(lines(facts, &advise(facts)).iter().any(|line| line.starts_with("refused")));
}

#[test]
fn options_that_mean_nothing_are_refused_by_name() {
    let input = drape_model::parse("sheet", &sheet(HANGING)).expect("valid");
    let refused = |options: Options| match compare("s", input.spec(), 0.4, &options, &|_| ()) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("taken"),
    };
    let usual = Options::default;
    for target in [0.0, -1.0, f64::NAN] {
        assert!(refused(Options { target_m: Some(target), ..usual() }).contains("--target"));
    }
    assert!(refused(Options { rate: 1e9, ..usual() }).contains("--frame"));
    assert!(refused(Options { budget: Duration::ZERO, ..usual() }).contains("--budget"));
    let methods = Some("no-such".to_owned());
    assert!(refused(Options { methods, ..usual() }).contains("no-such"));
}

/// A single frame that another process interrupts hardly counts, but a slow second half does.
#[test]
fn a_single_slow_frame_hardly_moves_the_time() {
    let clock = |frames: &[f64]| {
        let mut sum = 0.0;
        let end = |frame: &f64| {
            sum += frame;
            sum
        };
        frames.iter().map(end).collect::<Vec<f64>>()
    };
    assert_eq!(super::steady(&clock(&[1.0, 1.0, 100.0, 1.0, 1.0])), 9.0);
    assert_eq!(super::steady(&clock(&[1.0, 1.0, 3.0, 3.0])), 8.0);
    assert_eq!(super::steady(&[]), 0.0);
}

/// Ranked by counted work, the same question has the same answer, to the last bit.
#[test]
fn with_modelled_time_a_comparison_is_a_fact() {
    let input = drape_model::parse("sheet", &sheet(HANGING)).expect("valid");
    let options = Options {
        methods: Some("leapfrog,bdf2,xpbd,imex-euler:forcing_term=1e-6".to_owned()),
        budget: Duration::from_secs(3600),
        clock: Clock::Modelled,
        ..Options::default()
    };
    let facts = || {
        let compared = compare("sheet", input.spec(), 0.4, &options, &|_| ());
        Facts { seconds: 0.0, ..compared.unwrap_or_else(|error| panic!("{error}")).facts }
    };
    let first = facts();
    assert_eq!(first, facts());
    // Its times come from the price list, not from a clock.
    let pick = advise(&first).take.expect("a method meets 1 cm").run;
    let run = &first.runs[pick];
    let choice = Choice::parse(&first.form_of(run).method, &[]).expect("a method");
    let counted = crate::cost::Counted {
        steps: u64::from(run.substeps * first.scene.frames),
        force_evaluations: run.force_evaluations,
        matvecs: run.matvecs,
        factorisations: run.factorisations,
        setups: 0,
        particles: first.scene.particles,
        springs: first.scene.springs,
    };
    let modelled = counted.seconds(crate::cost::prices().of(&choice.full_id()));
    let told = run.frame_s * f64::from(first.scene.frames);
    assert!(told > 0.3 * modelled && told < 3.0 * modelled + 1e-3, "{told} s, {modelled} s");
}

/// Runs in a journal are not made again, so even their times are the same. Missing runs are made.
#[test]
fn a_comparison_goes_on_from_its_journal() {
    let input = drape_model::parse("sheet", &sheet(HANGING)).expect("valid");
    let folder = tempfile::tempdir().expect("a folder");
    let facts = |methods: &str| {
        let methods = Some(methods.to_owned());
        let options = Options { methods, budget: Duration::from_secs(600), ..Options::default() };
        let unfinished = Unfinished::enter(folder.path(), false).expect("a folder of its own");
        let name = journal_name(input.spec(), 0.4, &options);
        let journal = unfinished.journal(&name, false).expect("a journal");
        let compared = resume("sheet", input.spec(), 0.4, &options, &journal, &|_| ());
        compared.unwrap_or_else(|error| panic!("{error}"))
    };
    let first = facts("leapfrog,bdf2");
    let again = facts("leapfrog,bdf2");
    let without_clock = |facts: &Facts| Facts { seconds: 0.0, ..facts.clone() };
    assert_eq!(without_clock(&first.facts), without_clock(&again.facts));
    assert_eq!(first.ends, again.ends);
    assert!(again.facts.seconds > 0.9 * first.facts.seconds, "the time before counts");
    let more = facts("leapfrog,bdf2,midpoint");
    assert_eq!(more.facts.truth, first.facts.truth);
    assert!(more.facts.runs.len() > first.facts.runs.len());
    for run in &first.facts.runs {
        let same = |other: &&Run| (other.form, other.substeps) == (run.form, run.substeps);
        let kept = more.facts.runs.iter().find(same).expect("the run before");
        // The finalists of another race may be timed again.
        assert!(kept.error_m == run.error_m && kept.verdict == run.verdict, "{kept:?} {run:?}");
    }
    let other = Options { seed: 3, ..Options::default() };
    let usual = journal_name(input.spec(), 0.4, &Options::default());
    assert_ne!(journal_name(input.spec(), 0.4, &other), usual);
    assert_ne!(journal_name(input.spec(), 0.5, &Options::default()), usual);
}

/// A search without a true motion counts for its budget alone. With a longer budget the search
/// starts again, and runs that were compared with themselves are made again.
#[test]
fn a_longer_budget_looks_for_the_true_motion_again() {
    let input = drape_model::parse("sheet", &sheet(HANGING)).expect("valid");
    let folder = tempfile::tempdir().expect("a folder");
    let options = |seconds: u64| Options {
        methods: Some("leapfrog,bdf2".to_owned()),
        budget: Duration::from_secs(seconds),
        ..Options::default()
    };
    let unfinished = Unfinished::enter(folder.path(), false).expect("a folder of its own");
    let name = journal_name(input.spec(), 0.4, &options(300));
    let none = Found::none(None);
    {
        let journal = unfinished.journal(&name, false).expect("a journal");
        Memory::new(&journal, None).keep_truth(&none, options(300).budget).expect("written");
    }
    let facts = |seconds: u64| {
        let journal = unfinished.journal(&name, false).expect("a journal");
        let compared = resume("sheet", input.spec(), 0.4, &options(seconds), &journal, &|_| ());
        compared.unwrap_or_else(|error| panic!("{error}")).facts
    };
    let short = facts(300);
    assert_eq!(short.truth, none.truth, "what was not found in this time is known");
    assert!(!short.runs.is_empty());
    let long = facts(600);
    assert!(long.truth.is_trusted && long.truth.members == 4, "{:?}", long.truth);
    let fresh = compared(&sheet(HANGING), "leapfrog,bdf2").facts;
    for run in &long.runs {
        let same = |other: &&Run| (other.form, other.substeps) == (run.form, run.substeps);
        if let Some(other) = fresh.runs.iter().find(same).filter(|run| run.is_sound()) {
            assert_eq!(run.error_m, other.error_m, "held against itself: {run:?}");
        }
    }
}

/// A run that does not end in time has not missed the target. Nor has a run without a true motion
/// to compare with.
#[test]
fn a_run_for_which_there_is_no_time_is_not_measured() {
    let input = drape_model::parse("sheet", &sheet(HANGING)).expect("valid");
    let options = Options::default();
    let stage = Stage::new("sheet", input.spec(), 0.4, &options).expect("valid");
    let now = Deadline::new(Instant::now(), None);
    let later = Deadline::new(Instant::now() + Duration::from_secs(3600), None);
    let found = super::truth::find(&stage, later).expect("supported");
    assert!(found.truth.is_trusted, "{:?}", found.truth);
    let choice = Choice::parse("bdf2", &[]).expect("a method");
    let check = |found: &Found, substeps: u32, deadline: Deadline| {
        held(&stage, found, (&choice, substeps), Clock::Wall, deadline).expect("supported")
    };
    assert_eq!(check(&found, 64, now), Checked::NotMeasured);
    let Checked::Held { error_m: Some(error_m), good_m } = check(&found, 64, later) else {
        panic!("it was measured and is sound")
    };
    assert!(error_m <= good_m && good_m >= 0.01, "{error_m} {good_m}");
    let none = Found::none(None);
    assert_eq!(check(&none, 64, later), Checked::NotMeasured);
    // An explosion misses the target: the run was measured and is not sound.
    let explicit = Choice::parse("explicit-euler", &[]).expect("a method");
    let missed = held(&stage, &found, (&explicit, 1), Clock::Wall, later).expect("supported");
    assert!(matches!(missed, Checked::Held { error_m: None, .. }), "{missed:?}");
}
