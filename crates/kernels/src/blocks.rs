//! Memory layouts of the symmetric 3×3 blocks of a matrix.
//!
//! One crate computes blocks and writes them in these layouts. Another crate reads them and
//! multiplies with them. Neither depends on the other.

use crate::Mat3;

/// Receives 3×3 blocks of symmetric matrices, and the pairs that they couple.
pub trait BlockSink {
    /// Adds `block` at `(i, i)` and `(j, j)` and subtracts it at `(i, j)` and `(j, i)`. The block
    /// must be symmetric.
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3);

    /// As [`add_pair`](Self::add_pair), for any block `B`: adds `B` at `(i, i)` and `Bᵀ` at
    /// `(j, j)`, and subtracts `B` at `(i, j)` and `Bᵀ` at `(j, i)`. Every symmetric matrix `H`
    /// whose rows of blocks sum to 0 is a sum of such pairs with `B = −H_ij`.
    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3);

    /// Adds the symmetric `block` at `(i, i)`, for a force on one particle alone.
    fn add_diagonal(&mut self, i: usize, block: &Mat3);
}

/// Rows and columns of the six numbers of a symmetric block: `xx, xy, xz, yy, yz, zz`.
pub const SIX: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// Number of numbers in a [`Line`].
pub const LINE: usize = 8;

/// A symmetric block in a line of the cache: `xx, xy, xz, yz, zz, xy, yy, yz`. Its columns overlap,
/// so that each of them is one register.
pub type Line = [f64; LINE];

/// Where each column of a block begins in its [`Line`].
pub const COLUMNS: [usize; 3] = [0, 5, 2];

/// Rows and columns of the numbers of a [`Line`].
pub const PLACES: [(usize, usize); LINE] =
    [(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (0, 1), (1, 1), (1, 2)];

/// The [`Line`] of `xx, xy, xz, yy, yz, zz`.
#[inline(always)]
pub fn line([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Line {
    [xx, xy, xz, yz, zz, xy, yy, yz]
}

/// The inverse of [`line()`].
#[inline(always)]
pub fn six([xx, xy, xz, yz, zz, _, yy, _]: Line) -> [f64; 6] {
    [xx, xy, xz, yy, yz, zz]
}

/// A symmetric matrix of symmetric 3×3 blocks along bands beside the diagonal.
#[derive(Debug)]
pub struct BandPlanes<'a> {
    /// Six planes for the diagonal, then six for each band: [`SIX`].
    pub planes: &'a mut [f64],
    /// Distance of two planes.
    pub stride: usize,
    /// Place of row 0 in a plane, at least the largest offset. The zeros before row 0 and behind
    /// the last row must stay zero. At least eight of them are behind the last row.
    pub lead: usize,
    /// The offsets of the bands, in increasing order: block (i, i + o) is stored at row i.
    pub offsets: &'a [usize],
}

/// A symmetric matrix of symmetric 3×3 blocks, one [`Line`] for each row and for each coupled pair.
#[derive(Debug)]
pub struct PairLines<'a> {
    /// Diagonal blocks, one per row.
    pub diagonal: &'a mut [Line],
    /// Blocks (i, j) of the coupled pairs.
    pub pairs: &'a mut [Line],
    /// Rows of each pair, the lower first.
    pub ends: &'a [[u32; 2]],
    /// Index into `pairs` of each edge that the matrix was made with, in their order. The entry has
    /// no meaning for an edge from a row to itself.
    pub slots: &'a [u32],
}

/// The layouts that one sweep over springs fills.
#[derive(Debug)]
pub enum BlockLayout<'a> {
    /// Along bands: regular grids.
    Bands(BandPlanes<'a>),
    /// One line a pair: springs in any order.
    Pairs(PairLines<'a>),
}

/// Which layout suits the blocks of a set of effects.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Coupling {
    /// Along bands with these offsets, in increasing order.
    Bands(Vec<usize>),
    /// One symmetric block a pair.
    Pairs,
    /// Compressed rows, if neither of the others suits.
    Rows,
}
