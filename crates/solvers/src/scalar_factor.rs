//! The complete factor of a scalar matrix, swept with three right-hand sides at a time.

use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::SymbolicCholeskyRaw;

use crate::pattern::Pattern;
use crate::rows::Rows;
use crate::sparse_factor::{Kind, SparseFactor};
use crate::{ScalarMatrix, SolverError, Vec3};

/// `A = L Lᵀ` or `A = L D Lᵀ`, in a fill-reducing order of the rows (AMD).
#[derive(Debug)]
pub(crate) struct ScalarFactor {
    /// The pattern that the factor was made for.
    pattern: Pattern,
    factor: SparseFactor,
    /// The factor by columns; the first entry of a column is `Lⱼⱼ`, or `Dⱼ`.
    starts: Vec<u32>,
    /// The row of `A` that each entry of the factor belongs to, so that vectors need no permutation.
    rows: Vec<u32>,
}

impl ScalarFactor {
    /// Analyses the pattern of `a`; its values do not matter.
    pub(crate) fn new(a: &ScalarMatrix, kind: Kind) -> Result<Self, SolverError> {
        let pattern = a.pattern().clone();
        let mut starts = vec![0];
        let mut columns = Vec::new();
        for j in 0..a.n() {
            columns.extend_from_slice(&pattern.columns()[pattern.lower(j)]);
            columns.push(j as u32);
            starts.push(columns.len() as u32);
        }
        // The simplicial factor is plain columns, which can be swept here.
        let threshold = SupernodalThreshold::FORCE_SIMPLICIAL;
        let factor = SparseFactor::new(kind, starts, columns, threshold)?;
        let SymbolicCholeskyRaw::Simplicial(symbolic) = factor.symbolic().raw() else {
            unreachable!("a simplicial factorisation was asked for");
        };
        Ok(Self {
            starts: symbolic.col_ptr().to_vec(),
            rows: symbolic
                .row_idx()
                .iter()
                .map(|&row| factor.original_row(row as usize) as u32)
                .collect(),
            pattern,
            factor,
        })
    }

    /// Number of rows.
    pub(crate) fn n(&self) -> usize {
        self.pattern.n()
    }

    /// Factors `a`. Rows that are not free keep their diagonal entry alone.
    pub(crate) fn update(&mut self, a: &ScalarMatrix, rows: Rows<'_>) -> Result<(), SolverError> {
        self.pattern.check(a.pattern())?;
        let upper = (0..a.n()).flat_map(|j| {
            let (columns, values) = a.row(j);
            columns
                .iter()
                .zip(values)
                .take_while(move |&(&i, _)| i as usize <= j)
                .map(move |(&i, &value)| if rows.kept(i as usize, j) { value } else { 0.0 })
        });
        self.factor.factorise(upper)
    }

    /// Whether the last update succeeded.
    pub(crate) fn factored(&self) -> bool {
        self.factor.factored()
    }

    /// Entries of each column of the factor, the diagonal one among them.
    pub(crate) fn column_counts(&self) -> impl Iterator<Item = usize> {
        self.starts.windows(2).map(|pair| (pair[1] - pair[0]) as usize)
    }

    /// How many pivots of an `L D Lᵀ` are negative, if the last update succeeded.
    pub(crate) fn negative_pivots(&self) -> Option<usize> {
        self.factor.negative_pivots()
    }

    /// `z ← A⁻¹ z`: solves `L y = z` column by column, then `Lᵀ z = y` (or `D⁻¹ y`) row by row.
    ///
    /// # Panics
    /// Without a factor.
    pub(crate) fn solve_in_place(&self, z: &mut [Vec3]) {
        assert!(self.factored(), "solve needs a factorisation that succeeded");
        let (kind, factor) = (self.factor.kind(), self.factor.factor());
        let column = |j: usize| self.starts[j] as usize..self.starts[j + 1] as usize;
        for j in 0..self.n() {
            let (rows, values) = (&self.rows[column(j)], &factor[column(j)]);
            let y = match kind {
                Kind::Llt => z[rows[0] as usize] / values[0],
                Kind::Ldlt => z[rows[0] as usize],
            };
            z[rows[0] as usize] = y;
            for (&i, &value) in rows[1..].iter().zip(&values[1..]) {
                z[i as usize] -= y * value;
            }
        }
        for j in (0..self.n()).rev() {
            let (rows, values) = (&self.rows[column(j)], &factor[column(j)]);
            let mut sum = match kind {
                Kind::Llt => z[rows[0] as usize],
                Kind::Ldlt => z[rows[0] as usize] / values[0],
            };
            for (&i, &value) in rows[1..].iter().zip(&values[1..]) {
                sum -= z[i as usize] * value;
            }
            z[rows[0] as usize] = match kind {
                Kind::Llt => sum / values[0],
                Kind::Ldlt => sum,
            };
        }
    }
}
