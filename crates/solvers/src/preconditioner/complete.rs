//! Complete sparse Cholesky factorisation of a scalar matrix.

use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::SymbolicCholeskyRaw;

use super::{Preconditioner, Rows};
use crate::pattern::Pattern;
use crate::sparse_llt::SparseLlt;
use crate::{ScalarMatrix, SolverError, Vec3};

/// `P = A⁻¹` up to round-off, from `A = L Lᵀ` with fill and a fill-reducing order of the rows (AMD).
///
/// As a preconditioner it makes conjugate gradients converge in one iteration while the matrix is
/// the factored one, and quickly while it is near. One factor serves the three coordinates.
#[derive(Debug)]
pub struct CompleteCholesky {
    /// The pattern that the factor was made for.
    pattern: Pattern,
    llt: SparseLlt,
    /// `L` by columns; the first entry of a column is its diagonal entry.
    starts: Vec<u32>,
    /// The row of `A` that each entry of `L` belongs to, so that vectors need no permutation.
    rows: Vec<u32>,
}

impl CompleteCholesky {
    /// The identity, with the symbolic factorisation of the pattern of `a`.
    ///
    /// # Errors
    /// [`SolverError::Factorisation`] when the factor does not fit into memory.
    pub fn new(a: &ScalarMatrix) -> Result<Self, SolverError> {
        let pattern = a.pattern().clone();
        let mut starts = vec![0];
        let mut columns = Vec::new();
        for j in 0..a.n() {
            columns.extend_from_slice(&pattern.columns()[pattern.lower(j)]);
            columns.push(j as u32);
            starts.push(columns.len() as u32);
        }
        // The simplicial factor is plain columns, which `apply` can sweep itself.
        let llt = SparseLlt::new(starts, columns, SupernodalThreshold::FORCE_SIMPLICIAL)?;
        let SymbolicCholeskyRaw::Simplicial(factor) = llt.symbolic().raw() else {
            unreachable!("a simplicial factorisation was asked for");
        };
        Ok(Self {
            starts: factor.col_ptr().to_vec(),
            rows: factor
                .row_idx()
                .iter()
                .map(|&row| llt.original_row(row as usize) as u32)
                .collect(),
            pattern,
            llt,
        })
    }

    /// Factors `a`. Rows that `free` says are not free keep their diagonal entry alone.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`]; [`SolverError::PatternChanged`] when `a` has another
    /// pattern than the matrix given to [`new`](Self::new), in which case the factor stays as it was.
    ///
    /// # Panics
    /// When `free` has not one flag a row.
    pub fn update(&mut self, a: &ScalarMatrix, free: Option<&[bool]>) -> Result<(), SolverError> {
        self.pattern.check(a.pattern())?;
        let rows = Rows::new(free, a.n());
        let upper = (0..a.n()).flat_map(|j| {
            let (columns, values) = a.row(j);
            columns.iter().zip(values).take_while(move |&(&i, _)| i as usize <= j).map(
                move |(&i, &value)| {
                    if i as usize == j || rows.coupled(i as usize, j) { value } else { 0.0 }
                },
            )
        });
        self.llt.factorise(upper)
    }
}

impl Preconditioner for CompleteCholesky {
    /// Solves `L y = r` column by column, then `Lᵀ z = y` row by row, in place.
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        let n = self.pattern.n();
        assert_eq!(r.len(), n, "one vector a row");
        assert_eq!(z.len(), n, "one vector a row");
        z.copy_from_slice(r);
        let Some(factor) = self.llt.factor() else {
            return;
        };
        let column = |j: usize| self.starts[j] as usize..self.starts[j + 1] as usize;
        for j in 0..n {
            let (rows, values) = (&self.rows[column(j)], &factor[column(j)]);
            let y = z[rows[0] as usize] / values[0];
            z[rows[0] as usize] = y;
            for (&i, &value) in rows[1..].iter().zip(&values[1..]) {
                z[i as usize] -= y * value;
            }
        }
        for j in (0..n).rev() {
            let (rows, values) = (&self.rows[column(j)], &factor[column(j)]);
            let mut sum = z[rows[0] as usize];
            for (&i, &value) in rows[1..].iter().zip(&values[1..]) {
                sum -= z[i as usize] * value;
            }
            z[rows[0] as usize] = sum / values[0];
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
