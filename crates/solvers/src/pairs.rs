//! Symmetric 3×3 blocks, one for each coupled pair of rows: the matrix of a general mesh of springs.
//!
//! # One result
//!
//! A row is summed as [`BlockMatrix`](crate::BlockMatrix) sums it, from its first scalar column to its last, so both give
//! the same bits. A block left of the diagonal is the one of the other row: it is read from there.
//!
//! # What it costs
//!
//! With `p` pairs a row a product takes `18 (2p + 1)` flops a row and moves `64 (p + 1)` bytes of blocks, `8 (2p + 1)` of places and
//! 48 of vectors: on a sheet with tension, shear and bending springs (`p` = 6) 234 flops and 600 bytes, against 1036 bytes in
//! [`BlockMatrix`](crate::BlockMatrix). The blocks left of the diagonal are those of earlier rows, which the cache still has where
//! rows that are coupled have numbers close together.
//!
//! Tried with steps of Baraff and Witkin's method on 2704 rows in disorder, one core of a busy Zen 4, least time of many steps:
//!
//! | tried | expected | a step |
//! |---|---|---|
//! | compressed rows, a search for each block | | 2.0 ms |
//! | one line a pair, its place known; columns overlap, so that each is one register | half the memory, a fourth of the instructions | 0.99 ms |
//! | **four rows side by side**: a sum of 39 terms waits for each of them | products cost half as much | 0.94 ms |

use crate::{LinearOperator, Mat3, Vec3};

/// Numbers of a line.
const LINE: usize = 8;
/// Rows that are summed side by side: each waits for its own sums only.
const TOGETHER: usize = 4;
/// Where the columns of a block begin in its line.
const COLUMNS: [usize; 3] = [0, 5, 2];
/// Rows and columns of the numbers of a line.
const PLACES: [(usize, usize); LINE] =
    [(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (0, 1), (1, 1), (1, 2)];

/// A symmetric matrix of symmetric 3×3 blocks. Each coupled pair has one block, in a line of the cache: `xx, xy, xz, yz, zz, xy,
/// yy, yz`, in which the columns overlap.
///
/// ```
/// use drape_solvers::{LinearOperator, Mat3, PairMatrix, Vec3};
/// let mut a = PairMatrix::new(3, [(2, 1)]);
/// (0..3).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
/// a.add_pair(1, 2, &(10.0 * Vec3::x() * Vec3::x().transpose()));
/// let mut y = [Vec3::zeros(); 3];
/// a.multiply(&[Vec3::zeros(), Vec3::new(1.0, 1.0, 0.0), Vec3::zeros()], &mut y);
/// assert_eq!(y, [Vec3::zeros(), Vec3::new(11.0, 1.0, 0.0), Vec3::new(-10.0, 0.0, 0.0)]);
/// ```
#[derive(Debug)]
pub struct PairMatrix {
    n: usize,
    /// The lines of the diagonal, then of the pairs, and as much again as the last column reaches beyond the last line.
    numbers: Vec<f64>,
    /// Where the first line begins: at the beginning of a line of the cache.
    lead: usize,
    /// Rows of each pair, the lower first; rising.
    ends: Vec<[u32; 2]>,
    /// The pair of each edge that the matrix was made with.
    slots: Vec<u32>,
    /// The blocks of row `i` are `entries[starts[i]..starts[i + 1]]`: line and column of each, by rising column.
    entries: Vec<[u32; 2]>,
    starts: Vec<usize>,
}

/// The lines of a [`PairMatrix`], for those who add many blocks at a time.
#[derive(Debug)]
pub struct PairLines<'a> {
    /// Diagonal blocks, one a row.
    pub diagonal: &'a mut [[f64; 8]],
    /// Blocks (i, j) of the pairs.
    pub pairs: &'a mut [[f64; 8]],
    /// Rows of each pair, the lower first.
    pub ends: &'a [[u32; 2]],
    /// The pair of each edge that the matrix was made with, in their order; of no meaning for an edge of a row to itself.
    pub slots: &'a [u32],
}

