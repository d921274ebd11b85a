//! The exact motion, which exponential integrators reproduce on linear problems.

use super::Amplification;
use nalgebra::Matrix2;

/// The exact solution of `x'' = −κx − δx'` after a step: `exp [[0, 1], [−θ, −η]]`.
///
/// With `a = η/2` and `s² = θ − a²` it is `e^{−a} (cos s + (sin s)/s [[a, 1], [−θ, −a]])`. Past the
/// critical damping `s` is imaginary, and `cosh` and `sinh` take the place of `cos` and `sin`.
///
/// ```
/// use drape_oracle::recurrence::{exact_oscillator, spectral_radius};
/// assert!((spectral_radius(&exact_oscillator(100.0, 0.4)) - (-0.2_f64).exp()).abs() < 1e-15);
/// ```
pub fn exact_oscillator(theta: f64, eta: f64) -> Amplification {
    let a = 0.5 * eta;
    let square = theta - a * a;
    // e^{−a} cos s and e^{−a} (sin s)/s
    let (cos, sinc) = if square >= 0.0 {
        let s = square.sqrt();
        let sinc = if s > 0.0 { libm::sin(s) / s } else { 1.0 };
        (libm::exp(-a) * libm::cos(s), libm::exp(-a) * sinc)
    } else {
        let s = (-square).sqrt();
        // a − s without cancellation.
        let (slow, fast) = (libm::exp(-theta / (a + s)), libm::exp(-a - s));
        let difference = -slow * libm::expm1(-2.0 * s);
        (0.5 * (slow + fast), 0.5 * difference / s)
    };
    Matrix2::new(cos + sinc * a, sinc, -theta * sinc, cos - sinc * a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recurrence::spectral_radius;

    #[test]
    fn it_is_the_exponential_of_the_equation() {
        for (theta, eta) in [
            (0.0, 0.0),
            (0.36, 0.06),
            (1.0, 2.0),
            (2.0, 30.0),
            (100.0, 0.4),
            (1e-9, 1e-9),
            (1.0, 3.0),
        ] {
            let exact = Matrix2::new(0.0, 1.0, -theta, -eta).exp();
            let error = (exact_oscillator(theta, eta) - exact).norm();
            assert!(error < 1e-13 * (1.0 + exact.norm()), "θ={theta} η={eta}: {error:e}");
        }
    }

    #[test]
    fn spectral_radii_match_the_golden_table() {
        let table = [
            ((0.36, 0.06), 0.9704455335),
            ((1.0, 0.0), 1.0),
            ((100.0, 0.4), 0.8187307531),
            ((100.0, 0.0), 1.0),
            ((1e4, 0.0), 1.0),
        ];
        for ((theta, eta), expected) in table {
            let found = spectral_radius(&exact_oscillator(theta, eta));
            assert!((found - expected).abs() < 1e-10, "θ={theta} η={eta}: {found}");
        }
        let least = spectral_radius(&exact_oscillator(1e4, 200.0));
        assert!((least / 3.720075976e-44 - 1.0).abs() < 1e-6, "a double root: {least:e}");
    }
}
