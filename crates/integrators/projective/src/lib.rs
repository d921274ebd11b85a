//! Projective dynamics: backward Euler by a fixed number of iterations with a constant matrix, and
//! four ways to accelerate them.
//!
//! builds-on: backward Euler → updated CG → **projective dynamics** → vertex block descent
//!
//! # What it is
//!
//! Backward Euler needs a new matrix and its factor in each iteration of Newton's method. Liu,
//! Bargteil, O'Brien and Kavan (2013) and Bouaziz et al. (2014) replace the Hessian by a constant
//! matrix that bounds it from above. An iteration then has two steps. The *local* step projects
//! each spring on its rest length, for each spring alone. The *global* step solves one linear
//! system, whose matrix is factorised once for all steps. Games and films run ten iterations a
//! frame and show what results.
//!
//! Take it where the time for a frame is fixed and `h²k/m` is at most some tens. Take it with
//! `acceleration=lbfgs` and a `residual` to solve backward Euler without factorisations. For stiff
//! cloth take Newton's method, or many small explicit steps: ten iterations leave stiff cloth
//! nearly motionless.
//!
//! # The mathematics
//!
//! Every member minimises the
//! [incremental potential](drape_integrator::IncrementalPotential) of backward Euler,
//!
//! ```text
//! Φ(v) = ½‖v − v̂‖²_M + U(x_n + h v) + ½ h vᵀ D v        v̂ = v_n + h M⁻¹ f_frozen       (P1)
//! A    = M + h² L_k + h L_c                                                            (P2)
//! ```
//!
//! from the inertial velocity `v⁰ = v̂`, with the gradient filtered by the constraints `S`:
//!
//! ```text
//! f^k = −A⁻¹ S ∇Φ(v^k)            v^{k+1} = v^k + f^k                                  (P3)
//! x_{n+1} = x_n + h v_{n+1}
//! ```
//!
//! | setting `acceleration` | from `f^k` to `v^{k+1}` | lowers `Φ`? | forces and energies an iteration |
//! |---|---|---|---|
//! | `none` | (P3) | always | 1 |
//! | `chebyshev` (Wang 2015) | three-term recurrence with a guessed `ρ` (P5) | not checked | 1 |
//! | `anderson` (Peng et al. 2018) | secants of the fixed-point map (P6), (P7) | checked, else (P3) | 2 to 3 |
//! | `lbfgs` (Liu, Bouaziz, Kavan 2017) | quasi-Newton from `A⁻¹` (P8), line search (P9) | Armijo, else (P3) | 2 or more |
//! | `admm` (Overby et al. 2017) | a copy and a multiplier of each spring (P10)–(P12) | no | 2 |
//!
//! Each iteration solves one system with three right-hand sides. Each acceleration has its file in
//! `iteration`, with its equations.
//!
//! * **Descent.** The Hessian of `Φ` never exceeds `A`, since `T' ≤ k` and `T/L ≤ k`. So each plain
//!   iteration lowers `Φ`: `Φ(v^{k+1}) ≤ Φ(v^k) − ½‖f^k‖²_A` (P4). A low `Φ` bounds no energy while
//!   it is above the minimum.
//! * **Rate.** Across a spring of length `L`, (P3) leaves the part `q = θ (ℓ/L)/(1 + θ + η)` of the
//!   error. That is 0.99 at rest length and `θ = 100`. Along springs, and at rest length 0, one
//!   iteration is exact. The number of iterations for a given error grows like `θ`, with
//!   Chebyshev's method like `√θ`.
//! * **Relation to updated CG.** (P3) is its fixed-point iteration. The differences are an exact
//!   global step, a fixed number of iterations, and the start at `v̂` in place of `v_n`.
//! * **Order and stability.** Converged, it is backward Euler: order 1, L-stable on linear
//!   problems, with its law of spin. Short of that a step lies between free flight and backward
//!   Euler.
//! * **Conservation.** Momentum is exact after any number of iterations: `v̂` has it, and the
//!   columns of `A` add up to the masses.
//! * **Springs.** All springs are implicit. Those with several slopes take their steepest one in
//!   `A`. *Projected damping* stands in `Φ` with its directions at `x_n`, and in `A` as full
//!   damping, which bounds it. Angles, hinges and air stay at the old level.
//! * **Constraints.** Pins and contacts filter the gradient and the change of velocity. With
//!   contacts the factor no longer solves the global step; it preconditions conjugate gradients.
//!   Friction follows the normal impulses, which are part of `∇Φ` at the last iterate.
//! * **Stop test.** By default the number of iterations is fixed. The report has the residual that
//!   they leave, relative to the change of velocity that the forces would make, and the status
//!   `Converged`, since no tolerance was missed. With `residual` above 0 the iteration stops there;
//!   if `iterations` do not suffice, the status is `IterationLimit`. Round-off always stops.
//! * **Settings.** `chebyshev` begins after ten plain iterations: with `iterations=10` it is
//!   `none`. `rho` is the rate that it expects. It must grow with `θ`: a value that is too small
//!   helps little, and one that is too large stalls. `memory` counts the past iterates of
//!   `anderson` and `lbfgs`. They belong to one step; none is carried over.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `A` | [`drape_integrator::LaplacianSolver::matrix`] | kg | `n` × `n`, scalar |
//! | `Φ`, `v̂` | [`drape_integrator::IncrementalPotential`] | J, m/s | –, `n` × 3 |
//! | `v^k` | `v` | m/s | `n` × 3 |
//! | `S ∇Φ(v^k)` | `gradient` | kg m/s | `n` × 3 |
//! | `f^k` | `residual` | m/s | `n` × 3 |
//! | `ω`, `ρ` | `omega`, `rho` | – | |
//! | `θ_j` of (P6) | `theta` | – | `memory` |
//! | `s_j`, `y_j` | `s`, `y` | m/s, kg m/s | `n` × 3 each |
//! | `u` | `multipliers` | m | springs × 3 |
//! | `θ = h²k/m`, `η = hc/m`, `ℓ/L` | – | – | |
//!
//! # Where it failed here, and what it cost
//!
//! *Convergence.* A sheet of 20 × 20 particles that hangs from two corners, shear springs of 0.1 k,
//! undamped, after 0.2 s; one step of 0.01 s. What is left of the distance between `v̂` and
//! Newton's minimum:
//!
//! | iterations | θ = 1: 10 | 30 | θ = 100: 10 | 30 | 100 | 400 | θ = 1e4: 30 | 100 | 400 |
//! |---|---|---|---|---|---|---|---|---|---|
//! | `none` | 2.9e-2 | 3.6e-4 | 0.480 | 0.353 | 0.182 | 3.1e-2 | 0.890 | 0.743 | 0.494 |
//! | `chebyshev`, `rho=0.95` | 2.9e-2 | 6.2e-5 | 0.480 | 0.213 | 5.0e-2 | 7.5e-4 | 0.784 | 0.534 | 0.381 |
//! | `chebyshev`, `rho=0.99` | 2.9e-2 | 2.9e-3 | 0.480 | 9.8e-2 | 6.3e-3 | 5.9e-6 | 0.642 | 0.440 | 0.296 |
//! | `chebyshev`, `rho=0.999` | 2.9e-2 | 1.8e-2 | 0.480 | 0.249 | 1.2e-2 | 2.1e-8 | 0.488 | 0.318 | 0.165 |
//! | `anderson` | 4.2e-4 | 2.0e-9 | 0.302 | 5.2e-2 | 1.3e-4 | 8.3e-11 | 0.492 | 0.291 | 9.3e-2 |
//! | `lbfgs` | 1.6e-3 | 3.2e-8 | 0.293 | 6.3e-2 | 1.0e-3 | 2.8e-8 | 0.485 | 0.280 | 3.5e-2 |
//! | `admm` | 3.3e-2 | 5.3e-4 | 0.481 | 0.353 | 0.182 | 3.1e-2 | 0.890 | 0.743 | 0.494 |
//!
//! At `θ` = 1 everything converges. At `θ` = 1e4 nothing does within 400 iterations, where Newton's
//! method takes eight. ADMM converges as fast as the plain iteration: its multipliers pay off for
//! materials other than springs.
//!
//! *Locking.* The same sheet with `d/m` = 40 1/s, 0.3 s at `h` = 0.01 s; path of the middle of the
//! free edge over that of the exact motion. Backward Euler has 1.03:
//!
//! | `k/m` | 1e4 | 1e6 | 1e8 | 1e10 |
//! |---|---|---|---|---|
//! | `none`, 10 iterations | 1.03 | 1.03 | 0.18 | 0.11 |
//! | `none`, 50 | 1.03 | 1.03 | 0.45 | 0.10 |
//! | `chebyshev`, `rho=0.99`, 50 | 1.03 | 1.03 | 0.96 | 0.12 |
//! | `anderson`, 10 | 1.03 | 1.03 | 0.40 | 0.10 |
//! | `anderson`, 30 | 1.03 | 1.03 | 1.07 | 0.11 |
//! | `lbfgs`, 10 | 1.03 | 1.01 | 0.34 | 0.10 |
//! | `lbfgs`, 30 | 1.03 | 1.03 | 1.17 | 0.11 |
//! | `admm`, 10 | 1.03 | 1.03 | 0.18 | 0.11 |
//!
//! "Unconditionally stable" means standstill here. A ratio near 1 may also deceive: `lbfgs` with 30
//! iterations at 1e8 *stretches*, and its error is 11 % of the motion, with the fall 19 % too deep.
//! The error of `none` with ten iterations is 2.8 % at 1e4, which is that of backward Euler to four
//! digits; 3.8 % at 1e6, where backward Euler has 2.1 %; and 81 % at 1e8.
//!
//! *Cost* of a step of that sheet: ten plain iterations evaluate forces 13 times and solve 10
//! times; ten of `anderson` 23, of `lbfgs` 24 times. A relative residual of 0.5 is left at `k/m` =
//! 1e6 after ten plain iterations, 0.16 after ten of `anderson`, and 0.02 after 30 of `lbfgs`.
//!
//! *Energy.* Over 2 s at `k/m` = 1e6, `h` = 0.01 s, undamped or with `d/m` = 40 1/s, the energy of
//! no form above rose over its start. It ended 1.04 to 1.14 J lower undamped (backward Euler 1.13
//! J), and 1.50 to 1.52 J lower damped.
//!
//! *Near round-off.* Decreases of `Φ` drown in round-off from some 1e-7 of the velocities on. There
//! the line search of `lbfgs` accepted noise, and a pair `s, y` of noise spoilt the next direction:
//! 1000 iterations did not reach a residual of 1e-10. Full steps that ignore such pairs reach it.
//!
//! *Multipliers.* Two particles that spin through compression, `θ` = 20: `admm` left a residual of
//! 6e-8 after 1000 iterations. A spring that turns round moves the target of its own multiplier.
//!
//! # References
//!
//! * Liu, Bargteil, O'Brien, Kavan, *Fast simulation of mass-spring systems*, ACM Trans. Graph.
//!   32(6), 2013, doi 10.1145/2508363.2508406.
//! * Bouaziz, Martin, Liu, Kavan, Pauly, *Projective dynamics*, ACM Trans. Graph. 33(4), 2014, doi
//!   10.1145/2601097.2601116.
//! * Wang, *A Chebyshev semi-iterative approach for accelerating projective and position-based
//!   dynamics*, ACM Trans. Graph. 34(6), 2015, doi 10.1145/2816795.2818063.
//! * Peng, Deng, Zhang, Geng, Qin, Liu, *Anderson acceleration for geometry optimization and
//!   physics simulation*, ACM Trans. Graph. 37(4), 2018, doi 10.1145/3197517.3201290.
//! * Liu, Bouaziz, Kavan, *Quasi-Newton methods for real-time simulation of hyperelastic
//!   materials*, ACM Trans. Graph. 36(3), 2017, doi 10.1145/2990496.
//! * Overby, Brown, Li, Narain, *ADMM ⊇ projective dynamics*, IEEE Trans. Vis. Comput. Graph.
//!   23(10), 2017, doi 10.1109/TVCG.2017.2730875.

mod iteration;
mod ledger;
mod settings;
mod step;
#[cfg(test)]
mod tests;

pub use settings::{Acceleration, PROJECTIVE, ProjectiveSettings};
pub use step::{Projective, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
