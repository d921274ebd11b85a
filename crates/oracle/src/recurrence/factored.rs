//! Damping and springs one after the other, on one spring.

use super::{Amplification, Recurrence};
use nalgebra::Matrix2;

/// The first step of [`factored_backward_euler`], which has no previous spring forces:
/// `(1 + θ) x_+ = x + w/(1 + η)`.
pub fn factored_start(theta: f64, eta: f64) -> Amplification {
    let (x, w) = (1.0 / (1.0 + theta), 1.0 / ((1.0 + theta) * (1.0 + eta)));
    Matrix2::new(x, w, x - 1.0, w)
}

/// Backward Euler with the product `(1 + θ)(1 + η)` in place of the matrix `1 + θ + η`. Full
/// damping is solved first, under the assumption that the springs pull as in the previous step;
/// then the spring is solved. The spectral radius is at most 1 for all `θ` and `η`.
///
/// ```
/// use drape_oracle::recurrence::{backward_euler, factored_backward_euler};
/// assert_eq!(factored_backward_euler(1.0, 0.0), backward_euler(1.0, 0.0));
/// assert_eq!(factored_backward_euler(0.0, 0.5), backward_euler(0.0, 0.5));
/// ```
#[doc(alias = "Douglas 1962")]
pub fn factored_backward_euler(theta: f64, eta: f64) -> Amplification {
    let pivot = 1.0 / ((1.0 + theta) * (1.0 + eta));
    Matrix2::new(1.0 - theta * pivot, pivot, -theta * pivot, pivot)
}

/// As [`factored_backward_euler`], with two-step backward differentiation at the step ratio
/// `ω = h_n/h_{n−1}`.
///
/// With `τ = (1 + ω)/(1 + 2ω)`, `θ_τ = τ²θ`, `η_τ = τη` and the bases `x*`, `w*` of the formula the
/// way of a step is `q = (τ w* − θ_τ x* − η_τ θ_τ (x* − x_n))/((1 + θ_τ)(1 + η_τ))`.
///
/// ```
/// use drape_oracle::recurrence::{bdf, factored_bdf2};
/// let (found, exact) = (factored_bdf2(1.0, 2.0, 0.0), bdf(2, 2.0, 0.0));
/// let pairs = found.blocks().iter().zip(exact.blocks());
/// assert!(pairs.into_iter().all(|(a, b)| (a - b).norm() < 1e-15));
/// ```
pub fn factored_bdf2(omega: f64, theta: f64, eta: f64) -> Recurrence {
    let sum = 1.0 + 2.0 * omega;
    let (present, past) = ((1.0 + omega) * (1.0 + omega) / sum, -omega * omega / sum);
    let tau = (1.0 + omega) / sum;
    let (theta, eta) = (tau * tau * theta, tau * eta);
    let pivot = 1.0 / ((1.0 + theta) * (1.0 + eta));
    let block = |weight: f64, is_present: bool| {
        let newest = if is_present { 1.0 } else { 0.0 };
        let from_x = -theta * (weight + eta * (weight - newest)) * pivot;
        let from_w = tau * weight * pivot;
        Matrix2::new(weight + from_x, from_w, from_x / tau, from_w / tau)
    };
    vec![block(present, true), block(past, false)].into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recurrence::spectral_radius;
    use nalgebra::Vector2;

    /// Step by step as the words say: damping on `w + s` with `s = −θ x`, then the spring.
    #[test]
    fn matrices_are_what_the_words_say() {
        for (theta, eta) in [(0.3, 0.1), (5.0, 2.0), (100.0, 0.0), (0.0, 7.0)] {
            let (x, w): (f64, f64) = (0.3, -0.8);
            let step = |pending: f64| {
                let damped = w - eta / (1.0 + eta) * (w + pending);
                let way = (damped - theta * x) / (1.0 + theta);
                Vector2::new(x + way, way)
            };
            let y = Vector2::new(x, w);
            assert!((factored_start(theta, eta) * y - step(0.0)).norm() < 1e-15);
            assert!((factored_backward_euler(theta, eta) * y - step(-theta * x)).norm() < 1e-15);
            let (x_old, w_old) = (0.4, 0.2);
            let (base, tau) = ((4.0 * x - x_old) / 3.0, 2.0 / 3.0);
            let (theta_tau, eta_tau) = (tau * tau * theta, tau * eta);
            let free = tau * (4.0 * w - w_old) / 3.0;
            let damped = free - eta_tau / (1.0 + eta_tau) * (free - theta_tau * x);
            let way = (damped - theta_tau * base) / (1.0 + theta_tau);
            let found = factored_bdf2(1.0, theta, eta).next(&[y, Vector2::new(x_old, w_old)]);
            assert!((found - Vector2::new(base + way, way / tau)).norm() < 1e-14);
        }
    }

    #[test]
    fn motion_never_grows() {
        let powers = || (-12..=16).map(|power| 10.0_f64.powf(0.5 * f64::from(power)));
        for (theta, eta) in powers().flat_map(|t| powers().map(move |e| (t, e))) {
            let first = spectral_radius(&factored_backward_euler(theta, eta));
            let second = factored_bdf2(1.0, theta, eta).spectral_radius();
            assert!(first.max(second) < 1.0 + 1e-9, "{theta} {eta}: {first}, {second}");
        }
    }
}
