//! The complete factor of a scalar matrix, which solves for three right-hand sides at a time.

use std::cell::RefCell;

use crate::free::FreeRows;
use crate::ordering;
use crate::pattern::Pattern;
use crate::sparse_factor::{FactorKind, SparseFactor};
use crate::tiles::Tiles;
use crate::{ScalarMatrix, SolverError, Vec3};
use drape_kernels::lanes::Lanes;

/// `A = L Lᵀ` or `A = L D Lᵀ`, in a fill-reducing order of the rows.
#[derive(Debug)]
pub(crate) struct ScalarFactor {
    /// The pattern that the factor was made for.
    pattern: Pattern,
    factor: SparseFactor,
    tiles: Tiles<1>,
    /// The row of `A` at each place of the order.
    order: Vec<u32>,
    /// Number of entries in each column of `L`, in that order; the tiles store a few more zeros.
    column_counts: Vec<u32>,
    /// The vector of a solve in that order, with the idle entry of the tiles.
    work: RefCell<Vec<Lanes>>,
}

impl ScalarFactor {
    /// Analyses the pattern of `a`; its values do not matter.
    pub(crate) fn new(a: &ScalarMatrix, kind: FactorKind) -> Result<Self, SolverError> {
        let pattern = a.pattern().clone();
        let mut starts = vec![0];
        let mut columns = Vec::new();
        for j in 0..a.n() {
            columns.extend_from_slice(&pattern.columns()[pattern.lower(j)]);
            columns.push(j as u32);
            starts.push(columns.len() as u32);
        }
        let order = ordering::fill_reducing(&pattern)?;
        let factor = SparseFactor::new(kind, starts, columns, &order)?;
        let tiles = Tiles::new(factor.symbolic());
        let work = RefCell::new(vec![[0.0; 4]; a.n() + 1]);
        let column_counts = ordering::column_counts(&pattern, &order);
        Ok(Self { pattern, factor, tiles, order, column_counts, work })
    }

    /// Number of rows.
    pub(crate) fn n(&self) -> usize {
        self.pattern.n()
    }

    /// Factors `a`. Rows that are not free keep their diagonal entry alone.
    pub(crate) fn update(
        &mut self,
        a: &ScalarMatrix,
        rows: FreeRows<'_>,
    ) -> Result<(), SolverError> {
        self.pattern.check(a.pattern())?;
        let upper = (0..a.n()).flat_map(|j| {
            let (columns, values) = a.row(j);
            columns
                .iter()
                .zip(values)
                .take_while(move |&(&i, _)| i as usize <= j)
                .map(move |(&i, &value)| if rows.kept(i as usize, j) { value } else { 0.0 })
        });
        self.factor.factorise(|values| {
            let mut slots = values.iter_mut();
            slots.by_ref().zip(upper).for_each(|(slot, value)| *slot = value);
            debug_assert!(slots.next().is_none(), "fewer values than the pattern has");
        })?;
        self.tiles.fill(self.factor.symbolic(), self.factor.kind(), self.factor.factor());
        Ok(())
    }

    /// Whether the last update succeeded.
    pub(crate) fn factored(&self) -> bool {
        self.factor.factored()
    }

    /// Number of entries in each column of the factor, with the diagonal.
    pub(crate) fn column_counts(&self) -> impl Iterator<Item = usize> {
        self.column_counts.iter().map(|&count| count as usize)
    }

    /// Number of negative pivots of an `L D Lᵀ`, if the last update succeeded.
    pub(crate) fn negative_pivots(&self) -> Option<usize> {
        self.factor.negative_pivots()
    }

    /// `x ← A⁻¹ b`.
    ///
    /// # Panics
    /// Without a factor.
    pub(crate) fn solve(&self, b: &[Vec3], x: &mut [Vec3]) {
        assert!(self.factored(), "solve needs a factorisation that succeeded");
        let mut work = self.work.borrow_mut();
        for (z, &row) in work.iter_mut().zip(&self.order) {
            let b = &b[row as usize];
            *z = [b.x, b.y, b.z, 0.0];
        }
        self.tiles.solve(&mut work[..]);
        for (z, &row) in work.iter().zip(&self.order) {
            x[row as usize] = Vec3::new(z[0], z[1], z[2]);
        }
    }
}
