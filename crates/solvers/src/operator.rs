//! The matrix as conjugate gradients see it.

use crate::Vec3;

/// A linear map of block vectors to block vectors.
pub trait LinearOperator {
    /// Number of particles `n`; the matrix has 3n scalar rows.
    fn size(&self) -> usize;

    /// In how many [bands](crate::bands) threads share sweeps over vectors of this map.
    fn bands(&self) -> usize {
        1
    }

    /// `y ← A x`; every entry of `y` is overwritten.
    ///
    /// # Panics
    /// Implementations may panic when `x` or `y` has not [`size`](Self::size) entries.
    fn multiply(&self, x: &[Vec3], y: &mut [Vec3]);
}
