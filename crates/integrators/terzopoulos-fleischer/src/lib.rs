//! The semi-implicit step of Terzopoulos, Platt, Barr and Fleischer (1987) and Terzopoulos and
//! Fleischer (1988): implicit with the stiffness matrix of the last step.
//!
//! builds-on: backward Euler → **Terzopoulos-Fleischer** → Baraff-Witkin
//!
//! # Why
//!
//! The force of a spring is *exactly* a matrix times the positions, if the matrix may depend on them:
//! `f = −K(x) x` with the secant stiffnesses `k̃ = k (1 − ℓ/L)` as weights of a graph Laplacian. Taking the matrix at the
//! old level and the positions it acts on at the new one leaves one linear system a step, with one scalar matrix for
//! three coordinates; velocities are central in the damping `C = L_c`:
//!
//! ```text
//! (M/h² + C/2h + K(x_n)) x_{n+1} = f_ext + (M/h² + C/2h) x_n + (M/h − C/2) v_n          v_n = (x_n − x_{n−1})/h
//! ```
//!
//! # How the code does it
//!
//! With `x_{n+1} = x_n + h v_{n+1}` and times `h` this is a system for the velocity, which pins and contacts speak of
//! (`secant`):
//!
//! ```text
//! A v_{n+1} = (M − ½ h C) v_n + h (f_ext − K(x_n) x_n)          A = M + h² K(x_n) + ½ h C
//! ```
//!
//! where `−K(x_n) x_n` is the springs' force at `x_n`. `A` changes in every step and is factorised in every step. Where springs are
//! compressed the weights are negative and `A` may be indefinite: it is factorised as `L D Lᵀ`
//! ([`drape_solvers::CompleteLdlt`]), which does not mind; the step then reports `Indefinite`. Where a pivot vanishes there is no
//! solution, and the step is refused with the state as it was (`StepError::Solver`). Setting `clamp=true` raises negative weights to 0; a compressed
//! spring then exerts no force at all, which is another equation: its solution does not tend to that of the original
//! one as `h → 0`. Of projected damping the half that would be implicit enters as `½ h L_c` in the matrix with its
//! remainder at level `n`. Contacts act on the velocity that the solve gives, particle by particle.
//!
//! # What it cost and where it failed here
//!
//! Order 1. On an oscillator `|ζ|² = (1 − η/2)/(1 + θ + η/2)` where the roots are complex: about as dissipative as
//! backward Euler. Momentum is conserved. The force acts along the *new* direction of a spring, with the tension that it
//! had before: there is next to no resistance to sideways motion at rest length, hence no locking. But neither is there
//! any to stretching: a spring at rest has secant stiffness 0, and pulls only one step after it was stretched. Where the jump
//! of a step is large the answer overshoots, and energy grows: no theorem forbids it. For rest length 0 the weights are
//! constant and the method is as stable as backward Euler.
//!
//! Compression is worse: from a spring of length `L ≪ θℓ` a step leads to a length of about `L²/(θℓ)`, so that
//! collapse attracts. Such a spring stays collapsed, where a real one would push its ends apart, and its secant
//! `kℓ/L` grows until round-off shows in the momentum.
//!
//! Measured on the hanging sheet of 400 particles with shear springs of 0.1 k: a step costs 220 µs, nearly all of it the factorisation. On
//! the smooth scene its order is 1, clamped 0.4 and falling, with an error that stays at one hundredth of the motion (one tenth
//! at k/m = 1e4). At k/m = 1e4 it follows the exact solution up to h = 0.005 s and is lost at 0.01 s; at k/m = 1e6 it gained
//! more energy than the scene has at every step from 0.00125 to 0.01 s.
//!
//! Plots: error against the step in `results/figures/order-smooth.svg` and `order-stiff.svg`, spin in
//! `momentum-spin.svg`, hard cases in `hard-cases.svg`.
//! What to try next: the tangent instead of the secant (Baraff-Witkin), which knows the stiffness before it is needed.
//!
//! # Symbols
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `K(x_n)` | [`drape_model::LinearSplit::visit_secants`] | N/m | `n` × `n`, scalar |
//! | `C`, that is `L_c` | [`drape_model::LinearSplit::visit_weights`] | N s/m | `n` × `n`, scalar |
//! | `A` | `matrix` | kg | `n` × `n`, scalar |
//! | `b` | `b` | kg m/s | `n` × 3 |

mod ledger;
mod secant;
mod settings;
mod step;

pub use settings::{TERZOPOULOS_FLEISCHER, TerzopoulosFleischerSettings};
pub use step::{REGISTRATION, TerzopoulosFleischer};
