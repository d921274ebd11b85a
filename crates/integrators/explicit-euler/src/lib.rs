//! Explicit Euler, symplectic Euler and leapfrog: the methods without a solve.
//!
//! builds-on: **explicit Euler → symplectic Euler → leapfrog** → Provot → backward Euler
//!
//! # What they are
//!
//! *Explicit Euler* is the baseline that shows why other methods are needed. *Symplectic Euler* is
//! the baseline for cost. *Leapfrog* (velocity Verlet) is symmetric and of order 2, for one force
//! evaluation per step, as in the other two. At its stability limit it is the competitor of every
//! implicit method. Take symplectic Euler or leapfrog where the springs are soft, or where damping
//! is light and accuracy matters.
//!
//! # The mathematics
//!
//! Explicit (forward) Euler is the explicit Adams method (2) of EEH for `k = 1`:
//!
//! ```text
//! x_{n+1} = x_n + h v_n          v_{n+1} = v_n + h M⁻¹ f(x_n, v_n)                     (2)
//! ```
//!
//! In symplectic Euler the new velocity moves the positions. With `damping=implicit`, (S3) replaces
//! (S1):
//!
//! ```text
//! v_{n+1} = v_n + h M⁻¹ f(x_n, v_n)                                                   (S1)
//! x_{n+1} = x_n + h v_{n+1}                                                           (S2)
//! (M + h L_c) v_{n+1} = M v_n + h (f(x_n, v_n) + L_c v_n)                             (S3)
//! ```
//!
//! Leapfrog kicks half before and half after the drift. It evaluates the conservative force `F`
//! once per step, since the next step reuses it. Its damping is Crank–Nicolson's:
//!
//! ```text
//! v½      = v_n + h/2 M⁻¹ (F(x_n) − D(x_n) v_n)                                       (L1)
//! x_{n+1} = x_n + h v½                                                                (L2)
//! (M + h/2 L_c) v_{n+1} = M v½ + h/2 (F(x_{n+1}) + R(x_{n+1}, v_{n+1}))               (L3)
//! R(x, v) = L_c v − D(x) v
//! ```
//!
//! This is Newmark's method with `β = 0`, `γ = ½`. `R` is 0 for full damping.
//!
//! With `damping=explicit` no step solves anything. Each half kick solves `M v' = F(x) − D(x) v`,
//! at fixed `x`, by Heun's method with `τ = h/2`; (L4) replaces the damping in (L1) and (L3):
//!
//! ```text
//! g₁ = F − D v      g₂ = F − D (v + τ M⁻¹ g₁)      v ← v + τ M⁻¹ ½ (g₁ + g₂)           (L4)
//! ```
//!
//! For damping that is linear in `v` this is the Taylor series `e^{−y} ≈ 1 − y + ½y²` of the exact
//! kick, `y = ½hδ`. A kick never reverses a velocity. Drag that is not linear keeps order 2.
//!
//! On the oscillator `x'' = −κx − δx'` with `θ = h²κ`, `η = hδ`:
//!
//! | method | stable if |
//! |---|---|
//! | explicit Euler | `θ ≤ η` and `2η ≤ 4 + θ`: never without damping |
//! | symplectic Euler, damping explicit | `θ + 2η < 4` |
//! | symplectic Euler, damping implicit | `θ < 4 + 2η` |
//! | leapfrog | `θ < 4`, whatever `η` |
//! | leapfrog, `damping=explicit` | `θ < 4 (1 + p²)/((1 + p)(1 − η/4))` and `η < 4`, `p = 1 − η/2 + η²/8`; `θ < 4` and `η < 4` suffice |
//!
//! The largest eigenvalue of `M⁻¹L_k` on a structural grid is at most `8 k/m`, hence `h < √(m/2k)`
//! for symplectic Euler and leapfrog. Both conserve linear and (undamped) angular momentum exactly,
//! and an energy close to the true one.
//!
//! * **Contacts.** In symplectic Euler the constrained new velocity moves a particle in contact. In
//!   explicit Euler the old velocity moves it, and in leapfrog `v½`, so those velocities are
//!   constrained. Afterwards the obstacle removes the inward velocity that the forces add.
//! * **Leapfrog's force** is kept for the system's [revisions](drape_model::System::revisions) and
//!   for the positions, which each step compares to the last bit. After any other change it is
//!   evaluated anew, with or without `restart`. Changes of velocity, step size and contacts do not
//!   require this.
//! * **Leapfrog's damping.** Without damping there is no matrix. Full damping takes one solve.
//!   Projected damping takes two: `R` is taken first at `v_n`, then at the velocity that this
//!   gives, which keeps order 2.
//! * **Leapfrog's substeps.** `step=auto` and `step=bound` divide a step into equal substeps of at
//!   most `safety · 2/√λ`, with `damping=explicit` also of at most `safety · 4/δ`, where `δ` is
//!   [`drape_integrator::DampingBound`]. For `bound`, `λ` is [`drape_integrator::StiffnessBound`],
//!   which holds at all positions and costs one sweep over the springs. For `auto`, `λ` is 1.05
//!   times an estimate of the largest eigenvalue of `M⁻¹∇²U` by power iteration. The estimate
//!   converges at first and after a change of the system. Later steps follow it with two products
//!   for every thirty substeps since the last estimate, at most twenty. A product counts as the
//!   three force evaluations that it costs.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `x_n`, `v_n` | `state.x`, `state.v` | m, m/s | `n` × 3 |
//! | `f`, `F` | `force` | N | `n` × 3 |
//! | `v½` | `state.v` after the first kick | m/s | `n` × 3 |
//! | `L_c` | [`drape_integrator::LaplacianSolver`] | N s/m | `n` × `n` |
//! | `R` | `r` | N | `n` × 3 |
//! | `λ` | [`drape_integrator::StabilityLimit`] by [`drape_integrator::LargestEigenvalue`] or [`drape_integrator::StiffnessBound`] | 1/s² | |
//! | `δ` | [`drape_integrator::DampingBound`] | 1/s | |
//! | `½ (g₁ + g₂) − F` | [`drape_integrator::ExplicitKick::damping`] | N | `n` × 3 |
//!
//! # Where they failed here
//!
//! The runs: a falling sheet hung from two corners with 20 × 20 and 52 × 52 particles, and `k/m` of
//! 1e4 and 1e6 1/s². Shear springs have a tenth of `k` or are absent; `d/m` is 0 or 40 1/s. The
//! runs take 2 s in steps of 0.01 and 0.1 s.
//!
//! * The largest eigenvalue of the flat sheet is 4.0 to 4.4 `k/m`; the bound is 8 to 8.8. Where the
//!   sheet crumples, the eigenvalue rises to between 6.2 and 7.9 `k/m`. Two products every thirty
//!   substeps are too few to follow it: the estimate falls to between 0.54 and 0.84 of the truth.
//!   Half as many again do little, and noise in the vector does nothing.
//! * So `auto` depends on its safety factor: 0.7 never failed, 0.8 gained up to 8e3 J, and 0.9 and
//!   above blew up in more than half of the undamped runs. Damping of `d/m` = 40 hides most of it.
//! * `bound` with `safety` = 0.95 never failed, nor did 1. It took 15 % fewer force evaluations
//!   than `auto` with 0.7 (3141 to 3715), and 31 % fewer where the sheet crumples most (2981 to
//!   4352). Its substep is constant, so the matrix of the damping is kept.
//! * An undamped step costs 1.1 to 1.3 times a symplectic one. With damping, the solve dominates:
//!   49 µs against 10 µs at 20 × 20. Sparse Cholesky is the default because its cost does not
//!   depend on the damping. Jacobi-preconditioned conjugate gradients (measured to 1e-12) take 4 to
//!   12 iterations per solve at `d/m` = 40, and a step costs 0.35 to 1.55 times as much. At `d/m` =
//!   1e4 they take 15 to 150 iterations, and a step costs up to 19 times as much.
//! * *Stability is not enough.* `v½` has only the explicit half of the damping. Rough initial
//!   velocities or an impact therefore move positions by up to `h (η/2 − 1) v_n`: a net with random
//!   velocities rose to 1e4 times its energy at `h d/m` = 500 before it lost it. From rest, energy
//!   fell at every damping.
//! * Projected damping keeps angular momentum; leapfrog with it only to `O(h²)`.
//!
//! *Explicit damping.* On the sheet with `d/m` = 40 it has the error of Crank–Nicolson, or a little
//! less, for half of the time of a step (0.3 s, errors relative to the motion; times with other
//! work on the machine):
//!
//! | `k/m`, 1/s² | steps | error, explicit | Crank–Nicolson | µs a step, explicit | Crank–Nicolson |
//! |---|---|---|---|---|---|
//! | 1e4 | 33 | 7.8e-5 | 9.6e-5 | 14 | 27 |
//! | 1e4 | 45 | 4.2e-5 | 5.1e-5 | 17 | 28 |
//! | 1e6 | 330 | 2.9e-6 | 3.2e-6 | 38 | 75 |
//! | 1e6 | 882 | 4.0e-7 | 4.5e-7 | 44 | 80 |
//! | 1e8 | 3294 | 9.7e-8 | 9.9e-8 | 40 | 83 |
//!
//! At `d/m = √(k/m)` the limit `hδ < 4` and not that of the springs sets the step.
//!
//! To try next: damping implicit in the first half kick and explicit in the second, which has the
//! same eigenvalues and does not throw positions; a bound for each particle, and small steps only
//! where it is high.

mod ledger;
mod settings;
mod step;
mod workspace;

pub use drape_integrator::StepControl;
pub use settings::{
    DampingTreatment, EXPLICIT_EULER, ExplicitSettings, LEAPFROG, LeapfrogDamping,
    LeapfrogSettings, SYMPLECTIC_EULER, SymplecticSettings,
};
pub use step::{EXPLICIT, ExplicitEuler, Leapfrog, SYMPLECTIC, SymplecticEuler, VERLET};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] = &[
    ("src/lib.rs", include_str!("lib.rs")),
    ("src/step/explicit.rs", include_str!("step/explicit.rs")),
    ("src/step/symplectic.rs", include_str!("step/symplectic.rs")),
    ("src/step/leapfrog.rs", include_str!("step/leapfrog.rs")),
];
