//! Preconditioners: approximations of the inverse matrix, from cheap ones to the inverse itself.
//!
//! Throughout, `P ≈ A⁻¹` and a preconditioner is *applied*: `z = P r`. (Baraff & Witkin 1998 define
//! `P` by `Pᵢᵢ = 1/Aᵢᵢ` and then apply `P⁻¹`; only one of the two can be meant.)
//!
//! All of them are made for a pattern by `new`, which reserves the memory, and filled by `update`,
//! which allocates nothing. Before the first update, and after one that failed, they are the
//! identity: slow, but right.
//!
//! An update may be told which rows are `free`. The others are pinned: their couplings are left
//! out, so `P` does not carry the residual of a pinned particle, which is none of the solver's
//! business, to its free neighbours, and approximates the inverse of the matrix that is really
//! solved.

mod block_jacobi;
mod complete;
mod dense;
mod incomplete;
mod jacobi;
mod multigrid;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;
mod wavefront;

pub use block_jacobi::BlockJacobi;
pub use complete::CompleteCholesky;
pub use dense::DenseInverse;
pub use incomplete::IncompleteCholesky;
pub use jacobi::Jacobi;
pub use multigrid::{Cycle, Multigrid};

use crate::Vec3;

/// A symmetric positive definite approximation `P` of the inverse of a matrix.
pub trait Preconditioner {
    /// `z ← P r`; every entry of `z` is overwritten.
    ///
    /// # Panics
    /// Implementations may panic when `r` or `z` has another length than the matrix has rows.
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]);
}

/// `P = I`: plain conjugate gradients.
#[derive(Clone, Copy, Debug, Default)]
pub struct Identity;

impl Preconditioner for Identity {
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        z.copy_from_slice(r);
    }
}
