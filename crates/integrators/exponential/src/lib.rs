//! Exponential Rosenbrock-Euler: linear waves without any error, by the exponential of the
//! Jacobian.
//!
//! builds-on: explicit Euler → Rosenbrock methods → **exponential**
//!
//! # What it is
//!
//! An implicit step damps or delays the vibrations that it steps over. This step linearises the
//! forces and then solves the linear equation exactly. As long as springs keep their direction, the
//! step is exact at any size, stiff or not. It solves no linear system: a Krylov subspace gives the
//! action of the exponential, from products with the Jacobian alone.
//!
//! Take it for moderately stiff cloth at errors of 1e-3 to 1e-4, or to see which part of an error
//! is nonlinear. The number of products per second grows with the frequency of the fastest wave, as
//! it does for leapfrog, so the method can be faster only by a constant factor. It follows the
//! tangent of a spring that turns, and nothing bounds the energy that this adds. Without damping it
//! blows up in cases in which an implicit method is stable.
//!
//! # The mathematics
//!
//! With `y = (x, v)`, `F(y) = (v, M⁻¹ f)` and the exact Jacobian `J = (0, I; −M⁻¹K, −M⁻¹D)` at
//! `y_n`:
//!
//! ```text
//! y_{n+1} = y_n + h φ₁(hJ) F = y_n + h F + h² φ₂(hJ) J F                                       (1)
//! φ₁(z) = (eᶻ − 1)/z            φ₂(z) = (φ₁(z) − 1)/z
//! ```
//!
//! The second form is the one computed. `J F` is the same for a cloth that moves as a whole, so the
//! result does not depend on the frame, and a free fall takes only a few products.
//!
//! * **Order and stability.** Order 2. On linear problems `R(z) = eᶻ`: exact, whatever `h` is. `K`
//!   is the raw Hessian, indefinite where springs are compressed; a clamped one would cost an
//!   order. `J` holds the turn of projected damping. Coefficients of drag are frozen, so that air
//!   enters with order 1.
//! * **Conservation.** The step conserves linear momentum. It conserves neither angular momentum nor
//!   energy: two particles that rotate at 2 rad/s keep 0.9950 (`θ = 1`) and 0.7045 (`θ = 100`) of their spin in 100 steps of
//!   0.01 s.
//! * **The subspace.** Arnoldi's method with full orthogonalisation from `J F`, on `(x/s, v)` with
//!   `s = max(1, √(k/m))⁻¹`, gives `J V_m ≈ V_m H`, and
//!
//! ```text
//! h² φ₂(hJ) J F ≈ h² β V_m φ₂(hH) e₁           error ≈ β h³ h_{m+1,m} |e_mᵀ φ₃(hH) e₁|          (2)
//! ```
//!
//!   (Saad 1992). The step tests the error after every fourth dimension, in large subspaces after an
//!   eighth of their dimensions. It accepts `krylov_tol · h`, in metres a second for velocities, and
//!   `s` times that for positions.
//! * **The small functions.** `φ₂(hH) e₁` is part of one column of an exponential. Where
//!   `hH` is small beside its dimension, a column needs Taylor series with vectors only; else the
//!   exponential of a part of the way is squared.
//! * **Too few dimensions.** A step that has not converged with `max_dim` dimensions would explode.
//!   The subspace does not depend on `h`, so the method halves the step until the same subspace is
//!   sufficient. It takes the rest of the step with a new Jacobian. The report counts these
//!   substeps; more than 32 are refused.
//! * **Products.** Products use matrices `K` and `D` of 3×3 blocks, assembled once per step along the
//!   bands of a regular grid, or in compressed rows. A sweep over the springs without a matrix would
//!   compute each block anew, with a square root and a division. It is used for the first product
//!   only, where it multiplies differences exactly.
//! * **Refused.** Contact, friction and pins on paths, which are not part of the linear equation.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h`, `tau` for a substep | s | |
//! | `s` | `Jacobian::scale` | s | |
//! | `J F` | `Workspace::flow` | m/s², in the positions over `s` | `2n` × 3 |
//! | `V`, `H`, `β` | `Krylov` | –, 1/s, m/s² | `2n` × 3 × `m`, `m` × `m` |
//!
//! # Where it failed here, and what it cost
//!
//! The hanging sheet: 400 particles of 1 g, shear springs of 0.1 k, two pins, d/m = 40/s, 0.3 s.
//! Errors are relative to the way of the sheet; a smaller `krylov_tol` changes none of their
//! digits but the last. Times are those of one core of a shared machine:
//!
//! | k/m | h | error | products in a step, `krylov_tol` = 1e-2 | 1e-3 | 1e-5 | a step |
//! |---|---|---|---|---|---|---|
//! | 1e4 | 0.01 | 1.98e-4 | 7.9 | 9.0 | 9.3 | 1.1 ms |
//! | 1e4 | 0.005 | 5.09e-5 | 5.0 | 5.0 | 9.0 | 1.0 ms |
//! | 1e4 | 0.0025 | 1.29e-5 | 5.0 | 5.0 | 8.1 | 0.8 ms |
//! | 1e6 | 0.01 | 3.46e-3 | 30.1 | 32.1 | 36.1 | 4 ms |
//! | 1e6 | 0.005 | 3.14e-4 | 16.7 | 20.4 | 24.0 | 2 ms |
//! | 1e6 | 0.0025 | 4.13e-5 | 12.1 | 12.8 | 16.6 | 1.5 ms |
//! | 1e8 | 0.002 | 3.88e-3 | 56.2 | 56.6 | 63.5 | 13 ms |
//! | 1e8 | 0.001 | 4.59e-4 | 32.1 | 32.7 | 36.7 | 4 ms |
//!
//! * The cost is that of the fastest wave. Products in a step follow `h ω_max`, which is 21 at
//!   k/m = 1e6 and h = 0.01 s. Orthogonalisation takes `m²` products of vectors and soon outweighs
//!   the springs; the step reports it as `m²/16` products with the matrix.
//! * In steps of 0.01 s at k/m = 1e6 the sheet with d/m = 40 loses energy over 2 s, as it should.
//!   Without damping it blows up: 8e15 J after 35 steps. At k/m = 1e8 and h = 0.01 s it blows up
//!   with damping too, in subspaces of 270 dimensions that have converged: it is the tangent that
//!   fails, not the subspace.
//! * `φ₂` from `½ + z φ₃`, which saves a column, loses a factor `|z|` of accuracy: it was off by
//!   1e-9 on a critically damped spring of `θ = 1e4`, where a column for `φ₂` stays below 2.5e-10.
//!
//! # References
//!
//! * D. Pope, *An exponential method of numerical integration of ordinary differential equations*,
//!   Communications of the ACM 6, 1963. doi:10.1145/366707.367592.
//! * Y. Saad, *Analysis of some Krylov subspace approximations to the matrix exponential operator*,
//!   SIAM Journal on Numerical Analysis 29, 1992. doi:10.1137/0729014.
//! * C. Moler, C. Van Loan, *Nineteen dubious ways to compute the exponential of a matrix, twenty-five
//!   years later*, SIAM Review 45, 2003. doi:10.1137/S00361445024180.
//! * M. Hochbruck, A. Ostermann, J. Schweitzer, *Exponential Rosenbrock-type methods*, SIAM Journal
//!   on Numerical Analysis 47, 2009. doi:10.1137/080717717.
//! * D. Michels, G. Sobottka, A. Weber, *Exponential integrators for stiff elastodynamic problems*,
//!   ACM Transactions on Graphics 33(1), article 7, 2014. doi:10.1145/2508462 (not looked up).
//! * D. Michels, V. Luan, M. Tokman, *A stiffly accurate integrator for elastodynamic problems*,
//!   ACM Transactions on Graphics 36(4), 2017. doi:10.1145/3072959.3073706.
//! * Y. Chen, U. Ascher, D. Pai, *Exponential Rosenbrock-Euler integrators for elastodynamic
//!   simulation*, IEEE Transactions on Visualization and Computer Graphics 24, 2018.
//!   doi:10.1109/TVCG.2017.2768532 (not looked up).

mod jacobian;
mod krylov;
mod series;
mod settings;
mod step;

pub use settings::{EXPONENTIAL, ExponentialSettings};
pub use step::{Exponential, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
