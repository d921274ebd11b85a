//! The generalized-α family: Newmark, Hilber–Hughes–Taylor, Chung–Hulbert. One parameter sets the
//! damping of stiff motion.
//!
//! builds-on: explicit Euler → backward Euler → midpoint → **generalized-α**
//!
//! # What it is
//!
//! Structural engineers want order 2, and numerical damping only of vibrations that the step does
//! not resolve. The family carries an acceleration `a` beside positions and velocities, and
//! evaluates inertia and force at two different points of the step. One number, `rho_inf`, is the
//! fraction of infinitely stiff motion that a step leaves: 1 all of it, 0 nothing. Take it where
//! the amount of numerical damping must be chosen. TR-BDF2 is more accurate at the same step, for
//! about 1.4 times the work.
//!
//! # The mathematics
//!
//! ```text
//! (1 − α_m) a_{n+1} + α_m a_n = (1 − α_f) M⁻¹f_{n+1} + α_f M⁻¹f_n                      (1)
//! x_{n+1} = x_n + h v_n + h² ((½ − β) a_n + β a_{n+1})                                 (2)
//! v_{n+1} = v_n + h ((1 − γ) a_n + γ a_{n+1})
//! ```
//!
//! `a_n` is an algorithmic acceleration, not `M⁻¹f_n`; it starts as `a_0 = M⁻¹f_0`. Solved for
//! `v_{n+1}`, (1) and (2) are one implicit stage with two time constants:
//!
//! ```text
//! x_{n+1} = X* + τ_x v_{n+1}          M (v_{n+1} − V*) = τ_v f_{n+1}                   (3)
//! X* = x_n + h v_n + h² (½ − β) a_n − τ_x (v_n + h (1 − γ) a_n)                        (4)
//! V* = v_n + h (1 − γ) a_n + hγ/(1 − α_m) (α_f M⁻¹f_n − α_m a_n)
//! τ_x = hβ/γ          τ_v = hγ (1 − α_f)/(1 − α_m)
//! M⁻¹f_{n+1} = (v_{n+1} − V*)/τ_v                                                      (5)
//! ```
//!
//! [`drape_integrator::ImplicitStage`] solves (3) with the matrix `M + τ_x τ_v K + τ_v D`. (5) is
//! kept for the next step; a new evaluation would multiply the residual by `h²k/m`.
//!
//! | `family` | `α_m` | `α_f` | `γ` | order |
//! |---|---|---|---|---|
//! | `chung-hulbert` | `(2ρ − 1)/(ρ + 1)` | `ρ/(ρ + 1)` | `½ − α_m + α_f` | 2 |
//! | `hht`, ρ ≥ ½ | 0 | `(1 − ρ)/(1 + ρ)` | `½ + α_f` | 2 |
//! | `newmark` | 0 | 0 | `(3 − ρ)/(2 + 2ρ)` | 1, and 2 for ρ = 1 |
//!
//! `β = ¼ (γ + ½)²` in all rows, `ρ` is `rho_inf`. `newmark` with ρ = 1 is the trapezoidal rule.
//! `hht` with ρ = ½ is `chung-hulbert` with ρ = ½.
//!
//! * **Stability.** A-stable on linear problems. For `chung-hulbert` with ρ = 1 the recurrence has
//!   a third root −1, that of the acceleration, which only inconsistent starts excite. No energy
//!   theorem holds: undamped cloth at large `h²k/m` gains energy for ρ near 1, hence the default ρ
//!   = ½.
//! * **Changes of the step.** For `chung-hulbert` and `hht` the acceleration belongs to a time
//!   between two steps, which depends on their length. Each change of `h` costs an order: with
//!   steps of 1 and 2 in turn the observed order is 1.1. The trapezoidal rule keeps order 2.
//! * **Conservation.** Momentum, to round-off with `solver=cholesky` and to the tolerance of the
//!   solve with the default solver: the remaining residual is a momentum. The trapezoidal rule
//!   keeps `(1 + ¼θ (1 − ℓ/L)) d × v` of a pair, so its angular momentum oscillates and never
//!   drifts.
//! * **Contact.** A particle in contact forgets the algorithmic acceleration: `a_n := M⁻¹f_n`.
//!   Along its constraints it moves at one velocity through the step. Particles that slide with
//!   friction have order 1 in their positions. After a restart or a change of the system
//!   `a_n := M⁻¹f_n` for all.
//! * **Damping.** Projected damping and air take directions and coefficients at the predicted new
//!   level, so order 2 holds.
//! * **Settings.** `residual`, `max_iterations`, `jacobian`, `solver` as in backward Euler. One
//!   Newton iteration by conjugate gradients (`max_iterations=1,solver=cg,cg_tolerance=0.01`) keeps
//!   order 2; such a step reports `IterationLimit`. It is safe only with damping and up to `h²k/m`
//!   of about 100, see below.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h`, `τ_x`, `τ_v` | `h`, `tau` | s | |
//! | `a_n`, `M⁻¹f_n` | `a`, `g` | m/s² | `n` × 3 |
//! | `X*`, `V*` | `x_star`, `v_star` | m, m/s | `n` × 3 |
//!
//! # Where it failed here, and what it cost
//!
//! *The hanging sheet.* 400 particles, shear springs of 0.1 k, d/m = 40/s, 0.3 s. Error of the
//! positions over the way, against a reference of order 8:
//!
//! | | 1e4, h = 0.01 s | 0.0025 s | 1e6, h = 0.01 s | 0.0025 s |
//! |---|---|---|---|---|
//! | backward Euler | 2.79e-2 | 7.06e-3 | 2.13e-2 | 5.75e-3 |
//! | ρ = 1 | 2.15e-4 | 1.35e-5 | 6.74e-4 | 4.21e-5 |
//! | ρ = 0.8 | 2.27e-4 | 1.42e-5 | 7.12e-4 | 4.44e-5 |
//! | ρ = 0.5 (default) | 3.20e-4 | 2.02e-5 | 1.01e-3 | 6.30e-5 |
//! | ρ = 0 | 1.07e-3 | 7.29e-5 | 3.69e-3 | 2.31e-4 |
//!
//! A step takes as many Newton iterations as one of backward Euler, about three at 1e6. With one CG
//! solve per step the errors at 1e6 are 9.6e-4 (0.01 s, 21 CG iterations per step) and 2.6e-4
//! (0.005 s), at a ninth of the time. Over 2 s this form never gains energy at 1e4 and 1e6 with d/m
//! = 40/s. It gains 71 J at 1e6 without damping, and 4e4 J at 1e8 with d/m = 40/s: take full Newton
//! there, or [`safeguard=work`](drape_integrator::Safeguard). On the sheet of 20 × 20 particles in
//! the docs of `drape-multistep`, over 5 s with one step a frame, that takes 2.4 Newton iterations
//! and gains nothing; one iteration gains 990 J.
//!
//! *Undamped*, k/m = 1e6, h = 0.01 s, 2 s, potential energy of 4 J; unsolved steps are those that
//! used up 100 Newton iterations, of 200:
//!
//! | ρ | 1 | 0.8 | 0.5 | 0 |
//! |---|---|---|---|---|
//! | greatest gain, J | 539 | 153 | 0 | 0 |
//! | change at the end, J | 527 | 147 | −0.35 | −0.43 |
//! | unsolved steps | 2 | 1 | 0 | 1 |
//!
//! With d/m = 40/s the energy never rises.
//!
//! *Common mistakes* are to use `a_{n+1}` for `M⁻¹f_{n+1}`, and to keep `a_n` over an impact.
//!
//! # References
//!
//! N. Newmark, *A method of computation for structural dynamics*, J. Eng. Mech. Div. ASCE 85
//! (1959), doi 10.1061/JMCEA3.0000098. H. Hilber, T. Hughes, R. Taylor, *Improved numerical
//! dissipation for time integration algorithms in structural dynamics*, Earthq. Eng. Struct. Dyn. 5
//! (1977), doi 10.1002/eqe.4290050306. J. Chung, G. Hulbert, *A time integration algorithm for
//! structural dynamics with improved numerical dissipation: the generalized-α method*, J. Appl.
//! Mech. 60 (1993), doi 10.1115/1.2900803.

mod settings;
mod step;
mod workspace;

pub use settings::{Family, GENERALIZED_ALPHA, GeneralizedAlphaSettings};
pub use step::{GeneralizedAlpha, REGISTRATION};
pub use workspace::Workspace;

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
