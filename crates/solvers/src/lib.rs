//! Matrices, preconditioners and solvers for implicit time steps of particle systems.
//!
//! # The problem
//!
//! An implicit step solves `A x = b` once or several times, with a large, sparse, symmetric
//! positive definite matrix. Some particles are constrained: their motion is prescribed in all
//! directions, across a plane, or across a line. Baraff & Witkin (1998, section 5) keep these
//! particles in the system and filter them. With projectors `S` on the free directions and
//! prescribed values `z`, the solution must satisfy
//!
//! ```text
//! x = S x + (I − S) z,     S (b − A x) = 0,
//! ```
//!
//! so that particles can be constrained and released without a new matrix. `A x − b` in the
//! filtered directions is the impulse of the constraints.
//!
//! This crate contains matrices, vectors and filters. It does not contain springs, masses or time.
//!
//! # How it works
//!
//! * A vector is a slice of [`Vec3`], one for each particle. [`vector`] fixes the order of every
//!   sum, so that results do not depend on the machine.
//! * [`ScalarMatrix`] is a graph Laplacian plus a diagonal, n×n, and acts on the three coordinates
//!   alike: the matrix of the implicit-explicit schemes of Eberhardt, Etzmuß & Hauth (2000).
//! * [`BlockMatrix`] has 3×3 blocks, for Jacobians that couple the coordinates, in a layout that
//!   suits the mesh. Both matrices have a fixed pattern that is refilled in place, and are a
//!   [`LinearOperator`].
//! * [`Constraints`] holds `S` and `(I − S) z`, and visits constrained particles only.
//! * [`filtered_pcg`] is Baraff & Witkin's modified conjugate gradient method with the corrections
//!   of Ascher & Boxerman (2003). It reports its costs. [`constraint_impulse`] gives `A x − b`
//!   afterwards.
//! * [`ScalarPcg`] is the same for a [`ScalarMatrix`], with the same bits, by fused SIMD kernels.
//! * A [`Preconditioner`] is [`Identity`], [`Jacobi`], [`BlockJacobi`], [`IncompleteCholesky`],
//!   [`CompleteCholesky`] or [`DenseInverse`]. The last two are the inverse up to round-off.
//! * [`Multigrid`] holds coarser and coarser versions of a [`BlockMatrix`]. A cycle over them is a
//!   [`Preconditioner`] whose quality does not fall as the mesh grows.
//! * [`BlockFactor`] solves directly. With [`BlockMatrix::project`] its solution obeys constraints,
//!   too.
//! * [`CompleteLdlt`] and [`BlockFactor`] of kind [`FactorKind::Ldlt`] solve directly when the
//!   matrix may be indefinite, and count its negative eigenvalues. They do not modify pivots: a
//!   matrix that they cannot factor gives an error.
//! * [`BlockLu`] solves directly with [`UnsymmetricBlocks`]. It uses no library.
//!
//! Solves and refactorisations allocate nothing. Sums, products and the incomplete factorisation
//! have the same bits on every machine. The complete factorisations and the dense inverse come from
//! the library `faer`, whose kernels may round differently on different processors.
//!
//! # What the inverse costs
//!
//! The matrix of a square sheet of n particles with structural springs, on one core of an AMD EPYC.
//! *Made* means computed in memory that is already allocated; *solved* means for three right-hand
//! sides.
//!
//! | n | [`CompleteCholesky`] made | solved | [`DenseInverse`] made | solved |
//! |---|---|---|---|---|
//! | 400 | 0.08 ms | 0.004 ms | 2 ms | 0.07 ms |
//! | 1936 | 0.5 ms | 0.024 ms | 170 ms | 2.5 ms |
//! | 3600 | 1.2 ms | 0.05 ms | 1.1 s | 9 ms |
//!
//! [`CompleteLdlt`] solves in the same way.
//!
//! The dense inverse is never cheaper in this table: its costs grow with n³ and n², those of the
//! sparse factors about with n^1.5 and n log n. It exists for measurements of methods that were
//! published with a dense inverse.
//!
//! # Symbols
//!
//! | symbol | Rust name | unit | shape |
//! |---|---|---|---|
//! | `A` | [`ScalarMatrix`], [`BlockMatrix`] | the caller's | n×n scalars; n×n blocks of 3×3 |
//! | `P ≈ A⁻¹` | [`Preconditioner`] | 1 / unit of `A` | 3n×3n, never formed |
//! | `S` | [`Filter`], [`Constraints::project`] | – | 3×3 projector a particle |
//! | `(I − S) z` | [`Constraints::prescribed`] | as `x` | one vector per particle |
//! | `x`, `b` | `x`, `b` | `b` is `A` times `x` | n vectors |
//! | `b̂ = S (b − A (I − S) z)` | [`Reference::FilteredRightHandSide`] | as `b` | n vectors |
//! | `r = S (b − A x)` | [`PcgWorkspace::residual`] | as `b` | n vectors |
//! | `A x − b` | [`constraint_impulse`] | as `b` | n vectors |
//! | `ε` | [`PcgSettings::forcing_term`] | – | scalar |
//! | `L` in `L Lᵀ` | [`IncompleteCholesky`], [`CompleteCholesky`], [`BlockFactor`] | √ of `A`'s | lower triangle |
//! | `L` in `L D Lᵀ` | [`CompleteLdlt`], [`BlockFactor`] | – | lower triangle with ones on the diagonal |
//! | `D` | [`CompleteLdlt::negative_pivots`], [`BlockFactor::negative_pivots`] | as `A` | diagonal |
//! | `A⁻¹` | [`DenseInverse`] | 1 / unit of `A` | n×n scalars |
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
//! * N. Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd edition, SIAM 2002.
//! * J. Meijerink, H. van der Vorst, *An iterative solution method for linear systems of which the
//!   coefficient matrix is a symmetric M-matrix*, Mathematics of Computation 31, 1977.

pub mod block;
pub mod constraint;
pub mod direct;
pub mod error;
mod free;
pub mod laplacian;
pub mod operator;
mod ordering;
mod pattern;
pub mod pcg;
mod pivots;
pub mod preconditioner;
mod scalar;
mod scalar_factor;
mod sparse_factor;
mod start;
#[cfg(test)]
mod test_support;
mod tiles;

pub use block::{BlockMatrix, SinglePcg};
pub use constraint::{Constraints, Filter};
pub use direct::{BlockFactor, BlockLu, CompleteLdlt, FactorKind, UnsymmetricBlocks};
pub use drape_kernels::blocks::Coupling;
pub use drape_kernels::{Mat3, Vec3, bands, lanes, vector};
pub use error::SolverError;
pub use laplacian::ScalarMatrix;
pub use operator::LinearOperator;
pub use pcg::{
    Norm, PcgReport, PcgSettings, PcgWorkspace, Reference, SolveStatus, constraint_impulse,
    filtered_pcg,
};
pub use preconditioner::{
    BlockJacobi, CompleteCholesky, DenseInverse, Identity, IncompleteCholesky, Jacobi, Multigrid,
    Preconditioner, Products,
};
pub use scalar::{ResidualNorms, ScalarLayout, ScalarPcg, ScalarPreconditioner};
pub use start::StartValue;
