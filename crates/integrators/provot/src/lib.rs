//! Provot's method (1995): symplectic Euler, and springs that are too long are shortened by hand.
//!
//! builds-on: explicit Euler → symplectic Euler → leapfrog → **Provot** → backward Euler
//!
//! # Why
//!
//! An explicit method must keep `h²k/m` small, so that it can afford soft springs only, and a sheet of soft springs
//! hangs like rubber. Provot leaves the springs soft and forbids what is wrong with them, more than ten percent
//! of elongation. After a step of symplectic Euler,
//!
//! ```text
//! v = v_n + h M⁻¹ f(x_n, v_n)          x = x_n + h v
//! ```
//!
//! every tension and shear spring with `L > (1 + τ_c) ℓ` is shortened to `(1 + τ_c) ℓ`, one after the other: its ends move
//! along it by `w_i/(w_i + w_j)` and `w_j/(w_i + w_j)` of the excess, `w = 1/m`, and `w = 0` where pinned. Then
//!
//! ```text
//! v_{n+1} = (x_{n+1} − x_n)/h
//! ```
//!
//! EEH's objection (section 3): this is "not physically sound", no differential equation is solved.
//!
//! # How the code does it
//!
//! The correction is [`drape_integrator::ElongationLimit`]; the step reports the largest distance that it moved a
//! position. The velocity of a particle changes by its displacement over `h`: that is the formula above, except that a
//! particle led out of an obstacle does not get back the speed of recovery which the contact took from it, and that one
//! which nothing moved keeps its bits. While no spring is too long, the method is symplectic Euler bit for bit.
//!
//! Contacts constrain the velocity of symplectic Euler. A correction does not know them: it may push a particle into
//! an obstacle. One that was in contact gets no velocity inwards from that, and the next step leads it out.
//!
//! # What it cost and where it failed here
//!
//! A sheet of 6 × 6 particles hung from two corners, `k/m` = 400 1/s², undamped, 1 s of steps of 5 ms:
//!
//! * *Energy.* Symplectic Euler keeps it within 0.005 of the unit `m g · 1 m`. With one sweep at `τ_c` = 0.1 a share of 0.14 is
//!   lost, with `velocity=positions-only` 22 units are gained: the springs that were cut go on stretching at the speed that
//!   they had, and fall again and again.
//! * *Order of the sweep.* At `τ_c` = 0.02 and two sweeps a step, backward, alternating and shuffled sweeps are 3 to 6 mm
//!   away from forward ones after half a second.
//! * *Sweeps.* Shortening a spring stretches its neighbours: with `τ_c` = 0.05 the largest elongation in the run is 0.077 after one
//!   sweep a step, 0.060 after 3, 0.053 after 10, 0.0500 after 100. Where pins are too far apart it is never met.
//! * *Momentum* is conserved to round-off. *Angular momentum is not*: the ends are moved along the new direction of the
//!   spring, so that that of a pair shrinks by the factor `L_{n+1}/L` by which the spring is shortened, with either choice
//!   of the velocity.
//!
//! The explicit step still needs `h²λ + 2hδ < 4` of the soft springs. What to try next: stiff springs and an implicit method,
//! which is the rest of this list.
//!
//! # Symbols
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `τ_c` | [`drape_integrator::ElongationSettings::limit`] | – | |
//! | `x`, before the correction | `uncorrected` | m | `n` × 3 |
//! | `ℓ`, `L` | [`drape_integrator::ElongationLimit`] | m | per spring |
//! | `w` | `inverse_mass` | 1/kg | `n` |

mod ledger;
mod settings;
mod step;

pub use settings::{PROVOT, ProvotSettings, VelocityUpdate};
pub use step::{Provot, REGISTRATION};
