//! The precomputed inverse of Desbrun, Schröder and Barr (1999): implicit integration by one constant
//! filter.
//!
//! builds-on: backward Euler → Baraff-Witkin → **Desbrun** → Kang → IMEX
//!
//! # Why
//!
//! The cost of an implicit step is its linear system. Desbrun, Schröder and Barr replace the Hessian of the springs by the part that
//! never changes, the graph Laplacian of the stiffnesses, so that the matrix `A = M + h² L_k + h L_c` can be
//! inverted once, before the simulation. A step multiplies the springs' force, with an artificial viscosity
//! that stems from the implicit velocity, by that inverse:
//!
//! ```text
//! F̃ = F(x_n) − h L_k v_n − L_c v_n            internal force with viscosity
//! F_filtered = M A⁻¹ F̃                         the filter W = M A⁻¹
//! v_{n+1} = v_n + h M⁻¹ (F_filtered + f_external)          x_{n+1} = x_n + h v_{n+1}
//! ```
//!
//! Viscosity passes the filter, gravity does not. Up to that, this *is* IMEX Euler (EEH (21)) with another solver:
//! with `torque=none` and without external forces the two give the same trajectory.
//!
//! What the constant matrix does wrong is rotation: it resists sideways motion of every spring. The filtered forces
//! no longer sum up to zero torque, and Desbrun et al. correct that after the step (`torque`).
//!
//! # How the code does it
//!
//! * `inverse=cholesky` (default) keeps a sparse Cholesky factor of `A`; `inverse=dense` keeps `A⁻¹` itself, `n²` numbers and as many of work space, as
//!   published. Both are exact. A dense inverse that would take more than `memory_limit_mib` is refused before it is
//!   allocated. Both are rebuilt, and the step that needs it is charged, when `h`, a stiffness, a damping coefficient, a
//!   mass or a pin changes. Rows of pinned particles are taken out; their springs stay in the diagonal of
//!   their neighbours.
//! * `torque` (module `torque`): `none`; `literal`, the published formula, in which the correction has the unit of
//!   force × length² × time and so depends on the units of the scene; `consistent` (default), the rigid rotation that
//!   restores the angular momentum which the filter took (full damping has a torque of its own, which stays). Pins and contacts may take any torque: with a pinned particle `consistent` does
//!   nothing.
//! * `inverse_dynamics=true` shortens over-stretched springs after the step like Provot
//!   ([`drape_integrator::ElongationLimit`]); the velocity is the distance moved over `h` in any case.
//! * Contacts act on the velocity that results, particle by particle: the inverse is that of the free cloth.
//!
//! # What it cost and where it failed here
//!
//! Order 1, momentum conserved. With `torque=none`, full damping, no contacts and not both pins and gravity it *is* IMEX Euler: its
//! energy never rises, and a stiff sheet *locks*: springs lose sideways velocity by `1/(1+θ)` a step. Neither contacts, which act
//! outside the filter, nor the corrections have such a theorem: the stiff square table gained 0.4 J at h = 0.01 s. The torque correction restores the rotation of the whole and nothing else; drape and folds stay locked. Filtered
//! gravity would be slower still; unfiltered gravity beside pins costs the energy theorem.
//!
//! The dense inverse costs `n²` numbers and products a step and `n³` operations at each change; the sparse factor gives the same
//! motion for a small fraction of both. A change of `h` or `k` does not forbid the method, it costs one factorisation.
//!
//! Measured on the hanging sheet of 400 particles with shear springs of 0.1 k, k/m = 1e6, h = 0.01 s: a step costs 25 to 65 µs with the sparse
//! factor and about 130 µs with the dense inverse, against 40 to 90 µs of IMEX Euler by conjugate gradients and 7 ms of backward Euler; after a
//! second the free edge hangs 0.22 m low instead of 0.47 m. A free sheet that spins in its plane keeps 5 % of its angular
//! momentum in a second at k/m = 1e4 without correction, 15 % with the literal one and all of it with the consistent one.
//! The energy that this takes is not the one that the filter took: it rose by 12 % in that second, and from 15 J to 64 J within two
//! at k/m = 1e8 and 20 rad/s; the literal form diverged at 20 rad/s. Because gravity is not filtered, a hanging chain comes to rest
//! `(h² + hc/k) g` too long at its pin: small, but not the solution of the static problem.
//!
//! Plots: error against the step in `results/figures/order-smooth.svg` and `order-stiff.svg`, spin in
//! `momentum-spin.svg`, hard cases in `hard-cases.svg`.
//! What to try next: updating the right-hand side, which takes the locking back (`drape-imex`, EEH Algorithm 1).
//!
//! # Symbols
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `A` | [`drape_integrator::LaplacianSolver`] | kg | `n` × `n`, scalar |
//! | `h F̃` | [`drape_integrator::ViscousImpulse`] | kg m/s | `n` × 3 |
//! | `F_filtered` | `filtered` | N | `n` × 3 |
//! | `δT` | `torque` | N m | 3 |
//! | `θ = h²k/m` | – | – | |
//! | `I_G` | `inertia` | kg m² | 3 × 3 |

mod ledger;
mod settings;
mod step;
mod torque;

pub use settings::{DESBRUN, DesbrunSettings, Inverse, Torque};
pub use step::{Desbrun, REGISTRATION};
