//! The precomputed inverse of Desbrun, Schröder and Barr (1999): implicit integration by one
//! constant filter.
//!
//! builds-on: backward Euler → Baraff-Witkin → **Desbrun** → Kang → IMEX
//!
//! # What it is
//!
//! Most of the cost of an implicit step is its linear system. Desbrun, Schröder and Barr replace
//! the Hessian of the springs by its constant part, the graph Laplacian of the stiffnesses. The
//! matrix `A = M + h² L_k + h L_c` can then be inverted once, before the simulation. Take it where
//! the step and the springs never change, and where folds may move slowly.
//!
//! # The mathematics
//!
//! A step multiplies the springs' force, with an artificial viscosity that stems from the implicit
//! velocity, by the inverse. `W = M A⁻¹` is the filter:
//!
//! ```text
//! F̃ = F(x_n) − h L_k v_n − L_c v_n                                                    (D1)
//! Δv = A⁻¹ h F̃ = h M⁻¹ F_filtered          F_filtered = W F̃                            (D2)
//! F_corr,i = m_i β × r_i,  β = −I_G⁻¹ Σ r_i × (F_filtered,i − f_damping,i)             (D3)
//! v_{n+1} = v_n + Δv + h M⁻¹ (F_corr + f_external)                                     (D4)
//! x_{n+1} = x_n + h v_{n+1}                                                            (D5)
//! ```
//!
//! The viscosity passes through the filter, gravity does not. Without (D3) and external forces this
//! *is* IMEX Euler (EEH (21)) with another solver: with `torque=none` the two methods give the same
//! trajectory. The constant matrix misrepresents rotation, because it resists sideways motion of
//! every spring. The filtered forces then have a torque, which (D3) corrects.
//!
//! * **Inverse.** `inverse=cholesky` (default) keeps a sparse Cholesky factor of `A`.
//!   `inverse=dense` keeps `A⁻¹` itself, as published: `n²` numbers, and as many of work space.
//!   Both are exact. A dense inverse above `memory_limit_mib` is refused before it is allocated.
//!   Both are rebuilt when `h`, a stiffness, a damping coefficient, a mass or a pin changes, and
//!   the report of that step counts the rebuild. Rows of pinned particles are removed; their
//!   springs stay in the diagonal of their neighbours.
//! * **`torque`** (module `torque`) has three values. `none`: no correction. `literal`: the
//!   published formula, in which the correction has the unit of force × length² × time and so
//!   depends on the units of the scene. `consistent` (default): (D3), the rigid rotation that
//!   restores the angular momentum which the filter took. Full damping has a torque of its own,
//!   which is not corrected. Pins and contacts may take any torque, so with a pinned particle
//!   `consistent` does nothing.
//! * **`inverse_dynamics=true`** shortens over-stretched springs after the step like Provot
//!   ([`drape_integrator::ElongationLimit`]). The velocity is always the distance moved over `h`.
//! * **Contacts** act on the resulting velocity, particle by particle, because the inverse is that
//!   of the free cloth.
//!
//! The order is 1, and momentum is conserved. With `torque=none`, full damping, no contacts and not
//! both pins and gravity the method is IMEX Euler, and its energy never rises.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `A` | [`drape_integrator::LaplacianSolver`] | kg | `n` × `n`, scalar |
//! | `h F̃` | [`drape_integrator::ViscousImpulse`] | kg m/s | `n` × 3 |
//! | `Δv = h M⁻¹ F_filtered` | `change` | m/s | `n` × 3 |
//! | `δT` of `torque=literal` | `torque` | N m | 3 |
//! | `θ = h²k/m` | – | – | |
//! | `I_G` | `inertia` | kg m² | 3 × 3 |
//!
//! # Where it failed here
//!
//! A stiff sheet *locks*: springs lose sideways velocity by a factor of `1/(1+θ)` per step. The
//! torque correction restores only the rotation of the whole sheet; drape and folds stay locked.
//! Contacts and corrections act outside the filter, and no theorem bounds the energy that they add:
//! the stiff square table gained 0.4 J at h = 0.01 s. Filtered gravity would be slower still;
//! unfiltered gravity beside pins invalidates the energy theorem.
//!
//! The dense inverse costs `n²` numbers and `n²` products per step, and `n³` operations at each
//! change. The sparse factor gives the same motion for a small fraction of both. A change of `h` or
//! `k` costs one factorisation.
//!
//! Measured on the hanging sheet of 400 particles with shear springs of 0.1 k, k/m = 1e6, h = 0.01
//! s:
//!
//! | | time a step |
//! |---|---|
//! | sparse factor | 25 to 65 µs |
//! | dense inverse | about 130 µs |
//! | IMEX Euler, conjugate gradients | 40 to 90 µs |
//! | backward Euler | 7 ms |
//!
//! * After a second the free edge hangs 0.22 m low instead of 0.47 m.
//! * Angular momentum that a free sheet, spinning in its plane at k/m = 1e4, keeps for a second: 5
//!   % without correction, 15 % with the literal one, all with the consistent one.
//! * The consistent correction does not give back the energy that the filter took: energy rose by
//!   12 % in that second, and from 15 J to 64 J within two at k/m = 1e8 and 20 rad/s. The literal
//!   form diverged at 20 rad/s.
//! * Because gravity is not filtered, a hanging chain comes to rest `(h² + hc/k) g` too long at its
//!   pin: small, but not the solution of the static problem.
//!
//! Plots: error against the step in `results/figures/order-smooth.svg` and `order-stiff.svg`, spin
//! in `momentum-spin.svg`, hard cases in `hard-cases.svg`.
//!
//! To try next: an updated right-hand side, which removes the locking (`drape-imex`, EEH Algorithm
//! 1).

mod ledger;
mod settings;
mod step;
mod torque;

pub use settings::{DESBRUN, DesbrunSettings, Inverse, Torque};
pub use step::{Desbrun, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
