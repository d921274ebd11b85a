use super::ALWAYS;
use super::scenes::{Case, Setting, cases};
use crate::methods::runs::{Film, Substeps, Variant};
use crate::studies::filmed::Stage as _;
use crate::studies::rest::facts::{Run, THERE};
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

/// The shape of a run counts if it is better than those of the static search.
#[test]
fn a_better_shape_of_a_run_makes_the_others_wrong() {
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
    assert!(last.is_right() && !others.iter().any(Run::is_right), "{runs:?}");
    // A run that a library's functions may have rounded adds no shape.
    setting.scene.minima.pop();
    runs[2].portable = false;
    setting.learn(&mut runs);
    assert_eq!(setting.scene.minima.len(), known);
}
