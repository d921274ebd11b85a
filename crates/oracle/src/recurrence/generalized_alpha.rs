//! Newmark's method and its relatives, which carry an acceleration, as a matrix of three unknowns.

use nalgebra::{Complex, Matrix3, Vector3};

/// Coefficients of the generalized-α family on `M a = f`:
///
/// ```text
/// (1 − α_m) a_{n+1} + α_m a_n = (1 − α_f) M⁻¹f_{n+1} + α_f M⁻¹f_n
/// x_{n+1} = x_n + h v_n + h² ((½ − β) a_n + β a_{n+1})
/// v_{n+1} = v_n + h ((1 − γ) a_n + γ a_{n+1})
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralizedAlpha {
    /// `α_m`.
    pub alpha_m: f64,
    /// `α_f`.
    pub alpha_f: f64,
    /// `β`.
    pub beta: f64,
    /// `γ`.
    pub gamma: f64,
}

impl GeneralizedAlpha {
    /// Of order 2 with the least loss of slow motion at these `α`: `γ = ½ − α_m + α_f`,
    /// `β = ¼ (1 − α_m + α_f)²`.
    fn second_order(alpha_m: f64, alpha_f: f64) -> Self {
        let shift = alpha_f - alpha_m;
        Self { alpha_m, alpha_f, beta: 0.25 * (1.0 + shift) * (1.0 + shift), gamma: 0.5 + shift }
    }

    /// Chung and Hulbert (1993), whose spectral radius at infinite stiffness is `rho`.
    #[doc(alias = "Chung-Hulbert 1993")]
    pub fn chung_hulbert(rho: f64) -> Self {
        Self::second_order((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0))
    }

    /// Hilber, Hughes and Taylor (1977) with `α_f = alpha` from 0 to ⅓. The spectral radius at
    /// infinite stiffness is `(1 − α)/(1 + α)`.
    #[doc(alias = "HHT-alpha")]
    pub fn hht(alpha: f64) -> Self {
        Self::second_order(0.0, alpha)
    }

    /// Newmark (1959) with `γ = (3 − ρ)/(2 + 2ρ)` and `β = ¼ (γ + ½)²`, whose spectral radius at
    /// infinite stiffness is `rho`. It is the trapezoidal rule for `rho = 1`, else of order 1.
    #[doc(alias = "Newmark 1959")]
    pub fn newmark(rho: f64) -> Self {
        let gamma = (3.0 - rho) / (2.0 + 2.0 * rho);
        Self { alpha_m: 0.0, alpha_f: 0.0, beta: 0.25 * (gamma + 0.5) * (gamma + 0.5), gamma }
    }

    /// The matrix that one step applies to `(x, hv, h²a)` of the oscillator.
    pub fn matrix(&self, theta: f64, eta: f64) -> Matrix3<f64> {
        let Self { alpha_m, alpha_f, beta, gamma } = *self;
        let new = Matrix3::new(
            1.0,
            0.0,
            -beta,
            0.0,
            1.0,
            -gamma,
            (1.0 - alpha_f) * theta,
            (1.0 - alpha_f) * eta,
            1.0 - alpha_m,
        );
        let old = Matrix3::new(
            1.0,
            1.0,
            0.5 - beta,
            0.0,
            1.0,
            1.0 - gamma,
            -alpha_f * theta,
            -alpha_f * eta,
            -alpha_m,
        );
        new.lu().solve(&old).unwrap_or_else(|| Matrix3::repeat(f64::NAN))
    }

    /// `(x, hv, h²a)` with the consistent acceleration `a = −κx − δv`.
    pub fn start(x: f64, w: f64, theta: f64, eta: f64) -> Vector3<f64> {
        Vector3::new(x, w, -theta * x - eta * w)
    }

    /// Largest modulus of the eigenvalues of [`matrix`](Self::matrix). For `α_m = α_f = ½` one of
    /// them is −1 at every stiffness. It belongs to an inconsistent acceleration, which a
    /// consistent start does not excite, so it is left out.
    pub fn spectral_radius(&self, theta: f64, eta: f64) -> f64 {
        let matrix = self.matrix(theta, eta);
        if !matrix.iter().all(|entry| entry.is_finite()) {
            return f64::NAN;
        }
        // ζ³ − t ζ² + s ζ − d = 0.
        let (t, d) = (matrix.trace(), matrix.determinant());
        let s = 0.5 * (t * t - (matrix * matrix).trace());
        if self.alpha_m == 0.5 && self.alpha_f == 0.5 {
            // Divided by ζ + 1: ζ² − (t + 1) ζ − d.
            return largest_root(t + 1.0, -d);
        }
        let real = real_root(t, s, d);
        // Divided by ζ − r: ζ² − (t − r) ζ + s − r (t − r).
        let rest = largest_root(t - real, s - real * (t - real));
        rest.max(real.abs())
    }
}

/// Largest modulus of the roots of `ζ² − t ζ + d`.
fn largest_root(t: f64, d: f64) -> f64 {
    let half = 0.5 * t;
    let root = Complex::new(half * half - d, 0.0).sqrt();
    (root + half).norm().max((root - half).norm())
}

/// A real root of `ζ³ − t ζ² + s ζ − d` with `|ζ| ≤ 4`, by bisection; rational steps of a stable
/// method have no larger one.
fn real_root(t: f64, s: f64, d: f64) -> f64 {
    let value = |z: f64| ((z - t) * z + s) * z - d;
    let (mut low, mut high) = (-4.0, 4.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if value(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests;
