//! Products of blocks along bands with vectors, in single and in double precision.
//!
//! Each of the six numbers of a symmetric block has a plane: one array for a diagonal of the matrix.
//! The loop over the rows of a group is plain Rust, which the caller has compiled for the vector
//! units of the processor. The docs of `bands` have the costs, and what was tried.

use std::ops::{AddAssign, Mul};

/// Rows whose sums stay in the first-level cache; a page of each plane in double precision.
pub(super) const GROUP: usize = 512;
/// Blocks of each row in one pass over a group, during which the sums stay in registers.
const TOGETHER: usize = 4;

/// A number of either precision.
pub(super) trait Number: Copy + Mul<Output = Self> + AddAssign {}

impl Number for f32 {}
impl Number for f64 {}

/// The blocks of one diagonal, left or right of the main one, as factors of rows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Term {
    /// Place of the `xx` of row 0 in the planes.
    block: usize,
    /// Place of the factor of a chunk's first row in a plane of the vector.
    x: usize,
}

/// The blocks of a row in the order of their columns. The planes of the diagonal come first, then
/// those of each band, `stride` numbers each, with `lead` zeros before row 0.
pub(super) fn terms(offsets: &[usize], lead: usize, stride: usize) -> Vec<Term> {
    let band = |b: usize| 6 * (b + 1) * stride + lead;
    let numbered = || offsets.iter().copied().enumerate();
    let left = numbered().rev().map(|(b, o)| Term { block: band(b) - o, x: lead - o });
    let right = numbered().map(|(b, o)| Term { block: band(b), x: lead + o });
    left.chain([Term { block: lead, x: lead }]).chain(right).collect()
}

/// The blocks and factors of a group of rows.
#[derive(Clone, Copy)]
pub(super) struct Place<'a, T> {
    /// Planes of the matrix.
    pub(super) planes: &'a [T],
    pub(super) stride: usize,
    /// First row of the group.
    pub(super) row: usize,
    /// Three planes of the vector.
    pub(super) x: &'a [T],
    pub(super) x_stride: usize,
    /// Place of the first row in a plane of the vector.
    pub(super) x_row: usize,
    /// Rows of the group.
    pub(super) rows: usize,
}

impl<'a, T: Number> Place<'a, T> {
    /// Adds the products with all blocks of each row to the sums of its coordinates.
    #[inline(always)]
    pub(super) fn add_all(&self, terms: &[Term], sums: &mut [[T; GROUP]; 3]) {
        let (terms, rest) = terms.as_chunks::<TOGETHER>();
        for terms in terms {
            self.add(terms, sums);
        }
        for term in rest {
            self.add(&[*term], sums);
        }
    }

    /// Adds the products with some blocks of each row, one after the other.
    #[inline(always)]
    fn add<const N: usize>(&self, terms: &[Term; N], sums: &mut [[T; GROUP]; 3]) {
        let m = self.rows.min(GROUP);
        let blocks: [[&[T]; 6]; N] =
            std::array::from_fn(|k| std::array::from_fn(|c| self.block(terms[k], c, m)));
        let x: [[&[T]; 3]; N] =
            std::array::from_fn(|k| std::array::from_fn(|c| self.factor(terms[k], c, m)));
        let [sx, sy, sz] = sums;
        for t in 0..m {
            let (mut s0, mut s1, mut s2) = (sx[t], sy[t], sz[t]);
            for k in 0..N {
                let (b, x) = (&blocks[k], &x[k]);
                s0 += b[0][t] * x[0][t];
                s1 += b[1][t] * x[0][t];
                s2 += b[2][t] * x[0][t];
                s0 += b[1][t] * x[1][t];
                s1 += b[3][t] * x[1][t];
                s2 += b[4][t] * x[1][t];
                s0 += b[2][t] * x[2][t];
                s1 += b[4][t] * x[2][t];
                s2 += b[5][t] * x[2][t];
            }
            (sx[t], sy[t], sz[t]) = (s0, s1, s2);
        }
    }

    #[inline(always)]
    fn block(&self, term: Term, c: usize, m: usize) -> &'a [T] {
        &self.planes[term.block + c * self.stride + self.row..][..m]
    }

    #[inline(always)]
    fn factor(&self, term: Term, axis: usize, m: usize) -> &'a [T] {
        &self.x[term.x + axis * self.x_stride + self.x_row..][..m]
    }
}
