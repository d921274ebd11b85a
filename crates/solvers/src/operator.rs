//! The matrix as conjugate gradients use it.

use crate::Vec3;

/// A linear map of block vectors to block vectors.
pub trait LinearOperator {
    /// Number of particles `n`; the matrix has 3n scalar rows.
    fn size(&self) -> usize;

    /// In how many [bands](crate::bands) threads share sweeps over vectors of this map.
    fn bands(&self) -> usize {
        1
    }

    /// Writes the product: `y ← A x`. Every entry of `y` is overwritten.
    ///
    /// # Panics
    /// Implementations may panic if `x` or `y` does not have [`size`](Self::size) entries.
    fn multiply(&self, x: &[Vec3], y: &mut [Vec3]);
}
