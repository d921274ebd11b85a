//! What the experiment rests on: its starts, budgets and fronts, and that it has every method.

use super::scenes::{Case, Setting, Shape, normal};
use super::*;
use crate::cost::prices;
use crate::methods;
use crate::methods::runs::work;
use crate::studies::work_precision::facts::{Beside, Flaw};
use drape_model::Vec3;
use drape_report::Record;
use drape_report::number::significant;
use variants::{DOP853, Knob, Variant};

/// A small and soft scene of the star.
fn small(shape: Shape, budget: f64) -> Setting {
    let mut case: Case = cases().swap_remove(0);
    (case.shape, case.side, case.stiffness, case.budget) = (shape, 6, 1e3, budget);
    Setting::new(&case).expect("a valid scene")
}

fn variant(label: &str) -> &'static Variant {
    VARIANTS.iter().find(|variant| variant.label == label).expect("a known label")
}

#[test]
fn every_method_of_the_registry_runs_everywhere_and_every_variant_can_be_built() {
    for method in methods::all() {
        let is_it = |v: &&Variant| v.method.split(':').next() == Some(method.id);
        assert!(VARIANTS.iter().filter(is_it).any(Variant::is_run_everywhere), "{}", method.id);
    }
    for (n, variant) in VARIANTS.iter().enumerate() {
        assert!(VARIANTS[..n].iter().all(|other| other.label != variant.label));
        let values = match variant.knob {
            Knob::Steps => &[8.0][..],
            Knob::Setting(_, values) | Knob::Tolerance(values) => values,
        };
        for &value in values {
            let choice = variant.choice(value).expect("a valid setting");
            assert_eq!(choice.is_none(), variant.method == DOP853, "{}", variant.label);
        }
    }
}

#[test]
fn the_star_has_no_scene_twice_and_the_quick_subset_is_part_of_it() {
    let cases = cases();
    assert_eq!(cases.len(), 19);
    for (n, case) in cases.iter().enumerate() {
        // Scenes of other names are the same if their systems are.
        let spec = case.spec().expect("a valid scene");
        let same = |c: &Case| c.spec().expect("a valid scene") == spec;
        assert!(!cases[..n].iter().any(same), "{case:?}");
    }
    assert_eq!(cases.iter().filter(|case| case.is_quick()).count(), 1);
    assert_eq!(cases.iter().filter(|case| case.is_base()).count(), 5);
}

#[test]
fn sheets_start_bent_but_not_stretched_and_only_the_thrown_one_turns() {
    for shape in [Shape::Hanging, Shape::Thrown, Shape::Spread] {
        let setting = small(shape, 1e6);
        let state = &setting.simulation.state;
        let width = (state.x[1] - state.x[0]).norm();
        assert!((width / 0.2 - 1.0).abs() < 1e-3, "{shape:?}: {width}");
        let pinned = setting.simulation.system.pinned().iter().filter(|pinned| **pinned).count();
        assert_eq!(
            pinned,
            match shape {
                Shape::Hanging => 2,
                Shape::Thrown => 0,
                Shape::Spread => 4,
            }
        );
        let spin: Vec3 = state.x.iter().zip(&state.v).map(|(x, v)| x.cross(v)).sum();
        assert_eq!(spin.norm() > 1.0, shape == Shape::Thrown, "{shape:?}: {spin}");
    }
}

#[test]
fn finer_runs_come_closer_and_the_same_run_gives_the_same_bits() {
    let setting = small(Shape::Hanging, 1e9);
    for label in [DOP853, "leapfrog", "backward-euler", "imex-sbdf2"] {
        let row = setting.row(variant(label), Some(2e6)).expect("runs");
        let errors: Vec<f64> = row.runs.iter().filter_map(|run| run.error).collect();
        assert!(errors.len() > 1, "{label}: {:?}", row.runs);
        assert!(errors[errors.len() - 1] < 0.2 * errors[0], "{label}: {errors:?}");
        let last = row.runs.last().expect("a run");
        let again = setting.run(variant(label), last.value).expect("a run").run;
        assert_eq!(&again, last, "{label}");
    }
}

