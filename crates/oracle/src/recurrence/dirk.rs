//! Runge–Kutta methods, each as a matrix.

use super::one_step::Amplification;
use nalgebra::{DMatrix, DVector};

/// Coefficients `a_ij`, `b_i` of a Runge–Kutta method for `y' = F(y)`:
///
/// ```text
/// Y_i = y_n + h Σ_j a_ij F(Y_j)          y_{n+1} = y_n + h Σ_i b_i F(Y_i)
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias = "Butcher tableau")]
pub struct RungeKutta {
    /// One row a stage; missing entries at its end are 0.
    pub a: Vec<Vec<f64>>,
    /// Weights of the stages.
    pub b: Vec<f64>,
}

/// `γ` of the L-stable methods of order 3 with three implicit stages: the root of
/// `γ³ − 3γ² + 3γ/2 − 1/6` between ⅓ and ½.
const THIRD: f64 = 0.435_866_521_508_459;

impl RungeKutta {
    /// Whose last row of `a` is `b`.
    fn stiffly_accurate(rows: &[&[f64]]) -> Self {
        let a: Vec<Vec<f64>> = rows.iter().map(|row| row.to_vec()).collect();
        let b = a.last().cloned().unwrap_or_default();
        Self { a, b }
    }

    /// Implicit midpoint: one stage, order 2.
    pub fn midpoint() -> Self {
        Self { a: vec![vec![0.5]], b: vec![1.0] }
    }

    /// TR-BDF2 with `γ = 2 − √2` as three stages, the first explicit; order 2 (Bank et al. 1985,
    /// Hosea and Shampine 1996).
    #[doc(alias = "Hosea-Shampine 1996")]
    pub fn tr_bdf2() -> Self {
        let (d, w) = (1.0 - 0.5_f64.sqrt(), 0.25 * 2.0_f64.sqrt());
        Self::stiffly_accurate(&[&[0.0], &[d, d], &[w, w, d]])
    }

    /// Alexander's method of two stages and order 2 (1977).
    #[doc(alias = "Alexander 1977")]
    pub fn sdirk2() -> Self {
        let gamma = 1.0 - 0.5_f64.sqrt();
        Self::stiffly_accurate(&[&[gamma], &[1.0 - gamma, gamma]])
    }

    /// Alexander's method of three stages and order 3 (1977).
    pub fn sdirk3() -> Self {
        let (g, g2) = (THIRD, THIRD * THIRD);
        Self::stiffly_accurate(&[
            &[g],
            &[0.5 * (1.0 - g), g],
            &[-1.5 * g2 + 4.0 * g - 0.25, 1.5 * g2 - 5.0 * g + 1.25, g],
        ])
    }

    /// Kværnø's method of four stages and order 3, the first stage explicit (2004).
    #[doc(alias = "Kvaerno 2004")]
    pub fn esdirk3() -> Self {
        // c = (0, 2γ, 1, 1); the third row has order 2, the fourth order 3.
        let g = THIRD;
        let third = [(-4.0 * g * g + 6.0 * g - 1.0) / (4.0 * g), (1.0 - 2.0 * g) / (4.0 * g), g];
        let fourth = [
            (6.0 * g - 1.0) / (12.0 * g),
            -1.0 / ((24.0 * g - 12.0) * g),
            (-6.0 * g * g + 6.0 * g - 1.0) / (6.0 * g - 3.0),
            g,
        ];
        Self::stiffly_accurate(&[&[0.0], &[g, g], &third, &fourth])
    }

    /// Method of five stages and order 4 (Hairer and Wanner, Solving ODEs II, table 6.5).
    #[doc(alias = "Hairer-Wanner")]
    pub fn sdirk4() -> Self {
        Self::stiffly_accurate(&[
            &[0.25],
            &[0.5, 0.25],
            &[17.0 / 50.0, -1.0 / 25.0, 0.25],
            &[371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0, 0.25],
            &[25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0, 0.25],
        ])
    }

    /// `a_ij` as a square matrix.
    pub fn matrix(&self) -> DMatrix<f64> {
        let s = self.b.len();
        DMatrix::from_fn(s, s, |i, j| self.a[i].get(j).copied().unwrap_or(0.0))
    }

    /// One step on the oscillator: `R(J) = I + (bᵀ ⊗ J) (I − A ⊗ J)⁻¹ (1 ⊗ I)` with
    /// `J = [[0, 1], [−θ, −η]]`. NaN where a stage has no solution.
    pub fn amplification(&self, theta: f64, eta: f64) -> Amplification {
        let j = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -theta, -eta]);
        let (a, s) = (self.matrix(), self.b.len());
        let system = DMatrix::identity(2 * s, 2 * s) - a.kronecker(&j);
        let ones = DVector::from_element(s, 1.0).kronecker(&DMatrix::identity(2, 2));
        let weights = DMatrix::from_row_slice(1, s, &self.b).kronecker(&j);
        let Some(stages) = system.lu().solve(&ones) else {
            return Amplification::repeat(f64::NAN);
        };
        let step = DMatrix::identity(2, 2) + weights * stages;
        Amplification::new(step[(0, 0)], step[(0, 1)], step[(1, 0)], step[(1, 1)])
    }
}

#[cfg(test)]
mod tests;
