//! The explicit inverse of a scalar matrix.

use std::mem::size_of;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, Par};

use super::Preconditioner;
use crate::free::FreeRows;
use crate::{ScalarMatrix, SolverError, Vec3};

/// `P = A⁻¹` up to round-off as a full n×n matrix, from dense `A = L Lᵀ` and `A⁻¹ = L⁻ᵀ L⁻¹`.
///
/// It takes 16 n² bytes, n³ operations to make and 6 n² to apply, whatever the sparsity of `A`,
/// because the inverse of a connected graph's matrix has no zeros. Its advantage is that a solve is
/// one product with a matrix that can be computed beforehand, if `A` does not change.
///
/// A product sums in fixed order, from the first column to the last. The library `faer` computes
/// the inverse, and its last bits may differ from one processor to another.
pub struct DenseInverse {
    n: usize,
    /// `A⁻¹` by rows; as it is symmetric, by columns too. While it is computed, `A` and then `L`.
    inverse: Vec<f64>,
    /// `L⁻¹`.
    factor_inverse: Vec<f64>,
    scratch: MemBuffer,
    updated: bool,
}

impl DenseInverse {
    /// The identity, with memory for the inverse of a matrix with as many rows as `a`.
    ///
    /// It computes the required memory first, so a refusal allocates nothing. The count omits the
    /// memory that the library's kernels allocate on their first use in a thread, which is twice
    /// the processor's last-level cache.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if more than `limit_bytes` are needed.
    pub fn new(a: &ScalarMatrix, limit_bytes: usize) -> Result<Self, SolverError> {
        let n = a.n();
        let bytes = Self::bytes_needed(n);
        // No single allocation may be larger than `isize::MAX`.
        let limit = limit_bytes.min(isize::MAX as usize) as u64;
        if bytes > limit {
            return Err(SolverError::TooLarge { bytes, limit });
        }
        let mut dense = Self {
            n,
            inverse: vec![0.0; n * n],
            factor_inverse: vec![0.0; n * n],
            scratch: MemBuffer::new(cholesky_in_place_scratch::<f64>(
                n,
                Par::Seq,
                Default::default(),
            )),
            updated: false,
        };
        dense.warm_up()?;
        Ok(dense)
    }

    /// The bytes that [`new`](Self::new) allocates for `n` rows: two n×n matrices and one column.
    /// `u64::MAX` stands for that many or more.
    pub fn bytes_needed(n: usize) -> u64 {
        let matrices = (n as u64)
            .checked_mul(n as u64)
            .and_then(|entries| entries.checked_mul(2 * size_of::<f64>() as u64));
        // Where the count of the matrices fits, the library's count cannot overflow.
        matrices.map_or(u64::MAX, |matrices| {
            let column = cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
            matrices.saturating_add(column.size_bytes() as u64)
        })
    }

    /// Inverts `a`. Rows that are not `free` keep only the inverse of their diagonal entry.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`], after which the preconditioner is the identity.
    /// [`SolverError::PatternChanged`] for another number of rows (other couplings do not matter);
    /// the inverse then stays as it was.
    ///
    /// # Panics
    /// Unless `free` has one flag for each row.
    pub fn update(&mut self, a: &ScalarMatrix, free: Option<&[bool]>) -> Result<(), SolverError> {
        if a.n() != self.n {
            return Err(SolverError::PatternChanged {
                expected_size: self.n,
                expected_nonzeros: self.n * self.n,
                size: a.n(),
                nonzeros: a.nonzeros(),
            });
        }
        self.updated = false;
        self.copy_lower_triangle(a, FreeRows::new(free, a.n()))?;
        self.invert(self.n)?;
        for i in 0..self.n {
            for j in 0..i {
                self.inverse[i * self.n + j] = self.inverse[j * self.n + i];
            }
        }
        self.updated = true;
        Ok(())
    }

    /// Writes the entries of `a` on and below the diagonal to `inverse`, by columns.
    fn copy_lower_triangle(
        &mut self,
        a: &ScalarMatrix,
        rows: FreeRows<'_>,
    ) -> Result<(), SolverError> {
        self.inverse.fill(0.0);
        for i in 0..self.n {
            let (columns, values) = a.row(i);
            for (&j, &value) in columns.iter().zip(values) {
                let j = j as usize;
                if j > i {
                    break;
                }
                if !rows.kept(i, j) {
                    continue;
                }
                if !value.is_finite() {
                    return Err(SolverError::NotPositiveDefinite { row: i, pivot: Some(value) });
                }
                self.inverse[j * self.n + i] = value;
            }
        }
        Ok(())
    }

    /// Inverts the first `size` rows and columns of `inverse` in place; it reads and writes the
    /// lower triangle.
    fn invert(&mut self, size: usize) -> Result<(), SolverError> {
        let n = self.n;
        let mut a = MatMut::from_column_major_slice_mut(&mut self.inverse, n, n)
            .submatrix_mut(0, 0, size, size);
        let mut inverse_l = MatMut::from_column_major_slice_mut(&mut self.factor_inverse, n, n)
            .submatrix_mut(0, 0, size, size);
        let stack = MemStack::new(&mut self.scratch);
        cholesky_in_place(a.rb_mut(), Default::default(), Par::Seq, stack, Default::default())
            .map_err(|LltError::NonPositivePivot { index }| SolverError::NotPositiveDefinite {
                row: index,
                pivot: None,
            })?;
        invert_lower_triangular(inverse_l.rb_mut(), a.rb(), Par::Seq);
        triangular::matmul(
            a,
            BlockStructure::TriangularLower,
            Accum::Replace,
            inverse_l.rb().transpose(),
            BlockStructure::TriangularUpper,
            inverse_l.rb(),
            BlockStructure::TriangularLower,
            1.0,
            Par::Seq,
        );
        Ok(())
    }