#[test]
fn what_would_go_over_the_budget_ends_the_row_with_that_verdict() {
    for (label, budget) in [("imex-euler", 3e5), (DOP853, 1.4e4), ("backward-euler", 1e6)] {
        let setting = small(Shape::Hanging, budget);
        let row = setting.row(variant(label), None).expect("runs");
        let (last, others) = row.runs.split_last().expect("runs");
        assert_eq!((last.verdict, last.error), (Verdict::OverBudget, None), "{label}");
        assert!(
            others.iter().all(|run| run.verdict == Verdict::Completed && run.effort <= budget),
            "{label}"
        );
        assert!(!others.is_empty(), "{label}");
    }
}

/// Very long steps may take more work than shorter ones, so none of them ends a row.
#[test]
fn a_very_long_step_over_the_budget_does_not_end_the_row() {
    for label in ["imex-euler", "backward-euler"] {
        let mut setting = small(Shape::Hanging, 10.0);
        setting.fewest = 1;
        let runs = setting.row(variant(label), None).expect("runs").runs;
        // A budget is looked at between steps.
        let mut later = runs.iter().skip(1);
        assert!(later.all(|run| run.verdict == Verdict::OverBudget), "{label}: {runs:?}");
        let values: Vec<f64> = runs.iter().map(|run| run.value).collect();
        assert_eq!(values, [1.0, 2.0, 4.0, 8.0], "{label}");
    }
}

/// A budget of modelled time buys each form the visits that take this time at its own prices.
#[test]
fn a_budget_of_modelled_time_is_held_at_the_prices_of_the_form() {
    for label in ["imex-euler", "vbd"] {
        let mut setting = small(Shape::Hanging, f64::INFINITY);
        setting.most_s = 1e-3;
        let visits = prices().of(variant(label).method).visits_within(setting.most_s);
        let row = setting.row(variant(label), None).expect("runs");
        let (last, others) = row.runs.split_last().expect("runs");
        assert_eq!((last.verdict, last.error), (Verdict::OverBudget, None), "{label}");
        assert!(!others.is_empty() && others.iter().all(|run| run.effort <= visits), "{label}");
        let most = others.iter().map(|run| run.effort).fold(0.0, f64::max);
        assert!(2.5 * most > visits, "{label}: {most} of {visits}");
    }
}

/// Whatever ran before, with a larger, a smaller or the same budget, a row that takes runs over is
/// the row that computes all of them.
#[test]
fn kept_runs_do_not_change_a_row() {
    let sheet = small(Shape::Hanging, 0.0);
    let fresh = |form: &Variant, budget: f64| {
        let mut setting = sheet.clone();
        setting.case.budget = budget;
        setting.row(form, None).expect("runs").runs
    };
    for label in ["imex-euler", "backward-euler", "leapfrog", DOP853] {
        let form = variant(label);
        // A run whose last step alone goes over the budget is complete.
        let whole = fresh(form, 1e6);
        let last = whole.iter().rfind(|run| run.verdict == Verdict::Completed).expect("a run");
        let tight = last.effort - 1.0;
        let budgets = [3e5, 1e6, 3e5, tight, 4e5, 1e6];
        let orders = [budgets.to_vec(), budgets.into_iter().rev().collect()];
        for order in orders {
            let mut setting = sheet.clone();
            setting.kept = Some(std::sync::Arc::default());
            for budget in order {
                setting.case.budget = budget;
                let row = setting.row(form, None).expect("runs");
                assert_eq!(row.runs, fresh(form, budget), "{label}, {budget}");
            }
        }
    }
}

