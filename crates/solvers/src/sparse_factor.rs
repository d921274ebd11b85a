//! The one place that talks to the sparse Cholesky library: symbolic factor, numbers and scratch
//! memory are kept together, so that a numeric factorisation allocates nothing.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::{LdltError, LdltRegularization};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use crate::SolverError;
use crate::pivots::{BadPivot, PivotCheck};

/// Which factorisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `A = L Lᵀ`, for positive definite matrices.
    Llt,
    /// `A = L D Lᵀ` with ones on the diagonal of `L`; the factor holds `D` in their place.
    Ldlt,
}

/// A factor of a sparse symmetric matrix given by the columns of its upper triangle.
pub(crate) struct SparseFactor {
    kind: Kind,
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    factored: bool,
    /// One number a row for the check of the pivots of an `L D Lᵀ`; empty for `L Lᵀ`.
    sums: Vec<f64>,
    negative_pivots: usize,
    scratch: MemBuffer,
}

impl SparseFactor {
    /// Analyses a pattern: column `j` of the upper triangle has the rows
    /// `rows[starts[j]..starts[j + 1]]`, increasing, the last one being `j`.
    pub(crate) fn new(
        kind: Kind,
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
        let (scratch, sums) = match kind {
            Kind::Llt => (
                symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
                Vec::new(),
            ),
            Kind::Ldlt => (
                symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default()),
                vec![0.0; n],
            ),
        };
        let scratch = scratch.or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let mut factor = Self {
            kind,
            values: vec![0.0; rows.len()],
            factor: vec![0.0; symbolic.len_val()],
            factored: false,
            sums,
            negative_pivots: 0,
            scratch: MemBuffer::new(scratch),
            starts,
            rows,
            symbolic,
        };
        if let SymbolicCholeskyRaw::Supernodal(_) = factor.symbolic.raw() {
            factor.warm_up()?;
        }
        Ok(factor)
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
        self.eliminate().map_err(|permuted| self.bad_pivot(self.original_row(permuted), None))?;
        if self.kind == Kind::Ldlt {
            self.negative_pivots = self
                .check_pivots()
                .map_err(|bad| self.bad_pivot(self.original_row(bad.row), Some(bad.pivot)))?;
        }
        self.factored = true;
        Ok(())
    }

    /// Lets the library compute the factor, or else the permuted row where it stopped.
    fn eliminate(&mut self) -> Result<(), usize> {
        let n = self.starts.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.starts, None, &self.rows);
        let matrix = SparseColMatRef::new(pattern, &self.values);
        let stack = MemStack::new(&mut self.scratch);
        let result = match self.kind {
            Kind::Llt => self
                .symbolic
                .factorize_numeric_llt(
                    &mut self.factor,
                    matrix,
                    Side::Upper,
                    Default::default(),
                    Par::Seq,
                    stack,
                    Default::default(),
                )
                .map(drop)
                .map_err(|LltError::NonPositivePivot { index }| index),
            Kind::Ldlt => self
                .symbolic
                .factorize_numeric_ldlt(
                    &mut self.factor,
                    matrix,
                    Side::Upper,
                    // A regularised pivot of zero stands for no regularisation at all.
                    LdltRegularization {
                        dynamic_regularization_signs: None,
                        dynamic_regularization_delta: 0.0,
                        dynamic_regularization_epsilon: 0.0,
                    },
                    Par::Seq,
                    stack,
                    Default::default(),
                )
                .map(drop)
                .map_err(|LdltError::ZeroPivot { index }| index),
        };
        // The library counts rows from one where it goes column by column, but from zero where it
        // goes by supernodes.
        result.map_err(|index| match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => index - 1,
            SymbolicCholeskyRaw::Supernodal(_) => index,
        })
    }

    /// Reads an `L D Lᵀ` and returns the number of its negative pivots.
    fn check_pivots(&mut self) -> Result<usize, BadPivot> {
        let largest = self.values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let mut check = PivotCheck::new(&mut self.sums, largest);
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(l) => {
                for (k, ends) in l.col_ptr().windows(2).enumerate() {
                    let column = ends[0] as usize..ends[1] as usize;
                    let rows = l.row_idx()[column.clone()][1..].iter().map(|&i| i as usize);
                    check.column(k, &self.factor[column], rows)?;
                }
            }
            SymbolicCholeskyRaw::Supernodal(l) => {
                for s in 0..l.n_supernodes() {
                    let (begin, end) = (l.supernode(s).start(), l.supernode_end()[s] as usize);
                    let pattern = l.supernode(s).pattern();
                    // A dense panel by columns: a square on the diagonal, and the rows below it.
                    let panel = &self.factor[l.col_ptr_for_val()[s] as usize..];
                    let columns = panel.chunks_exact(end - begin + pattern.len());
                    for (k, column) in (begin..end).zip(columns) {
                        let rows = (k + 1..end).chain(pattern.iter().map(|&i| i as usize));
                        check.column(k, &column[k - begin..], rows)?;
                    }
                }
            }
        }
        Ok(check.negative())
    }

    /// `rhs ← A⁻¹ rhs`.
    ///
    /// # Panics
    /// Without a factor.
    pub(crate) fn solve_in_place(&mut self, rhs: &mut [f64]) {
        assert!(self.factored, "solve needs a factorisation that succeeded");
        let n = rhs.len();
        let rhs = MatMut::from_column_major_slice_mut(rhs, n, 1);
        let stack = MemStack::new(&mut self.scratch);
        match self.kind {
            Kind::Llt => LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
                Conj::No,
                rhs,
                Par::Seq,
                stack,
            ),
            Kind::Ldlt => LdltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
                Conj::No,
                rhs,
                Par::Seq,
                stack,
            ),
        }
    }

    /// Which factorisation this is.
    pub(crate) fn kind(&self) -> Kind {
        self.kind
    }

    /// The symbolic factorisation.
    pub(crate) fn symbolic(&self) -> &SymbolicCholesky<u32> {
        &self.symbolic
    }

    /// Whether the last factorisation succeeded.
    pub(crate) fn factored(&self) -> bool {
        self.factored
    }

    /// The values of the factor; without a successful factorisation they mean nothing.
    pub(crate) fn factor(&self) -> &[f64] {
        &self.factor
    }

    /// How many pivots of an `L D Lᵀ` are negative, if the last factorisation succeeded.
    pub(crate) fn negative_pivots(&self) -> Option<usize> {
        self.factored.then_some(self.negative_pivots)
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
            Some(slot) => Err(self.bad_pivot(
                self.starts.partition_point(|&start| start as usize <= slot) - 1,
                Some(self.values[slot]),
            )),
        }
    }

    /// What a bad pivot means for this factorisation.
    fn bad_pivot(&self, row: usize, pivot: Option<f64>) -> SolverError {
        match self.kind {
            Kind::Llt => SolverError::NotPositiveDefinite { row, pivot },
            Kind::Ldlt => SolverError::Singular { row, pivot },
        }
    }
}

impl std::fmt::Debug for SparseFactor {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("SparseFactor")
            .field("kind", &self.kind)
            .field("rows", &(self.starts.len() - 1))
            .field("factored", &self.factored)
            .finish_non_exhaustive()
    }
}
