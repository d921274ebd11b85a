//! Implicit midpoint: second order, no numerical damping on linear springs, exact momentum and
//! angular momentum.
//!
//! builds-on: explicit Euler → backward Euler → **midpoint** → generalized-α, TR-BDF2
//!
//! # What it is
//!
//! Backward Euler takes the force at the end of the step and damps all motion. Implicit midpoint
//! takes the force in the middle. It costs the same, is second order, and damps nothing by itself.
//! Take it for cloth with damping of its own, where the step resolves the motion to be seen. Do not
//! take it for undamped cloth at large `h²k/m`: there it gains energy.
//!
//! # The mathematics
//!
//! It is the Gauss method of one stage. In cloth it was used by Volino and Magnenat-Thalmann
//! (2005). The unknown `w` is the velocity in the middle of the step:
//!
//! ```text
//! M (w − v_n) = h/2 f(x_n + h/2 w, w)                                                   (1)
//! x_{n+1} = x_n + h w          v_{n+1} = 2 w − v_n                                      (2)
//! ```
//!
//! (1) is a stage with `τ = h/2`, which [`drape_integrator::ImplicitStage`] solves. Newton starts
//! at the best of `v_n`, the inertial target, and `2 v_n − w` with the `w` of the last step.
//!
//! In contact the step is read as two halves. The obstacle acts on the first half, which gives `w`;
//! the second half takes the same forces without the impulse `λ` of the obstacle:
//!
//! ```text
//! n·w = n·(x_s − x_n)/h          v_{n+1} = 2 w − v_n − M⁻¹λ                             (3)
//! ```
//!
//! So `x_{n+1}` touches the surface, and an impact is not reversed. Without contact (3) is (2).
//!
//! * **Order and stability.** Order 2. On the oscillator `R(z) = (1 + z/2)/(1 − z/2)`: `|R| = 1`
//!   without damping, `R(∞) = −1`. A-stability is a statement about linear springs.
//! * **Conservation.** Momentum and angular momentum are exact for springs, up to the residual of
//!   the solve: round-off with a tight `residual` and `solver=cholesky`, its tolerance with the
//!   default solver. The method is symplectic. Energy is not conserved.
//! * **Damping.** Full damping is linear in the velocity and taken in the middle. Projected damping
//!   and air take their directions and coefficients at the predicted middle, which is within
//!   `O(h²)`, so order 2 holds.
//! * **Settings.** `residual`, `max_iterations`, `jacobian`, `solver` as in backward Euler. One
//!   Newton iteration by conjugate gradients (`max_iterations=1,solver=cg,cg_tolerance=0.01`) keeps
//!   order 2, because Newton starts within `O(h²)` and squares that. Such a step reports
//!   `IterationLimit`. With `start=last` it starts at `v_n`, which is the linearly
//!   implicit midpoint: on a hanging sheet at k/m = 1e6 it is the better one in 16 steps of 16 ms and
//!   the worse one in 64 (the page `methodology` has the numbers). One iteration is safe only with
//!   damping and up to `h²k/m` of about 100, see below.
//!   [`safeguard=work`](drape_integrator::Safeguard) iterates again where the residual adds energy.
//!   It cannot remove the energy that the solved step itself gains. `tolerance` puts the method
//!   under [step size control](drape_integrator::Adaptive), with the error constant 1/12.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `w` | [`drape_integrator::ImplicitStage::velocity`] | m/s | `n` × 3 |
//! | `x̂`, `v̂`: predicted middle | `ahead` | m, m/s | `n` × 3 |
//!
//! # Where it failed here, and what it cost
//!
//! *The hanging sheet.* 400 particles, shear springs of 0.1 k, d/m = 40/s, 0.3 s. The table shows
//! the error of the positions relative to the path length, against a reference of order 8:
//!
//! | `k/m`, `h` | error | error of backward Euler | Newton iterations per step |
//! |---|---|---|---|
//! | 1e4, 0.01 s | 1.12e-4 | 2.79e-2 | 2 |
//! | 1e6, 0.01 s | 6.90e-4 | 2.13e-2 | 2.9 |
//! | 1e6, 0.0025 s | 4.29e-5 | 5.75e-3 | 2 |
//! | 1e8, 0.01 s | 6.20e-4 | 1.87e-2 | 4.1 |
//!
//! A step costs as much as one of backward Euler and is 30 to 250 times as accurate.
//!
//! *One linear solve per step* by conjugate gradients, the same sheet at k/m = 1e6: 6.48e-4 at
//! 0.01 s for 19 CG iterations per step, 1.76e-4 at 0.005 s for 12. That is the error of full
//! Newton at a ninth of its time. Over 2 s with d/m = 40/s the energy never rises at k/m = 1e4 and
//! 1e6, but at 1e8 and h = 0.01 s it rises by 1e8 J: take full Newton, or TR-BDF2, there.
//!
//! *Undamped it fails.* At k/m = 1e6, h = 0.01 s the same sheet without damping gains 1.4e4 J in 2
//! s from potential energy of 4 J, though every step is solved. With one CG solve per step it gains
//! 2.5e4 J. Two undamped particles that turn at `h²κ = 100` keep their angular momentum to 1e-8,
//! but the length of the spring rings: the energy is 0.14 % too large after 1 s.
//!
//! *A common mistake* is to report `w` as the new velocity. The result damps and has order 1.
//!
//! # References
//!
//! P. Volino, N. Magnenat-Thalmann, *Implicit midpoint integration and adaptive damping for
//! efficient cloth simulation*, Computer Animation and Virtual Worlds 16 (2005),
//! doi 10.1002/cav.78. E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration* (2006),
//! doi 10.1007/3-540-30666-8.

mod ledger;
mod settings;
mod step;

pub use settings::{MIDPOINT, MidpointSettings};
pub use step::{Midpoint, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
