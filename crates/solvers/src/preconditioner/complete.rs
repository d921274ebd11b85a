//! Complete sparse Cholesky factorisation of a scalar matrix.

use super::Preconditioner;
use crate::free::FreeRows;
use crate::scalar_factor::ScalarFactor;
use crate::sparse_factor::FactorKind;
use crate::{ScalarMatrix, SolverError, Vec3};

/// `P = A⁻¹` up to round-off, from `A = L Lᵀ` with fill and a fill-reducing order of the rows.
///
/// As a preconditioner it makes conjugate gradients converge in one iteration while the matrix is
/// the factored one, and quickly while it is near. One factor serves the three coordinates.
#[derive(Debug)]
pub struct CompleteCholesky {
    factor: ScalarFactor,
}

impl CompleteCholesky {
    /// The identity, with the symbolic factorisation of the pattern of `a`.
    ///
    /// # Errors
    /// [`SolverError::Factorisation`] when the factor does not fit into memory.
    pub fn new(a: &ScalarMatrix) -> Result<Self, SolverError> {
        Ok(Self { factor: ScalarFactor::new(a, FactorKind::Cholesky)? })
    }

    /// Factors `a`. Rows that `free` says are not free keep their diagonal entry alone.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`]; [`SolverError::PatternChanged`] when `a` has another
    /// pattern than the matrix given to [`new`](Self::new), in which case the factor stays as it
    /// was.
    ///
    /// # Panics
    /// When `free` has not one flag a row.
    pub fn update(&mut self, a: &ScalarMatrix, free: Option<&[bool]>) -> Result<(), SolverError> {
        self.factor.update(a, FreeRows::new(free, a.n()))
    }

    /// Entries of each column of `L`, the diagonal one among them, in the fill-reducing order:
    /// their sum is the memory of the factor, the sum of their squares the operations that make it.
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
    use crate::LinearOperator;
    use crate::test_support::{Random, graph, grid_edges, laplacian};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_inverts_the_matrix((n, edges) in graph(20)) {
            let mut random = Random::new(14);
            let a = laplacian(n, &edges, 0.3, || random.unit().abs());
            let mut p = CompleteCholesky::new(&a).unwrap();
            p.update(&a, None).unwrap();
            let x = random.vectors(n);
            let (mut b, mut solution) = (x.clone(), x.clone());
            a.multiply(&x, &mut b);
            p.apply(&b, &mut solution);
            for i in 0..n {
                prop_assert!((solution[i] - x[i]).norm() < 1e-11);
            }
        }
    }

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

    #[test]
    fn pinned_rows_keep_their_diagonal_alone() {
        let edges = grid_edges(5);
        let a = laplacian(25, &edges, 0.3, || 1.0);
        let free: Vec<bool> = (0..25).map(|i| i != 7 && i != 12).collect();
        let kept: Vec<_> = edges.iter().copied().filter(|&(i, j)| free[i] && free[j]).collect();
        let mut reduced = laplacian(25, &kept, 0.3, || 1.0);
        for i in 0..25 {
            reduced.add_diagonal(i, a.diagonal(i) - reduced.diagonal(i));
        }
        let mut p = CompleteCholesky::new(&a).unwrap();
        p.update(&a, Some(&free)).unwrap();
        let x = Random::new(15).vectors(25);
        let (mut b, mut solution) = (x.clone(), x.clone());
        reduced.multiply(&x, &mut b);
        p.apply(&b, &mut solution);
        for i in 0..25 {
            assert!((solution[i] - x[i]).norm() < 1e-13);
        }
    }

    #[test]
    fn a_failed_update_leaves_the_identity_and_the_next_one_succeeds() {
        let mut a = laplacian(9, &grid_edges(3), 1.0, || 1.0);
        let mut p = CompleteCholesky::new(&a).unwrap();
        a.add_diagonal(4, -100.0);
        let error = p.update(&a, None).unwrap_err();
        assert!(matches!(error, SolverError::NotPositiveDefinite { .. }));
        let r = Random::new(16).vectors(9);
        let (mut z, mut back) = (r.clone(), r.clone());
        p.apply(&r, &mut z);
        assert_eq!(z, r);
        a.add_diagonal(4, 100.0);
        p.update(&a, None).unwrap();
        p.apply(&r, &mut z);
        a.multiply(&z, &mut back);
        assert!((0..9).all(|i| (back[i] - r[i]).norm() < 1e-13));
        let other = laplacian(9, &[(0, 8)], 1.0, || 1.0);
        let error = p.update(&other, None).unwrap_err();
        assert!(matches!(error, SolverError::PatternChanged { .. }));
    }
}
