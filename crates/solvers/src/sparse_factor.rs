//! The only module that calls the sparse Cholesky library. It keeps symbolic factor, numbers and
//! scratch memory together, so that a numeric factorisation allocates nothing.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::{LdltError, LdltRegularization};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, SymbolicSupernodalParams};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Side};

use std::ops::Range;

use crate::SolverError;
use crate::pivots::{BadPivot, PivotCheck};

/// The kind of factorisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorKind {
    /// `A = L Lᵀ`, for positive definite matrices.
    Cholesky,
    /// `A = L D Lᵀ` with ones on the diagonal of `L`; the factor holds `D` in their place.
    Ldlt,
}

/// Neighbouring supernodes are merged into one of at most this many columns while at most this part
/// of its entries are zeros. The library's own limits allow 0.8 instead of 0.3, which costs a tenth
/// more in the solve.
const AMALGAMATION: [(usize, f64); 4] = [(4, 1.0), (16, 0.3), (48, 0.1), (usize::MAX, 0.05)];

/// A factor of a sparse symmetric matrix, which is given by the columns of its upper triangle. The
/// factor consists of supernodes: neighbouring columns with the same rows below them, a dense
/// panel.
pub(crate) struct SparseFactor {
    kind: FactorKind,
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    factored: bool,
    /// One number for each row, for the pivot check of an `L D Lᵀ`; empty for `L Lᵀ`.
    sums: Vec<f64>,
    negative_pivots: usize,
    scratch: MemBuffer,
}