/// A spring is nearly at right angles to the normals at its ends, so noise along them hardly
/// stretches it. Vertical noise would: the outer springs rise by 0.31 of their length.
#[test]
fn noise_leaves_the_sheet_along_its_normal() {
    let case = cases().into_iter().find(Case::is_quick).expect("a quick case");
    let spec = case.spec().expect("a valid scene");
    for spring in &spec.springs {
        let ends = [spring.i, spring.j].map(|i| Vec3::from(spec.particles.position_m[i as usize]));
        let along = (ends[0] - ends[1]).normalize();
        for normal in ends.iter().map(normal) {
            assert!((normal.norm() - 1.0).abs() < 1e-12 && normal.z > 0.9, "{normal}");
            assert!(normal.dot(&along).abs() < 0.018, "{normal}, {along}");
        }
    }
    let tilts = spec.springs.iter().map(|spring| {
        let [a, b] = [spring.i, spring.j].map(|i| spec.particles.position_m[i as usize][2]);
        (a - b).abs() / spring.rest_length_m
    });
    assert!(tilts.fold(0.0, f64::max) > 0.3);
}

fn row(label: &str, method: &str, points: &[(f64, f64)]) -> Row {
    let run = |&(error, effort): &(f64, f64)| Run {
        error: Some(error),
        modelled_s: effort,
        effort,
        ..Run::uncounted(effort, None, Verdict::Completed)
    };
    Row {
        scene: "scene".to_owned(),
        label: label.to_owned(),
        method: method.to_owned(),
        knob: "steps".to_owned(),
        is_headline: false,
        runs: points.iter().map(run).collect(),
    }
}

fn scene(stiffness: f64) -> Scene {
    let case = Case { stiffness, side: 4, ..cases().swap_remove(0) };
    Setting::new(&case).expect("a valid scene").scene
}

#[test]
fn the_front_is_what_no_run_beats_and_the_runner_up_is_another_method() {
    let mut rows = vec![
        row("leapfrog", "leapfrog", &[(0.2, 10.0), (0.05, 20.0), (0.05, 30.0)]),
        row("leapfrog, Cholesky", "leapfrog:solver=cholesky", &[(0.009, 50.0)]),
        row("imex-euler", "imex-euler", &[(0.5, 5.0), (0.008, 75.0), (0.3, 15.0)]),
        row("provot", "provot", &[(0.009, 60.0)]),
    ];
    front::mark(rows.iter_mut(), 0.0);
    let marks: Vec<_> = rows.iter().flat_map(|row| &row.runs).map(|run| run.is_on_front).collect();
    assert_eq!(marks, [true, true, false, true, true, true, false, false]);
    let mut scene = scene(100.0);
    scene.id = "scene".to_owned();
    let winner = front::winner(&scene.id, &rows, 0.01);
    assert_eq!(winner.label.as_deref(), Some("leapfrog, Cholesky"));
    assert_eq!((winner.runner_up.as_deref(), winner.ratio), (Some("imex-euler"), Some(1.5)));
    let tied: Vec<_> = winner.tied.iter().map(|tied| tied.label.as_str()).collect();
    assert_eq!(tied, ["imex-euler"], "a run with the winner's answer is no other");
    assert_eq!(front::winner(&scene.id, &rows, 1e-3).label, None);
}

/// The cheapest run does not win if it gains energy or stands still, and it is on no front.
#[test]
fn a_run_with_a_flaw_does_not_win() {
    let table = [
        // The energy beyond the true one, the motion kept, and the noise of the energy.
        (0.5, 1.0, 0.0, Some(Flaw::GainsEnergy)),
        (0.021, 1.0, 0.0, Some(Flaw::GainsEnergy)),
        (0.019, 1.0, 0.0, None),
        (0.05, 1.0, 0.03, None),
        (-0.5, 1.0, 0.0, None),
        (0.0, 0.49, 0.0, Some(Flaw::Locked)),
        (0.0, 0.51, 0.0, None),
    ];
    for (energy, retained, floor, flaw) in table {
        let mut rows = vec![
            row("xpbd-lines", "xpbd-lines", &[(0.05, 10.0)]),
            row("midpoint", "midpoint", &[(0.04, 50.0)]),
        ];
        let beside = Beside { shape_m: 0.0, strain: 0.0, energy, retained };
        let fast = &mut rows[0].runs[0];
        (fast.beside, fast.flaw) = (Some(beside), beside.flaw(floor));
        assert_eq!(fast.flaw, flaw, "{beside:?}");
        front::mark(rows.iter_mut(), 0.0);
        assert_eq!(rows[0].runs[0].is_on_front, flaw.is_none(), "{beside:?}");
        assert!(rows[1].runs[0].is_on_front, "{beside:?}");
        let winner = front::winner("scene", &rows, 0.1);
        let named = if flaw.is_none() { "xpbd-lines" } else { "midpoint" };
        assert_eq!(winner.label.as_deref(), Some(named), "{beside:?}");
        assert_eq!(winner.energy, flaw.is_none().then_some(energy), "{beside:?}");
    }
}

