//! A synthetic record of the study of trajectories.

use super::{CURVES, record};
use drape_harness::studies::trajectory::facts::{Beside, Facts, Row, Run, Scene, Tied, Winner};
use drape_report::{Record, Verdict};

/// The dampings of the study at three stiffnesses; errors of order 1 and 2; noise grows with the stiffness until
/// nothing ranks.
pub(crate) fn trajectory() -> Record<Facts> {
    let scene = |damping: &str, k_over_m: f64, floor: f64| Scene {
        id: format!("k/m = {k_over_m:e}, {damping}"),
        damping: damping.to_owned(),
        particles: 400,
        springs: 1482,
        stiffness_over_mass_per_s2: k_over_m,
        damping_over_mass_per_s: 10.0,
        damping_ratio: 0.01,
        span_s: 0.25,
        motion_m: 0.2,
        released_j: 0.3,
        dissipated: 0.1,
        strain: 0.01,
        reference_error: 1e-9,
        reference_tolerance: 1e-10,
        members: 9,
        floor,
        shape_floor_m: 0.01 * floor,
        strain_floor: 0.1 * floor,
        energy_floor: 0.1 * floor,
        budget_s: 0.05,
    };
    let scenes: Vec<_> = ["d/m = 0", "d/m = 10", "d/m = 40", "ζ = 0.01", "ζ = 0.1", "ζ = 1"]
        .into_iter()
        .flat_map(|damping| {
            [(1e4, 1e-5), (1e6, 1e-4), (1e8, 8e-3)].map(|(k, n)| scene(damping, k, n))
        })
        .collect();
    let (mut rows, mut winners) = (Vec::new(), Vec::new());
    for scene in &scenes {
        for (n, (method, label)) in CURVES.into_iter().enumerate() {
            let p = 1 + n as i32 % 2;
            let run = |step: i32| {
                let error = 0.2 * 2f64.powi(-p * step);
                let beside = Beside {
                    shape_m: 0.1 * error,
                    strain: 0.01 * error,
                    energy: -0.3 * error,
                    retained: 1.0 - 0.5 * error,
                };
                let is_lost = n < 3 && step == 0;
                Run {
                    value: 8.0 * 2f64.powi(step),
                    step_s: Some(0.25 / (8.0 * 2f64.powi(step))),
                    verdict: if is_lost { Verdict::Diverged } else { Verdict::Completed },
                    error: (!is_lost).then_some(error),
                    beside: (!is_lost).then_some(beside),
                    flaw: None,
                    modelled_s: 1e-3 * 2f64.powi(step) * (1.0 + n as f64),
                    effort: 1e5 * 2f64.powi(step) * (1.0 + n as f64),
                    steps: 8,
                    force_evaluations: 8,
                    matvecs: 0,
                    factorisations: 0,
                    setups: 0,
                    cg_iterations: 0,
                    unconverged_steps: 0,
                    is_on_front: n == 1,
                    portable: true,
                }
            };
            rows.push(Row {
                scene: scene.id.clone(),
                label: label.to_owned(),
                method: method.to_owned(),
                knob: "steps".to_owned(),
                is_headline: n % 2 == 0,
                runs: (0..6).map(run).collect(),
            });
        }
        let ranked = [1e-1, 1e-2, 1e-3].into_iter().filter(|level| scene.ranks(*level));
        winners.extend(ranked.map(|level| Winner {
            scene: scene.id.clone(),
            level,
            label: Some(CURVES[1].1.to_owned()),
            is_explicit: Some(true),
            value: Some(16.0),
            modelled_s: Some(6e-3),
            energy: Some(-0.03),
            retained: Some(0.95),
            runner_up: Some("imex-euler".to_owned()),
            ratio: Some(1.75),
            tied: vec![Tied { label: "imex-euler".to_owned(), is_explicit: false, ratio: 1.75 }],
            is_narrow: false,
        }));
    }
    record("trajectory", false, Facts { scenes, rows, winners })
}
