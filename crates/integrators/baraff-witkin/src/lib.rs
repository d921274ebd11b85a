//! Baraff and Witkin's linearised implicit step (*Large Steps in Cloth Simulation*, SIGGRAPH 1998):
//! backward Euler with one linear solve per step.
//!
//! builds-on: backward Euler → **Baraff-Witkin** → Desbrun → Kang → IMEX
//!
//! # What it is
//!
//! Backward Euler needs the forces at the end of the step, and so the solution of a nonlinear
//! system. Baraff and Witkin replace these forces by their first-order expansion about the start.
//! In the terms of EEH section 2.3 this is one iteration of (5) with the Jacobian at the start.
//! Take it for stiff cloth, large steps and heavy damping. Its 3×3 blocks are stiff along each
//! spring and nearly free across it, so the sheet does not lock as with IMEX Euler.
//!
//! # The mathematics
//!
//! The expansion turns `Δx = h (v_0 + Δv) + y`, `M Δv = h f(x_0 + Δx, v_0 + Δv)` into (equation
//! numbers of Baraff and Witkin, after secondary sources)
//!
//! ```text
//! (M − h ∂f/∂v − h² ∂f/∂x) Δv = h (f_0 + h ∂f/∂x v_0 + ∂f/∂x y)           (6), (15), (16), (18)
//! x_{n+1} = x_n + h (v_n + Δv) + y                    v_{n+1} = v_n + Δv
//! p = A Δv − b                                                              (17)
//! ```
//!
//! * **Jacobians.** A spring has `−∂f/∂x = k [ûûᵀ + (1 − ℓ/L)(I − ûûᵀ)]`, which is negative across
//!   a compressed spring. With `h²k/m (ℓ/L − 1) > 1` the matrix may become indefinite, but
//!   conjugate gradients need a definite one. By default (`hessian=clamped`) the negative part is
//!   left out on both sides of the equation, which is then equivalent to
//!   `(M − h ∂f/∂v − h² ∂f/∂x) v_{n+1} = M v_n + h (f_0 − ∂f/∂v v_n)`.
//! * **Damping.** Full damping is linear. Projected damping takes its directions at `x_n`,
//!   `−∂f/∂v = c ûûᵀ`, and neglects the rotation of `û` in `∂f/∂x`. Baraff and Witkin neglect only
//!   its non-symmetric part. The difference is of second order in `h`, so the step stays of order
//!   1.
//! * **Constraints.** Filtered conjugate gradients with the *changes* of velocity `z` prescribed
//!   start from the prescribed part alone. `p`, kg m/s, is the impulse of the constraints. A
//!   contact that pulls is released.
//! * **Contacts.** `contact=velocity` leads particles out of obstacles as all other methods here
//!   do. `contact=position` alters positions: `y` puts a particle on the surface in the step that
//!   finds it inside, and `∂f/∂x y` transmits this to its neighbours within the same step. EEH
//!   chose velocities because `y` had raised their iteration counts.
//! * **Matrix.** `b` is formed without a matrix: each spring's block multiplies the difference of
//!   `h v_0 + y` at its ends. So a translation of the whole sheet adds exactly nothing. The matrix
//!   is that of [`drape_integrator::Linearisation`]. It is valid for one step, so each step counts
//!   a set-up.
//! * **Solvers.** Conjugate gradients use the layout of [`drape_solvers::BlockMatrix`] that suits
//!   the mesh, filled in one sweep together with `b`. They never end in an error: they report the
//!   residual at which they stopped, and the step uses the last iterate. If a diagonal block of the
//!   raw matrix is not definite, they run without a preconditioner. The direct solver (`solver=cholesky`) factorises `S A S` again after every
//!   release of contacts. For the raw matrix it is `L D Lᵀ`, which also solves indefinite systems
//!   and reports them as `Indefinite`. Overflow, and pivots lost in round-off, are errors that
//!   leave the state unchanged.
//! * **Left out:** step size control by the stretch of the triangles, and energies of triangles;
//!   forces here are those of springs.
//!
//! Where forces are linear (rest length 0, or along a spring) the step is backward Euler's,
//! `1/(1+θ+η) · [[1+η, 1], [−θ, 1]]`. Two free particles obey
//! `L_{n+1} = L_n / (1 + η + θ max(0, 1 − ℓ/len_n))`, with the length *before* the step and `η = 0`
//! for projected damping: a spring slows its own rotation neither at rest length nor in
//! compression. With the raw matrix, which has no maximum in the formula, compression makes it spin
//! faster.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `Δv` | `change` | m/s | `n` × 3 |
//! | `y` | `y` | m | `n` × 3 |
//! | `A = M − h ∂f/∂v − h² ∂f/∂x` | `matrix` | kg | `n` × `n` blocks of 3 × 3 |
//! | `b` | `b` | kg m/s | `n` × 3 |
//! | `S`, `z` | `changes` ([`drape_solvers::Constraints`]) | –, m/s | 3 × 3 and 3 a particle |
//! | `P` | `block_jacobi` (approximates `A⁻¹`) | 1/kg | 3 × 3 a particle |
//! | `p = A Δv − b` | `impulse` | kg m/s | `n` × 3 |
//! | `ε` | [`BaraffWitkinSettings::forcing_term`] | – | |
//! | `θ`, `η` | `h²k/m`, `hc/m`; of a free pair `2h²k/m`, `2hc/m` | – | |
//!
//! # Where it failed here, and what it cost
//!
//! *The hanging sheet*, 20 × 20 particles of 1 g on 1 m², shear springs with a tenth of `k`, `c/m`
//! = 40 /s (shear: 4), `h` = 0.01 s. Path of the middle of the free edge in the first second, m:
//!
//! | `k/m`, 1/s² | backward Euler | direct | CG, ε = 1e-3 | its iterations per step | raw, direct |
//! |---|---|---|---|---|---|
//! | 1e2 | 4.941 | 4.941 | 4.941 | 6 | 4.941 |
//! | 1e4 | 3.206 | 3.209 | 3.209 | 10 | 3.208 |
//! | 1e5 | 2.893 | 2.868 | 2.868 | 21 | 2.890 |
//! | 1e6 | 2.643 | 2.582 | 2.581 | 51 | 2.594 |
//! | 1e7 | 2.607 | 2.271 | 2.271 | 82 | 2.276 |
//! | 1e8 | 2.600 | 1.892 | 1.857 | 114 | 1.958 |
//!
//! Up to 1e6 nothing locks. Beyond 1e6 one linearisation is not enough: a fast rotation stretches
//! the springs within the step, and the following steps lose motion because of it. A loose
//! tolerance loses more (1.596 m at 1e8 with ε = 1e-2).
//!
//! *Energy.* There is no energy theorem. In the runs above, the energy never rises. At larger
//! `h²k/m` it rises, even with direct solves, and falls again afterwards. The fall of the sheet
//! releases about 2 J. Largest energy above the start, direct solves:
//!
//! | `h`, s | `k/m`, 1/s² | shear springs | undamped | `c/m` = 40 /s |
//! |---|---|---|---|---|
//! | 0.1 | 1e6 | `k` | 319 J | 12 J |
//! | 0.1 | 1e6 | `k/10` | 174 J | 7.8 J |
//! | 0.1 | 1e6 | none | 4.0 kJ | 6.9 J |
//! | 0.01 | 1e10 | none | 27 J | 19 J |
//! | 0.01 | 1e12 | `k/10` | 5.7 J | 3.0 J |
//! | 0.01 | 1e12 | none | 0.9 kJ | 0.8 kJ |
//!
//! *The raw matrix* keeps a little more motion where it stays definite, and blows up where it does
//! not: to more than 1e10 J with `h` = 0.1 s and `k/m` = 1e6, solved exactly or not.
//!
//! *Explicit shear* (`implicit=tension`) is limited as in symplectic Euler, `h²λ < 4`. Tension
//! springs do not resist shear. Unlike the scalar matrix of the implicit-explicit methods, their
//! blocks do not stabilise the explicit springs either. With a tenth of `k` the sheet above gains 8
//! kJ at `k/m` = 1e6.
//!
//! *Velocity or position.* Iterations in 1 s of the table cloth (`square-table`), velocity →
//! position:
//!
//! | `k/m`, 1/s² | `h` = 0.02 s | 0.01 s | 0.005 s | 0.001 s |
//! |---|---|---|---|---|
//! | 1e4 | 1219 → 1343 | 1367 → 1327 | 1604 → 1545 | 3083 → 3668 |
//! | 1e6 | 3051 → 3043 | 3788 → 7299 | 6735 → 9351 | 9543 → 10068 |
//!
//! Position alteration costs more in most rows, and up to twice as much. The cost is highest where
//! the cloth is stiff. EEH's observation holds, though not in every case. Energy rose in none of
//! these runs.
//!
//! *Speed.* A step of the hanging sheet, `k/m` = 1e4 /s², `h` = 0.01 s, ε = 1e-3, all springs
//! implicit. µs of processor time on one core of a shared Zen 4. Beside it stands a program on
//! Eigen (assembly by known positions, Jacobi), which takes 6.5 iterations per step because it
//! starts from the last `Δv`; this one takes 9.8:
//!
//! | particles | Eigen | here | ratio |
//! |---|---|---|---|
//! | 400 | 248 | 121 | 2.05 |
//! | 2704 | 2021 | 903 | 2.24 |
//! | 10 000 | 8207 | 3314 | 2.48 |
//! | 99 856 | 92 000 | 36 000 | 2.6 |
//!
//! | part of the step at 2704 particles | share | what was done |
//! |---|---|---|
//! | products with the matrix | 0.39 | bands instead of compressed rows |
//! | matrix and `∂f/∂x (h v_0 + y)` | 0.15 | one sweep instead of a search a block; before, about 0.4 of a step that took 3 to 4 times as long |
//! | sums and updates of conjugate gradients | 0.17 | |
//! | block-Jacobi | 0.07 | eight blocks at a time |
//! | forces | 0.05 | |
//!
//! The same sheet as a general mesh, particles and springs in disorder, without a preconditioner.
//! Median µs of a step over seven runs in turns on one core of a shared Zen 4. Each iteration on the
//! mesh read six numbers a pair of rows from a line of the cache, and now four numbers a spring:
//!
//! | particles | grid | six numbers a pair | four numbers a spring | ratio to the grid |
//! |---|---|---|---|---|
//! | 400 | 74 | 134 | 82 | 1.1 |
//! | 2704 | 515 | 925 | 582 | 1.1 |
//! | 10 000 | 1830 | 3310 | 2080 | 1.1 |
//! | 99 856 | 28 700 | 76 500 | 27 000 | 0.9 |
//!
//! Four things were tried, and all helped: the places of all blocks from a table instead of two
//! searches each, blocks and `∂f/∂x (h v_0 + y)` of a batch of springs at once, one block for both
//! triangles, and four numbers for a block, each force computed once
//! (`crates/solvers/src/block/pairs.rs`). Springs with projected damping, and effects other than
//! springs, still take compressed rows.
//!
//! To try next: full damping of sorted springs in the same pass as their stiffness, on meshes; more
//! Newton iterations where one is too few, which is backward Euler; a block incomplete
//! factorisation as preconditioner for stiff sheets.

mod ledger;
mod linear_system;
mod settings;
mod step;
#[cfg(test)]
mod test_support;

pub use settings::{
    BARAFF_WITKIN, BaraffWitkinSettings, BlockSolver, FirstChange, Hessian, Preconditioning,
    Recovery,
};
pub use step::{BaraffWitkin, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
