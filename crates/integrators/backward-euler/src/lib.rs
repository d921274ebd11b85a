//! Backward Euler, solved by Newton's method to convergence: the reference for every other implicit
//! method at the same step size.
//!
//! builds-on: explicit Euler → Provot → **backward Euler** → Terzopoulos-Fleischer, Baraff-Witkin,
//! BDF
//!
//! # What it is
//!
//! An explicit step must resolve the fastest vibration of the stiffest spring, although nobody
//! wants to see this vibration. A method that takes the force at the *new* level may step over it.
//! Take backward Euler as the reference at a given step, and where each step must be solved to
//! convergence. BDF2 costs the same and is more accurate.
//!
//! # The mathematics
//!
//! It is the BDF method (3) of EEH for `k = 1`, with the whole force at the new level:
//!
//! ```text
//! M (v_{n+1} − v_n) = h f(x_{n+1}, v_{n+1})          x_{n+1} = x_n + h v_{n+1}          (4)
//! ```
//!
//! (4) is the stationarity condition of the incremental potential
//! [`Φ(v) = ½‖v − v̂‖²_M + U(x_n + h v) + (h/2) vᵀ D v`](drape_integrator::IncrementalPotential),
//! which [`Newton`](drape_integrator::Newton) minimises (5). It starts at the best of `v_n`, the
//! inertial target `v̂` and the extrapolation (22). It uses the exact Hessian while this is
//! positive definite, otherwise the projected Hessian, and an Armijo line search.
//! [`drape_integrator::ImplicitStage`] evaluates the explicit forces, finds the contacts and
//! minimises.
//!
//! * **Order and stability.** Order 1, and L-stable on linear problems: on the oscillator the
//!   amplification matrix is `1/(1+θ+η) · [[1+η, 1], [−θ, 1]]`.
//! * **Conservation.** Linear momentum is conserved, to round-off with `solver=cholesky` and to the
//!   tolerance of the solve with the default solver, because the sum of a residual over the
//!   particles is a momentum. The angular momentum of one spring obeys
//!   `L_{n+1} = L_n / (1 + θ (1 − ℓ/len_{n+1}))`: this angular momentum decays in tension and
//!   *grows in compression*. So backward Euler is **not** energy monotone. It guarantees
//!   `Φ(v_{n+1}) ≤ Φ(v)`, up to round-off, for every start `v` that the step considers.
//! * **Stop test.** `‖S∇Φ‖_{M⁻¹} ≤ max(residual · scale, round-off)`. The scale is the change of
//!   velocity that the forces at the start would make in the step, so it does not depend on the
//!   frame. The round-off is that of forces of size `k|x|`, about `ε_mach h k |x|`, whatever the
//!   strain. At very large `h²k/m` Newton's method follows a curved valley and may need more than
//!   its 100 iterations; the step then reports `IterationLimit`.
//! * **Settings.** They cover further work that the paper names. They do not change the stop test,
//!   so the solution is the same. `jacobian=saved` keeps the factor over iterations and steps, for
//!   at most 20 steps, while corrections shrink by a factor of 0.3 or better, `h` changes by less
//!   than 20 %, and contacts and pins stay. `solver=cg` solves Newton's systems by conjugate
//!   gradients. `cg_tolerance` or the rule of Eisenstat and Walker (`forcing`) sets their
//!   tolerance; the diagonal blocks or the saved factor precondition them. `solver=multigrid`
//!   preconditions them by a cycle of [multigrid](drape_solvers::Multigrid) on the Hessian.
//!   `solver=auto`, the default, chooses one of the last two by the stiffness (see below), or the
//!   saved factor with `jacobian=saved`. `solver=cholesky` factorises in each iteration. It is the
//!   most exact solver, and for large sheets by far the slowest. `safeguard=work` continues
//!   [linearised](drape_integrator::Safeguard) steps that would gain energy. `tolerance` puts the
//!   method under [step size control](drape_integrator::Adaptive).
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `Φ` | [`drape_integrator::IncrementalPotential::value`] | J | |
//! | `v̂` | [`drape_integrator::IncrementalPotential::target`] | m/s | `n` × 3 |
//!
//! # Where it failed here, and what it cost
//!
//! The hanging sheet: 400 particles, shear springs of 0.1 k, k/m = 1e6, h = 0.01 s. With factors a
//! step takes three Newton iterations, each with one of 1200 unknowns: about 7 ms. In that time
//! symplectic Euler takes some 600 steps, although about 15 of its steps would cover the same
//! simulated time. The sheet falls like the exact one, while with IMEX Euler it locks. The error is
//! numerical damping: order 1 on a smooth scene, observed order 0.43 where springs of k/m = 1e6
//! vibrate within a step. A spinning sheet loses 4 % of its angular momentum in a second. BDF2 is
//! 1.7 to 3.4 times as accurate there.
//!
//! *Saved Jacobians, CG.* 25 steps of 0.01 s on the same sheet (from the record `solver-control`):
//!
//! | factorisations, Newton, CG iterations | `k/m` = 1e4 | 1e6 | 1e8 |
//! |---|---|---|---|
//! | fresh, Cholesky | 50, 50, 0 | 75, 75, 0 | 124, 109, 0 |
//! | saved, Cholesky | 4, 208, 0 | 24, 180, 0 | 116, 329, 0 |
//! | diagonal blocks, CG | 0, 112, 636 | 0, 125, 4126 | 0, 191, 11498 |
//! | saved, CG | 2, 97, 221 | 10, 111, 431 | 26, 163, 1147 |
//!
//! *Cost of a converged step* at k/m = 1e8 on a sheet of 52×52 particles with shear and bending
//! springs of 0.1 k. Mean of the first 20 steps of 0.01 s. One force evaluation takes about 0.1 ms,
//! one factorisation 15 ms, one solve with the factor 0.43 ms and one product 0.07 ms:
//!
//! | | factorisations | Newton | CG | force evaluations |
//! |---|---|---|---|---|
//! | fresh, Cholesky | 5.6 | 4.9 | | 19 |
//! | saved, Cholesky | 5.1 | 13.4 | | 44 |
//! | diagonal blocks, CG, Eisenstat-Walker | | 8.3 | 740 | 29 |
//! | saved, CG, `cg_tolerance` 0.3 | 1.0 | 11.7 | 49 | 36 |
//! | saved, CG, 0.1 | 1.0 | 8.4 | 40 | 27 |
//! | saved, CG, 0.01 | 1.0 | 5.7 | 63 | 20 |
//! | saved, CG, Eisenstat-Walker | 1.05 | 6.5 | 46 | 23 |
//! | the same, factor kept up to 40 CG iterations in a solve instead of 10 | 0.9 | 6.8 | 116 | 24 |
//! | the same, up to 80 | 0.5 | 6.8 | 181 | 24 |
//! | multigrid, CG, Eisenstat-Walker | | 5.9 | 32 | 22 |
//!
//! * All rows but the last, which was not compared there, end within 2e-12 m of each other, with
//!   the same residual. If springs are compressed, a step may have several solutions, and the path
//!   of the iteration decides which one it finds: on `sheet-on-sphere` multigrid ends 5 mm from the
//!   others after 0.2 s, with `cg_tolerance=1e-6` beside them.
//! * With `jacobian=saved,solver=cg` a step takes 0.6 of the time of fresh factors; the factor is
//!   renewed about once per step. The other settings differ little. With `solver=multigrid` it
//!   takes 0.3 of that time on 52×52 particles and 0.24 on 100×100. The number of cycles does not
//!   grow with the sheet. Since then multigrid sweeps over half of the matrix, and its products go
//!   along bands: a step takes half of that again. `results/profile.md` has all times, and `profile`
//!   in `benches` measures them again.
//! * A factor is worth 30 CG iterations, so it does not pay to keep it longer. At 1e8 a saved
//!   factor serves no more than one step as a solver, but still as a preconditioner.
//! * The factor of the scalar Laplacian `M + h² L_k + h L_c`, which never changes, needs half the
//!   iterations of the diagonal blocks (303 against 567 to 1e-3 on a matrix of this kind). It takes
//!   as long as they do, because the Laplacian is as stiff across the springs, where the cloth
//!   hardly resists, as along them. Multigrid does not have this disadvantage. Its weights come
//!   from the same Laplacian, but its coarse matrices are made from the Hessian.
//! * A factor in single precision saved 3 % of a step with `jacobian=saved,solver=cg`: arithmetic
//!   bounds the sweeps, and the factorisation is done once per step.
//! * A prototype of incomplete Cholesky without fill-in of the 3×3 blocks needed 119 iterations a
//!   step; diagonal blocks needed 743, multigrid 27. It took 1.4 times as long as multigrid. Coarse
//!   motions along the springs' directions, or with rotations, did not help.
//! * *Adaptive steps* follow the fall at nearly constant size. They find the right constant step,
//!   and gain nothing over it.
//!
//! *The solver by the stiffness.* `solver=auto` takes conjugate gradients with diagonal blocks in
//! stages up to `τ_x τ_v k/m = 200`, where `k` sums the stiffnesses of all springs at a particle,
//! and multigrid above, both with the rule of Eisenstat and Walker. The step starts at the
//! candidate with the least residual. It takes a full step if the gradients at both ends show that
//! the potential falls (approximate Wolfe conditions), and then evaluates no energy. So it takes
//! about half the force evaluations.
//!
//! From 1000 particles on, multigrid reuses its coarse matrices over the iterations of a stage
//! while a solve takes at most ten cycles. Conjugate gradients then run in
//! [single precision](drape_solvers::SinglePcg) up to `τ_x τ_v k/m` = 2000, on regular grids
//! without obstacles; contacts need blocks that single precision does not hold. The forcing terms
//! are at most 0.03, unless a looser solve reaches the goal, and at least 1e-5. Newton's residual,
//! in double precision, checks the result, so the step ends at the same residual. If single
//! precision fails, the rest of the stage is solved in double precision: by conjugate gradients up
//! to 200 and by multigrid above.
//!
//! The limit of 200 comes from the sheet of 52 × 52 particles of the table above. The next table
//! shows the processor time of a step, in units of a step of `baraff-witkin`, which is linearised
//! and solved less tightly. It covers the first 6 to 60 steps, with other work on the machine. Both
//! solvers were named, so they ran in double precision.
//! | `k/m` | greatest `h²k/m` as above | CG | multigrid | force evaluations of CG |
//! |---|---|---|---|---|
//! | 1e4 | 4.8 | 4.3 | 9.6 | 18 |
//! | 1e5 | 48 | 5.9 | 9.0 | 19 |
//! | 1e6 | 480 | 4.5 | 3.6 | 19 |
//! | 1e8 | 48 000 | 4.5 | 1.6 | 28 |
//!
//! Multigrid has since become twice as fast. The limits stayed: at k/m = 1e6 both solvers, when
//! named, take the same time, and single precision takes half of it.
//!
//! *How well to solve a linearised step.* With `max_iterations=1` no later iteration mends a loose
//! linear solution, and the first term of Eisenstat and Walker is 0.5. `auto` therefore solves the
//! last iteration that a step may take to 0.01. The table has both terms for steps with
//! `max_iterations=1,safeguard=work` on the square cloth of `animation` (400 particles, cotton blend,
//! light damping, 60 frames a second): the mean distance from the true surface, and the time a frame
//! on one core of AMD EPYC (family 25, model 17).
//! | method | term | 1 step a frame | 2 steps | 4 steps |
//! |---|---|---|---|---|
//! | `backward-euler` | 0.5 | 30 mm, 1.3 ms | 20 mm, 1.5 ms | 12 mm, 2.7 ms |
//! | | 0.01 | 21 mm, 1.5 ms | 13 mm, 2.6 ms | 8.1 mm, 3.2 ms |
//! | `bdf2` | 0.5 | 27 mm, 1.3 ms | 17 mm, 1.6 ms | 149 mm, 3.6 ms |
//! | | 0.01 | 9.6 mm, 1.2 ms | 4.1 mm, 2.5 ms | 2.0 mm, 3.2 ms |
//! | `generalized-alpha` | 0.5 | 24 mm, 1.3 ms | 24 mm, 1.5 ms | 173 mm, 3.4 ms |
//! | | 0.01 | 9.5 mm, 1.0 ms | 3.4 mm, 2.1 ms | 1.7 mm, 3.2 ms |
//! | `dirk` | 0.5 | 19 mm, 1.6 ms | 142 mm, 3.2 ms | 157 mm, 5.3 ms |
//! | | 0.01 | 3.1 mm, 2.5 ms | 1.4 mm, 3.6 ms | 0.4 mm, 5.3 ms |
//!
//! With four steps a frame a stage is soft enough for diagonal blocks. They leave the error in the
//! long waves, so half of the residual holds the whole cloth up. Multigrid, which solves the stages
//! of one and two steps, reaches long waves, too. The gain is not everywhere: on 2500 particles the
//! loose solve made the safeguard go on, which mended the nonlinear error as well (`bdf2` with one
//! step: 3.4 mm in 9.6 ms, now 5.4 mm in 8.7 ms). On a ball, backward Euler with one or two steps a
//! frame now exceeds the budget of work.
//!
//! `results/profile.md` has the time of the default. A converged step costs more than a linearised
//! one because it needs more products.
//!
//! Plots: work against error in `results/figures/control-work.svg`, error against the step in
//! `order-smooth.svg` and `order-stiff.svg`, spin in `momentum-spin.svg`, hard cases in
//! `hard-cases.svg`.

mod ledger;
mod settings;
mod step;

pub use settings::{BACKWARD_EULER, BackwardEulerSettings};
pub use step::{BackwardEuler, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
