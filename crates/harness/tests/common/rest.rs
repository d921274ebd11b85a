//! A synthetic record of the study of rest.

use super::work::timings_of;
use super::{CURVES, record};
use drape_harness::studies::rest::facts::{
    Accepted, Counters, End, Facts, Minimum, Motion, Run, Scene, TimingRow,
};
use drape_report::{Record, Timings, Verdict};

/// Two tables; methods that arrive, one that is locked, one still on its way, one in a worse shape.
pub(crate) fn rest() -> Record<Facts> {
    let minimum = |waves: u32, energy_j: f64| Minimum {
        from: format!("{waves} waves"),
        energy_j,
        residual: 1e-8,
        is_minimum: waves != 5,
    };
    let scene = |id: &str, is_priced: bool| Scene {
        id: id.to_owned(),
        particles: 241,
        springs: 900,
        is_priced,
        span_s: 3.0,
        limit_steps: 400,
        released_j: 2e-3,
        prestress: 0.0,
        minima: vec![minimum(2, -1e-3), minimum(5, -9e-4)],
        motions: vec![Motion {
            from: "true motion".to_owned(),
            ends: [800, 1600].map(|steps| End { steps, energy_j: Some(-9.5e-4) }).into(),
            is_converged: true,
        }],
        accepted: vec![
            Accepted { energy_j: -1e-3, excess_energy: 0.0, from: vec!["2 waves".to_owned()] },
            Accepted {
                energy_j: -9.5e-4,
                excess_energy: 0.025,
                from: vec!["true motion".to_owned()],
            },
        ],
        portable: true,
    };
    let scenes = vec![scene("round table, denim", false), scene("square table", true)];
    let mut runs = Vec::new();
    for scene in &scenes {
        for (n, (method, label)) in CURVES.iter().enumerate() {
            for steps in [1, 2, 6] {
                let verdict = match n {
                    1 => Verdict::Locked,
                    2 => Verdict::Open,
                    _ => Verdict::Stable,
                };
                let has_arrived = verdict == Verdict::Stable;
                let cost = 0.01 * f64::from(steps) * (n + 1) as f64;
                runs.push(Run {
                    scene: scene.id.clone(),
                    label: (*label).to_owned(),
                    method: (*method).to_owned(),
                    steps,
                    is_limited: false,
                    verdict,
                    arrival_s: has_arrived.then_some(1.0 + 0.1 * n as f64),
                    shape_error_m: Some(2e-4),
                    residual: Some(0.005),
                    speed_m_s: Some(5e-4),
                    rest_energy_j: Some(-1e-3),
                    is_minimum: None,
                    excess_energy: Some(if n == 3 { 0.2 } else { 1e-6 }),
                    reached_j: (n != 3).then_some(-1e-3),
                    gain: 0.0,
                    effort: has_arrived.then_some(1e9 * cost),
                    modelled_s: (has_arrived && scene.is_priced).then_some(cost),
                    counts: Counters { force_evaluations: 100, ..Counters::default() },
                    portable: true,
                });
            }
        }
    }
    record("rest", false, Facts { scenes, runs })
}

/// Times of its runs that are right.
pub(crate) fn rest_timings() -> Timings<TimingRow> {
    let right = rest().facts.runs.into_iter().filter(Run::is_right);
    let row = |run: Run| {
        let seconds = 1e-9 * run.effort.unwrap_or(1.0);
        let (scene, label, steps) = (run.scene, run.label, run.steps);
        TimingRow { scene, label, steps, samples_s: vec![seconds], seconds, probe_s: None }
    };
    timings_of("rest", right.map(row).collect())
}
