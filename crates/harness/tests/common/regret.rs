//! Advice beside exhaustive search.

use super::record;
use drape_harness::studies::regret::facts as regret;
use drape_report::{Record, TIMINGS_FORMAT, Timings};

/// Three scenes; one advice misses its target, one case has none.
pub(crate) fn regret() -> Record<regret::Facts> {
    let pick = |label: &str, frame_s| regret::Pick {
        label: label.to_owned(),
        method: format!("{label}:setting=1"),
        substeps: 4,
        error_m: 0.008,
        frame_s,
    };
    let case = |scene: &str, ratio: Option<f64>, again_m: Option<f64>| regret::Case {
        scene: scene.to_owned(),
        description: "A cloth that hangs.".to_owned(),
        particles: 105,
        target_m: 0.01,
        good_m: 0.01,
        is_trusted: true,
        best: ratio.map(|_| pick("bdf2", 1e-4)),
        advice: ratio.map(|ratio| pick("leapfrog", 1e-4 * ratio)),
        regret: ratio,
        effort: 0.05,
        again_m,
        again_good_m: Some(0.01),
        portable: false,
    };
    let cases = vec![
        case("strip", Some(1.0), Some(0.009)),
        case("tug", Some(1.3), Some(0.02)),
        case("scrap", None, None),
    ];
    record("regret", false, regret::Facts { cases })
}

pub(crate) fn regret_timings() -> Timings<regret::TimingRow> {
    let row = |scene: &str, label: Option<&str>| regret::TimingRow {
        scene: scene.to_owned(),
        origin: regret::Origin::Springs,
        particles: 105,
        duration_s: 0.5,
        frames_per_s: 60.0,
        target_m: 0.01,
        budget_s: 6.0,
        seconds: 5.7,
        is_trusted: true,
        label: label.map(str::to_owned),
        substeps: 4,
        search_s: 8.5,
        is_judged: true,
        left: 1,
        best: Some("bdf2".to_owned()),
        best_substeps: 2,
        regret: label.map(|_| 1.05),
        again_m: label.map(|_| 0.009),
        again_good_m: label.map(|_| 0.01),
        over_model: label.map(|_| 1.2),
    };
    Timings {
        format: TIMINGS_FORMAT.to_owned(),
        experiment: "regret".to_owned(),
        method: "clock".to_owned(),
        rows: vec![row("strip", Some("leapfrog")), row("scrap", None)],
        provenance: super::provenance(),
    }
}
