//! The alternating direction method of multipliers (Overby, Brown, Li, Narain 2017).
//!
//! Each spring has a copy `z` of its difference `d = x_i − x_j`, and a multiplier `u` that makes
//! both agree. `w² = k` weighs the disagreement, so that the global matrix stays `A`:
//!
//! ```text
//! z ← argmin U(|z|) + ½ w² |z − (d + u)|²          along d + u, for each spring alone    (P10)
//! u ← u + d − z                                                                         (P11)
//! v^{k+1} = argmin ½‖v − v̂‖²_M + ½ h vᵀ D v + Σ ½ w² |d − z + u|²     d at x_n + h v     (P12)
//! ```
//!
//! For a linear spring (P10) is `|z| = (k ℓ + w² |d + u|)/(k + w²)`. The multipliers start at 0 in
//! each step. (P12) takes projected damping like (P3): the part beyond `L_c v` from the last
//! iterate.

use super::Iterate;
use drape_integrator::Implicit;
use drape_model::{Effect, System, Vec3};
use drape_solvers::vector::axpy;

/// Most iterations for the length of `z`. A linear spring takes one; for others each at least
/// halves the error.
const MAX_LENGTH_ITERATIONS: u32 = 60;
/// A force imbalance below this part of `w² |z|` is round-off.
const LENGTH_ROUND_OFF: f64 = 1e-15;

#[derive(Debug)]
pub(super) struct Admm {
    /// `u` of each spring, m, in the order of [`Implicit::visit_weights`].
    multipliers: Vec<Vec3>,
}

/// The length of `z`, (P10): the root of `T(r) + w² (r − p) = 0`. The slope on the left is at most
/// `k + w²`, with which each iteration divides; it is at least `w²`, half of that.
fn relaxed_length(k: f64, tension: &dyn Fn(f64) -> f64, p: f64) -> f64 {
    let mut r = p;
    for _ in 0..MAX_LENGTH_ITERATIONS {
        let imbalance = tension(r) + k * (r - p);
        r -= imbalance / (2.0 * k);
        if imbalance.abs() <= LENGTH_ROUND_OFF * k * (r + p) {
            break;
        }
    }
    r.max(0.0)
}

/// `a/|a|`, or 0.
fn direction(a: Vec3) -> Vec3 {
    let length = a.norm();
    if length > 0.0 { a / length } else { Vec3::zeros() }
}

impl Admm {
    pub(super) fn new(system: &System) -> Self {
        let mut springs = 0;
        Implicit::Springs.visit_weights(system, &mut |_, _, _, _| springs += 1);
        Self { multipliers: vec![Vec3::zeros(); springs] }
    }

    pub(super) fn begin(&mut self) {
        self.multipliers.fill(Vec3::zeros());
    }

    /// (P10) to (P12).
    #[doc(alias = "Overby-Brown-Li-Narain 2017")]
    #[doc(alias = "ADMM")]
    pub(super) fn advance(&mut self, at: &mut Iterate<'_>) {
        let h = at.potential.tau().v;
        let x = at.potential.positions(at.v);
        let mut multipliers = self.multipliers.iter_mut();
        let gradient = &mut *at.gradient;
        for split in Implicit::Springs.effects(at.system).filter_map(Effect::split) {
            split.visit_tensions(&mut |i, j, k, tension| {
                let Some(u) = multipliers.next() else { return };
                if k == 0.0 {
                    return;
                }
                let d = x[i] - x[j];
                let p = d + *u;
                let z = direction(p) * relaxed_length(k, tension, p.norm()); // (P10)
                *u += d - z; // (P11)
                // The force of the spring gives way to that of the disagreement.
                let f = (d - z + *u) * k - direction(d) * tension(d.norm());
                gradient[i] += f * h;
                gradient[j] -= f * h;
            });
        }
        at.report.force_evaluations += 1;
        at.metric.at_rest.project(at.gradient);
        at.fixed_point_residual();
        axpy(1.0, at.residual, at.v); // (P12)
    }
}
