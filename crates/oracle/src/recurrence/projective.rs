//! Projective dynamics: backward Euler, minimised by iterations with a constant matrix.
//!
//! Across a spring the force is `−κ_I x − κ_E x` with `κ_E = −κ_I ℓ/L`: the matrix holds `κ_I`
//! alone. The velocity starts at the inertial velocity `w` and converges to the velocity `w*` of
//! backward Euler. A plain iteration multiplies the distance to `w*` by
//!
//! ```text
//! q = −θ_E/(1 + θ_I + η)
//! ```
//!
//! An iteration with memory multiplies it by a polynomial in `q`.

use super::Amplification;
use nalgebra::Matrix2;

/// The rate `q`: the fraction of the distance to backward Euler that a plain iteration leaves.
pub fn projective_rate(theta_implicit: f64, theta_explicit: f64, eta: f64) -> f64 {
    -theta_explicit / (1.0 + theta_implicit + eta)
}

/// The fraction of the distance to backward Euler that `iterations` iterations of Chebyshev's
/// semi-iterative method leave. A plain iteration leaves `rate`; the first `delay` iterations, and
/// at least one, are plain (Wang 2015).
///
/// ```
/// use drape_oracle::recurrence::chebyshev_left;
/// assert_eq!(chebyshev_left(0.5, 0.9, 10, 10), 0.5_f64.powi(10));
/// assert!(chebyshev_left(0.9, 0.9, 1, 20) < 0.9_f64.powi(40));
/// ```
pub fn chebyshev_left(rate: f64, rho: f64, delay: u32, iterations: u32) -> f64 {
    let (mut before, mut left, mut omega) = (1.0, 1.0, 1.0);
    for k in 0..iterations {
        omega = match k {
            k if k < delay => 1.0,
            k if k == delay => 2.0 / (2.0 - rho * rho),
            _ => 4.0 / (4.0 - rho * rho * omega),
        };
        let next = omega * (rate * left - before) + before;
        (before, left) = (left, next);
    }
    left
}

/// Projective dynamics that leaves the fraction `left` of the distance between the inertial
/// velocity and the velocity of backward Euler: `w' = w* + left (w − w*)`, `x' = x + w'`,
/// `w* = (w − θx)/(1 + θ + η)`, `θ = θ_I + θ_E`. With `left = 0` it is backward Euler, with 1 no
/// force acts.
///
/// ```
/// use drape_oracle::recurrence::{backward_euler, projective};
/// assert!((projective(1.0, 0.25, 0.0) - backward_euler(1.0, 0.25)).norm() < 1e-15);
/// ```
pub fn projective(theta: f64, eta: f64, left: f64) -> Amplification {
    let d = 1.0 + theta + eta;
    let (pull, keep) = (-theta / d * (1.0 - left), 1.0 / d * (1.0 - left) + left);
    Matrix2::new(1.0 + pull, keep, pull, keep)
}
