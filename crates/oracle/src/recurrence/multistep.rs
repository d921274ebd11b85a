//! Linear multistep methods, implicit-explicit or not.

use nalgebra::linalg::{Schur, balancing::balance_parlett_reinsch};
use nalgebra::{Complex, DMatrix, Matrix2, Vector2};

use super::one_step::Amplification;

/// A linear recurrence of `k` steps, `y_{n+1} = Σ_j B_j y_{n−j}` on `y = (x, w)`.
///
/// All levels have `w = hv` with the size `h` of the present step. If the step size changes, keep
/// `(x, v)` and form `w` anew for each step.
///
/// ```
/// use drape_oracle::recurrence::{Recurrence, backward_euler, bdf};
/// use nalgebra::Vector2;
/// let start = Vector2::new(1.0, 0.0);
/// let first = Recurrence::from(backward_euler(1.0, 0.0)).next(&[start]);
/// let second = bdf(2, 1.0, 0.0).next(&[first, start]);
/// assert!((second - Vector2::new(-1.0, -8.0) / 13.0).norm() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Recurrence {
    blocks: Vec<Matrix2<f64>>,
}

impl From<Amplification> for Recurrence {
    fn from(matrix: Amplification) -> Self {
        Self { blocks: vec![matrix] }
    }
}

/// From the blocks, of the newest level first.
impl From<Vec<Amplification>> for Recurrence {
    fn from(blocks: Vec<Amplification>) -> Self {
        Self { blocks }
    }
}

impl Recurrence {
    /// The blocks `B_0, B_1, …`, which apply to the newest level, the one before it, …
    pub fn blocks(&self) -> &[Matrix2<f64>] {
        &self.blocks
    }

    /// The new level, computed from at least as many levels as there are blocks, newest first.
    pub fn next(&self, history: &[Vector2<f64>]) -> Vector2<f64> {
        let terms = self.blocks.iter().enumerate().map(|(j, block)| block * history[j]);
        terms.fold(Vector2::zeros(), |sum, term| sum + term)
    }

    /// The matrix that maps `(y_n, …, y_{n−k+1})` to `(y_{n+1}, …, y_{n−k+2})`, 2k × 2k.
    pub fn companion(&self) -> DMatrix<f64> {
        let size = 2 * self.blocks.len();
        let mut companion = DMatrix::zeros(size, size);
        for (j, block) in self.blocks.iter().enumerate() {
            companion.fixed_view_mut::<2, 2>(0, 2 * j).copy_from(block);
        }
        for i in 2..size {
            companion[(i, i - 2)] = 1.0;
        }
        companion
    }

    /// Eigenvalues of the [companion matrix](Self::companion). A `p`-fold eigenvalue is known to
    /// `ε^{1/p}` only. `None` if an entry is not finite or the QR iteration does not converge.
    pub fn eigenvalues(&self) -> Option<Vec<Complex<f64>>> {
        const MAX_ITERATIONS: usize = 10_000;
        let mut companion = self.companion();
        if !companion.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        balance_parlett_reinsch(&mut companion);
        let schur = Schur::try_new(companion, f64::EPSILON, MAX_ITERATIONS)?;
        Some(schur.complex_eigenvalues().iter().copied().collect())
    }

    /// Largest modulus of the eigenvalues: the factor by which a step multiplies the motion in the
    /// long run. It is NaN if there are [no eigenvalues](Self::eigenvalues).
    pub fn spectral_radius(&self) -> f64 {
        let moduli = self.eigenvalues().map(|all| all.into_iter().map(|z| z.norm()));
        moduli.map_or(f64::NAN, |moduli| moduli.fold(0.0, f64::max))
    }
}

/// Coefficients of a linear multistep method for `y' = f + g`, EEH (7):
///
/// ```text
/// Σ_{j=0}^k a_j y_{n+1−j} = h Σ_{j=1}^k c_j f_{n+1−j} + h Σ_{j=0}^k b_j g_{n+1−j}
/// ```
///
/// The newest level has index 0 (in the paper it has index `k`). The implicit part `g` is `x' = v`,
/// springs and damping; the explicit part `f` is the remainder of the forces. An explicit method
/// has `b = c`, so that its parts do not differ; a fully implicit one has `f = 0`.
#[derive(Clone, Debug, PartialEq)]
#[doc(alias = "EEH 7")]
pub struct Multistep {
    /// Coefficients of the levels.
    pub a: Vec<f64>,
    /// Coefficients of the implicit part, as many as `a`.
    pub b: Vec<f64>,
    /// Coefficients of the explicit part, as many as `a`; the first is 0.
    pub c: Vec<f64>,
}

