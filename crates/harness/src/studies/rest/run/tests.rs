use super::ALWAYS;
use super::scenes::{Case, Setting, cases};
use crate::methods::runs::{Film, Substeps, Variant};
use crate::studies::filmed::Stage as _;
use crate::studies::rest::facts::{RIGHT, Run, THERE};
use drape_report::Verdict;

fn quick() -> Setting {
    let case = cases().into_iter().find(Case::is_quick).expect("a quick case");
    Setting::new(&case).expect("a valid scene")
}

#[test]
fn every_cloth_begins_without_stress_and_has_a_minimum() {
    for case in cases() {
        let setting = Setting::new(&case).expect("a valid scene");
        let scene = &setting.scene;
        assert!(scene.prestress < 1e-12, "{}: {}", scene.id, scene.prestress);
        assert!(scene.minima.iter().any(|minimum| minimum.is_minimum), "{scene:?}");
    }
}

/// The small disc distinguishes runs that arrive, that stand still elsewhere and that explode.
#[test]
fn what_arrives_is_told_from_what_stands_still_and_what_explodes() {
    let setting = quick();
    let runs = |method, substeps| {
        let film = Film { form: Variant::new("a", method), substeps };
        setting.runs(&film).expect("runs")
    };
    let implicit = runs("backward-euler", Substeps::Ladder);
    for run in &implicit {
        assert_eq!(run.verdict, Verdict::Stable, "{run:?}");
        assert!(run.is_right() && run.shape_error_m.is_some_and(|error| error < THERE), "{run:?}");
    }
    let explicit = runs("symplectic-euler", Substeps::Limit);
    let [last] = &explicit[..] else { panic!("{explicit:?}") };
    assert!(last.arrival_s.is_some() && last.steps > setting.scene.limit_steps / 2, "{last:?}");
    // With a constant matrix and few sweeps, stiff cloth stays near its start.
    let locked = runs("imex-euler", Substeps::Ladder);
    assert!(locked.iter().any(|run| run.arrival_s.is_none()), "{locked:?}");
    let unstable = runs("explicit-euler", Substeps::Ladder);
    let is_lost = |run: &Run| matches!(run.verdict, Verdict::Diverged | Verdict::Unstable);
    assert!(unstable.iter().all(is_lost), "{unstable:?}");
    // Shorter steps are tried until one arrives.
    assert!(locked.len() > ALWAYS, "{locked:?}");
    let row = setting.time(last).expect("times");
    assert!(row.seconds > 0.0 && !row.samples_s.is_empty());
}

/// The shape of a run counts if it is better than those of the static search. Then others are wrong
/// unless a true motion reaches them.
#[test]
fn a_better_shape_of_a_run_is_the_least_known() {
    let mut setting = quick();
    let film = Film { form: Variant::new("a", "backward-euler"), substeps: Substeps::Ladder };
    let mut runs = setting.runs(&film).expect("runs");
    let known = setting.scene.minima.len();
    setting.learn(&mut runs);
    assert_eq!(setting.scene.minima.len(), known, "nothing is better: {:?}", setting.scene);
    assert!(runs.iter().all(Run::is_right), "{runs:?}");
    let mut better = runs[0].clone();
    let energy = better.rest_energy_j.expect("an energy") - 0.02 * setting.scene.released_j;
    better.rest_energy_j = Some(energy);
    better.is_minimum = Some(true);
    better.portable = true;
    runs.push(better);
    setting.learn(&mut runs);
    assert_eq!(setting.scene.minima.last().map(|minimum| minimum.energy_j), Some(energy));
    let (last, others) = runs.split_last().expect("runs");
    assert_eq!((last.is_right(), last.reached_j), (true, Some(energy)));
    for run in others {
        assert_ne!(run.reached_j, Some(energy), "{run:?}");
    }
    // A run that a library's functions may have rounded adds no shape.
    setting.scene.minima.pop();
    runs[2].portable = false;
    setting.learn(&mut runs);
    assert_eq!(setting.scene.minima.len(), known);
}

/// A true motion owes no one the least energy: its end is right beside a better minimum.
#[test]
fn the_end_of_a_true_motion_is_right_whatever_better_minimum_is_known() {
    let mut setting = quick();
    let ends: Vec<f64> = setting
        .scene
        .motions
        .iter()
        .filter(|motion| motion.is_converged)
        .filter_map(|motion| motion.ends.last()?.energy_j)
        .collect();
    assert!(!ends.is_empty(), "{:?}", setting.scene.motions);
    let film = Film { form: Variant::new("a", "symplectic-euler"), substeps: Substeps::Limit };
    let mut runs = setting.runs(&film).expect("runs");
    // Energies far below and far above all that a motion reaches.
    let (mut better, mut worse) = (runs[0].clone(), runs[0].clone());
    let released = setting.scene.released_j;
    better.rest_energy_j = runs[0].rest_energy_j.map(|energy| energy - 0.1 * released);
    better.is_minimum = Some(true);
    worse.rest_energy_j = runs[0].rest_energy_j.map(|energy| energy + 0.1 * released);
    runs.extend([better, worse]);
    setting.learn(&mut runs);
    let [own, better, worse] = &runs[..] else { panic!("{runs:?}") };
    assert!(own.excess_energy.is_some_and(|excess| excess > 2.0 * RIGHT), "{own:?}");
    assert!(own.is_right() && better.is_right() && !worse.is_right(), "{runs:?}");
    assert!(own.reached_j.is_some_and(|energy| ends.contains(&energy)), "{own:?}");
    assert_eq!(better.reached_j, better.rest_energy_j);
    let accepted = &setting.scene.accepted;
    assert_eq!(accepted[0].energy_j, setting.scene.minima.last().expect("a minimum").energy_j);
    assert!(accepted[1..].iter().all(|other| other.from[0].starts_with("true motion")));
}
