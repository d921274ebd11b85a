//! The energy-momentum method: a second-order step in which the springs do exactly the work by
//! which their energy falls.
//!
//! builds-on: implicit midpoint → **energy-momentum**
//!
//! # What it is
//!
//! Implicit midpoint keeps momentum and spin, but not energy: on stiff springs that turn it can
//! gain any amount. This method evaluates each spring not at one place but over the whole step, by
//! a *discrete gradient*. Momentum, angular momentum and energy then follow the exact laws at any
//! step size: the energy falls by the work of the damping and by nothing else.
//!
//! Take it where the integrator must neither lose nor gain energy: for long undamped motion, or as
//! a measure of the losses of other methods. Stiff vibrations are conserved too, so they ring on
//! forever. The theorem holds only for a step that is solved, and Newton's method may fail to solve
//! one.
//!
//! # The mathematics
//!
//! The unknown is the mean velocity `v̄` of the step:
//!
//! ```text
//! x_{n+1} = x_n + h v̄                 v_{n+1} = 2 v̄ − v_n                                     (1)
//! M (v̄ − v_n) = h/2 (F̄ − D v̄ + f)                                                            (2)
//! F̄_i = −ΔU/ΔL · (d_n + d_{n+1})/(L_n + L_{n+1})          for each spring                     (3)
//! ```
//!
//! `d = x_i − x_j` and `L = |d|` belong to a spring, `U(L)` is its energy. `f` are all other forces
//! at level `n`, such as gravity and air. A linear spring has `ΔU/ΔL = k ((L_n + L_{n+1})/2 − ℓ)`,
//! which needs no division by a difference. Springs of several slopes use the difference of
//! energies only between two pieces; for `|ΔL| < 1e-8 ℓ` they use the tension in the middle.
//!
//! * **Energy.** `F̄ · (d_{n+1} − d_n) = −ΔU/ΔL (L_{n+1}² − L_n²)/(L_n + L_{n+1}) = −ΔU`. So
//!   `H_{n+1} − H_n = −h v̄ᵀ D v̄` exactly, up to round-off and the residual of the solve. Gravity
//!   is constant, and its work is exact too. Contacts, pins on paths and air do work beside this
//!   identity; [the ledger](drape_integrator::EnergyLedger) counts it.
//! * **Momentum.** `F̄` acts in pairs, along `d_n + d_{n+1}`. Hence `Σ m v` and `Σ m x × v` are
//!   conserved. Two particles in rotation keep spin, energy and length at any `θ = h²κ`. Full
//!   damping takes angular momentum, by
//!   [`energy_momentum`](../drape_oracle/laws/spin/fn.energy_momentum.html).
//! * **Order and stability.** Order 2. On the oscillator it is implicit midpoint, with
//!   `|R(z)| = 1` without damping and `R(∞) = −1`.
//! * **Newton's method.** The matrix of (2) is
//!
//! ```text
//! A = M + h/2 (h G + D)         G_ij of a spring: g I + g' (d_n + d_{n+1}) û_{n+1}ᵀ             (4)
//! g = ΔU/ΔL / (L_n + L_{n+1})                     g' = ∂g/∂L_{n+1}
//! ```
//!
//!   It is not symmetric, as (2) is the gradient of no potential. [`drape_solvers::BlockLu`]
//!   factorises it in each iteration. A Newton step is halved until the residual falls, because no
//!   energy shows whether the step improves. The start is the best of `v_n`, `v_n + h/2 M⁻¹ f` and
//!   the extrapolation of the last two `v̄`, by their residuals. (An extrapolation of `v_n`, which
//!   rings, turns springs over and leads to another solution.)
//! * **Stop test.** `‖S r‖_{M⁻¹} ≤ max(residual · scale, round-off)`, as in
//!   [`drape_integrator::ImplicitStage`].
//! * **Settings.** `on_failure=halve` takes two steps of half the length where Newton finds no
//!   solution, up to six times; the report counts substeps and rejected attempts. `report` takes
//!   the best velocity that was found, and the step breaks the identity.
//! * **Limit.** All parts of a step together take at most 4 000 000/`n` Newton iterations. Parts
//!   that are still unsolved then use the best velocity that was found, and the step reports that
//!   it did not converge.
//! * **Constraints.** Pins prescribe `v̄`. A contact prescribes the `v̄` that leads to the surface,
//!   and a rebound the mean of the velocities before and after. The impulse that the contact bears
//!   in the second half of the step is removed from `v_{n+1}`, with friction, as in leapfrog.
//! * **Refused.** Angles and hinges, which would need discrete gradients of their own, and
//!   projected damping, whose direction would have to be chosen along the way.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `v̄` | `mean` | m/s | `n` × 3 |
//! | `r`, the residual of (2) | `MeanVelocity::residual` | kg m/s | `n` × 3 |
//! | `g`, `g'` | [`drape_model::LinearSplit::visit_discrete_gradients`] | N/m, N/m² | per spring |
//! | `A` | `MeanVelocity::assemble` | kg | `n` × `n` blocks |
//!
//! # Where it failed here, and what it cost
//!
//! The hanging sheet: 400 particles of 1 g, shear springs of 0.1 k, two pins, d/m = 40/s, 0.3 s.
//! The error is relative to the way of the sheet:
//!
//! | | h = 0.01 | 0.005 | 0.0025 | Newton iterations in a step |
//! |---|---|---|---|---|
//! | k/m = 1e4 | 1.35e-4 | 3.38e-5 | 8.45e-6 | 2 |
//! | k/m = 1e6 | 3.51e-4 | 8.77e-5 | 2.20e-5 | 3 to 2 |
//!
//! The same sheet in steps of 0.01 s over 2 s, with `residual=1e-9`. The rise is the greatest
//! height of the energy above its start; a fall of the whole sheet by 1 m is worth 3.9 J:
//!
//! | k/m, d/m | `on_failure` | rise, J | unsolved | substeps | Newton iterations in a step |
//! |---|---|---|---|---|---|
//! | 1e6, 40 | either | 0 | 0 | 200 | 2.9 |
//! | 1e6, 0 | either | 6e-11 | 0 | 200 | 8.5 |
//! | 1e8, 40 | either | 0 | 0 | 200 | 4.9 |
//! | 1e8, 0 | `halve` | 2e-10 | 0 | 270 | 74 |
//! | 1e8, 0 | `report` | 1.5e-2 | 57 | 200 | 53 |
//!
//! * At k/m = 1e6 without damping every step has a solution, and the energy stays to the tolerance
//!   of the solve.
//! * At 1e8 without damping Newton's method fails in a quarter of the steps. With `halve` the
//!   theorem holds, and the run takes 16 times as long as a damped one. With `report` the theorem
//!   fails. The velocity that an unsolved step uses decides by how much: with the end of the last
//!   attempt, instead of the best velocity, the sheet gained 2e5 J.
//! * Two particles always have a solution. It may lie behind a place where the matrix (4) is
//!   singular, at `2ℓ/(L_n + L_{n+1}) = 1 + (4 + 2η)/θ`, and no path of falling residuals leads
//!   there. This happens from `θ = 10` on, where springs are squeezed to a fraction of their
//!   length.
//! * A Newton iteration takes about 1 ms on one core of a shared machine, most of it the
//!   factorisation.
//! * Undamped vibrations never decay; a method with numerical damping removes them.
//!
//! # References
//!
//! * R. LaBudde, D. Greenspan, *Discrete mechanics – a general treatment*, Journal of Computational
//!   Physics 15, 1974. doi:10.1016/0021-9991(74)90081-3.
//! * J. Simo, N. Tarnow, *The discrete energy-momentum method. Conserving algorithms for nonlinear
//!   elastodynamics*, Zeitschrift für angewandte Mathematik und Physik 43, 1992.
//!   doi:10.1007/BF00913408.
//! * O. Gonzalez, *Time integration and discrete Hamiltonian systems*, Journal of Nonlinear Science
//!   6, 1996. doi:10.1007/BF02440162.

mod ledger;
mod newton;
mod past;
mod settings;
mod step;

pub use settings::{ENERGY_MOMENTUM, EnergyMomentumSettings, OnFailure};
pub use step::{EnergyMomentum, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