impl PairMatrix {
    /// The zero matrix with room for `n` diagonal blocks and for each edge. Edges may be repeated, and tie a row to itself.
    ///
    /// # Panics
    /// When an edge names a row that is not below `n`, or a `u32` cannot number rows and edges.
    pub fn new(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
        assert!(n < u32::MAX as usize, "more rows than a u32 can number");
        let list: Vec<[u32; 2]> = edges
            .into_iter()
            .inspect(|&(i, j)| assert!(i < n && j < n, "edge ({i}, {j}) leaves the {n} rows"))
            .map(|(i, j)| [i.min(j) as u32, i.max(j) as u32])
            .collect();
        let mut ends: Vec<_> = list.iter().copied().filter(|[i, j]| i != j).collect();
        ends.sort_unstable();
        ends.dedup();
        assert!(n + ends.len() < u32::MAX as usize, "more blocks than a u32 can number");
        let place = |pair| ends.binary_search(pair).map_or(u32::MAX, |slot| slot as u32);
        let slots = list.iter().map(place).collect();
        let (entries, starts) = rows(n, &ends);
        let numbers = vec![0.0; LINE * (n + ends.len() + 2)];
        let lead = numbers.as_ptr().align_offset(8 * LINE).min(LINE - 1);
        Self { n, numbers, lead, ends, slots, entries, starts }
    }

    /// Number of block rows.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Number of blocks that are not zero, in both triangles and on the diagonal.
    pub fn nonzeros(&self) -> usize {
        self.n + 2 * self.ends.len()
    }

    /// Sets all blocks to zero.
    pub fn clear(&mut self) {
        self.numbers.fill(0.0);
    }

    /// Adds the symmetric `block` to diagonal block `i`.
    pub fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        assert!(i < self.n, "row {i} of {}", self.n);
        self.add_at(i, block, 1.0);
    }

    /// Adds the symmetric `block` at (i, i) and (j, j), and its negative at (i, j) and (j, i). A pair that the matrix has no
    /// room for is a mistake of the caller: it stops a debug build, and a release build leaves the pair out.
    pub fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if i == j {
            return;
        }
        let slot = self.slot(i, j);
        debug_assert!(slot.is_some(), "the pattern has no pair ({i}, {j})");
        let Some(slot) = slot else { return };
        self.add_at(self.n + slot, block, -1.0);
        self.add_diagonal(i, block);
        self.add_diagonal(j, block);
    }

    /// Block (i, j); zero outside the pattern.
    pub fn get(&self, i: usize, j: usize) -> Mat3 {
        let line = if i == j { Some(i) } else { self.slot(i, j).map(|slot| self.n + slot) };
        line.map_or_else(Mat3::zeros, |line| {
            let line = &self.numbers[self.lead + LINE * line..];
            Mat3::from_fn(|row, column| line[COLUMNS[column] + row])
        })
    }

    /// All lines, for those who add many blocks at a time.
    pub fn lines_mut(&mut self) -> PairLines<'_> {
        let Self { n, numbers, lead, ends, slots, .. } = self;
        let (lines, _) = numbers[*lead..].as_chunks_mut::<LINE>();
        let (diagonal, pairs) = lines.split_at_mut(*n);
        PairLines { diagonal, pairs: &mut pairs[..ends.len()], ends, slots }
    }

    /// `xx, xy, xz, yy, yz, zz` of diagonal block `i`.
    #[inline(always)]
    pub(crate) fn diagonal(&self, i: usize) -> [f64; 6] {
        let line = &self.numbers[self.lead + LINE * i..][..LINE];
        [line[0], line[1], line[2], line[6], line[3], line[4]]
    }

    /// Which pair (i, j) is.
    fn slot(&self, i: usize, j: usize) -> Option<usize> {
        self.ends.binary_search(&[i.min(j) as u32, i.max(j) as u32]).ok()
    }

    fn add_at(&mut self, line: usize, block: &Mat3, sign: f64) {
        let line = &mut self.numbers[self.lead + LINE * line..][..LINE];
        for (number, place) in line.iter_mut().zip(PLACES) {
            *number += sign * block[place];
        }
    }
}

