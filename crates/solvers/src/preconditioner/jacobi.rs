//! The diagonal as preconditioner.

use super::Preconditioner;
use crate::{ScalarMatrix, SolverError, Vec3};

/// `P = diag(A)⁻¹` of a scalar matrix. It does not use couplings, so pinned rows need no mask.
#[derive(Clone, Debug)]
pub struct Jacobi {
    inverse_diagonal: Vec<f64>,
}

impl Jacobi {
    /// The identity, with memory for the rows of `a`.
    pub fn new(a: &ScalarMatrix) -> Self {
        Self { inverse_diagonal: vec![1.0; a.n()] }
    }

    /// Inverts the diagonal of `a`.
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

/// Whether a number can be a pivot of a positive definite matrix.
pub(super) fn is_pivot(pivot: f64) -> bool {
    pivot > 0.0 && pivot.is_finite()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::diagonal;

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
}
