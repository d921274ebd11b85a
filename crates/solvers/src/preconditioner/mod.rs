//! Preconditioners: approximations of the inverse matrix, from cheap ones to the inverse itself.
//!
//! Throughout, `P ≈ A⁻¹` and a preconditioner is *applied*: `z = P r`. (Baraff & Witkin 1998 define
//! `P` by `Pᵢᵢ = 1/Aᵢᵢ` and then apply `P⁻¹`; only one of the two can be intended.)
//!
//! `new` reserves the memory for a pattern; `update` fills it and allocates nothing. Before the
//! first update, and after a failed one, a preconditioner is the identity. This is slow but
//! correct.
//!
//! An update may take a mask of `free` rows. The other rows are pinned, and their couplings are
//! left out. `P` then approximates the inverse of the matrix that is actually solved, and does not
//! spread the residual of a pinned particle to its free neighbours.

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
pub use multigrid::{Multigrid, Products};

use crate::Vec3;
use crate::bands::in_bands;

/// A symmetric positive definite approximation `P` of the inverse of a matrix.
pub trait Preconditioner {
    /// Applies the preconditioner: `z ← P r`. Every entry of `z` is overwritten.
    ///
    /// # Panics
    /// Implementations may panic if the length of `r` or `z` differs from the number of rows of the
    /// matrix.
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]);

    /// As [`apply`](Self::apply), with the same bits. Threads may share it in so many
    /// [bands](crate::bands).
    ///
    /// # Panics
    /// As [`apply`](Self::apply).
    fn apply_in_bands(&self, _bands: usize, r: &[Vec3], z: &mut [Vec3]) {
        self.apply(r, z);
    }
}

/// `P = I`, which gives plain conjugate gradients.
#[derive(Clone, Copy, Debug, Default)]
pub struct Identity;

impl Preconditioner for Identity {
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        z.copy_from_slice(r);
    }

    fn apply_in_bands(&self, bands: usize, r: &[Vec3], z: &mut [Vec3]) {
        assert_eq!(r.len(), z.len(), "vectors of different length");
        in_bands(bands, z.len(), z, &|band, z: &mut [Vec3]| z.copy_from_slice(&r[band]));
    }
}
