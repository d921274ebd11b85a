//! Additive Runge–Kutta methods.

use super::Amplification;
use nalgebra::Matrix2;

/// The two tableaux of an additive Runge–Kutta method of up to `S` stages: an explicit and a
/// diagonally implicit tableau on the same stages. Unused stages have rows and weights of zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdditiveTableau<const S: usize> {
    /// `a^E`, strictly lower triangular.
    pub explicit: [[f64; S]; S],
    /// `a^I`, lower triangular.
    pub implicit: [[f64; S]; S],
    /// `b^E`.
    pub explicit_weights: [f64; S],
    /// `b^I`.
    pub implicit_weights: [f64; S],
}

/// Additive Runge–Kutta method on `x'' = −(κ_I + κ_E)x − δx'` with `κ_I` and `δ` implicit and `κ_E`
/// explicit. With `G = [[0, 1], [−θ_I, −η]]` and `E = [[0, 0], [−θ_E, 0]]`
///
/// ```text
/// Y_i = I + Σ_{j≤i} a^I_ij G Y_j + Σ_{j<i} a^E_ij E Y_j      R = I + Σ_i (b^I_i G + b^E_i E) Y_i
/// ```
///
/// Motion across a spring at its rest length has `θ_E = −θ_I`. Then `R = [[1, c], [0, g]]`: a step
/// keeps the fraction `g` of the velocity and moves by `c h v`.
///
/// ```
/// use drape_oracle::recurrence::{AdditiveTableau, additive_runge_kutta, imex_euler};
/// let euler = AdditiveTableau {
///     explicit: [[0.0, 0.0], [1.0, 0.0]],
///     implicit: [[0.0, 0.0], [0.0, 1.0]],
///     explicit_weights: [1.0, 0.0],
///     implicit_weights: [0.0, 1.0],
/// };
/// let off = additive_runge_kutta(&euler, 3.0, 0.5, 0.25) - imex_euler(3.0, 0.5, 0.25);
/// assert!(off.norm() < 1e-15);
/// ```
#[doc(alias = "IMEX Runge-Kutta")]
pub fn additive_runge_kutta<const S: usize>(
    tableau: &AdditiveTableau<S>,
    theta_implicit: f64,
    theta_explicit: f64,
    eta: f64,
) -> Amplification {
    let one = Amplification::identity();
    let g = Matrix2::new(0.0, 1.0, -theta_implicit, -eta);
    let e = Matrix2::new(0.0, 0.0, -theta_explicit, 0.0);
    let mut stages = [one; S];
    for i in 0..S {
        let mut known = one;
        for (j, earlier) in stages[..i].iter().enumerate() {
            known += (g * tableau.implicit[i][j] + e * tableau.explicit[i][j]) * earlier;
        }
        stages[i] = resolvent(tableau.implicit[i][i], theta_implicit, eta) * known;
    }
    let mut end = one;
    for (i, stage) in stages.iter().enumerate() {
        end += (g * tableau.implicit_weights[i] + e * tableau.explicit_weights[i]) * stage;
    }
    end
}

/// `(I − γJ)⁻¹` with `J = [[0, 1], [−θ, −η]]`.
pub(super) fn resolvent(gamma: f64, theta: f64, eta: f64) -> Amplification {
    let (square, brake) = (gamma * gamma * theta, gamma * eta);
    Matrix2::new(1.0 + brake, gamma, -gamma * theta, 1.0) / (1.0 + brake + square)
}
