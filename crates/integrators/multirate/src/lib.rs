//! The impulse method (r-RESPA): slow forces act in longer steps than fast ones.
//!
//! builds-on: explicit Euler → leapfrog → **impulse method**
//!
//! # What it is
//!
//! The stiffest force limits the step of an explicit method, yet leapfrog evaluates all forces in
//! each step. The impulse method evaluates the slow forces only at the ends of a long step, and the
//! fast forces in short steps between. Take it where the slow forces, such as those of hinges, cost
//! much more than the fast springs. Its resonance limits the long step, however slow the slow
//! forces are. Asynchronous variational integrators (Lew, Marsden, Ortiz and West 2003; for cloth
//! Thomaszewski, Pabst and Straßer 2008) give each element a step of its own. On a mesh of equal
//! springs they equal leapfrog; with two classes of forces they equal this method, with the same
//! resonance.
//!
//! # The mathematics
//!
//! `F_S` is the slow force, `F_F` the fast one; `D` is the damping, `H` the step and
//! `h = H/ratio`:
//!
//! ```text
//! v ← v + H/2 M⁻¹ F_S(x_n)                                                              (I1)
//! ratio × leapfrog of h with F_F and D:  half a kick, x ← x + h v, half a kick          (I2)
//! v ← v + H/2 M⁻¹ F_S(x_{n+1})                                                          (I3)
//! ```
//!
//! * **Order 2**, symplectic without damping. Momentum and angular momentum are exact: all kicks
//!   act in pairs. Free fall is exact.
//! * **Damping** acts in the short half kicks, by Heun's method
//!   ([`drape_integrator::ExplicitKick`]): nothing is solved. It is stable for `hδ < 4`. All
//!   damping is fast.
//! * **Settings.** `slow` names the slow forces: all springs and angles but tension, or those of
//!   bending, or those of angles. Gravity is constant, so it may act in the short steps; contacts
//!   are then treated as in leapfrog.
//! * **Resonance.** The slow kicks come with the period `H`. They add energy to a fast mode if `H`
//!   is a little less than half of the mode's period or a multiple of this half. With
//!   `θ_F = H²κ_F`, a slow stiffness of `H²κ_S` = 0.5 and many short steps the factor of a step
//!   exceeds 1 for `2.975 < √θ_F < 3.14`, by up to 0.085; with three short steps for
//!   `2.83 < √θ_F < 3.00`, by up to 0.103. The rule `H ≤ π/(2√λ_F)` is safe. It leaves a ratio of
//!   two at most, where `h` is at 0.4 of leapfrog's limit.
//! * **Pins and contacts** act in the short steps.
//! * **No energy ledger:** positions do not move by one velocity.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `H`, `h` | `h`, `short` | s | |
//! | `F_S`, `F_F` | `slow`, `fast` | N | `n` × 3 |
//! | `D` | `damped` | N s/m | `n` × `n` |
//!
//! # Where it failed here, and what it cost
//!
//! The hanging sheet: 20 × 20 particles, shear springs of 0.1 k, which are the slow ones, two pins,
//! `ratio` 3. `ω = √(4.35 k/m)` belongs to the sheet at rest.
//!
//! | `k/m`, 1/s² | `d/m`, 1/s | `H` | error after 0.3 s | energy gained |
//! |---|---|---|---|---|
//! | 1e6 | 40 | 2/ω | 1.2e-4 | |
//! | 1e6 | 40 | 4/ω | 5.3e-4 | 73 J in 2 s |
//! | 1e6 | 0 | 4/ω | | beyond 1e200 J in 2 s |
//! | 1e6 | 0 | 2/ω | | none in 2 s |
//! | 1e8 | 40 | 4/ω | | overflows in 0.5 s |
//! | 1e8 | 40 | 2/ω | | none in 0.5 s |
//!
//! * *Less accurate than leapfrog.* Leapfrog with explicit damping has an error of 2.9e-6 at a step
//!   of 1.9/ω, forty times less than this method at `H` = 2/ω with three short steps.
//! * *Little to gain.* Half of the springs are slow in this sheet. With a ratio of two the method
//!   saves a quarter of their evaluations.
//! * *Counts.* An evaluation of the slow or of the fast forces counts as one force evaluation each.
//!
//! To try next: a mollified impulse, which evaluates the slow forces at averaged positions and
//! pushes the resonance away (García-Archilla, Sanz-Serna and Skeel 1998).
//!
//! # References
//!
//! M. Tuckerman, B. J. Berne, G. J. Martyna: *Reversible multiple time scale molecular dynamics*.
//! The Journal of Chemical Physics 97 (1992) 1990–2001, doi:10.1063/1.463137.
//! H. Grubmüller, H. Heller, A. Windemuth, K. Schulten: *Generalized Verlet algorithm for efficient
//! molecular dynamics simulations with long-range interactions*. Molecular Simulation 6 (1991)
//! 121–142, doi:10.1080/08927029108022142.
//! A. Lew, J. E. Marsden, M. Ortiz, M. West: *Asynchronous variational integrators*. Archive for
//! Rational Mechanics and Analysis 167 (2003) 85–146, doi:10.1007/s00205-002-0212-y.

mod settings;
mod step;

pub use settings::{MULTIRATE, MultirateSettings, Slow};
pub use step::{Multirate, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
