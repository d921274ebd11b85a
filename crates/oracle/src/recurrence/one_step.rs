//! One-step methods, each as a matrix.

use nalgebra::Matrix2;

/// Amplification matrix on `(x, w)`, `w = hv`.
pub type Amplification = Matrix2<f64>;

/// Explicit Euler: `[[1, 1], [−θ, 1−η]]`.
pub fn explicit_euler(theta: f64, eta: f64) -> Amplification {
    Matrix2::new(1.0, 1.0, -theta, 1.0 - eta)
}

/// Symplectic Euler with the damping at the old velocity: `[[1−θ, 1−η], [−θ, 1−η]]`.
pub fn symplectic_euler(theta: f64, eta: f64) -> Amplification {
    Matrix2::new(1.0 - theta, 1.0 - eta, -theta, 1.0 - eta)
}

/// Symplectic Euler with the damping at the new velocity:
/// `[[1−θ/(1+η), 1/(1+η)], [−θ/(1+η), 1/(1+η)]]`.
pub fn symplectic_euler_implicit_damping(theta: f64, eta: f64) -> Amplification {
    imex_euler(0.0, theta, eta)
}

/// Leapfrog (velocity Verlet) with Crank–Nicolson damping, which is Newmark's method with `β = 0`,
/// `γ = ½`: half a kick, the drift, half a kick that takes the damping at the new velocity,
///
/// ```text
/// w½ = w − ½ (θ x + η w)      x' = x + w½      w' = (w½ − ½ θ x') / (1 + ½ η)
/// ```
///
/// The trace is `(2 − θ)/(1 + ½η)`, the determinant `(1 − ½η)/(1 + ½η)`. For every `η ≥ 0` the
/// method is stable if and only if `θ < 4`. At `θ = 4` one eigenvalue is −1, and a double one
/// without damping.
pub fn leapfrog(theta: f64, eta: f64) -> Amplification {
    let first = Matrix2::new(1.0, 0.0, -0.5 * theta, 1.0 - 0.5 * eta);
    let drift = Matrix2::new(1.0, 1.0, 0.0, 1.0);
    let d = 1.0 + 0.5 * eta;
    let second = Matrix2::new(1.0, 0.0, -0.5 * theta / d, 1.0 / d);
    second * drift * first
}

/// Backward Euler: `[[1+η, 1], [−θ, 1]] / (1+θ+η)`.
///
/// ```
/// use drape_oracle::recurrence::{backward_euler, spectral_radius};
/// assert!((spectral_radius(&backward_euler(1.0, 0.0)) - 0.5_f64.sqrt()).abs() < 1e-15);
/// ```
pub fn backward_euler(theta: f64, eta: f64) -> Amplification {
    Matrix2::new(1.0 + eta, 1.0, -theta, 1.0) / (1.0 + theta + eta)
}

/// Implicit midpoint, on a linear equation also the trapezoidal rule and Newmark's method with
/// `β = ¼`, `γ = ½`: `(I − ½J)⁻¹ (I + ½J)`, `J = [[0, 1], [−θ, −η]]`.
///
/// With `D = 1 + ½η + ¼θ`: `[[1 + ½η − ¼θ, 1], [−θ, 1 − ½η − ¼θ]] / D`.
pub fn implicit_midpoint(theta: f64, eta: f64) -> Amplification {
    let (quarter, half) = (0.25 * theta, 0.5 * eta);
    Matrix2::new(1.0 + half - quarter, 1.0, -theta, 1.0 - half - quarter) / (1.0 + half + quarter)
}

/// IMEX Euler on `x'' = −(κ_I + κ_E)x − δx'` with `κ_I` and `δ` implicit and `κ_E` explicit:
/// `[[1−(θ_I+θ_E)/D, 1/D], [−(θ_I+θ_E)/D, 1/D]]`, `D = 1 + θ_I + η`. With `θ_E = 0` it is backward
/// Euler.
pub fn imex_euler(theta_implicit: f64, theta_explicit: f64, eta: f64) -> Amplification {
    let d = 1.0 + theta_implicit + eta;
    let pull = (theta_implicit + theta_explicit) / d;
    Matrix2::new(1.0 - pull, 1.0 / d, -pull, 1.0 / d)
}

