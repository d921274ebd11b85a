//! Implicit-explicit methods with a constant sparse matrix: those of Eberhardt, Etzmuß and Hauth
//! (2000), "EEH", and the two-step methods of order 2 that their section 2.2 allows.
//!
//! builds-on: Kang, Adams–Bashforth, BDF → **IMEX Euler → updated CG → IMEX of two steps**
//!
//! # What they are
//!
//! The stiffness of a textile sits in its tension springs. Their force splits into a linear part
//! and a remainder of constant size, `f = −L_k x + F2(x)` with `F2_i = +k ℓ û`. *IMEX Euler* takes
//! the linear part and the damping at the new level, and all other forces at the old one. Each step
//! is then one linear system with a *constant* matrix. *Updated CG* re-evaluates `F2` while it
//! iterates. The *two-step methods* extrapolate `F2`, which gives order 2. Take IMEX Euler where
//! energy must never rise, updated CG for stiff cloth with large steps and plausible motion, SBDF2
//! or MCNAB2 for order 2 on moderate stiffness.
//!
//! # The mathematics
//!
//! IMEX Euler (19):
//!
//! ```text
//! A v_{n+1} = M v_n + h [F_explicit(x_n, v_n) − L_k x_n]      A = M + h² L_k + h L_c     (21)
//! x_{n+1}   = x_n + h v_{n+1}                                                          (20)
//! ```
//!
//! `A` is scalar (the same for x, y and z), symmetric, positive definite and diagonally dominant.
//! The paper prints the signs of (16)–(18) and (21) so that the matrix would be indefinite. drape
//! reads them so that a stretched spring contracts; [`errata`] lists all readings. At very high
//! stiffness the sheet *locks*: `A` resists sideways motion of every spring with the full stiffness
//! `k`, and only `F2`, frozen at `x_n`, could take that back. IMEX Euler equals symplectic Euler
//! with an extra damping of `h k` on each spring. Algorithm 1 therefore re-evaluates `F2` at
//! `x_n + h v`:
//!
//! ```text
//! repeat  b = M v_n + h [F_frozen − L_k x_n + F2(x_n + h v)]                            (U1)
//!         CG on A v = b from the present v until |r| ≤ ε |b|                            (U2)
//! until   an update of b needs no CG iteration
//! ```
//!
//! Its fixed point is backward Euler of the whole system if all springs are in the matrix.
//! Algorithm 1 leaves details to the reader; the setting `safeguard` chooses between two readings:
//!
//! * `safeguard=paper`: the loop as printed. The counter's test reads as "first iteration of this
//!   pass", since the printed order can never take that branch. Only `F2` moves to `x_n + h v`; if
//!   `−L_k x` moved too, `h² L_k v` would count twice.
//! * `safeguard=robust` (default): each pass minimises a quadratic that lies above the
//!   [incremental potential](drape_integrator::IncrementalPotential) and touches it at the present
//!   `v`. CG lowers that quadratic at every iteration, so the potential falls monotonically.
//!   Safeguards keep this property. The start is the better of `v_n` and the extrapolation. The
//!   stop test refers to the change of velocity that the forces would make in the step. At the
//!   outer cap, or for `θ` above `newton_above`, Newton continues (U3). A step that gains energy
//!   (U4) is solved more tightly until it gains none or has converged. Where it can do neither, a
//!   step of IMEX Euler replaces it (U5). The energy is that in the frame of the pins, else of the
//!   air, else of the first obstacle, so the step is the same in every frame.
//!
//!   ```text
//!   ∇Φ(v) = 0                       by Newton's method                                  (U3)
//!   ½‖v‖²_M + U(x_n + h v) ≤ H_n    no gain of energy                                   (U4)
//!   A v = b(0)                      IMEX Euler                                          (U5)
//!   ```
//!
//! The two-step methods are the methods (7) with `k = 2`. With `F` for everything explicit and
//! `G = −L_k x − L_c v`, all of them ([`Coefficients`]) are
//!
//! ```text
//! X* = (1/a_0) [−a_1 x_n − a_2 x_{n−1} + h (b_1 v_n + b_2 v_{n−1})]          τ = h b_0/a_0   (8)
//! b  = −(1/a_0) M (a_1 v_n + a_2 v_{n−1})
//!      + (h/a_0) [c_1 F_n + c_2 F_{n−1} + b_1 G_n + b_2 G_{n−1}] − τ L_k X*                (8)
//! (M + τ² L_k + τ L_c) v_{n+1} = b                                                         (9)
//! x_{n+1} = X* + τ v_{n+1}
//! ```
//!
//! The formulas leave open points, which drape decides as follows:
//!
//! * *Start.* One step of backward Euler, by Newton's method. IMEX Euler would multiply velocities
//!   across the springs by `1/(1 + θ)` once and for all. The method starts anew when masses,
//!   stiffnesses, damping coefficients or pins change, and after `restart`.
//! * *Varying steps.* Coefficients are exact for `ω = h_n/h_{n−1}` in [1/2, 2]; beyond, and for
//!   CNLF at any change, the method starts anew. Since `τ` depends on `ω`, one change of the step
//!   size changes the matrix twice, except for CNAB2 and CNLF.
//! * *Contacts* are found at `x_n` and prescribe `n·v_{n+1} = n·(x_s − X*)/τ`. Where a contact
//!   begins or cuts a velocity, the particle's past is rewritten along the normal: it came with its
//!   new velocity, after a rebound in free flight. Where an impact meets friction, the past along
//!   the surface is rewritten too, at constant velocity, half a step of sliding late. Forces of the
//!   past are then evaluated anew, so that a force across a stiff spring is extrapolated along the
//!   path of its ends. So an elastic rebound neither takes nor gives energy.
//! * *Friction.* A sticking particle is prescribed a velocity, which fixes its place only if the
//!   difference formula joins neighbouring levels. CNLF has
//!   `x_{n+1} = x_{n−1} + h (v_{n+1} + v_{n−1})`, so a stopped particle would alternate between two
//!   positions: CNLF refuses friction. The impulse that limits the friction of an impact includes
//!   the impulse that leads the particle to the surface. A difference formula of two levels makes
//!   that up to twice as large. An impact on a rough surface therefore takes more along it than
//!   Coulomb's law; sliding that lasts takes exactly as much.
//! * *Force sweeps.* Three a step: `F`, `G` and `L_k X*`.
//!
//! *Stop test* (setting `norm`). The print stops at `|r| ≤ ε |b|`, which is `norm=euclid`. `b`
//! holds the momentum `M v_n`, so a sheet that moves fast as a whole is solved loosely. Across
//! springs it grows like `θ`, and one heavy particle hides the residuals of all others. By default
//! (`norm=velocity`) `ε` refers to the change of velocity that the forces would make within `τ`, by
//! the lightest mass ([`drape_integrator::StepReference`]). The robust form always does so.
//! `imex-euler:paper` and `imex-updated:paper` name the settings as printed.
//!
//! *Springs with piecewise-linear tension.* With `T(L)` of several slopes, `F2 = (K L − T(L)) û`
//! for any `K`. The setting `split` of the methods of order 1 chooses the `K` in `A`. `majorant`
//! (the default; the two-step methods always take it) is the steepest slope of each spring: `A` is
//! constant and the theorems below hold. `paper`, the reading of section 5, is the slope of the
//! present piece at `x_n`: `A` is set up anew, charged as a change of stiffness, whenever a spring
//! reaches another piece. Within a step `K` is frozen. Algorithm 1 has the same fixed point with
//! either. With `paper` its passes need not descend, and the robust form restarts Newton's method
//! from `v_n` where they do not converge.
//!
//! *Step size control* (setting `tolerance`, not for CNLF) wraps the methods by
//! [`drape_integrator::Adaptive`]. From positions alone the error of a locked sheet looks like 0:
//! it hardly accelerates. So `estimator=splitting` adds the error of `F2` at the old level (or
//! extrapolated). One more update of the right-hand side would change the velocity by `δ = A⁻¹ r`,
//! and all further ones together by `q δ`. `q = rᵀδ/δᵀMδ` is the Rayleigh quotient, `1 + θ` of the
//! mode at hand. It costs one loose solve with the kept matrix and one force evaluation a substep.
//! `forcing=eisenstat-walker` lets updated CG solve each update as tightly as the progress of the
//! updates deserves.
//!
//! *IMEX Euler, solved exactly, never gains energy*, for every `h` and `k`:
//! `H_{n+1} ≤ H_n − ½‖v_{n+1} − v_n‖²_M − h vᵀ L_c v`. Write `U = ½k|d|² − kℓ|d|`, a difference of
//! convex functions; the step takes the first part implicitly and the second explicitly (Eyre's
//! splitting). The theorem needs all stiff springs in the matrix, full damping, static pins and
//! conservative external forces. With springs of several slopes it needs the steepest one in the
//! matrix: `½ K |d|² − U` must be convex. It does not cover
//!
//! * projected damping, which the scalar matrix takes as `−L_c v` and corrects explicitly;
//! * explicit shear or bending springs: a mode with `θ_E` explicit and `θ_I` implicit is stable
//!   while `θ_E < 4 + θ_I`;
//! * loose tolerances with the extrapolated start;
//! * contacts that push out.
//!
//! *Two steps, linear theory*: on `x'' = −(κ_I + κ_E)x − δx'` the factors of a step are the roots
//! of `A² + ηAB + θ_I B² + θ_E BC = 0` with `A(ζ) = a_0 ζ² + a_1 ζ + a_2`, `B` likewise,
//! `C = c_1 ζ + c_2`. Sideways motion at rest length has `θ_E = −θ_I`, for which 1 is a double root
//! at any stiffness: no locking. Beside it there are parasites:
//!
//! | | parasites at `θ_E = −θ_I` | explicit springs beside very stiff implicit ones stable for |
//! |---|---|---|
//! | SBDF2 | `½/√(9/4 + θ)` | `θ_E < θ_I/3` |
//! | CNAB2 | `0, −θ/(4 + θ)`: rings | none |
//! | MCNAB2 | tend to 1/3 | `θ_E < θ_I/8` |
//! | CNLF | 1: never forgotten | `θ_E < θ_I` |
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `A`, `M + τ² L_k + τ L_c` | [`drape_integrator::LaplacianSolver::matrix`] | kg | `n` × `n`, scalar |
//! | `b` | `b` | kg m/s | `n` × 3 |
//! | `v_{n+1}` | `velocity` | m/s | `n` × 3 |
//! | `F2` | [`drape_model::LinearSplit::add_nonlinear_force`] | N | `n` × 3 |
//! | `F`, `G` | `explicit`, `linear` in `split_forces` | N | `n` × 3 |
//! | `a`, `b`, `c` with an index | [`Coefficients`] | – | 3, 3, 2 |
//! | `X*` | `position`, until the step ends | m | `n` × 3 |
//! | `τ` | [`Coefficients::tau`] | s | |
//! | `ω = h_n/h_{n−1}` | `omega` | – | |
//! | `ε` | `forcing_term` | – | |
//! | `θ = h²k/m` | `theta` | – | |
//! | `P` | `preconditioner` (approximates `A⁻¹`) | 1/kg | |
//! | `S` | [`drape_solvers::Constraints`] | – | 3 × 3 a particle |
//!
//! # Where they failed here, and what they cost
//!
//! *Locking*: with IMEX Euler a spring at rest length loses transverse velocity by `1/(1+θ)` a
//! step. Two particles in free rotation keep `L_{n+1} = L_n/(1 + θ + η)`, here with `θ = 2h²k/m`,
//! `η = 2hc/m` of the pair, whatever the amplitude.
//!
//! *Updated, as printed*: the predictor with a loose `ε` injects energy, from `εθ` of some tenths
//! on. Explicit springs that the matrix does not dominate make updated CG gain energy, hence
//! `implicit=springs` by default there. With `split=paper` a spring that is caught on a much
//! steeper piece springs back with more energy than it came with.
//!
//! *Two steps*: no theorem bounds the energy. A compressed spring is an explicit one with too much
//! stiffness, `θ_E = −σθ_I` with `σ = ℓ/L > 1`. SBDF2 multiplies its sideways motion by up to
//! `σ + √(σ² − σ)` a step until the spring has turned.
//!
//! *Order.* A smooth sheet of 6 × 6 particles with `h` = 0.6 ms. Observed orders of the two-step
//! methods are 1.97 to 1.99, with full and projected damping, at constant and at alternating steps:
//!
//! | | error over the motion |
//! |---|---|
//! | IMEX Euler | 2.9e-3 |
//! | backward Euler | 2.3e-3 |
//! | SBDF2 | 1.7e-5 |
//! | CNLF | 1.1e-5 |
//! | MCNAB2 | 0.9e-5 |
//! | CNAB2 | 0.8e-5 |
//!
//! *Locking of a sheet.* A sheet of 20 × 20 particles that falls from two corners, shear 0.1 k,
//! `d/m` = 40 1/s, `h` = 0.01 s; path of the middle of the free edge within 1 s over its path with
//! backward Euler, all springs implicit, and CG iterations per step:
//!
//! | `k/m` | 1e4 | 1e5 | 1e6 | 1e7 | 1e8 | CG at 1e6 |
//! |---|---|---|---|---|---|---|
//! | IMEX Euler | 0.90 | 0.37 | 0.08 | 0.013 | 0.001 | 3.6 |
//! | SBDF2 | 1.03 | 1.03 | 0.79 | 0.26 | 0.04 | 8.1 |
//! | CNAB2 | 1.02 | 1.03 | 0.93 | 0.41 | 0.07 | 7.6 |
//! | MCNAB2 | 1.02 | 1.03 | 0.91 | 0.38 | 0.06 | 7.9 |
//! | CNLF | 1.02 | 1.03 | 0.94 | 0.41 | 0.07 | 11.6 |
//!
//! The double root holds at rest length and for slow turns. In a turn of `φ` a step SBDF2 loses
//! `φ²` of the spin a step, as backward Euler does. MCNAB2 loses half of it, at any stiffness above
//! `θ` = 100. CNAB2 and CNLF ring: at `θ` ≥ 1e4 and `φ` = 0.05 their spin wanders by a factor of
//! several.
//!
//! *Energy.* Up to `k/m` = 1e7 no run of that sheet over 2 s, damped or not, rose above its start,
//! but for CNLF by up to 1e-5 J. Rises of up to 0.05 J were seen at 1e8, and of 4 to 13 J at 1e10,
//! where 2 J can be set free: compressed springs again. With explicit shear MCNAB2 reached 1e6 J
//! there.
//!
//! *Tolerance.* With `ε` = 0.1 relative to `|b|` CNAB2 gained 18 J at `k/m` = 1e8 and SBDF2 0.7 J
//! at 1e6. Relative to the forces neither gained any, for 1.3 times the iterations. 1e-2 suffices
//! for a path right to 1e-3 up to 1e6. Avoid loose tolerances with the extrapolated start: 0.1 with
//! SBDF2 at 1e5, undamped, gained 0.06 J.
//!
//! *Impacts.* A cloth comes down on a table without gaining energy with SBDF2, CNAB2 and MCNAB2 at
//! `k/m` = 1e4 (`h` = 0.01 s) and 1e6 (0.005 s). With CNLF it gains 13 J at 1e6, where 0.6 J can be
//! set free: contacts feed its parasite. A single stiff rod (`θ` = 1e4) that lands on one end is
//! beyond all of them: the impact compresses it, and it springs up or off sideways instead of
//! falling over as with backward Euler. IMEX Euler leaves it standing on its end.
//!
//! To try next: drop the past after a hard impact and take a step of backward Euler (more robust,
//! and an order of magnitude dearer in scenes that are always in contact); follow the direction of
//! `F2` instead of its components when extrapolating.

#[doc = include_str!("../docs/errata.md")]
pub mod errata {}
mod ledger;
mod right_hand_side;
mod settings;
mod splitting;
mod step;
#[cfg(test)]
mod tests;
mod two_step;
mod workspace;

pub use settings::{
    Estimator, IMEX_EULER, IMEX_UPDATED, ImexEulerSettings, ImexUpdatedSettings, Safeguard,
};
pub use step::{EULER, ImexEuler, ImexUpdated, UPDATED};
pub use two_step::{
    CNAB2, CNLF, Coefficients, IMEX_CNAB2, IMEX_CNLF, IMEX_MCNAB2, IMEX_SBDF2, ImexTwoStep,
    ImexTwoStepSettings, MCNAB2, SBDF2, TwoStep, TwoStepValues,
};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] = &[
    ("src/lib.rs", include_str!("lib.rs")),
    ("src/step/euler.rs", include_str!("step/euler.rs")),
    ("src/step/robust.rs", include_str!("step/robust.rs")),
    ("src/two_step/step.rs", include_str!("two_step/step.rs")),
    ("src/two_step/coefficients.rs", include_str!("two_step/coefficients.rs")),
];
