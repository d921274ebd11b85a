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

/// The block `a I + κ w wᵀ` of a spring: `wx, wy, wz, a`. All springs of a matrix share the unit
/// `κ`.
pub type SpringBlock = [f64; 4];

/// `xx, xy, xz, yy, yz, zz` of a [`SpringBlock`] with this unit.
#[inline(always)]
pub fn six([wx, wy, wz, a]: SpringBlock, unit: f64) -> [f64; 6] {
    let [x, y, z] = [unit * wx, unit * wy, unit * wz];
    [x * wx + a, x * wy, x * wz, y * wy + a, y * wz, z * wz + a]
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

/// A symmetric matrix of springs in any order: a block `B` of the spring from `i` to `j` adds `B` at
/// `(i, i)` and `(j, j)`, and `−B` at `(i, j)` and `(j, i)`.
#[derive(Debug)]
pub struct SpringBlocks<'a> {
    /// The multiple of the identity that each row has beside its springs: its mass.
    pub own: &'a mut [f64],
    /// Diagonal blocks beside `own` and the springs, one a row: `xx, xy, xz, yy, yz, zz`. A sweep
    /// that overwrites the matrix clears them.
    pub general: &'a mut Vec<[f64; 6]>,
    /// One block for each spring.
    pub springs: &'a mut [SpringBlock],
    /// `κ` of the blocks: with it `w` has no unit. A matrix scaled by a power of two then keeps
    /// every digit. Square roots of the stiffness itself would change for odd powers.
    pub unit: &'a mut f64,
    /// Rows of each spring, the lower first.
    pub ends: &'a [[u32; 2]],
    /// Index into `springs` of each edge that the matrix was made with, in their order; no two are
    /// the same. The entry has no meaning for an edge from a row to itself.
    pub slots: &'a [u32],
}

/// The layouts that one sweep over springs fills.
#[derive(Debug)]
pub enum BlockLayout<'a> {
    /// Along bands: regular grids.
    Bands(BandPlanes<'a>),
    /// One block a spring: springs in any order.
    Pairs(SpringBlocks<'a>),
}

/// Which layout suits the blocks of a set of effects.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Coupling {
    /// Along bands with these offsets, in increasing order.
    Bands(Vec<usize>),
    /// One block `a I + κ w wᵀ` a spring.
    Pairs,
    /// Compressed rows, if neither of the others suits.
    Rows,
}