/// The second method needs three times as long, but only because its cheap run errs by a little more
/// than the level.
#[test]
fn a_lead_that_hangs_on_the_level_is_narrow() {
    for (error, is_narrow) in [(0.105, true), (0.12, false)] {
        let rows = [
            row("leapfrog", "leapfrog", &[(0.05, 10.0)]),
            row("midpoint", "midpoint", &[(error, 15.0), (0.02, 30.0)]),
        ];
        let winner = front::winner("scene", &rows, 0.1);
        assert_eq!((winner.ratio, winner.is_narrow), (Some(3.0), is_narrow), "{error}");
        assert!(winner.tied.is_empty());
    }
}

/// Noise is the same as in `trajectory`, errors are those without it, and DOP853 is
/// judged by its energy too.
#[test]
fn noise_is_measured_beside_the_reference_and_every_form_is_judged() {
    let mut case: Case = cases().swap_remove(0);
    (case.side, case.stiffness, case.budget) = (6, 1e3, 1e9);
    let alone = Setting::new(&case).expect("a valid scene");
    let setting = Setting::beside_noise(&case).expect("a valid scene");
    assert!(setting.scene.floor > 1e-8 && setting.scene.floor < 1e-3, "{:?}", setting.scene);
    assert!(setting.scene.ranks(1e-2) && !setting.scene.ranks(setting.scene.floor));
    for label in [DOP853, "leapfrog", "baraff-witkin"] {
        let form = variant(label);
        let row = setting.row(form, Some(2e6)).expect("runs");
        let done: Vec<_> = row.runs.iter().filter(|run| run.error.is_some()).collect();
        assert!(done.iter().all(|run| run.beside.is_some()), "{label}");
        let last = done.last().expect("a run");
        assert_eq!(last.flaw, None, "{label}");
        assert!((last.beside.expect("errors").retained - 1.0).abs() < 0.1, "{label}: {last:?}");
        // Nobody watches the run that is timed, and it has the same error.
        let again = alone.run(form, last.value).expect("a run").run;
        assert_eq!(again.error, last.error, "{label}");
    }
}

#[test]
fn words_name_where_the_winner_turns_and_who_spends_the_budget() {
    let mut facts = Facts { scenes: Vec::new(), rows: Vec::new(), winners: Vec::new() };
    for (stiffness, efforts) in [(1e2, [10.0, 20.0]), (1e4, [30.0, 15.0])] {
        let scene = scene(stiffness);
        for (method, effort) in ["leapfrog", "bdf2"].into_iter().zip(efforts) {
            let mut row = Row { scene: scene.id.clone(), ..row(method, method, &[(0.01, effort)]) };
            let dear = Run { verdict: Verdict::OverBudget, error: None, ..row.runs[0].clone() };
            row.runs.push(dear);
            facts.rows.push(row);
        }
        let rough = Row { scene: scene.id.clone(), ..facts.rows[0].clone() };
        let rough_run = Run { error: Some(0.05), ..rough.runs[0].clone() };
        let over = rough.runs[1].clone();
        facts.rows.push(Row { label: "rough".to_owned(), runs: vec![rough_run, over], ..rough });
        facts.winners.push(front::winner(&scene.id, &facts.rows, 0.01));
        facts.scenes.push(scene);
    }
    let words = super::super::words::words(&facts);
    let said = &words.conclusion;
    let turn =
        "explicit methods lead only up to k/m = 10² s⁻², implicit ones only from 10⁴ s⁻² on.";
    assert!(said.contains(turn), "{said}");
    let said = words.observations.join("\n");
    assert!(
        said.contains("1 of 3 variants exhaust their budget before they reach an error of 1 %"),
        "{said}"
    );
}

