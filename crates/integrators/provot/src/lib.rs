//! Provot's method (1995): symplectic Euler, then a limit on the elongation of springs.
//!
//! builds-on: explicit Euler → symplectic Euler → leapfrog → **Provot** → backward Euler
//!
//! # What it is
//!
//! An explicit method must keep `h²k/m` small, so it can afford soft springs only, and a sheet of
//! soft springs hangs like rubber. Provot keeps the springs soft and forbids an elongation of more
//! than ten percent. Take it where plausible motion at low cost is enough. EEH object (section 3)
//! that this is "not physically sound": it solves no differential equation.
//!
//! # The mathematics
//!
//! After a step of symplectic Euler,
//!
//! ```text
//! v = v_n + h M⁻¹ f(x_n, v_n)                                                         (P1)
//! x = x_n + h v                                                                       (P2)
//! ```
//!
//! every tension and shear spring with `L > (1 + τ_c) ℓ` is shortened to `(1 + τ_c) ℓ`, one after
//! the other. Its ends move along it by these parts of the excess, with `w = 1/m`, and `w = 0`
//! where pinned:
//!
//! ```text
//! w_i/(w_i + w_j)     and     w_j/(w_i + w_j)                                         (P3)
//! v_{n+1} = (x_{n+1} − x_n)/h                                                         (P4)
//! ```
//!
//! * **Correction.** [`drape_integrator::ElongationLimit`] computes (P3), and the step reports the
//!   largest distance that it moved a position. (P4) changes the velocity of a particle by its
//!   displacement over `h`. Two exceptions: a particle that nothing moved keeps its bits. A
//!   particle led out of an obstacle does not get back the speed of recovery that the contact took.
//!   While no spring is too long, the method is symplectic Euler bit for bit.
//! * **Contacts** constrain the velocity of symplectic Euler. A correction does not know them and
//!   may push a particle into an obstacle. A particle that was in contact gets no inward velocity
//!   from that, and the next step leads it out.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `τ_c` | [`drape_integrator::ElongationSettings::limit`] | – | |
//! | `x`, before the correction | `uncorrected` | m | `n` × 3 |
//! | `ℓ`, `L` | [`drape_integrator::ElongationLimit`] | m | per spring |
//! | `w` | `inverse_mass` | 1/kg | `n` |
//!
//! # Where it failed here
//!
//! A sheet of 6 × 6 particles hung from two corners, `k/m` = 400 1/s², undamped, 1 s of steps of 5
//! ms:
//!
//! * *Energy.* Symplectic Euler keeps it within 0.005 of the unit `m g · 1 m`. With one sweep at
//!   `τ_c` = 0.1 a fraction of 0.14 is lost. With `velocity=positions-only` 22 units are gained:
//!   the shortened springs go on stretching at their old speed, so the sheet falls again and again.
//! * *Order of the sweep.* At `τ_c` = 0.02 and two sweeps a step, backward, alternating and
//!   shuffled sweeps are 3 to 6 mm away from forward ones after half a second.
//! * *Sweeps.* Shortening a spring stretches its neighbours. With `τ_c` = 0.05 the largest
//!   elongation in the run is 0.077 after one sweep a step, 0.060 after 3, 0.053 after 10, 0.0500
//!   after 100. Where pins are too far apart the limit is never met.
//! * *Momentum* is conserved to round-off. *Angular momentum is not*: the ends move along the new
//!   direction of the spring. With either setting of the velocity, the angular momentum of a pair
//!   shrinks by the factor `L_{n+1}/L`.
//!
//! The explicit step still needs `h²λ + 2hδ < 4` of the soft springs. To try next: stiff springs
//! and an implicit method.

mod ledger;
mod settings;
mod step;

pub use settings::{PROVOT, ProvotSettings, VelocityUpdate};
pub use step::{Provot, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
