//! Maps and limits of steps, and kept motion.

use super::{CURVES, record};
use drape_harness::studies::locking::facts as locking;
use drape_harness::studies::stability::facts as stability;
use drape_report::Record;
use drape_report::Verdict;

/// Every verdict over steps and stiffnesses, limits with and without theory, a scan; `quick`: one
/// column.
pub(crate) fn stability(quick: bool) -> Record<stability::Facts> {
    let verdicts = [
        Verdict::Stable,
        Verdict::Locked,
        Verdict::Marginal,
        Verdict::Unstable,
        Verdict::Diverged,
        Verdict::OverBudget,
    ];
    let mut columns = vec![(1e4, 40.0), (1e6, 40.0), (1e4, 0.0), (1e6, 0.0)];
    columns.truncate(if quick { 1 } else { 4 });
    let (mut cells, mut limits, mut shear) = (Vec::new(), Vec::new(), Vec::new());
    for (n, (method, label)) in CURVES.into_iter().enumerate() {
        for &(k_over_m, damping) in &columns {
            for (m, step_s) in [0.01, 0.0316, 0.1, 1.0].into_iter().enumerate() {
                cells.push(stability::Cell {
                    label: label.to_owned(),
                    method: method.to_owned(),
                    stiffness_over_mass_per_s2: k_over_m,
                    damping_over_mass_per_s: damping,
                    step_s,
                    verdict: verdicts[(n + m) % 6],
                    starts: 1,
                    gain: if (n + m) % 6 == 4 { f64::MAX } else { 1e-3 },
                    drift: 0.0,
                    reach: Some(0.4),
                    reached_s: 2.0,
                    portable: true,
                });
            }
        }
        for scene in ["pair", "sheet"] {
            limits.push(stability::Limit {
                scene: scene.to_owned(),
                label: label.to_owned(),
                method: method.to_owned(),
                stiffness_over_mass_per_s2: 1e4,
                damping_over_mass_per_s: 40.0,
                largest_eigenvalue_per_s2: 2e4,
                rule: "θ < 4".to_owned(),
                theory_s: [Some(0.01), None, Some(0.0)][n % 3],
                visible_s: Some(0.01),
                measured_s: (n != 3).then_some(0.0099),
                is_unlimited: n % 3 == 1,
                range_s: [1e-4, 8.0],
                runs: 9,
                portable: true,
            });
        }
    }
    for label in if quick { &[][..] } else { &["imex-euler", "imex-updated"] } {
        let ratio = |ratio: f64| stability::Ratio {
            ratio,
            verdict: if ratio > 0.5 { Verdict::Diverged } else { Verdict::Stable },
            gain: if ratio > 0.5 { f64::MAX } else { 0.0 },
        };
        shear.push(stability::Shear {
            label: (*label).to_owned(),
            method: (*label).to_owned(),
            stiffness_over_mass_per_s2: 1e6,
            step_s: 0.01,
            bound: 0.52,
            start_bound: None,
            first_failure: Some(0.6),
            ratios: [0.01, 0.1, 0.5, 0.6, 1.0].map(ratio).into(),
            portable: true,
        });
    }
    record("stability", quick, stability::Facts { cells, limits, shear })
}

/// Sheets that lock more and more, one run over budget; `quick`: a single stiffness and step.
pub(crate) fn locking(quick: bool) -> Record<locking::Facts> {
    let stiffnesses = if quick { vec![1e6] } else { vec![1e4, 1e6, 1e8] };
    let sheet = |k_over_m: f64| locking::Sheet {
        stiffness_over_mass_per_s2: k_over_m,
        damping_over_mass_per_s: 40.0,
        side: 20,
        path_m: 2.7,
        path_error_m: 1e-4,
        half_fall_s: 0.3,
        reference_step_s: 1e-5,
        lever: 240.0,
        swing_lever: 162.0,
        portable: true,
    };
    let mut runs = Vec::new();
    let mut labels = CURVES.to_vec();
    labels.push(("imex-euler:implicit=springs", "imex-euler"));
    for (n, (method, label)) in labels.into_iter().enumerate() {
        let mut places: Vec<_> = stiffnesses.iter().map(|&k| (k, 0.01)).collect();
        places.extend((!quick).then_some((1e6, 0.001)));
        for (k_over_m, step_s) in places {
            let law: f64 = 240.0 * 9.81 / (step_s * k_over_m);
            let is_over = n == 2 && step_s < 0.01;
            let kept = (law / 3.0).min(1.0);
            let value = |value: f64| (!is_over).then_some(value);
            runs.push(locking::Run {
                label: label.to_owned(),
                method: method.to_owned(),
                stiffness_over_mass_per_s2: k_over_m,
                step_s,
                path_m: value(2.7 * kept),
                retained: value(kept),
                retained_beside_backward_euler: None,
                retained_fall: value(kept),
                height_m: value(-0.4 * kept),
                prototype_path_m: (label == "imex-euler").then_some(2.5 * kept),
                late_speed_m_s: value(0.9 * law),
                law_m_s: law,
                verdict: match n {
                    _ if is_over => Verdict::OverBudget,
                    0 => Verdict::Diverged,
                    _ if kept < 0.5 => Verdict::Locked,
                    _ => Verdict::Stable,
                }
                .to_owned(),
                gain: 0.0,
                unconverged_steps: 0,
                portable: true,
            });
        }
    }
    let spring = |direction: &str, theta: f64| locking::Spring {
        label: "imex-euler".to_owned(),
        method: "imex-euler".to_owned(),
        direction: direction.to_owned(),
        theta,
        step_s: 0.01,
        steps: 100,
        load_m_s2: 1e-3,
        speed_m_s: 1e-5 / theta,
        law_m_s: 1e-5 / theta,
        recurrence_error: Some(1e-15),
        free_m_s: 1e-3,
        portable: true,
    };
    let springs =
        ["along x", "oblique"].into_iter().flat_map(|name| [1.0, 10.0].map(|t| spring(name, t)));
    let facts = locking::Facts {
        sheets: stiffnesses.iter().map(|&k| sheet(k)).collect(),
        runs,
        springs: springs.collect(),
    };
    record("locking", quick, facts)
}
