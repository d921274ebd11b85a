//! Explicit and symplectic Euler: the two methods that need no solve.
//!
//! # What they do
//!
//! Explicit (forward) Euler is the explicit Adams method (2) of EEH for `k = 1`:
//!
//! ```text
//! x_{n+1} = x_n + h v_n          v_{n+1} = v_n + h M⁻¹ f(x_n, v_n)
//! ```
//!
//! Symplectic Euler differs in one index: the new velocity moves the positions,
//!
//! ```text
//! v_{n+1} = v_n + h M⁻¹ f(x_n, v_n)          x_{n+1} = x_n + h v_{n+1}
//! ```
//!
//! and with `damping=implicit` it solves `(M + h L_c) v_{n+1} = M v_n + h f_conservative(x_n)` first.
//!
//! # What to expect
//!
//! On the oscillator `x'' = −κx − δx'` with `θ = h²κ`, `η = hδ`:
//!
//! | method | stable if |
//! |---|---|
//! | explicit Euler | `θ ≤ η` and `2η ≤ 4 + θ`: never without damping |
//! | symplectic Euler, damping explicit | `θ + 2η < 4` |
//! | symplectic Euler, damping implicit | `θ < 4 + 2η` |
//!
//! The largest eigenvalue of `M⁻¹L_k` on a structural grid is at most `8 k/m`, hence `h < √(m/2k)`
//! for symplectic Euler. It conserves linear and (undamped) angular momentum exactly and an energy close to the
//! true one. Explicit Euler is kept as the baseline that shows why anything else is needed.
//!
//! Contacts: in symplectic Euler the constrained new velocity moves the particle. In explicit Euler
//! the old velocity does, so the constraint is imposed on it before it moves anything.
//!
//! # Symbols
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `x_n`, `v_n` | `state.x`, `state.v` | m, m/s | `n` × 3 |
//! | `f` | `force` | N | `n` × 3 |
//! | `L_c` | [`drape_integrator::LaplacianSolver`] | N s/m | `n` × `n` |

mod settings;
mod step;
mod workspace;

pub use settings::{DampingTreatment, EXPLICIT_EULER, SYMPLECTIC_EULER, SymplecticSettings};
pub use step::{ExplicitEuler, SymplecticEuler};
