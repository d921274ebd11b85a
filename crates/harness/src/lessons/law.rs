//! The effect of a step on the oscillator, from the start of a run on.

use super::Setting;
use drape_oracle::recurrence::{Amplification, GeneralizedAlpha, Recurrence, spectral_radius};
use nalgebra::Vector2;

/// The effect of a method on the oscillator `(x, w = hv)`, as functions of `θ = h²κ` and `η = hδ`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Law {
    /// Every step multiplies the state by one matrix.
    OneStep(fn(f64, f64) -> Amplification),
    /// A first step, then a recurrence, both of substeps.
    TwoSteps {
        /// The first substep.
        first: fn(f64, f64) -> Amplification,
        /// All others.
        later: fn(f64, f64) -> Recurrence,
        /// Substeps in a step.
        substeps: u32,
    },
    /// The method carries an acceleration.
    Alpha(fn() -> GeneralizedAlpha),
}

impl Law {
    /// The largest modulus of the eigenvalues of a step. In the long run each step multiplies the
    /// motion by this number.
    pub(crate) fn radius(&self, theta: f64, eta: f64) -> f64 {
        match self {
            Self::OneStep(matrix) => spectral_radius(&matrix(theta, eta)),
            Self::TwoSteps { later, substeps, .. } => {
                let n = f64::from(*substeps);
                libm::pow(later(theta / (n * n), eta / n).spectral_radius(), n)
            }
            Self::Alpha(family) => family().spectral_radius(theta, eta),
        }
    }

    /// The angle by which a step turns the oscillation of the largest modulus, rad. NaN if no such
    /// oscillation exists.
    pub(crate) fn angle(&self, theta: f64, eta: f64) -> f64 {
        let (recurrence, substeps) = match self {
            Self::OneStep(matrix) => (Recurrence::from(matrix(theta, eta)), 1.0),
            Self::TwoSteps { later, substeps, .. } => {
                let n = f64::from(*substeps);
                (later(theta / (n * n), eta / n), n)
            }
            Self::Alpha(_) => return f64::NAN,
        };
        let largest = recurrence
            .eigenvalues()
            .and_then(|all| all.into_iter().max_by(|a, b| a.norm().total_cmp(&b.norm())));
        largest.map_or(f64::NAN, |root| substeps * root.arg().abs())
    }

    /// Energy at the end of a run over that at its start, %.
    pub(crate) fn left(&self, setting: &Setting) -> f64 {
        let (theta, eta) = setting.numbers(setting.step);
        100.0 * self.energy(theta, eta, setting.steps())
    }

    /// Energy after `steps` steps over that at the start, which is all kinetic.
    pub(crate) fn energy(&self, theta: f64, eta: f64, steps: u64) -> f64 {
        let energy = |theta: f64, x: f64, w: f64| theta * x * x + w * w;
        let start = Vector2::new(0.0, 1.0);
        match self {
            Self::OneStep(matrix) => {
                let matrix = matrix(theta, eta);
                let end = (0..steps).fold(start, |y, _| matrix * y);
                energy(theta, end.x, end.y)
            }
            Self::TwoSteps { first, later, substeps } => {
                let n = f64::from(*substeps);
                let (theta, eta) = (theta / (n * n), eta / n);
                let later = later(theta, eta);
                let mut levels = [first(theta, eta) * start, start];
                for _ in 1..steps * u64::from(*substeps) {
                    levels = [later.next(&levels), levels[0]];
                }
                energy(theta, levels[0].x, levels[0].y)
            }
            Self::Alpha(family) => {
                let matrix = family().matrix(theta, eta);
                let start = GeneralizedAlpha::start(start.x, start.y, theta, eta);
                let end = (0..steps).fold(start, |y, _| matrix * y);
                energy(theta, end.x, end.y)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_oracle::recurrence::{Multistep, backward_euler, bdf, implicit_midpoint};

    /// Closed forms. Backward Euler has `(1 + θ)⁻ⁿ` and the radius `(1 + θ)^{−1/2}`. The midpoint
    /// rule keeps all energy and turns by `2 atan(√θ/2)`. A run of one step of two-step differences
    /// equals backward Euler.
    #[test]
    fn laws_are_those_of_known_methods() {
        let euler = Law::OneStep(backward_euler);
        assert!((euler.energy(0.25, 0.0, 4) - 1.25_f64.powi(-4)).abs() < 1e-15);
        assert!((euler.radius(0.25, 0.0) - 1.25_f64.powf(-0.5)).abs() < 1e-15);
        let midpoint = Law::OneStep(implicit_midpoint);
        assert!((midpoint.energy(9.0, 0.0, 7) - 1.0).abs() < 1e-14);
        assert!((midpoint.angle(4.0, 0.0) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let two = Law::TwoSteps { first: backward_euler, later: |t, e| bdf(2, t, e), substeps: 1 };
        assert_eq!(two.energy(0.25, 0.0, 1), euler.energy(0.25, 0.0, 1));
        // A step of n substeps is n steps of a substep.
        let divided =
            Law::TwoSteps { first: backward_euler, later: |t, e| bdf(2, t, e), substeps: 5 };
        let (whole, parts) = (divided.energy(0.25, 0.0, 2), two.energy(0.01, 0.0, 10));
        assert!((whole - parts).abs() < 1e-15, "{whole} {parts}");
        // The trapezoidal rule after a step of backward Euler: only the first step loses energy.
        let trapezoid = Law::TwoSteps {
            first: backward_euler,
            later: |t, e| Multistep::cnab2(1.0).recurrence(t, 0.0, e),
            substeps: 1,
        };
        assert!((trapezoid.energy(1.0, 0.0, 10) - 0.5).abs() < 1e-14);
    }
}