/// Times of `n+1, n, n−1, …` in units of the present step, counted from level `n`.
fn times(earlier: &[f64]) -> Vec<f64> {
    let mut times = vec![1.0, 0.0];
    for step in earlier {
        times.push(times[times.len() - 1] - step);
    }
    times
}

/// Coefficients, constant first, of the polynomial that is 1 at node `j` and 0 at the others.
fn lagrange(nodes: &[f64], j: usize) -> Vec<f64> {
    let mut polynomial = vec![1.0];
    for (i, node) in nodes.iter().enumerate().filter(|(i, _)| *i != j) {
        let scale = nodes[j] - nodes[i];
        polynomial.push(0.0);
        for power in (0..polynomial.len()).rev() {
            let below = if power == 0 { 0.0 } else { polynomial[power - 1] };
            polynomial[power] = (below - node * polynomial[power]) / scale;
        }
    }
    polynomial
}

/// `Σ_q p_q weight(q)`: a linear functional of a polynomial, given on the powers of `t`.
fn apply(polynomial: &[f64], weight: impl Fn(f64) -> f64) -> f64 {
    polynomial.iter().enumerate().map(|(q, p)| p * weight(q as f64)).sum()
}

impl Multistep {
    /// Adams–Bashforth, EEH (2): the integral over the step of the polynomial through the last `k`
    /// values. `earlier` has the sizes of the `k − 1` steps before this one in units of this one,
    /// newest first: 1 at a constant step size.
    ///
    /// ```
    /// use drape_oracle::recurrence::Multistep;
    /// assert_eq!(Multistep::adams_bashforth(&[1.0]).b, [0.0, 1.5, -0.5]);
    /// ```
    #[doc(alias = "EEH 2")]
    pub fn adams_bashforth(earlier: &[f64]) -> Self {
        let times = times(earlier);
        let old = &times[1..];
        // ∫_0^1 t^q dt = 1/(q + 1).
        let weights = (0..old.len()).map(|j| apply(&lagrange(old, j), |q| 1.0 / (q + 1.0)));
        let b: Vec<f64> = std::iter::once(0.0).chain(weights).collect();
        let mut a = vec![0.0; b.len()];
        (a[0], a[1]) = (1.0, -1.0);
        Self { a, c: b.clone(), b }
    }

    /// Backward differentiation, EEH (3), with the explicit part extrapolated (SBDF): the
    /// polynomial through `k + 1` levels satisfies the equation at the new one. `earlier` as for
    /// [`adams_bashforth`](Self::adams_bashforth).
    ///
    /// ```
    /// use drape_oracle::recurrence::Multistep;
    /// let bdf2 = Multistep::bdf(&[1.0]);
    /// assert_eq!((bdf2.a, bdf2.b), (vec![1.5, -2.0, 0.5], vec![1.0, 0.0, 0.0]));
    /// ```
    #[doc(alias = "EEH 3")]
    pub fn bdf(earlier: &[f64]) -> Self {
        let times = times(earlier);
        let old = &times[1..];
        // At t = 1 every power of t is 1 and its derivative q.
        let a: Vec<f64> = (0..times.len()).map(|j| apply(&lagrange(&times, j), |q| q)).collect();
        let extrapolation = (0..old.len()).map(|j| apply(&lagrange(old, j), |_| 1.0));
        let c = std::iter::once(0.0).chain(extrapolation).collect();
        let mut b = vec![0.0; a.len()];
        b[0] = 1.0;
        Self { a, b, c }
    }

    /// IMEX Euler (19): backward and explicit Euler.
    #[doc(alias = "EEH 19")]
    pub fn imex_euler() -> Self {
        Self::bdf(&[])
    }

    /// SBDF2 at the step ratio `ω = h_n/h_{n−1}`: `a = ((1+2ω)/(1+ω), −(1+ω), ω²/(1+ω))`,
    /// `b = (1, 0, 0)`, `c = (1+ω, −ω)`. It forgets its start as long as `ω < 1 + √2`.
    ///
    /// Without damping and at `ω = 1` it is stable for
    /// `−θ_I ≤ θ_E ≤ min(θ_I (1 + θ_I), (16 + θ_I)/3)`. Beside a very stiff implicit part, a third
    /// of it may be explicit.
    pub fn sbdf2(omega: f64) -> Self {
        Self::bdf(&[1.0 / omega])
    }

