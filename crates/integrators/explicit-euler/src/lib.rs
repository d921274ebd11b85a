//! Explicit Euler, symplectic Euler and leapfrog: the methods that need no solve.
//!
//! builds-on: **explicit Euler → symplectic Euler → leapfrog** → Provot → backward Euler
//!
//! # Why
//!
//! Explicit (forward) Euler is the explicit Adams method (2) of EEH for `k = 1`:
//!
//! ```text
//! x_{n+1} = x_n + h v_n          v_{n+1} = v_n + h M⁻¹ f(x_n, v_n)
//! ```
//!
//! Symplectic Euler differs in one index: the new velocity moves the positions,
//!
//! ```text
//! v_{n+1} = v_n + h M⁻¹ f(x_n, v_n)          x_{n+1} = x_n + h v_{n+1}
//! ```
//!
//! and with `damping=implicit` it solves `(M + h L_c) v_{n+1} = M v_n + h f_conservative(x_n)` first. Leapfrog (velocity
//! Verlet) kicks half before and half after the drift, which makes it symmetric and of order 2 for the same single
//! force `F` a step, since the last one serves the next step; its damping is Crank–Nicolson's:
//!
//! ```text
//! v½      = v_n + h/2 M⁻¹ (F(x_n) − D(x_n) v_n)
//! x_{n+1} = x_n + h v½
//! (M + h/2 L_c) v_{n+1} = M v½ + h/2 (F(x_{n+1}) + R(x_{n+1}, v_{n+1}))          R(x, v) = L_c v − D(x) v
//! ```
//!
//! This is Newmark's method with `β = 0`, `γ = ½`. `R` is 0 for full damping. Explicit Euler is the baseline that shows why
//! anything else is needed, symplectic Euler the one for cost, leapfrog at its stability limit what an implicit method
//! has to beat.
//!
//! On the oscillator `x'' = −κx − δx'` with `θ = h²κ`, `η = hδ`:
//!
//! | method | stable if |
//! |---|---|
//! | explicit Euler | `θ ≤ η` and `2η ≤ 4 + θ`: never without damping |
//! | symplectic Euler, damping explicit | `θ + 2η < 4` |
//! | symplectic Euler, damping implicit | `θ < 4 + 2η` |
//! | leapfrog | `θ < 4`, whatever `η` |
//!
//! The largest eigenvalue of `M⁻¹L_k` on a structural grid is at most `8 k/m`, hence `h < √(m/2k)` for
//! symplectic Euler and leapfrog. Both conserve linear and (undamped) angular momentum exactly and an
//! energy close to the true one.
//!
//! # How the code does it
//!
//! One file a method in `step`. In symplectic Euler the constrained new velocity moves a particle in contact. In
//! explicit Euler the old velocity does, so the constraint is imposed on it before it moves anything; in
//! leapfrog `v½` does. What the forces do after that, the obstacle stops.
//!
//! *Leapfrog's force* is kept from step to step for the system's [revisions](drape_model::System::revisions) and for
//! the positions, which are compared to the last bit at the start of each step: after any change from outside it is
//! evaluated anew, whether or not `restart` was called. Changes of velocity, step size and contacts do not touch it.
//!
//! *Leapfrog's damping.* Without damping there is no matrix. With full damping there is one solve, with projected damping
//! there are two: `R` is taken at `v_n` first, at the velocity that this gives then, which is what order 2 needs.
//! Predictions that save the second solve, `2 v½ − v_n` and `2 v_n − v_{n−1}`, are unstable on modes that `L_c` damps and
//! `D` does not, such as the swing of a stretched spring.
//!
//! *Leapfrog's substeps.* `step=auto` and `step=bound` divide the step that the caller asks for into equal substeps of at
//! most `safety · 2/√λ`. For `auto`, `λ` is 1.05 times an estimate of the largest eigenvalue of `M⁻¹∇²U` by power
//! iteration, converged at first and after a change of the system, then followed at the start of each step with two
//! products for every thirty substeps since the last estimate, at most twenty; a product is counted as the three force evaluations that it costs. For `bound`, `λ` is
//! [`drape_integrator::StiffnessBound`], which holds at all positions and costs a sweep over the springs once.
//!
//! # What it cost and where it failed here
//!
//! A falling sheet hung from two corners, 20 × 20 and 52 × 52 particles, `k/m` of 1e4 and 1e6 1/s², shear springs of a
//! tenth or none, undamped or `d/m` = 40 1/s, 2 s in steps of 0.01 and 0.1 s:
//!
//! * The largest eigenvalue of the flat sheet is 4.0 to 4.4 `k/m` and rises to between 6.2 and 7.9 `k/m` where it crumples,
//!   with a bound of 8 to 8.8. Two products every thirty substeps are too few to follow: the estimate falls to between
//!   0.54 and 0.84 of the truth. Half as many again do little, and mixing noise into the vector does nothing.
//! * So `auto` lives on its safety factor: 0.7 never failed, 0.8 gained up to 8e3 J, 0.9 and above blew up in more than
//!   half of the undamped runs. Damping of `d/m` = 40 hides most of it.
//! * `bound` with `safety` = 0.95 never failed, nor did 1, and took 15 % fewer force evaluations than `auto` with 0.7 (3141 to
//!   3715), 31 % fewer where the sheet crumples most (2981 to 4352). Its substep being constant, the matrix of the damping
//!   is kept.
//! * An undamped step costs 1.1 to 1.3 times a symplectic one. With damping, the solve is most of it: 49 µs against 10 µs
//!   at 20 × 20. Sparse Cholesky is the default because its cost does not depend on the damping. Jacobi-preconditioned
//!   conjugate gradients (measured to 1e-12) take 4 to 12 iterations a solve at `d/m` = 40, and a step then costs 0.35 to 1.55 times as
//!   much; at `d/m` = 1e4 they take 15 to 150, and a step costs up to 19 times as much.
//! * *Stable is not all.* `v½` has the explicit half of the damping only, so that a part of `v_n` that the damping has not
//!   met yet, in rough initial velocities or after an impact, moves positions by up to `h (η/2 − 1) v_n`: a net with random
//!   velocities rose to 1e4 times its energy at `h d/m` = 500 before it lost it. From rest, energy fell at every damping.
//! * Projected damping keeps angular momentum, leapfrog with it only to `O(h²)`.
//!
//! To try next: damping in the first half kick implicit, in the second explicit, which has the same eigenvalues and does not
//! throw positions; a bound for each particle, and small steps only where it is high.
//!
//! # Symbols
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `x_n`, `v_n` | `state.x`, `state.v` | m, m/s | `n` × 3 |
//! | `f`, `F` | `force` | N | `n` × 3 |
//! | `v½` | `v` after the first kick | m/s | `n` × 3 |
//! | `L_c` | [`drape_integrator::LaplacianSolver`] | N s/m | `n` × `n` |
//! | `R` | `remainder` | N | `n` × 3 |
//! | `λ` | [`drape_integrator::LargestEigenvalue`], [`drape_integrator::StiffnessBound`] | 1/s² | |

mod ledger;
mod settings;
mod stability_limit;
mod step;
mod workspace;

pub use settings::{
    DampingTreatment, EXPLICIT_EULER, ExplicitSettings, LEAPFROG, LeapfrogSettings,
    SYMPLECTIC_EULER, StepControl, SymplecticSettings,
};
pub use step::{EXPLICIT, ExplicitEuler, Leapfrog, SYMPLECTIC, SymplecticEuler, VERLET};
