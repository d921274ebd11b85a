//! A synthetic record of the study of animation.

use super::work::timings_of;
use super::{CURVES, record};
use drape_harness::studies::animation::facts::{
    Counters, Facts, Measure, Missing, Run, Scene, TimingRow,
};
use drape_report::{Record, Timings, Verdict};

/// Two scenes; methods whose error falls with the calls, one that locks, one that explodes.
pub(crate) fn animation() -> Record<Facts> {
    let scene = |id: &str, floor: f64| Scene {
        id: id.to_owned(),
        fabric: "cotton-blend".to_owned(),
        measure: if id == "hanging" { Measure::Shape } else { Measure::Trajectory },
        has_all_forms: true,
        particles: 400,
        springs: 1482,
        stiffness_n_per_m: 2000.0,
        stiffness_over_mass_per_s2: 4e6,
        theta: 1111.0,
        damping_over_stiffness_s: 1e-5,
        frames_per_s: 60,
        span_s: 1.0,
        limit_substeps: 48,
        reference_substeps: 192,
        members: 4,
        shape_floor_m: floor,
        trajectory_floor_m: floor,
        reference_error_m: 0.1 * floor,
        strain: 0.01,
        released_j: 0.9,
        prestress: 0.0,
        portable: true,
        computed: None,
    };
    let scenes = vec![scene("hanging", 1e-4), scene("on a ball", 1e-2)];
    let mut runs = Vec::new();
    for scene in &scenes {
        let forms = CURVES.iter().enumerate().flat_map(|(n, (method, label))| {
            [(n, method, (*label).to_owned()), (n, method, format!("{label}, tight"))]
        });
        for (n, method, label) in forms {
            for substeps in [1, 2, 4, 8] {
                let error = 0.03 / f64::from(substeps) / (n + 1) as f64;
                let verdict = match n {
                    1 => Verdict::Locked,
                    2 => Verdict::Unstable,
                    3 => Verdict::OverBudget,
                    _ => Verdict::Stable,
                };
                runs.push(Run {
                    scene: scene.id.clone(),
                    label: label.clone(),
                    method: (*method).to_owned(),
                    substeps,
                    inside: None,
                    is_limited: false,
                    verdict,
                    shape_error_m: Some(error),
                    trajectory_error_m: Some(error),
                    excess_strain: Some(0.001),
                    retained: Some(1.0),
                    kinetic: Some(0.9),
                    contact: None,
                    gain: 0.0,
                    counts: Counters { force_evaluations: 100, ..Counters::default() },
                    portable: true,
                });
            }
        }
    }
    // A sluggish run near the true shape, and one far from it.
    let of = |label: &str, kinetic: f64, error: f64| Run {
        label: label.to_owned(),
        method: label.to_owned(),
        substeps: 1,
        verdict: Verdict::Stable,
        kinetic: Some(kinetic),
        shape_error_m: Some(error),
        ..runs[0].clone()
    };
    let apart = [of("sluggish", 0.5, 2e-4), of("astray", 1.0, 0.2)];
    runs.extend(apart);
    record("animation", false, Facts { scenes, runs, missing: Vec::new() })
}

/// The same scenes as those of the long study, one of them not yet run to its end.
pub(crate) fn animation_long() -> Record<Facts> {
    let mut facts = animation().facts;
    for scene in &mut facts.scenes {
        scene.has_all_forms = false;
    }
    let named = |label: &str| vec![label.to_owned()];
    let missing = Missing {
        scene: "hanging".to_owned(),
        not_run: named("vbd"),
        not_timed: named("astray"),
        over_budget: named("dear"),
    };
    record("animation-long", false, Facts { missing: vec![missing], ..facts })
}

/// Times of its sound runs.
pub(crate) fn animation_timings() -> Timings<TimingRow> {
    times_of("animation")
}

/// Times of the sound runs of the long study.
pub(crate) fn animation_long_timings() -> Timings<TimingRow> {
    times_of("animation-long")
}

fn times_of(study: &str) -> Timings<TimingRow> {
    let sound = animation().facts.runs.into_iter().filter(Run::is_sound);
    let row = |run: Run| {
        let frame_s = 1e-3 * f64::from(run.substeps);
        TimingRow {
            scene: run.scene,
            label: run.label,
            substeps: run.substeps,
            inside: run.inside,
            frames: 10,
            samples_s: vec![10.0 * frame_s],
            frame_s,
            probe_s: None,
        }
    };
    timings_of(study, sound.map(row).collect())
}
