//! Work under control of steps and tolerances.

use super::record;
use drape_harness::studies::solver_control::facts as control;
use drape_report::Record;
use drape_report::Verdict;

/// Two scenes; errors fall with the work, one adaptive run diverges.
pub(crate) fn control() -> Record<control::Facts> {
    let scene = |id: &str, stiffness: f64| control::Scene {
        id: id.to_owned(),
        stiffness_over_mass_per_s2: stiffness,
        damping_over_mass_per_s: 40.0,
        span_s: 0.25,
        reference_error_m: 1e-9,
        portable: false,
    };
    let scenes = vec![scene("hanging-1e4", 1e4), scene("hanging-1e6", 1e6)];
    let mut runs = Vec::new();
    let mut add = |series: &str, scene: usize, label: &str, adaptive, value, n: u64| {
        let diverged = adaptive && n == 3 && scene == 1;
        runs.push(control::Run {
            series: series.to_owned(),
            scene: scenes[scene].id.clone(),
            label: label.to_owned(),
            is_adaptive: adaptive,
            value,
            method: format!("{label}:setting={n}"),
            step_s: 0.01,
            error: (!diverged).then_some(0.3 / (n * n) as f64),
            energy_gain_j: 0.0,
            substeps: 25 * n,
            rejected: n,
            setups: n,
            factorisations: 10 * n,
            newton_iterations: 30 * n,
            outer_passes: 0,
            cg_iterations: 200 * n,
            matvecs: 225 * n,
            force_evaluations: 50 * n,
            work_sweeps: 10_000 * n,
            unconverged_steps: n / 4,
            verdict: if diverged { Verdict::Diverged } else { Verdict::Completed },
            portable: false,
        });
    };
    for scene in 0..2 {
        for label in ["backward-euler", "imex-euler", "imex-euler, plain estimate", "bdf2"] {
            for n in 1..=4 {
                add("steps", scene, label, false, Some(0.01 / n as f64), n);
                add("steps", scene, label, true, Some(0.1 / n as f64), n);
            }
        }
        for n in 1..=4 {
            add("forcing", scene, "backward-euler", false, Some(0.1 / (n * n) as f64), n);
            add("forcing", scene, "imex-euler", false, Some(0.1 / (n * n) as f64), n);
        }
        add("forcing", scene, "backward-euler", false, None, 2);
        add("jacobian", scene, "backward-euler: saved, Cholesky", false, None, 1);
        add("preconditioner", scene, "ic0", false, None, 1);
    }
    let histories = ["backward-euler", "bdf2"].map(|label| control::History {
        scene: "hanging-1e6".to_owned(),
        label: label.to_owned(),
        tolerance: 0.01,
        time_s: vec![0.01, 0.02, 0.03],
        step_s: vec![1e-3, 2e-3, 5e-3],
    });
    record("solver-control", false, control::Facts { scenes, runs, histories: histories.into() })
}