/// Lines and columns of the blocks of `n` rows, and where those of each row begin.
fn rows(n: usize, ends: &[[u32; 2]]) -> (Vec<[u32; 2]>, Vec<usize>) {
    let mut starts = vec![0; n + 1];
    for i in 0..n {
        starts[i + 1] = 1;
    }
    ends.iter().flatten().for_each(|i| starts[*i as usize + 1] += 1);
    for i in 0..n {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut entries = vec![[0; 2]; n + 2 * ends.len()];
    let mut push = |row: u32, line: u32, column: u32| {
        let next = &mut next[row as usize];
        entries[*next] = [line, column];
        *next += 1;
    };
    // Pairs rise by their lower row: first what is left of the diagonal.
    let pairs = || (n as u32..).zip(ends);
    pairs().for_each(|(line, &[i, j])| push(j, line, i));
    (0..n as u32).for_each(|i| push(i, i, i));
    pairs().for_each(|(line, &[i, j])| push(i, line, j));
    (entries, starts)
}

impl LinearOperator for PairMatrix {
    fn size(&self) -> usize {
        self.n
    }

    /// Each row is summed from its first scalar column to its last.
    fn multiply(&self, x: &[Vec3], y: &mut [Vec3]) {
        assert_eq!(x.len(), self.n, "one vector a block row");
        assert_eq!(y.len(), self.n, "one vector a block row");
        pulp::Arch::new().dispatch(Product { matrix: self, x, y });
    }
}

struct Product<'a> {
    matrix: &'a PairMatrix,
    x: &'a [Vec3],
    y: &'a mut [Vec3],
}

impl pulp::WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { matrix, x, y } = self;
        let numbers = &matrix.numbers[matrix.lead..];
        let (groups, rest) = y.as_chunks_mut::<TOGETHER>();
        let first_of_rest = TOGETHER * groups.len();
        for (g, y) in groups.iter_mut().enumerate() {
            *y = matrix.rows(numbers, TOGETHER * g, x);
        }
        for (k, y) in rest.iter_mut().enumerate() {
            [*y] = matrix.rows(numbers, first_of_rest + k, x);
        }
    }
}

impl PairMatrix {
    /// The products of `N` rows, from row `first`, with `x`.
    #[inline(always)]
    fn rows<const N: usize>(&self, numbers: &[f64], first: usize, x: &[Vec3]) -> [Vec3; N] {
        let starts = &self.starts[first..][..N + 1];
        let rows: [&[[u32; 2]]; N] =
            std::array::from_fn(|k| &self.entries[starts[k]..starts[k + 1]]);
        let common = rows.iter().map(|row| row.len()).min().unwrap_or(0);
        let mut sums = [[0.0; 4]; N];
        for e in 0..common {
            for (sum, row) in sums.iter_mut().zip(rows) {
                add_block(sum, numbers, row[e], x);
            }
        }
        for (sum, row) in sums.iter_mut().zip(rows) {
            row[common..].iter().for_each(|entry| add_block(sum, numbers, *entry, x));
        }
        sums.map(|sum| Vec3::new(sum[0], sum[1], sum[2]))
    }
}

/// Adds the product of a block with its part of `x`, column by column. The fourth number is of no meaning.
#[inline(always)]
fn add_block(sum: &mut [f64; 4], numbers: &[f64], [line, column]: [u32; 2], x: &[Vec3]) {
    let line = &numbers[LINE * line as usize..][..LINE + 1];
    let x = &x[column as usize];
    for (begin, x) in COLUMNS.into_iter().zip([x.x, x.y, x.z]) {
        let column = [line[begin], line[begin + 1], line[begin + 2], line[begin + 3]];
        for k in 0..4 {
            sum[k] += column[k] * x;
        }
    }
}

#[cfg(test)]
#[path = "pairs_tests.rs"]
mod tests;
