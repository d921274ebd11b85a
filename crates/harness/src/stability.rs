//! Verdicts on stability, by energy.
//!
//! A run is judged by the greatest rise of its total energy above the start, `Δ⁺ = max_n (H_n − H_0)`,
//! against `E_ref`, the energy that the scene sets free: `max(H_0 − min U, max T)` over a reference
//! trajectory. `Δ⁺ ≤ 0.02 E_ref` is stable, up to `0.5 E_ref` marginal, above unstable. Boundedness of
//! the positions alone is no test: the part of a spring's force that is taken explicitly is bounded, so
//! unstable runs saturate.

use crate::HarnessError;
use crate::methods::Choice;
use crate::run::{Counts, Simulation, count};
use drape_integrator::Implicit;
use drape_model::TimeSpan;

const STABLE: f64 = 0.02;
const MARGINAL: f64 = 0.5;
/// Fraction of the stability limit at which the reference runs.
const SAFETY: f64 = 0.25;

/// `E_ref` of a closed scene over `duration` seconds, J: from symplectic Euler well below its
/// stability limit, which follows the true motion and has the same bits on every machine.
///
/// # Errors
/// As [`crate::simulate`].
pub fn reference_energy(simulation: &Simulation, duration: f64) -> Result<f64, HarnessError> {
    let system = &simulation.system;
    let start = system.total_energy(&simulation.state);
    // Gershgorin: eigenvalues of M⁻¹L are at most twice the largest row sum.
    let mut rows = vec![(0.0_f64, 0.0_f64); system.len()];
    Implicit::Springs.visit_weights(system, &mut |i, j, k, c| {
        for end in [i, j] {
            rows[end].0 += 2.0 * k / system.mass()[end];
            rows[end].1 += 2.0 * c / system.mass()[end];
        }
    });
    let stiffness = rows.iter().fold(0.0_f64, |max, row| max.max(row.0));
    let damping = rows.iter().fold(0.0_f64, |max, row| max.max(row.1));
    // Symplectic Euler is stable for h²λ + 2hδ < 4.
    let limit = 4.0 / (damping + (damping * damping + 4.0 * stiffness).sqrt()).max(1e-300);
    let step_s = (SAFETY * limit).min(0.001).min(duration);
    let choice = Choice::parse("symplectic-euler", &[])?;
    let run = count(simulation, &choice, TimeSpan { step_s, duration_s: duration })?;
    Ok((start - run.least_potential).max(run.greatest_kinetic))
}

/// The verdict on a run: `stable`, `marginal`, `unstable` or `diverged`.
pub fn verdict(run: &Counts, reference_energy: f64) -> &'static str {
    if run.outcome.divergence.is_some() {
        "diverged"
    } else if run.energy_gain <= STABLE * reference_energy {
        "stable"
    } else if run.energy_gain <= MARGINAL * reference_energy {
        "marginal"
    } else {
        "unstable"
    }
}
