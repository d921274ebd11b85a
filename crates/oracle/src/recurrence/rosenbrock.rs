//! Rosenbrock methods.

use super::Amplification;
use super::imex_rk::resolvent;
use nalgebra::Matrix2;

/// The coefficients of a Rosenbrock method of up to `S` stages, in the notation of Hairer and
/// Wanner. Unused stages have rows and weights of zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RosenbrockTableau<const S: usize> {
    /// `α`, strictly lower triangular.
    pub alpha: [[f64; S]; S],
    /// `Γ`, lower triangular with equal numbers on the diagonal.
    pub gamma: [[f64; S]; S],
    /// `b`.
    pub weights: [f64; S],
}

/// Rosenbrock method on the oscillator with `(θ, η)`, whose matrix holds the Jacobian of
/// `(θ_A, η_A)`. With `J = [[0, 1], [−θ, −η]]` and `A` likewise
///
/// ```text
/// k_i = J (y + Σ_{j<i} α_ij k_j) + A Σ_{j≤i} γ_ij k_j          y' = y + Σ_i b_i k_i
/// ```
///
/// With the exact Jacobian, `A = J`, it is the Runge–Kutta method of the tableau `α + Γ`. One stage
/// with `γ = b = 1` is [`backward_euler`](super::backward_euler), as Baraff and Witkin take it.
///
/// ```
/// use drape_oracle::recurrence::{RosenbrockTableau, backward_euler, rosenbrock};
/// let euler = RosenbrockTableau { alpha: [[0.0]], gamma: [[1.0]], weights: [1.0] };
/// let off = rosenbrock(&euler, (3.0, 0.5), (3.0, 0.5)) - backward_euler(3.0, 0.5);
/// assert!(off.norm() < 1e-15);
/// ```
pub fn rosenbrock<const S: usize>(
    tableau: &RosenbrockTableau<S>,
    (theta, eta): (f64, f64),
    (theta_in_matrix, eta_in_matrix): (f64, f64),
) -> Amplification {
    let one = Amplification::identity();
    let jacobian = Matrix2::new(0.0, 1.0, -theta, -eta);
    let matrix = Matrix2::new(0.0, 1.0, -theta_in_matrix, -eta_in_matrix);
    let mut increments = [Amplification::zeros(); S];
    for i in 0..S {
        let mut known = jacobian;
        for (j, earlier) in increments[..i].iter().enumerate() {
            known += (jacobian * tableau.alpha[i][j] + matrix * tableau.gamma[i][j]) * earlier;
        }
        increments[i] = resolvent(tableau.gamma[i][i], theta_in_matrix, eta_in_matrix) * known;
    }
    let ends = increments.iter().zip(&tableau.weights);
    ends.fold(one, |sum, (increment, weight)| sum + increment * *weight)
}