impl SparseFactor {
    /// Analyses a pattern for elimination in the given order. Column `j` of the upper triangle has
    /// the rows `rows[starts[j]..starts[j + 1]]`, increasing; the last one is `j`.
    pub(crate) fn new(
        kind: FactorKind,
        starts: Vec<u32>,
        rows: Vec<u32>,
        order: &[u32],
    ) -> Result<Self, SolverError> {
        let n = starts.len() - 1;
        let mut position = vec![0; n];
        for (k, &i) in order.iter().enumerate() {
            position[i as usize] = k as u32;
        }
        let order = SymmetricOrdering::Custom(PermRef::new_checked(order, &position, n));
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
        let parameters = CholeskySymbolicParams {
            supernodal_params: SymbolicSupernodalParams { relax: Some(&AMALGAMATION) },
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Upper, order, parameters)
            .map_err(|error| SolverError::Factorisation {
                size: n,
                nonzeros: rows.len(),
                reason: match error {
                    FaerError::OutOfMemory => "out of memory",
                    _ => "the factor has more entries than can be indexed",
                },
            })?;
        let (scratch, sums) = match kind {
            FactorKind::Cholesky => (
                symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
                Vec::new(),
            ),
            FactorKind::Ldlt => (
                symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default()),
                vec![0.0; n],
            ),
        };
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
        factor.warm_up()?;
        Ok(factor)
    }

    /// Factors the identity once. The library's dense kernels allocate on their first use in a
    /// thread, and must not do so in the first step.
    fn warm_up(&mut self) -> Result<(), SolverError> {
        for &end in &self.starts[1..] {
            self.values[end as usize - 1] = 1.0;
        }
        self.factorise(|_| {})?;
        self.factored = false;
        Ok(())
    }

    /// Factors the matrix with the values that `fill` writes in the order of the pattern.
    pub(crate) fn factorise(&mut self, fill: impl FnOnce(&mut [f64])) -> Result<(), SolverError> {
        self.factored = false;
        fill(&mut self.values);
        self.check_finite()?;
        self.eliminate().map_err(|permuted| self.bad_pivot(self.original_row(permuted), None))?;
        if self.kind == FactorKind::Ldlt {
            self.negative_pivots = self
                .check_pivots()
                .map_err(|bad| self.bad_pivot(self.original_row(bad.row), Some(bad.pivot)))?;
        }
        self.factored = true;
        Ok(())
    }

    /// Lets the library compute the factor; the error is the permuted row where it stopped.
    fn eliminate(&mut self) -> Result<(), usize> {
        let n = self.starts.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.starts, None, &self.rows);
        let matrix = SparseColMatRef::new(pattern, &self.values);
        let stack = MemStack::new(&mut self.scratch);
        match self.kind {
            FactorKind::Cholesky => self
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
            FactorKind::Ldlt => self
                .symbolic
                .factorize_numeric_ldlt(
                    &mut self.factor,
                    matrix,
                    Side::Upper,
                    // A regularised pivot of zero means no regularisation.
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
        }
    }

    /// Reads an `L D Lᵀ` and returns the number of its negative pivots.
    fn check_pivots(&mut self) -> Result<usize, BadPivot> {
        let largest = self.values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let mut check = PivotCheck::new(&mut self.sums, largest);
        for supernode in supernodes(&self.symbolic) {
            // A dense panel by columns: a square on the diagonal, then the rows below it.
            let Range { start, end } = supernode.columns;
            let panel = &self.factor[supernode.values];
            let columns = panel.chunks_exact(end - start + supernode.below.len());
            for (k, column) in (start..end).zip(columns) {
                let rows = (k + 1..end).chain(supernode.below.iter().map(|&i| i as usize));
                check.column(k, &column[k - start..], rows)?;
            }
        }
        Ok(check.negative())
    }

    /// The kind of factorisation.
    pub(crate) fn kind(&self) -> FactorKind {
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

    /// The values of the factor, valid after a successful factorisation.
    pub(crate) fn factor(&self) -> &[f64] {
        &self.factor
    }

    /// Number of negative pivots of an `L D Lᵀ`, if the last factorisation succeeded.
    pub(crate) fn negative_pivots(&self) -> Option<usize> {
        self.factored.then_some(self.negative_pivots)
    }

    /// The row of the matrix at place `permuted` of the fill-reducing order.
    pub(crate) fn original_row(&self, permuted: usize) -> usize {
        self.symbolic.perm().map_or(permuted, |perm| perm.arrays().0[permuted] as usize)
    }

    /// An error for the first column with an infinite or undefined value, which the library would
    /// carry into the factor.
    fn check_finite(&self) -> Result<(), SolverError> {
        // Without an early exit, so that it costs little.
        if self.values.iter().fold(true, |all, value| all & value.is_finite()) {
            return Ok(());
        }
        let slot = self.values.iter().position(|value| !value.is_finite()).unwrap_or(0);
        let row = self.starts.partition_point(|&start| start as usize <= slot) - 1;
        Err(self.bad_pivot(row, Some(self.values[slot])))
    }

    /// The error of this factorisation for a bad pivot.
    fn bad_pivot(&self, row: usize, pivot: Option<f64>) -> SolverError {
        match self.kind {
            FactorKind::Cholesky => SolverError::NotPositiveDefinite { row, pivot },
            FactorKind::Ldlt => SolverError::Singular { row, pivot },
        }
    }
}

/// A dense panel of the library's factor: the columns `first..end` with the rows below them.
pub(crate) struct Supernode<'a> {
    pub(crate) columns: Range<usize>,
    pub(crate) below: &'a [u32],
    pub(crate) values: Range<usize>,
}

/// The supernodes of a symbolic factorisation; none where it goes column by column, which this
/// crate does not request.
pub(crate) fn supernodes(symbolic: &SymbolicCholesky<u32>) -> impl Iterator<Item = Supernode<'_>> {
    let supernodal = match symbolic.raw() {
        SymbolicCholeskyRaw::Supernodal(l) => Some(l),
        SymbolicCholeskyRaw::Simplicial(_) => None,
    };
    supernodal.into_iter().flat_map(|l| {
        (0..l.n_supernodes()).map(|s| Supernode {
            columns: l.supernode(s).start()..l.supernode_end()[s] as usize,
            below: l.supernode(s).pattern(),
            values: l.col_ptr_for_val()[s] as usize..l.col_ptr_for_val()[s + 1] as usize,
        })
    })
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
