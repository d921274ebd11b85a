//! Implicit-explicit Euler with a constant sparse matrix, and its updated form: the methods of
//! Eberhardt, Etzmuß and Hauth (2000), "EEH".
//!
//! # Why
//!
//! The stiffness of a textile sits in its tension springs. Their force splits into a linear part and a
//! remainder of constant size, `f = −L_k x + F2(x)` with `F2_i = +k ℓ û`. IMEX Euler (19) takes the linear
//! part and the damping at the new level and everything else at the old one, so that each step is
//! one linear system with a *constant* matrix (21):
//!
//! ```text
//! A v_{n+1} = M v_n + h [F_explicit(x_n, v_n) − L_k x_n]      A = M + h² L_k + h L_c
//! x_{n+1}   = x_n + h v_{n+1}                                                       (20)
//! ```
//!
//! `A` is scalar (the same for x, y and z), symmetric, positive definite and diagonally dominant. (The
//! paper prints the signs of (16)–(18) and (21) so that the matrix would be indefinite; this is the
//! reading in which a stretched spring contracts. All readings are listed in [`errata`].)
//!
//! At very high stiffness the sheet *locks*: `A` resists sideways motion of every spring with the full
//! stiffness `k`, and only `F2`, frozen at `x_n`, could take that back. IMEX Euler equals symplectic
//! Euler with an extra damping of `h k` on each spring. Algorithm 1 re-evaluates `F2` at `x_n + h v` while
//! it iterates:
//!
//! ```text
//! repeat  b = M v_n + h [F_frozen − L_k x_n + F2(x_n + h v)]
//!         CG on A v = b from the present v until |r| ≤ ε |b|
//! until   an update of b needs no CG iteration
//! ```
//!
//! Its fixed point is backward Euler of the whole system when all springs stand in the matrix.
//!
//! # How the code does it
//!
//! [`ImexEuler`] and [`ImexUpdated`] share the right-hand side (`right_hand_side`), the matrix
//! ([`drape_integrator::LaplacianSolver`]), the predictor (22) and the contacts. What Algorithm 1 leaves
//! to the reader is a setting:
//!
//! * `safeguard=paper`: the loop above as printed (with the counter's test read as "first iteration of
//!   this pass", since the printed order can never take that branch). Only `F2` moves to `x_n + h v`: were
//!   `−L_k x` moved too, `h² L_k v` would count twice.
//! * `safeguard=robust` (default): each pass minimises a quadratic that lies above the
//!   [incremental potential](drape_integrator::IncrementalPotential) and touches it at the present `v`, and
//!   CG lowers that quadratic at every iteration; so the potential falls monotonically. The safeguards
//!   keep this property alive: the start is the better of `v_n` and the extrapolation; the stop test
//!   refers to the change of velocity that the forces would make in the step, instead of `|b|`, which grows like `θ`
//!   and with the speed of the whole; reaching the outer cap, or `θ` above `newton_above`, continues
//!   with Newton; a step that gains energy is solved more tightly until it gains none or has
//!   converged; and where it can neither, a step of plain IMEX Euler takes its place.
//!
//! # What to expect
//!
//! *IMEX Euler, solved exactly, never gains energy*, for every `h` and `k`:
//! `H_{n+1} ≤ H_n − ½‖v_{n+1} − v_n‖²_M − h vᵀ L_c v`. Write `U = ½k|d|² − kℓ|d|`, a difference of convex
//! functions; the step takes the first part implicitly and the second explicitly (Eyre's splitting). The theorem needs
//! all stiff springs in the matrix, full damping, static pins and conservative external forces. It does
//! not cover projected damping, which the scalar matrix takes as `−L_c v` and corrects explicitly, explicit shear or
//! bending springs (a mode with `θ_E` explicit and `θ_I` implicit is stable while `θ_E < 4 + θ_I`), loose tolerances with the extrapolated
//! start, or contacts that push out.
//!
//! *Locking*: a spring at rest length loses transverse velocity by `1/(1+θ)` a step; two particles in free rotation keep
//! `L_{n+1} = L_n/(1 + θ + η)`, here with `θ = 2h²k/m`, `η = 2hc/m` of the pair, whatever the amplitude.
//!
//! *Updated, as printed*: the predictor with a loose `ε` injects energy, from `εθ` of some tenths on. Explicit springs that the
//! matrix does not dominate make updated CG gain energy, hence `implicit=springs` by default there.
//!
//! # Symbols
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `A` | [`drape_integrator::LaplacianSolver::matrix`] | kg | `n` × `n`, scalar |
//! | `b` | `b` | kg m/s | `n` × 3 |
//! | `v_{n+1}` | `velocity` | m/s | `n` × 3 |
//! | `F2` | [`drape_model::LinearSplit::add_nonlinear_force`] | N | `n` × 3 |
//! | `ε` | `forcing_term` | – | |
//! | `θ = h²k/m` | `theta` | – | |
//! | `P` | `preconditioner` (approximates `A⁻¹`) | 1/kg | |
//! | `S` | [`drape_solvers::Constraints`] | – | 3 × 3 a particle |

mod algorithm1;
#[doc = include_str!("../docs/errata.md")]
pub mod errata {}
mod right_hand_side;
mod settings;
mod step;
mod workspace;

pub use settings::{IMEX_EULER, IMEX_UPDATED, ImexEulerSettings, ImexUpdatedSettings, Safeguard};
pub use step::{ImexEuler, ImexUpdated};