    /// Crank–Nicolson with Adams–Bashforth of order 2 at the step ratio `ω`: `a = (1, −1, 0)`,
    /// `b = (½, ½, 0)`, `c = (1 + ½ω, −½ω)`.
    ///
    /// At `ω = 1` and without damping any `θ_E > 0` makes it unstable. With damping and large `θ_I`
    /// it is stable for about `θ_E < η`.
    pub fn cnab2(omega: f64) -> Self {
        Self { b: vec![0.5, 0.5, 0.0], ..Self::adams_bashforth(&[1.0 / omega]) }
    }

    /// Modified CNAB2 at the step ratio `ω`, which damps very stiff modes:
    /// `b = (8 + 1/ω, 7 − 1/ω, 1)/16`, the rest as in [`cnab2`](Self::cnab2).
    ///
    /// At `ω = 1` and `θ_I` from about 30 on, it is stable for `θ_E ≤ 8 + η + θ_I/8`.
    pub fn mcnab2(omega: f64) -> Self {
        // Order 2 leaves one weight free; the other two balance it about the middle of the step.
        let oldest = 1.0 / 16.0;
        let newest = 0.5 + oldest / omega;
        Self { b: vec![newest, 1.0 - newest - oldest, oldest], ..Self::cnab2(omega) }
    }

    /// Crank–Nicolson over two steps with leapfrog, at a constant step size: `a = (½, 0, −½)`,
    /// `b = (½, 0, ½)`, `c = (1, 0)`. Stable for `|θ_E| < θ_I`; without damping it damps nothing,
    /// parasitic oscillations included.
    pub fn cnlf() -> Self {
        Self { a: vec![0.5, 0.0, -0.5], b: vec![0.5, 0.0, 0.5], c: vec![0.0, 1.0, 0.0] }
    }

    /// The recurrence on `x'' = −(κ_I + κ_E)x − δx'` with `κ_I`, `δ` and `x' = v` in the implicit
    /// part and `κ_E` in the explicit one,
    ///
    /// ```text
    /// (a_0 I − b_0 J_I) y_{n+1} = Σ_{j≥1} (−a_j I + b_j J_I + c_j J_E) y_{n+1−j}
    /// J_I = [[0, 1], [−θ_I, −η]]      J_E = [[0, 0], [−θ_E, 0]]
    /// ```
    ///
    /// Its eigenvalues are the roots of `A² + ηAB + θ_I B² + θ_E BC = 0` with
    /// `A(ζ) = Σ a_j ζ^{k−j}`, `B` and `C` likewise.
    pub fn recurrence(&self, theta_implicit: f64, theta_explicit: f64, eta: f64) -> Recurrence {
        let implicit = Matrix2::new(0.0, 1.0, -theta_implicit, -eta);
        let explicit = Matrix2::new(0.0, 0.0, -theta_explicit, 0.0);
        let (a, b) = (self.a[0], self.b[0]);
        let adjugate = Matrix2::new(a + b * eta, b, -b * theta_implicit, a);
        let determinant = a * (a + b * eta) + b * b * theta_implicit;
        let block = |j: usize| {
            let level = Matrix2::identity() * -self.a[j];
            adjugate * (level + implicit * self.b[j] + explicit * self.c[j]) / determinant
        };
        Recurrence { blocks: (1..self.a.len()).map(block).collect() }
    }
}

/// Adams–Bashforth of order `k ≥ 1` at a constant step size: explicit Euler, AB2, AB3.
///
/// Its eigenvalues are the roots of `ρ² + ηρσ + θσ² = 0`, `ρ(ζ) = Σ a_j ζ^{k−j}`,
/// `σ(ζ) = Σ b_j ζ^{k−j}`. Without damping AB2 is unstable at every step size: it grows by `θ²/4`
/// per step if `θ` is small. AB3 is stable up to `θ = 144/275`.
pub fn adams_bashforth(k: usize, theta: f64, eta: f64) -> Recurrence {
    Multistep::adams_bashforth(&vec![1.0; k.saturating_sub(1)]).recurrence(theta, 0.0, eta)
}

/// Backward differentiation of order `k ≥ 1` at a constant step size: backward Euler, BDF2, BDF3.
///
/// Its eigenvalues are the roots of `ρ² + ηρσ + θσ² = 0`. Backward Euler and BDF2 are stable for
/// every `θ` and `η`; BDF3 without damping only for `θ ≥ 15/4`.
pub fn bdf(k: usize, theta: f64, eta: f64) -> Recurrence {
    Multistep::bdf(&vec![1.0; k.saturating_sub(1)]).recurrence(theta, 0.0, eta)
}

#[cfg(test)]
mod tests;
