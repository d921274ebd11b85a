//! Vectors as structures of arrays, in blocks and in whole.

use crate::vector::{BLOCK, SLOTS, combine};

/// Rows are rounded up to a multiple of this many.
pub(super) const ROWS: usize = 16;

/// Numbers that fill a cache line.
const LINE: usize = 8;

/// The three coordinates of up to [`BLOCK`] particles. A cache line of zeros after each keeps the coordinates
/// of a particle from the same place of different pages, where a load seems to depend on a store.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Block(pub(super) [[f64; BLOCK + LINE]; 3]);

impl Block {
    pub(super) const ZERO: Self = Self([[0.0; BLOCK + LINE]; 3]);

    /// `C` particles from `first` on.
    #[inline(always)]
    pub(super) fn piece<const C: usize>(&mut self, first: usize) -> [&mut [f64; C]; 3] {
        self.0.each_mut().map(|x| {
            let (piece, _) = x[first..].as_chunks_mut::<C>();
            &mut piece[0]
        })
    }

    /// The first `len` particles.
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

/// One number a row, with zeros before the first and after the last; row 0 begins a cache line.
#[derive(Debug)]
pub(super) struct Padded {
    numbers: Vec<f64>,
    /// Place of row 0.
    origin: usize,
}

impl Padded {
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
pub(super) struct Coordinates(pub(super) [Padded; 3]);

impl Coordinates {
    pub(super) fn zeros(n: usize, reach: usize) -> Self {
        Self(std::array::from_fn(|_| Padded::zeros(n, reach)))
    }

    /// The `len` rows from `first` on.
    #[inline(always)]
    pub(super) fn rows_mut(&mut self, first: usize, len: usize) -> [&mut [f64]; 3] {
        let [x, y, z] = &mut self.0;
        [x, y, z].map(|x| &mut x.rows_mut()[first..first + len])
    }
}

/// What the slots of the three coordinates of a block add up to.
#[inline(always)]
pub(super) fn total(sums: &[[f64; SLOTS]; 3]) -> f64 {
    combine(&std::array::from_fn(|s| [sums[0][s], sums[1][s], sums[2][s]]))
}
