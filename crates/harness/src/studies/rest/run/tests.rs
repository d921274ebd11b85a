use super::scenes::{Case, Setting, cases};
use crate::methods::runs::{Film, Substeps, Variant};
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

/// The small disc tells apart what arrives, what stands still elsewhere and what blows up.
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
    // A few sweeps of a constant matrix leave stiff cloth near its start.
    let locked = runs("imex-euler", Substeps::Ladder);
    assert!(locked.iter().any(|run| run.arrival_s.is_none()), "{locked:?}");
    let unstable = runs("explicit-euler", Substeps::Ladder);
    let is_lost = |run: &Run| matches!(run.verdict, Verdict::Diverged | Verdict::Unstable);
    assert!(unstable.iter().all(is_lost), "{unstable:?}");
    let row = setting.time(last).expect("times");
    assert!(row.seconds > 0.0 && !row.samples_s.is_empty());
}
