//! Matrices, preconditioners and solvers for implicit time steps of particle systems.
//!
//! # The problem
//!
//! An implicit step solves `A x = b` with a large, sparse, symmetric positive definite matrix, once
//! or several times a step, while some particles are held: their motion is prescribed in all
//! directions, across a plane, or across a line. Baraff & Witkin (1998, section 5) keep these
//! particles in the system and filter them: with projectors `S` on the free directions and
//! prescribed values `z` they ask for
//!
//! ```text
//! x = S x + (I − S) z,     S (b − A x) = 0,
//! ```
//!
//! so that particles can be caught and released without a new matrix. What is left of `A x − b` in
//! the filtered directions is what the constraints push with.
//!
//! This crate knows matrices, vectors and filters. It knows nothing of springs, masses or time.
//!
//! # How it does it
//!
//! * A vector is a slice of [`Vec3`], one a particle. [`vector`] fixes the order of every sum, so
//!   that results do not depend on the machine.
//! * [`ScalarMatrix`] is a graph Laplacian plus a diagonal, n×n, applied to the three coordinates
//!   alike (the matrix of the implicit-explicit schemes of Eberhardt, Etzmuß & Hauth 2000).
//!   [`BlockMatrix`] has 3×3 blocks, for Jacobians that couple the coordinates. Both have a fixed
//!   pattern that is refilled in place, and are a [`LinearOperator`].
//! * [`Constraints`] holds `S` and `(I − S) z`, and visits constrained particles only.
//! * [`filtered_pcg`] is Baraff & Witkin's modified conjugate gradient method with the corrections
//!   of Ascher & Boxerman (2003), and a report of what it took. [`constraint_impulse`] gives
//!   `A x − b` afterwards.
//! * A [`Preconditioner`] is [`Identity`], [`Jacobi`], [`BlockJacobi`], [`IncompleteCholesky`] or
//!   [`CompleteCholesky`].
//! * [`BlockCholesky`] solves directly. With [`BlockMatrix::project`] it obeys constraints too.
//!
//! Solves and refactorisations allocate nothing. Sums, products and the incomplete factorisation
//! are the same bits on every machine; the complete factorisations come from the library `faer`,
//! whose kernels may round differently on different processors.
//!
//! # Symbols
//!
//! | symbol | Rust name | unit | shape |
//! |---|---|---|---|
//! | `A` | [`ScalarMatrix`], [`BlockMatrix`] | the caller's | n×n scalars; n×n blocks of 3×3 |
//! | `P ≈ A⁻¹` | [`Preconditioner`] | 1 / unit of `A` | 3n×3n, never formed |
//! | `S` | [`Filter`], [`Constraints::project`] | – | 3×3 projector a particle |
//! | `(I − S) z` | [`Constraints::prescribed`] | as `x` | one vector a particle |
//! | `x`, `b` | `x`, `b` | `b` is `A` times `x` | n vectors |
//! | `b̂ = S (b − A (I − S) z)` | [`Reference::FilteredRightHandSide`] | as `b` | n vectors |
//! | `r = S (b − A x)` | [`PcgWorkspace::residual`] | as `b` | n vectors |
//! | `A x − b` | [`constraint_impulse`] | as `b` | n vectors |
//! | `ε` | [`PcgSettings::forcing_term`] | – | scalar |
//! | `L` | [`IncompleteCholesky`], [`CompleteCholesky`], [`BlockCholesky`] | √ of `A`'s | lower triangle |
//!
//! `P` is always the approximate *inverse*.
//!
//! # Sources
//!
//! * D. Baraff, A. Witkin, *Large Steps in Cloth Simulation*, SIGGRAPH 1998.
//! * B. Eberhardt, O. Etzmuß, M. Hauth, *Implicit-Explicit Schemes for Fast Animation with Particle
//!   Systems*, Eurographics Workshop on Computer Animation and Simulation 2000.
//! * U. Ascher, E. Boxerman, *On the modified conjugate gradient method in cloth simulation*, The
//!   Visual Computer 19, 2003.
//! * J. Meijerink, H. van der Vorst, *An iterative solution method for linear systems of which the
//!   coefficient matrix is a symmetric M-matrix*, Mathematics of Computation 31, 1977.

pub mod block;
pub mod constraint;
pub mod direct;
pub mod error;
pub mod laplacian;
pub mod operator;
mod pattern;
pub mod pcg;
pub mod preconditioner;
mod sparse_llt;
#[cfg(test)]
mod test_support;
pub mod vector;

pub use block::BlockMatrix;
pub use constraint::{Constraints, Filter};
pub use direct::BlockCholesky;
pub use error::SolverError;
pub use laplacian::ScalarMatrix;
pub use operator::LinearOperator;
pub use pcg::{
    Norm, PcgReport, PcgSettings, PcgWorkspace, Reference, SolveStatus, constraint_impulse,
    filtered_pcg,
};
pub use preconditioner::{
    BlockJacobi, CompleteCholesky, Identity, IncompleteCholesky, Jacobi, Preconditioner,
};

/// Position, velocity, force or the like of one particle.
pub type Vec3 = nalgebra::Vector3<f64>;

/// A 3×3 block.
pub type Mat3 = nalgebra::Matrix3<f64>;