/// The committed facts follow from their counts and the committed prices. By other prices they
/// differ.
#[test]
fn the_committed_record_has_the_prices_of_the_source() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../results/work-precision.json").as_ref();
    let committed: Record<Facts> = drape_report::file::read_json(path).expect("a record");
    let facts = committed.facts;
    assert!(repriced(facts.clone(), prices()) == facts, "run the bin `prices`");
    let mut dearer = prices().clone();
    for price in &mut dearer.forms {
        price.ns_a_visit[0] += 1.0;
    }
    assert!(repriced(facts.clone(), &dearer) != facts);
}

/// Forms with one linear solve a step. Each run is a row of the table in the methodology: scene, form,
/// steps, error, energy at the end beyond the true one, CG iterations, and the visits of springs over
/// those of symplectic Euler with its longest step that errs by at most 1 %. A run that errs by more
/// has no such ratio.
#[test]
fn the_forms_with_one_solve_a_step_are_as_good_as_the_docs_say() {
    const BDF2: &str = "bdf2:residual=1e-2,solver=cg,max_iterations=1";
    const FROM_LAST: &str = "midpoint:max_iterations=1,solver=cg,cg_tolerance=0.02,start=last";
    const MIDPOINT: &str = "midpoint:max_iterations=1,solver=cg,cg_tolerance=0.02";
    let docs =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../drape/docs/methodology.md");
    let docs = std::fs::read_to_string(docs).expect("the methodology");
    let row = |is_heavy: bool, stiffness: f64, method: &'static str, steps: f64| {
        let case = cases().into_iter().find(|case| {
            (case.shape, case.is_heavy, case.stiffness) == (Shape::Hanging, is_heavy, stiffness)
        });
        let setting = Setting::beside_noise(&case.expect("a scene")).expect("a valid scene");
        let run = |form: &Variant, steps: f64| setting.run(form, steps).expect("a run").run;
        let own = run(&work::main("one solve", method), steps);
        let explicit = variant("symplectic-euler");
        let good = |run: &Run| run.error.is_some_and(|error| error < 1e-2);
        let values = (8..14).map(|power| run(explicit, f64::from(1 << power)));
        let best = values.into_iter().find(good).expect("a good run");
        let damping = if is_heavy { "heavy" } else { "light" };
        let error = own.error.expect("an error");
        let ratio = if error < 1e-2 {
            format!("{:.2}", own.effort / best.effort)
        } else {
            "misses 1 %".to_owned()
        };
        format!(
            "| {damping}, 1e{} | `{method}` | {steps} | {} % | {} % | {} | {ratio} |",
            stiffness.log10(),
            significant(100.0 * error, 2),
            significant(100.0 * own.beside.expect("an energy").energy, 2),
            own.cg_iterations,
        )
    };
    let rows = [
        row(false, 1e6, BDF2, 32.0),
        row(false, 1e8, BDF2, 128.0),
        row(false, 1e8, BDF2, 256.0),
        row(true, 1e6, BDF2, 16.0),
        row(false, 1e6, FROM_LAST, 16.0),
        row(false, 1e6, MIDPOINT, 16.0),
        row(false, 1e6, FROM_LAST, 64.0),
        row(false, 1e6, MIDPOINT, 64.0),
    ];
    let missing: Vec<&String> = rows.iter().filter(|row| !docs.contains(*row)).collect();
    assert!(missing.is_empty(), "the methodology lacks {missing:#?}");
}
