//! The pattern of a symmetric sparse matrix: compressed rows, shared by the scalar and the block
//! matrix.

use std::ops::Range;

use crate::SolverError;

/// Compressed rows of a symmetric pattern with a full diagonal. Row `i` owns the slots
/// `starts[i]..starts[i + 1]`, whose columns increase.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pattern {
    starts: Vec<usize>,
    columns: Vec<u32>,
    diagonal: Vec<usize>,
}

impl Pattern {
    /// The diagonal of `n` rows, and (i, j) and (j, i) of every edge. Repeated edges count once.
    pub(crate) fn new(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
        assert!(n <= u32::MAX as usize, "more rows than a u32 can number");
        let mut entries: Vec<(usize, usize)> = (0..n).map(|i| (i, i)).collect();
        for (i, j) in edges {
            assert!(i < n && j < n, "edge ({i}, {j}) leaves the {n} rows");
            entries.push((i, j));
            entries.push((j, i));
        }
        entries.sort_unstable();
        entries.dedup();

        let mut starts = vec![0; n + 1];
        for &(i, _) in &entries {
            starts[i + 1] += 1;
        }
        for i in 0..n {
            starts[i + 1] += starts[i];
        }
        let diagonal =
            (0..entries.len()).filter(|&slot| entries[slot].0 == entries[slot].1).collect();
        let columns = entries.iter().map(|&(_, j)| j as u32).collect();
        Self { starts, columns, diagonal }
    }

    /// Number of rows.
    pub(crate) fn n(&self) -> usize {
        self.diagonal.len()
    }

    /// Number of slots, both triangles and the diagonal.
    pub(crate) fn nonzeros(&self) -> usize {
        self.columns.len()
    }

    /// Slots of row `i`.
    #[inline(always)]
    pub(crate) fn row(&self, i: usize) -> Range<usize> {
        self.starts[i]..self.starts[i + 1]
    }

    /// Slots of row `i` left of the diagonal.
    #[inline(always)]
    pub(crate) fn lower(&self, i: usize) -> Range<usize> {
        self.starts[i]..self.diagonal[i]
    }

    /// Slot of the diagonal entry of row `i`.
    #[inline(always)]
    pub(crate) fn diagonal(&self, i: usize) -> usize {
        self.diagonal[i]
    }

    /// Column of a slot.
    #[inline(always)]
    pub(crate) fn column(&self, slot: usize) -> usize {
        self.columns[slot] as usize
    }

    /// Columns of all slots.
    #[inline(always)]
    pub(crate) fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// Slot of (i, j), if the pattern has it. A binary search: rows are short.
    pub(crate) fn slot(&self, i: usize, j: usize) -> Option<usize> {
        let row = self.row(i);
        let start = row.start;
        let found = self.columns[row].binary_search(&(j as u32)).ok()?;
        Some(start + found)
    }

    /// The triangle left of the diagonal in compressed rows: where each row starts, and the columns.
    pub(crate) fn lower_triangle(&self) -> (Vec<usize>, Vec<u32>) {
        let (mut starts, mut columns) = (vec![0], Vec::new());
        for i in 0..self.n() {
            columns.extend_from_slice(&self.columns[self.lower(i)]);
            starts.push(columns.len());
        }
        (starts, columns)
    }

    /// The slot (j, i) of each slot (i, j) left of the diagonal, row by row.
    pub(crate) fn mirrors(&self) -> Vec<u32> {
        // Row j meets its columns beyond the diagonal in their order.
        let mut next: Vec<usize> = self.diagonal.iter().map(|slot| slot + 1).collect();
        let lower = (0..self.n()).flat_map(|i| self.lower(i));
        lower
            .map(|slot| {
                let next = &mut next[self.column(slot)];
                *next += 1;
                (*next - 1) as u32
            })
            .collect()
    }

    /// An error unless `other` is this pattern.
    pub(crate) fn check(&self, other: &Pattern) -> Result<(), SolverError> {
        if self == other { Ok(()) } else { Err(self.changed(other.n(), other.nonzeros())) }
    }

    /// The error for another matrix, with its numbers of rows and of slots.
    pub(crate) fn changed(&self, size: usize, nonzeros: usize) -> SolverError {
        let (expected_size, expected_nonzeros) = (self.n(), self.nonzeros());
        SolverError::PatternChanged { expected_size, expected_nonzeros, size, nonzeros }
    }
}
