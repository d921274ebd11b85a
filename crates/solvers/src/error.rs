//! Errors of a factorisation.

/// Why a factorisation or a preconditioner could not be computed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SolverError {
    /// A pivot was zero, negative or not a number.
    #[error(
        "the matrix is not positive definite: row {row} has {}; shorten the step, add mass to the \
         diagonal or leave the indefinite part of the Jacobian out",
        PivotText(*pivot, "a pivot that is not positive")
    )]
    NotPositiveDefinite {
        /// Row of the given matrix, before any permutation: a particle for a
        /// [`ScalarMatrix`](crate::ScalarMatrix); 3 × particle + coordinate for a
        /// [`BlockMatrix`](crate::BlockMatrix).
        row: usize,
        /// The pivot, if the factorisation reports it. The sparse Cholesky library does not.
        pivot: Option<f64>,
    },
    /// A pivot of a factorisation of an indefinite matrix was zero, not a number, or too small to
    /// leave correct digits.
    #[error(
        "the matrix is singular, or cannot be factored without exchanging rows: row {row} has {}; \
         change the step size, add mass to the diagonal or leave the indefinite part of the \
         Jacobian out",
        PivotText(*pivot, "a pivot that is zero or not finite")
    )]
    Singular {
        /// Row of the given matrix, before any permutation: a particle for a
        /// [`ScalarMatrix`](crate::ScalarMatrix); 3 × particle + coordinate for a
        /// [`BlockMatrix`](crate::BlockMatrix).
        row: usize,
        /// The pivot, if the factorisation reports it. The sparse Cholesky library does not report
        /// a pivot that is zero or has overflowed.
        pivot: Option<f64>,
    },
    /// A dense matrix would take more memory than the limit. Nothing was allocated.
    #[error(
        "the dense inverse needs {bytes} bytes, and {limit} are allowed; raise the limit, take \
         fewer particles, or use a sparse factorisation or conjugate gradients"
    )]
    TooLarge {
        /// Bytes needed; `u64::MAX` means that many or more.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// The matrix has another pattern than the factor.
    #[error(
        "the factor was made for the pattern of a matrix with {expected_size} rows and \
         {expected_nonzeros} non-zeros, and got another one ({size} rows, {nonzeros} non-zeros); \
         make a new factor when the topology changes"
    )]
    PatternChanged {
        /// Number of rows of the matrix for which the factor was made.
        expected_size: usize,
        /// Number of non-zeros of the matrix for which the factor was made.
        expected_nonzeros: usize,
        /// Number of rows of the given matrix.
        size: usize,
        /// Number of non-zeros of the given matrix.
        nonzeros: usize,
    },
    /// The symbolic factorisation failed: memory or index range is exhausted.
    #[error(
        "the symbolic factorisation of a matrix with {size} rows and {nonzeros} non-zeros failed \
         ({reason}); use the conjugate gradient solver for a problem of this size"
    )]
    Factorisation {
        /// Number of scalar rows.
        size: usize,
        /// Number of scalar non-zeros of one triangle.
        nonzeros: usize,
        /// The exhausted resource.
        reason: &'static str,
    },
}

/// A pivot, or words for one that is unknown.
struct PivotText(Option<f64>, &'static str);

impl std::fmt::Display for PivotText {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(pivot) => write!(out, "the pivot {pivot:e}"),
            None => out.write_str(self.1),
        }
    }
}
