//! Backward Euler, solved by Newton's method to convergence: the reference for every other implicit
//! method at the same step size.
//!
//! # What it does
//!
//! The BDF method (3) of EEH for `k = 1`, with the whole force at the new level,
//!
//! ```text
//! M (v_{n+1} − v_n) = h f(x_{n+1}, v_{n+1})          x_{n+1} = x_n + h v_{n+1}
//! ```
//!
//! is the stationarity condition of the incremental potential
//! [`Φ(v) = ½‖v − v̂‖²_M + U(x_n + h v) + (h/2) vᵀ D v`](drape_integrator::IncrementalPotential), which
//! [`Newton`](drape_integrator::Newton) minimises: start at the best of `v_n`, the inertial target `v̂` and the
//! extrapolation (22); exact Hessian while it is positive definite, projected otherwise; Armijo line
//! search.
//!
//! # What to expect
//!
//! Order 1 and L-stable on linear problems: on the oscillator the amplification matrix is
//! `1/(1+θ+η) · [[1+η, 1], [−θ, 1]]`. Linear momentum is conserved. The angular momentum of one spring obeys
//! `L_{n+1} = L_n / (1 + θ (1 − ℓ/len_{n+1}))`: it decays in tension and *grows in compression*, so that backward
//! Euler is **not** energy monotone; what it guarantees, up to round-off, is `Φ(v_{n+1}) ≤ Φ(v)` for every start
//! that was tried.
//!
//! The stop test is `‖S∇Φ‖_{M⁻¹} ≤ max(residual · scale, round-off)`. The scale is the change of velocity that the
//! forces at the start would make in the step, so that it does not depend on the frame; the round-off is that of
//! forces of size `k|x|`, about `ε_mach h k |x|`, whatever the strain. At very large `h²k/m` Newton's method
//! follows a curved valley and may need more than its 100 iterations; the step then reports
//! `IterationLimit`.
//!
//! # Symbols
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `Φ` | [`drape_integrator::IncrementalPotential::value`] | J | |
//! | `v̂` | [`drape_integrator::IncrementalPotential::target`] | m/s | `n` × 3 |

mod settings;
mod step;
mod workspace;

pub use settings::{BACKWARD_EULER, BackwardEulerSettings};
pub use step::BackwardEuler;