    /// Inverts an identity just large enough for the library to use all of its kernels. They
    /// allocate on their first use in a thread, and must not do so in the first step.
    fn warm_up(&mut self) -> Result<(), SolverError> {
        let size = self.n.min(512);
        for i in 0..size {
            self.inverse[i * self.n + i] = 1.0;
        }
        self.invert(size)
    }
}

impl Preconditioner for DenseInverse {
    /// Each row is summed from its first column to its last.
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        assert_eq!(r.len(), self.n, "one vector a row");
        assert_eq!(z.len(), self.n, "one vector a row");
        if !self.updated {
            z.copy_from_slice(r);
            return;
        }
        let row = |i: usize| &self.inverse[i * self.n..][..self.n];
        let (fours, rest) = z.as_chunks_mut::<4>();
        for (z, i) in fours.iter_mut().zip((0..).step_by(4)) {
            *z = products([row(i), row(i + 1), row(i + 2), row(i + 3)], r);
        }
        for (z, i) in rest.iter_mut().zip(self.n / 4 * 4..) {
            [*z] = products([row(i)], r);
        }
    }
}

/// Products of rows with a vector, each summed from the first column to the last. Several rows at a
/// time halve the time and change no bit: an addition has to wait for the one before it in its own
/// sum only.
fn products<const ROWS: usize>(rows: [&[f64]; ROWS], r: &[Vec3]) -> [Vec3; ROWS] {
    let mut sums = [[0.0; 3]; ROWS];
    for (j, r) in r.iter().enumerate() {
        for (sum, row) in sums.iter_mut().zip(rows) {
            for k in 0..3 {
                sum[k] += row[j] * r[k];
            }
        }
    }
    sums.map(Vec3::from)
}

impl std::fmt::Debug for DenseInverse {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("DenseInverse")
            .field("rows", &self.n)
            .field("updated", &self.updated)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::{Random, diagonal, grid_edges, laplacian};

    fn inverted(a: &ScalarMatrix) -> DenseInverse {
        let mut p = DenseInverse::new(a, usize::MAX).unwrap();
        p.update(a, None).unwrap();
        p
    }

    fn entries(p: &DenseInverse) -> nalgebra::DMatrix<f64> {
        nalgebra::DMatrix::from_row_slice(p.n, p.n, &p.inverse)
    }

    /// Large enough for all of the library's blockings.
    #[test]
    fn it_is_symmetric_and_spreads_one_impulse_over_a_mass_of_one() {
        let side = 24;
        let (n, edges) = (side * side, grid_edges(side));
        let mut random = Random::new(41);
        let mut a = laplacian(n, &edges, 0.0, || 10.0 * random.unit().abs());
        let mass: Vec<f64> = (0..n).map(|_| 1.5 + random.unit()).collect();
        for i in 0..n {
            a.add_diagonal(i, mass[i]);
        }
        let p = inverted(&a);
        let w = entries(&p);
        assert_eq!(w, w.transpose());
        // An M-matrix has a positive inverse.
        assert!(w.min() > 0.0);
        // (M + L) 1 = M 1, so A⁻¹ M 1 = 1.
        let masses: Vec<Vec3> = mass.iter().map(|&m| Vec3::repeat(m)).collect();
        let mut ones = masses.clone();
        p.apply(&masses, &mut ones);
        assert!(ones.iter().all(|v| (v - Vec3::repeat(1.0)).norm() < 1e-13));
    }

    #[test]
    fn products_are_summed_by_columns_bit_for_bit() {
        for side in 1..6 {
            let n = side * side;
            let mut random = Random::new(43);
            let a = laplacian(n, &grid_edges(side), 0.3, || random.unit().abs());
            let p = inverted(&a);
            let w = entries(&p);
            let r = random.vectors(n);
            let mut z = r.clone();
            p.apply(&r, &mut z);
            for i in 0..n {
                let expected = (0..n).fold(Vec3::zeros(), |sum, j| sum + w[(i, j)] * r[j]);
                assert_eq!(z[i], expected);
            }
        }
    }

    #[test]
    fn the_limit_is_what_is_needed() {
        let a = diagonal(&[1.0; 10]);
        let bytes = DenseInverse::bytes_needed(10);
        assert!(bytes >= 1600);
        assert!(DenseInverse::new(&a, bytes as usize).is_ok());
        let error = DenseInverse::new(&a, bytes as usize - 1).unwrap_err();
        assert_eq!(error, SolverError::TooLarge { bytes, limit: bytes - 1 });
    }

    #[test]
    fn needs_that_overflow_are_refused_whatever_the_limit() {
        assert_eq!(DenseInverse::bytes_needed(usize::MAX), u64::MAX);
        assert_eq!(DenseInverse::bytes_needed(u32::MAX as usize), u64::MAX);
        assert!(DenseInverse::bytes_needed(1 << 29) < u64::MAX);
    }

    #[test]
    fn an_empty_matrix_has_an_inverse() {
        inverted(&diagonal(&[])).apply(&[], &mut []);
    }
}
