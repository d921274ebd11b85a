//! Methods of kicks and drifts, each as a product of matrices on `(x, w)`, `w = hv`.

use super::Amplification;
use nalgebra::Matrix2;

/// A kick `w' = w − c (θ x + η w)` over the fraction `c` of a step, at fixed `x`. The exact
/// solution `w' = e^{−y} w − c θ x (1 − e^{−y})/y`, `y = cη`, is truncated after `terms` terms of
/// its series: one term is Euler's method, two terms are Heun's.
pub fn kick(share: f64, theta: f64, eta: f64, terms: u32) -> Amplification {
    let (mut keep, mut push, mut power) = (1.0, 0.0, 1.0); // power = (−y)^{q−1}/(q−1)!
    for q in 1..=terms {
        push += power / f64::from(q);
        power *= -share * eta / f64::from(q);
        keep += power;
    }
    Matrix2::new(1.0, 0.0, -share * theta * push, keep)
}

/// A drift `x' = x + c w` over the fraction `c` of a step.
pub fn drift(share: f64) -> Amplification {
    Matrix2::new(1.0, share, 0.0, 1.0)
}

/// Alternating kicks and drifts that begin and end with a kick. The series of the kicks has `terms`
/// terms.
///
/// ```
/// use drape_oracle::recurrence::{leapfrog, splitting};
/// assert_eq!(splitting(&[0.5, 0.5], &[1.0], 3.0, 0.0, 1), leapfrog(3.0, 0.0));
/// ```
pub fn splitting(kicks: &[f64], drifts: &[f64], theta: f64, eta: f64, terms: u32) -> Amplification {
    let start = kick(kicks[0], theta, eta, terms);
    let pairs = kicks[1..].iter().zip(drifts);
    pairs.fold(start, |step, (c, d)| kick(*c, theta, eta, terms) * drift(*d) * step)
}

/// Leapfrog with the damping in its half kicks by Heun's method.
///
/// With `p = 1 − y + ½y²`, `y = ½η`, and `s = ½θ (1 − ½y)` the trace is `1 − s − sp + p²` and the
/// determinant `p²`. It is stable if and only if `s (1 + p) < 2 (1 + p²)` and `η < 4`.
pub fn leapfrog_explicit_damping(theta: f64, eta: f64) -> Amplification {
    splitting(&[0.5, 0.5], &[1.0], theta, eta, 2)
}

/// Kicks `b₁, b₂, b₃, b₄` and drifts `a₁, a₂, a₃` of the symmetric method of order 4 with six
/// stages of Blanes and Moan (2002), "SRKN₆ᵇ".
const BLANES_MOAN: ([f64; 3], [f64; 2]) = (
    [0.082_984_406_417_405_2, 0.396_309_801_498_368, -0.039_056_304_922_348_6],
    [0.245_298_957_184_271, 0.604_872_665_711_080],
);

/// The symplectic Runge–Kutta–Nyström method of order 4 of Blanes and Moan. The series of the
/// damped kicks has `terms` terms.
pub fn srkn4(theta: f64, eta: f64, terms: u32) -> Amplification {
    let ([b1, b2, b3], [a1, a2]) = BLANES_MOAN;
    let (b4, a3) = (1.0 - 2.0 * (b1 + b2 + b3), 0.5 - a1 - a2);
    let (kicks, drifts) = ([b1, b2, b3, b4, b3, b2, b1], [a1, a2, a3, a3, a2, a1]);
    splitting(&kicks, &drifts, theta, eta, terms)
}

/// The impulse method (r-RESPA) on `x'' = −(κ_F + κ_S) x − δx'`: half a kick by the slow stiffness,
/// `ratio` steps of leapfrog with explicit damping by the fast one, half a kick.
pub fn impulse(theta_fast: f64, theta_slow: f64, eta: f64, ratio: u32) -> Amplification {
    let n = f64::from(ratio);
    // A fast step sees w = (h/n) v.
    let inner = leapfrog_explicit_damping(theta_fast / (n * n), eta / n);
    let scaled = Matrix2::new(inner.m11, inner.m12 / n, inner.m21 * n, inner.m22);
    let half = kick(0.5, theta_slow, 0.0, 1);
    half * (0..ratio).fold(half, |step, _| scaled * step)
}

#[cfg(test)]
mod tests;