/// Semi-implicit step of Terzopoulos and Fleischer: secant stiffness at the new level, damping half
/// at each, `(M + h²K + ½hL_c) v' = (M − ½hL_c) v − hKx`, `x' = x + hv'`.
///
/// With `D = 1 + θ + ½η`: `w' = ((1 − ½η)w − θx)/D`, `x' = x + w'`.
pub fn terzopoulos_fleischer(theta: f64, eta: f64) -> Amplification {
    let d = 1.0 + theta + 0.5 * eta;
    let (pull, keep) = (theta / d, (1.0 - 0.5 * eta) / d);
    Matrix2::new(1.0 - pull, keep, -pull, keep)
}

/// Predictor of Desbrun, Schröder and Barr with the damping of the scene in the filter matrix:
/// [`backward_euler`], as long as no external force acts (the filter does not affect external
/// forces).
pub fn desbrun(theta: f64, eta: f64) -> Amplification {
    backward_euler(theta, eta)
}

/// Kang's step on a mode in which a Jacobi sweep multiplies the error by `jacobi = γ`:
/// `Δw = −φ (θx + (θ+η)w)/(1+θ+η)`, `x' = x + w'`.
///
/// The exact `Δw` solves `(M + h²L_k + hL_c) Δv = h (F(x) − hL_k v − L_c v)`. The predictor
/// `Δv* = hF̃/D`, with the diagonal `D` of the matrix, is a Jacobi sweep from zero. Each correction
/// by the neighbours is another sweep. After `sweeps` corrections the step has made the fraction
/// `φ = 1 − γ^{sweeps+1}` of the exact change. Kang's formula has one correction.
///
/// The formula assumes equal entries of `D` for all particles. If `γ < 0`, an even number of
/// corrections overshoots (`φ > 1`): the mode is unstable once `φ (3θ + 2η) > 4 (1 + θ + η)`.
/// Meshes with structural springs only join black to white fields of a chequerboard. At high
/// stiffness they have modes with `γ → −1`; for these an odd number of corrections is stable too.
pub fn kang_mode(theta: f64, eta: f64, jacobi: f64, sweeps: u32) -> Amplification {
    let share = (1.0 - power(jacobi, sweeps)) / (1.0 + theta + eta);
    let (pull, brake) = (share * theta, share * (theta + eta));
    Matrix2::new(1.0 - pull, 1.0 - brake, -pull, 1.0 - brake)
}

/// `γ^{sweeps+1}`.
pub(crate) fn power(jacobi: f64, sweeps: u32) -> f64 {
    (0..sweeps).fold(jacobi, |power, _| power * jacobi)
}

/// Jacobi eigenvalue of the relative motion of two equal free particles: `−(s+d)/(1+s+d)`,
/// `s = h²k/m`, `d = hc/m`.
pub(crate) fn jacobi_of_pair(s: f64, d: f64) -> f64 {
    -(s + d) / (1.0 + s + d)
}

/// Kang's step on the relative motion of two equal free particles, `s = h²k/m`, `d = hc/m`, after
/// `sweeps` corrections: [`kang_mode`] with `θ = 2s`, `η = 2d`, `γ = −(s+d)/(1+s+d)`.
///
/// Kang's formula (`sweeps = 1`) without damping: `[[1−q, 1−q], [−q, 1−q]]`, `q = θ/(1+s)²`. The
/// predictor alone (`sweeps = 0`) is unstable for `s > 2`.
pub fn kang_pair(s: f64, d: f64, sweeps: u32) -> Amplification {
    kang_mode(2.0 * s, 2.0 * d, jacobi_of_pair(s, d), sweeps)
}

/// Kang's step on a particle whose only neighbour is pinned. Its matrix is diagonal, so the
/// predictor is exact and corrections change nothing: [`kang_mode`] with `γ = 0` is
/// [`backward_euler`].
pub fn kang_anchored(theta: f64, eta: f64, sweeps: u32) -> Amplification {
    kang_mode(theta, eta, 0.0, sweeps)
}

/// Largest modulus of the two eigenvalues: the factor by which a step multiplies the oscillation in
/// the long run.
pub fn spectral_radius(a: &Amplification) -> f64 {
    let (half_trace, determinant) = (0.5 * a.trace(), a.determinant());
    let discriminant = half_trace * half_trace - determinant;
    if discriminant < 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

#[cfg(test)]
mod tests;
