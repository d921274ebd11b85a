//! Complete sparse Cholesky factorisation of a scalar matrix.

use super::Preconditioner;
use crate::free::FreeRows;
use crate::scalar_factor::ScalarFactor;
use crate::sparse_factor::FactorKind;
use crate::{ScalarMatrix, SolverError, Vec3};

/// `P = A⁻¹` up to round-off, from `A = L Lᵀ` with fill and a fill-reducing order of the rows.
///
/// With it conjugate gradients converge in one iteration for the factored matrix, and quickly for a
/// matrix near it. One factor serves the three coordinates.
#[derive(Debug)]
pub struct CompleteCholesky {
    factor: ScalarFactor,
}

impl CompleteCholesky {
    /// The identity, with the symbolic factorisation for the pattern of `a`.
    ///
    /// # Errors
    /// [`SolverError::Factorisation`] if the factor does not fit into memory.
    pub fn new(a: &ScalarMatrix) -> Result<Self, SolverError> {
        Ok(Self { factor: ScalarFactor::new(a, FactorKind::Cholesky)? })
    }

    /// Factors `a`. Rows that are not `free` keep only their diagonal entry.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] if a pivot is not positive.
    /// [`SolverError::PatternChanged`] if `a` has another pattern than the matrix given to
    /// [`new`](Self::new); the factor then stays as it was.
    ///
    /// # Panics
    /// Unless `free` has one flag for each row.
    pub fn update(&mut self, a: &ScalarMatrix, free: Option<&[bool]>) -> Result<(), SolverError> {
        self.factor.update(a, FreeRows::new(free, a.n()))
    }

    /// Number of entries in each column of `L`, with the diagonal, in the fill-reducing order.
    /// Their sum is the number of stored entries, and the sum of their squares is the number of
    /// operations.
    pub fn column_counts(&self) -> impl Iterator<Item = usize> {
        self.factor.column_counts()
    }
}

impl Preconditioner for CompleteCholesky {
    /// Solves `L y = r`, then `Lᵀ z = D⁻¹ y`, by panels of columns.
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        assert_eq!(r.len(), self.factor.n(), "one vector a row");
        assert_eq!(z.len(), self.factor.n(), "one vector a row");
        if self.factor.factored() {
            self.factor.solve(r, z);
        } else {
            z.copy_from_slice(r);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::laplacian;

    #[test]
    fn columns_of_a_path_have_two_entries_and_those_of_a_clique_fill_the_triangle() {
        let path: Vec<_> = (1..6).map(|j| (j - 1, j)).collect();
        let p = CompleteCholesky::new(&laplacian(6, &path, 0.3, || 1.0)).unwrap();
        let counts: Vec<_> = p.column_counts().collect();
        assert_eq!((counts.len(), counts.iter().sum::<usize>()), (6, 11), "no fill");
        let all: Vec<_> = (0..6).flat_map(|i| (0..i).map(move |j| (i, j))).collect();
        let p = CompleteCholesky::new(&laplacian(6, &all, 0.3, || 1.0)).unwrap();
        assert_eq!(p.column_counts().collect::<Vec<_>>(), [6, 5, 4, 3, 2, 1]);
    }
}
