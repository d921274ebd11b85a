//! Vectors as structures of arrays, in blocks and in whole.

use crate::bands::Divisible;
use crate::vector::{BLOCK, SLOTS, combine};
use std::array::from_fn;

/// Rows are rounded up to a multiple of this many.
pub(super) const ROWS: usize = 16;

/// Groups of a block.
const GROUPS: usize = BLOCK / SLOTS;

/// Numbers that fill a cache line.
const LINE: usize = 8;

/// The three coordinates of up to [`BLOCK`] particles. A cache line of zeros after each keeps the
/// coordinates of a particle at different places of their pages; at the same place a load would
/// seem to depend on a store.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Block(pub(super) [[f64; BLOCK + LINE]; 3]);

impl Block {
    pub(super) const ZERO: Self = Self([[0.0; BLOCK + LINE]; 3]);

    /// Coordinate `k` of group `g`, modulo the block, so that the compiler needs no check.
    #[inline(always)]
    pub(super) fn group(&self, k: usize, g: usize) -> &[f64; SLOTS] {
        &self.0[k].as_chunks().0[g % GROUPS]
    }

    /// As [`group`](Self::group), for writing.
    #[inline(always)]
    pub(super) fn group_mut(&mut self, k: usize, g: usize) -> &mut [f64; SLOTS] {
        &mut self.0[k].as_chunks_mut().0[g % GROUPS]
    }

    /// The first `len` particles.
    #[inline(always)]
    pub(super) fn rows(&self, len: usize) -> [&[f64]; 3] {
        self.0.each_ref().map(|x| &x[..len])
    }

    /// The first `len` particles, for writing.
    #[inline(always)]
    pub(super) fn rows_mut(&mut self, len: usize) -> [&mut [f64]; 3] {
        self.0.each_mut().map(|x| &mut x[..len])
    }
}

/// `n` rounded up to whole groups.
pub(super) fn padded_rows(n: usize) -> usize {
    n.next_multiple_of(ROWS)
}

/// First row and number of rows of block `k` of `rows`.
#[inline(always)]
pub(super) fn block_rows(k: usize, rows: usize) -> (usize, usize) {
    let first = k * BLOCK;
    (first, BLOCK.min(rows - first))
}

/// One number per row, with zeros before the first and after the last; row 0 begins a cache line.
#[derive(Debug)]
pub(super) struct PaddedRow {
    numbers: Vec<f64>,
    /// Place of row 0.
    origin: usize,
}

impl PaddedRow {
    /// Zeros for `n` rows, with `reach` more on either side.
    pub(super) fn zeros(n: usize, reach: usize) -> Self {
        let numbers = vec![0.0; padded_rows(n) + 2 * reach + LINE];
        let aligned = numbers[reach..].as_ptr().align_offset(LINE * size_of::<f64>());
        Self { numbers, origin: reach + aligned.min(LINE) }
    }

    /// `len` numbers from row `first` on, which may be before row 0.
    #[inline(always)]
    pub(super) fn window(&self, first: isize, len: usize) -> &[f64] {
        let first = (self.origin as isize + first) as usize;
        &self.numbers[first..first + len]
    }

    /// `C` numbers from row `first` on, which may be before row 0.
    #[inline(always)]
    pub(super) fn piece<const C: usize>(&self, first: isize) -> &[f64; C] {
        let first = (self.origin as isize + first) as usize;
        &self.numbers[first..].as_chunks::<C>().0[0]
    }

    /// The rows.
    #[inline(always)]
    pub(super) fn rows_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[self.origin..]
    }
}

/// The three coordinates of a vector.
#[derive(Debug)]
pub(super) struct Coordinates([PaddedRow; 3]);

impl Coordinates {
    pub(super) fn zeros(n: usize, reach: usize) -> Self {
        Self(from_fn(|_| PaddedRow::zeros(n, reach)))
    }

    /// All rows, and the zeros around them.
    #[inline(always)]
    pub(super) fn rows(&self) -> Rows<'_> {
        Rows {
            numbers: self.0.each_ref().map(|x| &x.numbers[..]),
            origin: self.0.each_ref().map(|x| x.origin as isize),
        }
    }

    /// All rows, for writing.
    pub(super) fn rows_mut(&mut self) -> RowsMut<'_> {
        let origin = self.0.each_ref().map(|x| x.origin as isize);
        RowsMut { numbers: self.0.each_mut().map(|x| &mut x.numbers[..]), origin, first: 0 }
    }
}

/// Rows of the three coordinates of a vector.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    numbers: [&'a [f64]; 3],
    /// Where row 0 is, or would be.
    origin: [isize; 3],
}

impl<'a> Rows<'a> {
    /// The `len` rows from `first` on.
    #[inline(always)]
    pub(super) fn window(&self, first: usize, len: usize) -> [&'a [f64]; 3] {
        from_fn(|k| {
            let at = (self.origin[k] + first as isize) as usize;
            &self.numbers[k][at..at + len]
        })
    }

    /// `C` numbers of coordinate `k` from row `first` on, which may be before row 0.
    #[inline(always)]
    pub(super) fn piece<const C: usize>(&self, k: usize, first: isize) -> &'a [f64; C] {
        let at = (self.origin[k] + first) as usize;
        &self.numbers[k][at..].as_chunks::<C>().0[0]
    }
}

/// Rows of the three coordinates of a vector, for writing.
pub(super) struct RowsMut<'a> {
    numbers: [&'a mut [f64]; 3],
    /// Where row 0 is, or would be.
    origin: [isize; 3],
    /// The first row.
    first: usize,
}

impl RowsMut<'_> {
    /// The rows, for reading.
    #[inline(always)]
    pub(super) fn read(&self) -> Rows<'_> {
        Rows { numbers: self.numbers.each_ref().map(|x| &**x), origin: self.origin }
    }

    /// The `len` rows from `first` on.
    #[inline(always)]
    pub(super) fn window(&mut self, first: usize, len: usize) -> [&mut [f64]; 3] {
        let at = self.origin.map(|origin| (origin + first as isize) as usize);
        let [x, y, z] = &mut self.numbers;
        [&mut x[at[0]..][..len], &mut y[at[1]..][..len], &mut z[at[2]..][..len]]
    }
}

impl Divisible for RowsMut<'_> {
    fn split(self, blocks: usize) -> (Self, Self) {
        let Self { numbers: [x, y, z], origin, first } = self;
        let middle = first + blocks * BLOCK;
        let at = origin.map(|origin| origin + middle as isize);
        let (x, y, z) = (
            x.split_at_mut(at[0] as usize),
            y.split_at_mut(at[1] as usize),
            z.split_at_mut(at[2] as usize),
        );
        let left = Self { numbers: [x.0, y.0, z.0], origin, first };
        let origin = from_fn(|k| origin[k] - at[k]);
        (left, Self { numbers: [x.1, y.1, z.1], origin, first: middle })
    }
}

/// The sum over the slots of the three coordinates of a block.
#[inline(always)]
pub(super) fn total(sums: &[[f64; SLOTS]; 3]) -> f64 {
    combine(&from_fn(|s| [sums[0][s], sums[1][s], sums[2][s]]))
}
