//! Position-based dynamics in substeps, on one spring.

use super::{Amplification, backward_euler};
use nalgebra::Matrix2;

/// A step that is divided into `substeps` steps of another method, given as a function of `θ` and
/// `η` of a substep: `S⁻¹ B(θ/n², η/n)ⁿ S` with `S = diag(1, 1/n)`, since the second coordinate is
/// the velocity times the length of a step.
pub fn divided(
    method: impl Fn(f64, f64) -> Amplification,
    theta: f64,
    eta: f64,
    substeps: u32,
) -> Amplification {
    let n = f64::from(substeps);
    let part = method(theta / (n * n), eta / n);
    let whole = (0..substeps).fold(Amplification::identity(), |product, _| part * product);
    Matrix2::new(whole.m11, whole.m12 / n, whole.m21 * n, whole.m22)
}

/// XPBD with one sweep in each of `substeps` substeps (Macklin et al. 2019): on a single spring the
/// sweep solves the substep of [`backward_euler`] exactly, so its radius is
/// `(1 + θ/n² + η/n)^{−n/2}` where the motion oscillates.
///
/// ```
/// use drape_oracle::recurrence::{backward_euler, xpbd};
/// assert_eq!(xpbd(1.0, 0.5, 1), backward_euler(1.0, 0.5));
/// ```
pub fn xpbd(theta: f64, eta: f64, substeps: u32) -> Amplification {
    divided(backward_euler, theta, eta, substeps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recurrence::spectral_radius;
    use nalgebra::Vector2;

    /// `1.01⁻⁵`, `(1 + 0.36/16 + 0.06/4)⁻²`, `2⁻⁵`, computed elsewhere.
    #[test]
    fn spectral_radii_are_powers_of_backward_eulers() {
        for ((theta, eta, substeps), expected) in [
            ((1.0, 0.0, 10), 0.951_465_687_6),
            ((0.36, 0.06, 4), 0.929_017_273_9),
            ((100.0, 0.0, 10), 0.03125),
        ] {
            let found = spectral_radius(&xpbd(theta, eta, substeps));
            assert!((found - expected).abs() < 1e-10, "{theta} {eta} {substeps}: {found}");
        }
    }

    /// The definition, substep by substep, with the velocity in place of `hv`.
    #[test]
    fn a_step_is_its_substeps_one_after_the_other() {
        let (theta, eta, n): (f64, f64, u32) = (3.0, 0.2, 7);
        let count = f64::from(n);
        let mut y = Vector2::new(0.3, -0.8 / count);
        (0..n).for_each(|_| y = backward_euler(theta / count / count, eta / count) * y);
        let found = xpbd(theta, eta, n) * Vector2::new(0.3, -0.8);
        assert!((found - Vector2::new(y.x, y.y * count)).norm() < 1e-14);
    }
}
