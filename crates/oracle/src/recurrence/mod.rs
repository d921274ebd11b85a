//! One step of each method on the oscillator `x'' = −κx − δx'`, as matrices.
//!
//! A one-step method of step size `h` maps `(x, w = hv)` to `A (x, w)` with a matrix that depends
//! on `θ = h²κ` and `η = hδ` only. A `k`-step method has one such matrix for each of `k` earlier
//! levels ([`Recurrence`]). A method that does not reproduce its matrices to round-off is
//! implemented incorrectly.
//!
//! On springs of rest length 0 each eigenmode of the graph Laplacian is such an oscillator. With a
//! rest length above 0, so is the motion along an anchored spring, offset by that length. Small
//! motion across a spring of length `L` is an oscillator with `θ (1 − ℓ/L)`; implicit-explicit
//! methods take `θ` implicitly and `−θ ℓ/L` explicitly.

mod dirk;
mod exponential;
mod factored;
mod generalized_alpha;
mod imex_rk;
mod multistep;
mod one_step;
mod projective;
mod rkc;
mod rosenbrock;
mod splitting;
mod vbd;
mod xpbd;

pub use dirk::RungeKutta;
pub use exponential::exact_oscillator;
pub use factored::{factored_backward_euler, factored_bdf2, factored_start};
pub use generalized_alpha::GeneralizedAlpha;
pub use imex_rk::{AdditiveTableau, additive_runge_kutta};
pub use multistep::{Multistep, Recurrence, adams_bashforth, bdf};
pub use one_step::{
    Amplification, backward_euler, desbrun, explicit_euler, imex_euler, implicit_midpoint,
    kang_anchored, kang_mode, kang_pair, leapfrog, spectral_radius, symplectic_euler,
    symplectic_euler_implicit_damping, terzopoulos_fleischer,
};
pub(crate) use one_step::{jacobi_of_pair, power};
pub use projective::{chebyshev_left, projective, projective_rate};
pub use rkc::{rkc2, rkc2_polynomial};
pub use rosenbrock::{RosenbrockTableau, rosenbrock};
pub use splitting::{drift, impulse, kick, leapfrog_explicit_damping, splitting, srkn4};
pub use vbd::vbd_pair;
pub use xpbd::{divided, xpbd};

#[cfg(test)]
mod tests;
