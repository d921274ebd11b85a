//! Vertex block descent of Chen, Liu, Yang and Yuksel (2024): backward Euler by sweeps of 3×3
//! Newton steps, one particle at a time.
//!
//! builds-on: backward Euler → **vertex block descent**
//!
//! # What it is
//!
//! A step of backward Euler is the minimum of a potential over all particles. Newton's method finds
//! it with one large matrix. Vertex block descent moves one particle at a time to the minimum over
//! its own three coordinates, and sweeps over all particles a fixed number of times: nonlinear
//! Gauss-Seidel by blocks. It needs no matrix, no factorisation and no line search, and particles
//! without a common spring move in parallel. Take it where steps resolve the springs, `θ = h²k/m ≤
//! 1`: there 20 sweeps solve the step of backward Euler. Do not take it for stiff
//! cloth at large steps.
//!
//! # The mathematics
//!
//! The potential is that of [backward Euler](drape_integrator::IncrementalPotential). The unknown
//! is the velocity, `x = x_n + h v`:
//!
//! ```text
//! Φ(v) = ½‖v − v̂‖²_M + U(x_n + h v) + (h/2) vᵀ D(x_n) v      v̂ = v_n + h M⁻¹ f_explicit     (V1)
//! g_i  = m_i (v_i − v̂_i) − h f_i(x) + h (D v)_i              one particle's gradient         (V2)
//! H_i  = m_i I + h² K_ii + h D_ii                            and its block of the Hessian    (V3)
//! v_i ← v_i − (S H_i S + m_i (I − S))⁻¹ S g_i                for each i, colour by colour    (V4)
//! v^{(s)} ← ω_s (v^{(s)} − v^{(s−2)}) + v^{(s−2)}            on request, from sweep 2 on     (V5)
//! x_{n+1} = x_n + h v_{n+1}                                                                  (V6)
//! ```
//!
//! * **Blocks.** A spring adds `k [ûûᵀ + max(0, 1 − ℓ/L)(I − ûûᵀ)]` to `K_ii`; on springs with
//!   measured tension `T'` and `T/L` take the places of `k` and `k (1 − ℓ/L)`. Without the clamp a
//!   block is indefinite in compression. Angles and hinges add the projected blocks of
//!   [`drape_model::Stencils`]. `D` holds full damping, projected damping and the drag of the air,
//!   with directions and coefficients at level `n`; it is assembled once per step. Gravity is
//!   explicit.
//! * **Colours.** Each particle takes the least colour that no neighbour before it has. A grid with
//!   diagonals needs four. Particles of one colour do not feel each other, so results have the same
//!   bits for any number of threads. They do depend on the numbering of the particles.
//! * **Start.** `adaptive` starts at `v_n + σ (v̂ − v_n)`. The share `σ ∈ [0, 1]` of the explicit
//!   forces is the one that the last step followed: `σ = (v_n − v_{n−1})·(v̂ − v_n)/|v̂ − v_n|²`.
//!   It is 1 in free fall and 0 at rest. `inertial` starts at `v̂`, `previous` at `x = x_n`.
//! * **Chebyshev** (Wang 2015): `ω_2 = 2/(2 − ρ²)`, `ω_{s+1} = 4/(4 − ρ²ω_s)`; the setting
//!   `chebyshev` is `ρ`.
//! * **Augmented** (AVBD: Giles, Diaz, Yuksel 2025). For springs of finite stiffness AVBD is the
//!   same descent with stiffnesses `k̄ ≤ k` that rise, so that the first sweeps see a soft cloth
//!   and carry long waves:
//!
//!   ```text
//!   k̄ ← min(max(γ k̄, m/h²), k)                              at the start of a step          (V7)
//!   k̄ ← min(k̄ + β k |L − ℓ|/max(L, ℓ), k)                   after each sweep                (V8)
//!   ```
//!
//!   Three things differ from the authors' program. Its `β` is in N/m² and must be tuned to the
//!   scene; here it has no unit. Its least stiffness is 1 N/m; here it is `m/h²`. Its block takes
//!   the lengths of the columns of the geometric stiffness, which depend on the axes; here it is
//!   `|k̄ (1 − ℓ/L)| (I − ûûᵀ)`. Angles, hinges and curves of measured tension keep their laws.
//! * **Pins and contacts** are a filter `S` on each block and a prescribed part of `v_i`. Release
//!   and friction solve again, from the last iterate, as in every method
//!   ([`drape_integrator::ContactSet::solve`]). The impulse that decides is `∇Φ` at the end of the
//!   sweeps, so it carries their error.
//! * **Order and stability.** Where the sweeps converge: order 1, and on linear problems the
//!   amplification matrix of backward Euler, `1/(1+θ+η) · [[1+η, 1], [−θ, 1]]`. A particle that
//!   hangs on pins alone is one block, which one sweep solves. Each block step descends on a model
//!   of `Φ`, and `Φ` is not the energy: theory bounds neither.
//! * **Conservation.** Converged steps conserve linear momentum. Two particles show what a fixed
//!   number of sweeps leaves: with `a = h²k/m + hc/m` an error falls by `(a/(1 + a))²` in a sweep,
//!   and the momentum changes by the difference of the two errors. A mesh is slower: from `θ = 100`
//!   on, its long waves hardly move in 100 sweeps.
//! * **Report.** The number of sweeps is fixed, so a step always reports `Converged`. The relative
//!   residual is that of backward Euler's stop test at the end of the step.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `v̂` | `target` | m/s | `n` × 3 |
//! | `g_i`, `H_i` | `gradient`, `block` | kg m/s, kg | 3, 3 × 3 a particle |
//! | `S` | [`drape_solvers::Filter`] | – | 3 × 3 a particle |
//! | `ρ`, `ω` | `chebyshev`, `omega` | – | |
//! | `k̄` | `penalty` | N/m | per spring |
//! | `β`, `γ` | `beta`, `gamma` | – | |
//!
//! # Where it failed here, and what it cost
//!
//! The sheet of the measurements has 400 particles on two pins, shear springs of 0.1 k, `h` = 0.01
//! s, so that `θ` = `k/m` / 10⁴.
//!
//! *Like every relaxation, it removes stiff stretch slowly.* The table shows the error of one step
//! from the inertial start, over the error of that start:
//!
//! | | θ = 1: 10 | 30 sweeps | θ = 100: 10 | 30 | 100 | 400 | θ = 10⁴: 30 | 100 | 400 |
//! |---|---|---|---|---|---|---|---|---|---|
//! | `chebyshev=0` | 3.7e-4 | 3.0e-10 | 0.55 | 0.43 | 0.20 | 9.0e-3 | 0.92 | 0.88 | 0.71 |
//! | `chebyshev=0.95` | 7.0e-2 | 2.4e-4 | 0.41 | 0.20 | 1.7e-2 | 4.6e-7 | 0.95 | 0.73 | 0.51 |
//! | `chebyshev=0.99` | 0.39 | 5.3e-2 | 0.43 | 4.9e-2 | 8.3e-6 | 3.5e-12 | 1.02 | 0.56 | 0.31 |
//!
//! At `θ` = 100 Chebyshev's method with 0.99 needs 44 sweeps for 1 %, plain sweeps 390. At `θ` = 1
//! it is seven times slower than plain sweeps: `ρ` belongs to one stiffness and one mesh.
//!
//! *Unsolved steps lose motion.* Damping `d/m` = 40/s; error `e` of positions over the motion after
//! 0.3 s, path of the middle of the free edge over the exact path after 0.3 s (`R`), and path after
//! 2 s:
//!
//! | | `e`, 1e4 | `e`, 1e6 | `R`, 1e6 | path in 2 s, 1e6 | `R`, 1e8 | `R`, 1e10 |
//! |---|---|---|---|---|---|---|
//! | Newton's method | 0.028 | 0.021 | 1.029 | 4.57 m | | |
//! | 20 sweeps | 0.028 | 0.251 | 0.970 | 3.14 m | 0.752 | 0.616 |
//! | 100 sweeps | 0.028 | 0.066 | 1.012 | 4.25 m | 0.776 | 0.717 |
//! | 20 sweeps, `start=inertial` | 0.028 | 0.271 | 0.966 | 2.87 m | | |
//! | 20 sweeps, `start=previous` | 0.028 | 0.362 | 0.913 | 1.43 m | | |
//! | 20 sweeps, `chebyshev=0.95` | 0.028 | 0.104 | 1.004 | | | |
//! | 100 sweeps, `chebyshev=0.99` | 0.028 | 0.021 | 1.029 | | | |
//!
//! *Energy, `k/m` = 1e6, 2 s:* greatest rise of the total energy and its change, J.
//!
//! | | `d/m` = 40/s: rise | change | undamped: rise | change |
//! |---|---|---|---|---|
//! | 20 sweeps | 0 | −1.869 | 0.068 | −0.740 |
//! | 20 sweeps, `start=inertial` | 0 | −1.463 | 1.660 | −0.687 |
//! | 20 sweeps, `start=previous` | 0 | −1.934 | 0 | −1.607 |
//! | 100 sweeps | 0 | −1.617 | 0 | −1.151 |
//! | 100 sweeps, `chebyshev=0.95` | 0 | −1.507 | 0 | −1.134 |
//!
//! Damping does not stabilise a stiffer sheet: at 1e8 with 20 sweeps the energy rises by 4.0 J
//! within 0.3 s and by 23.5 J within 2 s, all of it in springs that were not solved. 100 sweeps
//! gain none.
//!
//! *Augmented stiffness helps.* Distance from Newton's method over the motion after 0.3 s:
//!
//! | | 1e6, 20 sweeps | 1e6, 100 | 1e8, 20 | 1e8, 100 |
//! |---|---|---|---|---|
//! | plain | 0.255 | 0.069 | 0.511 | 0.469 |
//! | `augmented=true` (`beta=0.1`) | 0.080 | 0.015 | 0.306 | 0.193 |
//! | `beta=1` | 0.155 | 0.049 | 0.413 | 0.331 |
//! | `beta=10` | 0.233 | 0.066 | 0.489 | 0.427 |
//!
//! The price is softer springs, and with 20 sweeps at 1e6 a rise of the energy by 0.08 J.
//!
//! *Cost.* By counted operations a sweep is about four force evaluations. By the clock, on one core
//! of a shared machine, it is 19: 51 µs for 400 particles, four at a time (module `lanes`), and 70
//! µs one by one. The forces of the same sheet take 2.7 µs in a kernel that goes along diagonals.
//!
//! *Public code.* `SolverVBD` of the physics engine Newton 1.8.0 (warp-lang 1.19.0) solves the same
//! (V2)–(V4) in single precision, from the inertial start. On undamped springs that stay stretched,
//! with the same colours, its positions agree with ours to 2e-7 m after four steps. Three things
//! differ. `drape_oracle::published` writes both forms out: a loop with the formulas of Newton
//! reproduces its positions to 2e-7 m, and a loop with ours reproduces ours to round-off.
//!
//! | | Newton | here | difference after four steps |
//! |---|---|---|---|
//! | colours | given by the user, or another algorithm | least free one | 1.3e-4 m, two sweeps |
//! | compression | `1 − ℓ/L`, which may make a block indefinite | no less than 0 | 2.9e-4 m |
//! | damping | `−(c/h)(L − L_n) û` along the iterate | `D(x_n) v` | 2.8e-3 m |
//!
//! Full damping, angles, Chebyshev's method, contacts and `augmented` do not map: its augmented
//! form is for rigid bodies.
//!
//! *The start `previous`* lets a stiff sheet that falls along its own plane stand in the air: the
//! sweeps must hand the weight from particle to particle. The other two starts fall exactly.
//!
//! # References
//!
//! * Chen, Liu, Yang, Yuksel 2024, "Vertex Block Descent", ACM Transactions on Graphics 43(4), doi
//!   10.1145/3658179.
//! * Giles, Diaz, Yuksel 2025, "Augmented Vertex Block Descent", ACM Transactions on Graphics
//!   44(4), doi 10.1145/3731195.
//! * Wang 2015, "A Chebyshev semi-iterative approach for accelerating projective and position-based
//!   dynamics", ACM Transactions on Graphics 34(6), doi 10.1145/2816795.2818063.

mod lanes;
mod ledger;
mod rows;
mod settings;
mod step;
mod sweep;
mod terms;
#[cfg(test)]
mod tests;

pub use settings::{Start, VBD, VbdSettings};
pub use step::{REGISTRATION, Vbd};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/sweep.rs", include_str!("sweep.rs"))];
