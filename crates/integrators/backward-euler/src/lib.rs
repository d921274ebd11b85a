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
//! Euler is **not** energy monotone; what it guarantees is `Φ(v_{n+1}) ≤ Φ(v)` for every start that was
//! tried.
//!
//! The stop test is `‖∇Φ‖_{M⁻¹} ≤ max(tolerance, 10⁻¹⁴ θ) · scale`: round-off leaves a floor of about
//! `5·10⁻¹⁵ θ`, so a fixed `10⁻¹³` would be out of reach for stiff scenes.
//!
//! # Symbols
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `Φ` | [`drape_integrator::IncrementalPotential::value`] | J | |
//! | `v̂` | [`drape_integrator::IncrementalPotential::target`] | m/s | `n` × 3 |
//! | `θ = h² k/m` | `theta` | – | |

mod settings;
mod step;
mod workspace;

pub use settings::{BACKWARD_EULER, BackwardEulerSettings};
pub use step::BackwardEuler;
