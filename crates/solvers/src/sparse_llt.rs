//! The one place that talks to the sparse Cholesky library: symbolic factor, numbers and scratch
//! memory are kept together, so that a numeric factorisation allocates nothing.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use crate::SolverError;

/// The Cholesky factor of a sparse symmetric matrix given by the columns of its upper triangle.
pub(crate) struct SparseLlt {
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    factored: bool,
    scratch: MemBuffer,
}

impl SparseLlt {
    /// Analyses a pattern: column `j` of the upper triangle has the rows
    /// `rows[starts[j]..starts[j + 1]]`, increasing, the last one being `j`.
    pub(crate) fn new(
        starts: Vec<u32>,
        rows: Vec<u32>,
        threshold: SupernodalThreshold,
    ) -> Result<Self, SolverError> {
        let n = starts.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: threshold,
            ..Default::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(pattern, Side::Upper, SymmetricOrdering::Amd, parameters)
                .map_err(|error| SolverError::Factorisation {
                size: n,
                nonzeros: rows.len(),
                reason: match error {
                    FaerError::OutOfMemory => "out of memory",
                    _ => "the factor has more entries than can be indexed",
                },
            })?;
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let mut llt = Self {
            values: vec![0.0; rows.len()],
            factor: vec![0.0; symbolic.len_val()],
            factored: false,
            scratch: MemBuffer::new(scratch),
            starts,
            rows,
            symbolic,
        };
        if let SymbolicCholeskyRaw::Supernodal(_) = llt.symbolic.raw() {
            llt.warm_up()?;
        }
        Ok(llt)
    }

    /// Factors the identity once: the library's dense kernels allocate on their first use in a
    /// thread, and that had better be here than in the first step.
    fn warm_up(&mut self) -> Result<(), SolverError> {
        let mut identity = vec![0.0; self.rows.len()];
        for &end in &self.starts[1..] {
            identity[end as usize - 1] = 1.0;
        }
        self.factorise(identity.into_iter())?;
        self.factored = false;
        Ok(())
    }

    /// Factors the matrix with these values, in the order of the pattern.
    pub(crate) fn factorise(
        &mut self,
        values: impl Iterator<Item = f64>,
    ) -> Result<(), SolverError> {
        self.factored = false;
        let mut slots = self.values.iter_mut();
        for (slot, value) in slots.by_ref().zip(values) {
            *slot = value;
        }
        debug_assert!(slots.next().is_none(), "fewer values than the pattern has");
        self.check_finite()?;

        let n = self.starts.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.starts, None, &self.rows);
        let result = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            SparseColMatRef::new(pattern, &self.values),
            Side::Upper,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
        if let Err(LltError::NonPositivePivot { index }) = result {
            // The library counts permuted rows from one.
            return Err(SolverError::NotPositiveDefinite {
                row: self.original_row(index - 1),
                pivot: None,
            });
        }
        self.factored = true;
        Ok(())
    }

    /// `rhs ← A⁻¹ rhs`.
    ///
    /// # Panics
    /// Without a factor.
    pub(crate) fn solve_in_place(&mut self, rhs: &mut [f64]) {
        assert!(self.factored, "solve needs a factorisation that succeeded");
        let n = rhs.len();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }

    /// The symbolic factorisation.
    pub(crate) fn symbolic(&self) -> &SymbolicCholesky<u32> {
        &self.symbolic
    }

    /// The values of the factor, if the last factorisation succeeded.
    pub(crate) fn factor(&self) -> Option<&[f64]> {
        self.factored.then_some(&self.factor[..])
    }

    /// The matrix's row that the fill-reducing order puts at `permuted`.
    pub(crate) fn original_row(&self, permuted: usize) -> usize {
        self.symbolic.perm().map_or(permuted, |perm| perm.arrays().0[permuted] as usize)
    }

    /// An error for the first column with a value that is infinite or not a number, which the
    /// library would carry into the factor.
    fn check_finite(&self) -> Result<(), SolverError> {
        match self.values.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(slot) => Err(SolverError::NotPositiveDefinite {
                row: self.starts.partition_point(|&start| start as usize <= slot) - 1,
                pivot: Some(self.values[slot]),
            }),
        }
    }
}

impl std::fmt::Debug for SparseLlt {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("SparseLlt")
            .field("rows", &(self.starts.len() - 1))
            .field("factored", &self.factored)
            .finish_non_exhaustive()
    }
}
