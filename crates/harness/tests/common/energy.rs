//! A synthetic record of the experiment `energy`.

use super::{CURVES, record};
use drape_harness::studies::energy::facts as energy;
use drape_report::Record;
use drape_report::Verdict;
use std::collections::BTreeMap;

/// Four scenes, undamped and damped, with ledgers that take and add; `quick`: the spinning sheet
/// only.
pub(crate) fn energy(quick: bool) -> Record<energy::Facts> {
    let names = ["spinning-1e4", "hanging-1e4", "hanging-1e6", "sphere-1e4"];
    let names = &names[..if quick { 1 } else { 4 }];
    let scenes: Vec<_> = names
        .iter()
        .flat_map(|name| [(name, false), (name, true)])
        .map(|(name, is_damped)| energy::Scene {
            id: format!("{name} {}", if is_damped { "damped" } else { "undamped" }),
            scene: (*name).to_owned(),
            is_damped,
            particles: 100,
            stiffness_over_mass_per_s2: 1e4,
            damping_over_mass_per_s: if is_damped { 40.0 } else { 0.0 },
            duration_s: 1.0,
            step_s: 0.01,
            reference_energy_j: 0.25,
            start_energy_j: 0.0,
            time_s: (0..=100).map(|n| 0.01 * f64::from(n)).collect(),
            portable: true,
        })
        .collect();
    let mut rows = Vec::new();
    for scene in &scenes {
        for (n, (method, label)) in CURVES.into_iter().enumerate() {
            let is_unstable = n == 0;
            let ledger = energy::Ledger {
                damping: if scene.is_damped { -0.5 } else { 0.0 },
                inertia: -0.0625 * n as f64,
                gaps: BTreeMap::from([("tension".to_owned(), -0.03125)]),
                residual: if n == 3 { 6.0 } else { 0.125 },
                constraint: 0.125,
                correction: if n == 3 { -6.0 } else { 1e-17 },
            };
            let drift = ledger.sum();
            let energies = |rate: f64| scene.time_s.iter().map(|t| rate * t).collect();
            rows.push(energy::Row {
                scene: scene.id.clone(),
                label: label.to_owned(),
                method: method.to_owned(),
                step_s: if n < 4 { 0.00125 } else { 0.01 },
                steps: 100,
                verdict: if is_unstable { Verdict::Diverged } else { Verdict::Stable },
                energy: energies(if is_unstable { 9.0 } else { drift }),
                drift: (!is_unstable).then_some(drift),
                gain: (!is_unstable).then_some(0.0),
                excess_dissipation: (!is_unstable).then_some(0.25),
                closure_defect: (!is_unstable && n != 5).then_some(3e-14),
                ledger: (!is_unstable && n != 5).then_some(ledger),
                unconverged_steps: 0,
                portable: true,
            });
        }
    }
    record(
        "energy",
        quick,
        energy::Facts { scenes, rows, unattributed: vec!["adams-bashforth2".to_owned()] },
    )
}
