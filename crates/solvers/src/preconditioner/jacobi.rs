//! Diagonal preconditioners, scalar and by 3×3 blocks.

use super::Preconditioner;
use crate::{BlockMatrix, Mat3, ScalarMatrix, SolverError, Vec3};

/// `P = diag(A)⁻¹` of a scalar matrix. Couplings play no part in it, so pinned rows need no mention.
#[derive(Clone, Debug)]
pub struct Jacobi {
    inverse_diagonal: Vec<f64>,
}

impl Jacobi {
    /// The identity, with room for the rows of `a`.
    pub fn new(a: &ScalarMatrix) -> Self {
        Self { inverse_diagonal: vec![1.0; a.n()] }
    }

    /// Takes over the diagonal of `a`.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] for a diagonal entry that is not positive;
    /// [`SolverError::PatternChanged`] for another number of rows (other couplings do not matter).
    pub fn update(&mut self, a: &ScalarMatrix) -> Result<(), SolverError> {
        if a.n() != self.inverse_diagonal.len() {
            return Err(SolverError::PatternChanged {
                expected_size: self.inverse_diagonal.len(),
                expected_nonzeros: self.inverse_diagonal.len(),
                size: a.n(),
                nonzeros: a.nonzeros(),
            });
        }
        for row in 0..a.n() {
            let pivot = a.diagonal(row);
            if !is_pivot(pivot) {
                self.inverse_diagonal.fill(1.0);
                return Err(SolverError::NotPositiveDefinite { row, pivot: Some(pivot) });
            }
            self.inverse_diagonal[row] = 1.0 / pivot;
        }
        Ok(())
    }

    /// `1 / Aᵢᵢ`.
    pub(crate) fn inverse_diagonal(&self) -> &[f64] {
        &self.inverse_diagonal
    }
}

impl Preconditioner for Jacobi {
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        assert_eq!(r.len(), self.inverse_diagonal.len(), "one vector a row");
        assert_eq!(z.len(), self.inverse_diagonal.len(), "one vector a row");
        for ((z, r), inverse) in z.iter_mut().zip(r).zip(&self.inverse_diagonal) {
            *z = r * *inverse;
        }
    }
}

/// The inverses of the 3×3 diagonal blocks of a block matrix.
#[derive(Clone, Debug)]
pub struct BlockJacobi {
    inverse_diagonal: Vec<Mat3>,
}

impl BlockJacobi {
    /// The identity, with room for the rows of `a`.
    pub fn new(a: &BlockMatrix) -> Self {
        Self { inverse_diagonal: vec![Mat3::identity(); a.n()] }
    }

    /// Takes over the diagonal blocks of `a`.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] for a diagonal block that is not positive definite;
    /// [`SolverError::PatternChanged`] for another number of rows (other couplings do not matter).
    pub fn update(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        if a.n() != self.inverse_diagonal.len() {
            return Err(SolverError::PatternChanged {
                expected_size: self.inverse_diagonal.len(),
                expected_nonzeros: self.inverse_diagonal.len(),
                size: a.n(),
                nonzeros: a.nonzeros(),
            });
        }
        for i in 0..a.n() {
            match inverse(&a.get(i, i)) {
                Ok(inverse) => self.inverse_diagonal[i] = inverse,
                Err((k, pivot)) => {
                    self.inverse_diagonal.fill(Mat3::identity());
                    return Err(SolverError::NotPositiveDefinite {
                        row: 3 * i + k,
                        pivot: Some(pivot),
                    });
                }
            }
        }
        Ok(())
    }
}

impl Preconditioner for BlockJacobi {
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        assert_eq!(r.len(), self.inverse_diagonal.len(), "one vector a row");
        assert_eq!(z.len(), self.inverse_diagonal.len(), "one vector a row");
        for ((z, r), p) in z.iter_mut().zip(r).zip(&self.inverse_diagonal) {
            for k in 0..3 {
                z[k] = p[(k, 0)] * r[0] + p[(k, 1)] * r[1] + p[(k, 2)] * r[2];
            }
        }
    }
}

