//! The semi-implicit step of Terzopoulos, Platt, Barr and Fleischer (1987) and Terzopoulos and
//! Fleischer (1988): implicit, with the stiffness matrix of the last step.
//!
//! builds-on: backward Euler → **Terzopoulos-Fleischer** → Baraff-Witkin
//!
//! # What it is
//!
//! The force of a spring is *exactly* a matrix times the positions, `f = −K(x) x`, if the matrix
//! may depend on the positions. The method takes the matrix at the old level and the positions at
//! the new one: one linear system per step, with one scalar matrix for three coordinates. Take it
//! where rest lengths are 0; elsewhere it is of historical interest.
//!
//! # The mathematics
//!
//! `K(x)` is a graph Laplacian with the secant stiffnesses `k̃ = k (1 − ℓ/L)` as weights.
//! Velocities are central in the damping `C = L_c`:
//!
//! ```text
//! (M/h² + C/2h + K(x_n)) x_{n+1} = f_ext + (M/h² + C/2h) x_n + (M/h − C/2) v_n          (T1)
//! v_n = (x_n − x_{n−1})/h
//! ```
//!
//! With `x_{n+1} = x_n + h v_{n+1}` and times `h`, (T1) is a system for the velocity, which pins
//! and contacts constrain (module `secant`):
//!
//! ```text
//! A v_{n+1} = b          A = M + h² K(x_n) + ½ h C                                      (T2)
//!                        b = (M − ½ h C) v_n + h (f_ext − K(x_n) x_n)
//! x_{n+1} = x_n + h v_{n+1}                                                             (T3)
//! ```
//!
//! `−K(x_n) x_n` is the springs' force at `x_n`.
//!
//! * **Matrix.** `A` changes in every step and is factorised in every step. Compressed springs have
//!   negative weights, so `A` may be indefinite: it is factorised as `L D Lᵀ`
//!   ([`drape_solvers::CompleteLdlt`]), and the step reports `Indefinite`. Where a pivot vanishes
//!   there is no solution: the step returns `StepError::Solver` and leaves the state as it was.
//! * **`clamp=true`** raises negative weights to 0. A compressed spring then exerts no force at
//!   all. This is another equation, and its solution does not tend to that of (T1) as `h → 0`.
//! * **Projected damping.** Its implicit half enters as `½ h L_c` in the matrix, with the remainder
//!   at level `n`.
//! * **Contacts** act on the velocity that the solve gives, particle by particle.
//!
//! On an oscillator `|ζ|² = (1 − η/2)/(1 + θ + η/2)` where the roots are complex: the method is
//! about as dissipative as backward Euler. The order is 1, and momentum is conserved.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `K(x_n)` | [`drape_model::LinearSplit::visit_secants`] | N/m | `n` × `n`, scalar |
//! | `C`, that is `L_c` | [`drape_model::LinearSplit::visit_weights`] | N s/m | `n` × `n`, scalar |
//! | `A` | `matrix` | kg | `n` × `n`, scalar |
//! | `b` | `b` | kg m/s | `n` × 3 |
//!
//! # Where it failed here
//!
//! The force acts along the *new* direction of a spring with its old tension. Sideways motion at
//! rest length meets almost no resistance, so nothing locks. But stretching meets almost no
//! resistance either: a spring at rest has secant stiffness 0, and pulls only one step after it was
//! stretched. If a step is large, the result overshoots and the energy grows; no theorem excludes
//! this. For rest length 0 the weights are constant, and the method is as stable as backward Euler.
//!
//! Compression is worse. From a spring of length `L ≪ θℓ` a step leads to a length of about
//! `L²/(θℓ)`, so springs collapse. A collapsed spring stays collapsed, where a real one would push
//! its ends apart, and its secant `kℓ/L` grows until round-off shows in the momentum.
//!
//! Measured on the hanging sheet of 400 particles with shear springs of 0.1 k: a step costs 220 µs,
//! nearly all of it the factorisation. On the smooth scene its order is 1. Clamped, the order is
//! 0.4 and falling, and the error stays at one hundredth of the motion (one tenth at k/m = 1e4). At
//! k/m = 1e4 it follows the exact solution up to h = 0.005 s and is lost at 0.01 s. At k/m = 1e6 it
//! gained more energy than the scene has at every step from 0.00125 to 0.01 s.
//!
//! Plots: error against the step in `results/figures/order-smooth.svg` and `order-stiff.svg`, spin
//! in `momentum-spin.svg`, hard cases in `hard-cases.svg`.
//!
//! To try next: the tangent instead of the secant (Baraff-Witkin), which accounts for the stiffness
//! one step earlier.

mod ledger;
mod secant;
mod settings;
mod step;

pub use settings::{TERZOPOULOS_FLEISCHER, TerzopoulosFleischerSettings};
pub use step::{REGISTRATION, TerzopoulosFleischer};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
