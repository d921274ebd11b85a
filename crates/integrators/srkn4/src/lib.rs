//! The symplectic Runge–Kutta–Nyström method of order 4 of Blanes and Moan (2002): six forces a
//! step, and the smallest errors of all explicit methods here.
//!
//! builds-on: explicit Euler → symplectic Euler → leapfrog → **symplectic Runge–Kutta–Nyström**
//!
//! # What it is
//!
//! Leapfrog is a kick, a drift and a kick. A longer series of kicks and drifts, with lengths chosen
//! well, is still symplectic and symmetric but of order 4. Take it where damping is light and an
//! error below 1e-5 is wanted: references, measurements of energy and spin. Leapfrog is cheaper for
//! larger errors, because the stability limit and not the error sets its step.
//!
//! # The mathematics
//!
//! A kick (N1) solves `M v' = F(x) − D v` at fixed `x`, a drift (N2) solves `x' = v`. The step
//! alternates seven kicks and six drifts (N3), which read the same from both ends:
//!
//! ```text
//! v ← e^{−b h M⁻¹D} v + …                   kick over b h, exact for fixed x            (N1)
//! x ← x + a h v                             drift                                       (N2)
//! b₁ a₁ b₂ a₂ b₃ a₃ b₄ a₃ b₃ a₂ b₂ a₁ b₁                                                (N3)
//! b₁ = 0.0829844064174052    b₂ = 0.396309801498368    b₃ = −0.0390563049223486
//! a₁ = 0.245298957184271     a₂ = 0.604872665711080    a₃ = ½ − a₁ − a₂ = −0.350…
//! b₄ = 1 − 2 (b₁ + b₂ + b₃)
//! ```
//!
//! Without damping a kick is `v ← v + b h M⁻¹ F(x)`. With the damping of springs its Taylor series,
//! to five terms, takes five products with `D` and no solve:
//!
//! ```text
//! w₁ = b h M⁻¹ (F(x) − D v)      w_q = −(b h/q) M⁻¹ D w_{q−1}      v ← v + w₁ + … + w₅  (N4)
//! ```
//!
//! * **Order 4**, with and without damping, full or projected. The step reads the same from both
//!   ends, so that its error has even orders only, and the series leaves an error of order 6.
//!   Crank–Nicolson in the kicks would drop the order to 2.
//! * **Stability.** Without damping the method is stable for `h√λ < 5.0269`, except in a narrow
//!   interval, `3.1635 < h√λ < 3.1686`, where a step multiplies the mode by up to 1.0024. Per force
//!   evaluation the limit is 0.84, against 2 for leapfrog. The series and the kicks and drifts that
//!   go back limit the damping: `hδ < 8.8` for `h√λ` up to 4.
//! * **Conservation.** Momentum and, without damping, angular momentum are exact: kicks act along
//!   springs. With damping a step multiplies the angular momentum of two particles by `Π p(b_i η)`,
//!   where `p` is the series of `e^{−y}`. The energy oscillates and does not drift.
//! * **Free fall** is exact.
//! * **Forces.** The last kick's force begins the next step: six evaluations a step. They are kept
//!   as leapfrog's are ([`drape_integrator::KeptForce`]).
//! * **Settings.** `step` and `safety` are leapfrog's: `auto` and `bound` divide a step into equal
//!   substeps of at most `safety · 5.0269/√λ` and `8/δ`, with `λ` from
//!   [`drape_integrator::StabilityLimit`] and `δ` from [`drape_integrator::DampingBound`].
//! * **Refusals.** Four of the thirteen parts of a step go back in time. Contacts, pins on paths
//!   and drag in a wind have no meaning in such parts.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `b_i`, `a_i` | `KICKS`, `DRIFTS` | – | 7, 6 |
//! | `F` | [`drape_integrator::KeptForce`] | N | `n` × 3 |
//! | `w_q` | `Damping::term` | m/s | `n` × 3 |
//! | `−D w` | `Damping::force` | N | `n` × 3 |
//! | `λ` | [`drape_integrator::StabilityLimit`] | 1/s² | |
//! | `δ` | [`drape_integrator::DampingBound`] | 1/s | |
//!
//! # Where it failed here, and what it cost
//!
//! The hanging sheet: 20 × 20 particles, shear springs of 0.1 k, two pins, `d/m` = 40 1/s, 0.3 s.
//! Errors are relative to the motion.
//!
//! | `k/m`, 1/s² | steps | force evaluations | error |
//! |---|---|---|---|
//! | 1e4 | 11 | 67 | 5.3e-5 |
//! | 1e4 | 16 | 97 | 7.7e-7 |
//! | 1e6 | 157 | 943 | 8.2e-10 |
//!
//! Leapfrog with explicit damping has 4.2e-5 after 45 forces (`k/m` = 1e4), 2.9e-6 after 330 and
//! 4.0e-7 after 882 (1e6).
//!
//! * *Cost of the damping.* A damped step takes 35 products with `D`. They count as products, not
//!   as forces; where `d` is small, fewer terms would do.
//! * *Energy.* Without damping at `k/m` = 1e6 the energy rose by at most 1.0e-4 J in 2 s with steps
//!   of `4/ω`, where `ω` belongs to the sheet at rest, and by 5.6e-5 J with `3.5/ω`. At `6/ω` it
//!   blew up at once. Crumpled cloth is stiffer, so the default `safety` of 0.7 keeps to `3.5/ω`.
//! * *Heavy damping.* Beyond `hδ` = 8.8 the velocities explode. There Runge–Kutta–Chebyshev or an
//!   implicit method is the right choice.
//!
//! To try next: fewer terms of the series where `hδ` is small; a pair of methods to control the
//! step size.
//!
//! # References
//!
//! S. Blanes, P. C. Moan: *Practical symplectic partitioned Runge–Kutta and Runge–Kutta–Nyström
//! methods*. Journal of Computational and Applied Mathematics 142 (2002) 313–330,
//! doi:10.1016/S0377-0427(01)00492-7.

mod settings;
mod step;

pub use settings::{SRKN4, Srkn4Settings};
pub use step::{REGISTRATION, Srkn4};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