/// Whether a number can be a pivot of a positive definite matrix.
pub(super) fn is_pivot(pivot: f64) -> bool {
    pivot > 0.0 && pivot.is_finite()
}

/// The inverse of a symmetric positive definite 3×3 block, `A⁻¹ = Mᵀ D⁻¹ M` with `M = L⁻¹` from
/// `A = L D Lᵀ`; else the row and the value of the pivot that is not positive.
fn inverse(a: &Mat3) -> Result<Mat3, (usize, f64)> {
    let check = |row: usize, pivot: f64| {
        if is_pivot(pivot) { Ok(pivot) } else { Err((row, pivot)) }
    };
    let d0 = check(0, a[(0, 0)])?;
    let (l10, l20) = (a[(1, 0)] / d0, a[(2, 0)] / d0);
    let d1 = check(1, a[(1, 1)] - l10 * a[(1, 0)])?;
    let l21 = (a[(2, 1)] - l20 * a[(1, 0)]) / d1;
    let d2 = check(2, a[(2, 2)] - l20 * a[(2, 0)] - l21 * l21 * d1)?;
    let (m10, m21, m20) = (-l10, -l21, l10 * l21 - l20);

    let i22 = 1.0 / d2;
    let i21 = m21 * i22;
    let i20 = m20 * i22;
    let i11 = 1.0 / d1 + m21 * i21;
    let i10 = m10 / d1 + m21 * i20;
    let i00 = 1.0 / d0 + m10 * m10 / d1 + m20 * i20;
    Ok(Mat3::new(i00, i10, i20, i10, i11, i21, i20, i21, i22))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::{Random, diagonal, graph, random_blocks};
    use proptest::prelude::*;

    #[test]
    fn jacobi_inverts_a_diagonal_matrix() {
        let a = diagonal(&[2.0, 4.0]);
        let mut p = Jacobi::new(&a);
        let r = [Vec3::new(2.0, 4.0, 8.0); 2];
        let mut z = r;
        p.apply(&r, &mut z);
        assert_eq!(z, r);
        p.update(&a).unwrap();
        p.apply(&r, &mut z);
        assert_eq!(z, [r[0] / 2.0, r[1] / 4.0]);
    }

    #[test]
    fn jacobi_names_the_row_that_is_not_positive() {
        for bad in [0.0, -1.0, f64::NAN] {
            let a = diagonal(&[2.0, bad]);
            let error = Jacobi::new(&a).update(&a).unwrap_err();
            assert!(matches!(error, SolverError::NotPositiveDefinite { row: 1, .. }));
        }
        let a = diagonal(&[2.0]);
        let other = diagonal(&[2.0, 3.0]);
        let error = Jacobi::new(&a).update(&other).unwrap_err();
        assert!(matches!(error, SolverError::PatternChanged { size: 2, .. }));
    }

    proptest! {
        #[test]
        fn block_jacobi_inverts_the_diagonal_blocks((n, edges) in graph(8)) {
            let mut random = Random::new(9);
            let a = random_blocks(n, &edges, &mut random);
            let mut p = BlockJacobi::new(&a);
            p.update(&a).unwrap();
            let r = random.vectors(n);
            let mut z = random.vectors(n);
            p.apply(&r, &mut z);
            for i in 0..n {
                prop_assert!((a.get(i, i) * z[i] - r[i]).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn block_jacobi_names_the_scalar_row() {
        let mut a = BlockMatrix::with_pattern(2, []);
        a.add_diagonal(0, &Mat3::identity());
        a.add_diagonal(1, &Mat3::new(1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0));
        let error = BlockJacobi::new(&a).update(&a).unwrap_err();
        let expected = SolverError::NotPositiveDefinite { row: 4, pivot: Some(-3.0) };
        assert_eq!(error, expected);
    }
}
