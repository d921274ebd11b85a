//! The second-order Runge–Kutta–Chebyshev method on the oscillator.

use super::Amplification;
use nalgebra::{Complex, Matrix2};

/// Damping of the stability polynomial, `ε`.
const EPSILON: f64 = 2.0 / 13.0;

/// `w₀`, `w₁`, `a_s`, `b_s` of `P_s(z) = a_s + b_s T_s(w₀ + w₁ z)`.
fn shape(stages: u32) -> [f64; 4] {
    let s = f64::from(stages);
    let w0 = 1.0 + EPSILON / (s * s);
    // T_s, T_s' and T_s'' at w₀ > 1 by hyperbolic functions.
    let angle = w0.acosh();
    let (sinh, cosh, root) = ((s * angle).sinh(), (s * angle).cosh(), angle.sinh());
    let first = s * sinh / root;
    let second = (s * s * cosh - w0 * first) / (root * root);
    let b = second / (first * first);
    [w0, first / second, 1.0 - b * cosh, b]
}

/// The stability polynomial `P_s(z)` of RKC2 with `ε = 2/13` (Sommeijer, Shampine and Verwer 1998).
pub fn rkc2_polynomial(stages: u32, z: Complex<f64>) -> Complex<f64> {
    let [w0, w1, a, b] = shape(stages);
    let argument = z * w1 + w0;
    let (mut last, mut chebyshev) = (Complex::new(1.0, 0.0), argument);
    for _ in 1..stages {
        (last, chebyshev) = (chebyshev, argument * chebyshev * 2.0 - last);
    }
    chebyshev * b + a
}

/// RKC2 with this many stages on the oscillator: `P_s(J)`, `J = [[0, 1], [−θ, −η]]`.
pub fn rkc2(stages: u32, theta: f64, eta: f64) -> Amplification {
    let [w0, w1, a, b] = shape(stages);
    let one = Matrix2::identity();
    let argument = one * w0 + Matrix2::new(0.0, 1.0, -theta, -eta) * w1;
    let (mut last, mut chebyshev) = (one, argument);
    for _ in 1..stages {
        (last, chebyshev) = (chebyshev, argument * chebyshev * 2.0 - last);
    }
    one * a + chebyshev * b
}

#[cfg(test)]
mod tests;
