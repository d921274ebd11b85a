//! Symmetric 3×3 blocks, one for each coupled pair of rows: the matrix of a general mesh of
//! springs.
//!
//! A block left of the diagonal is stored with the other row and read from there.
//!
//! # What it costs
//!
//! With `p` pairs a row a product takes `18 (2p + 1)` flops a row and moves `64 (p + 1)` bytes of
//! blocks, `8 (2p + 1)` of places and 48 of vectors: on a sheet with tension, shear and bending
//! springs (`p` = 6) 234 flops and 600 bytes, against 1036 bytes in compressed rows. The blocks
//! left of the diagonal belong to earlier rows. Where coupled rows have near numbers, these are
//! still in cache.
//!
//! Tried with steps of Baraff and Witkin's method on 2704 rows in disorder, on one core of a busy
//! Zen 4, least time of many steps:
//!
//! | tried | expected | a step |
//! |---|---|---|
//! | compressed rows, a search for each block | | 2.0 ms |
//! | one line a pair, its place known; each column is one register | half the memory, a fourth of the instructions | 0.99 ms |
//! | **four rows side by side**: a sum of 39 terms waits for each of them | products cost half as much | 0.94 ms |

use crate::{Mat3, Vec3};
use drape_kernels::blocks::{COLUMNS, LINE, PLACES, PairLines, six};
use drape_kernels::planes::Aligned;
use std::ops::Range;

/// Rows summed side by side: each waits for its own sums only.
const TOGETHER: usize = 4;

/// A symmetric matrix of symmetric 3×3 blocks. Each coupled pair has one block, in a
/// [`Line`](drape_kernels::blocks::Line) of the cache.
#[derive(Clone, Debug)]
pub(super) struct Pairs {
    n: usize,
    /// The lines of the diagonal, then of the pairs, then room for the last column's reach beyond
    /// the last line.
    numbers: Aligned,
    /// Rows of each pair, the lower first; rising.
    ends: Vec<[u32; 2]>,
    /// The pair of each edge given to [`new`](Self::new).
    slots: Vec<u32>,
    /// The blocks of row `i` are `entries[starts[i]..starts[i + 1]]`: line and column of each, by
    /// rising column.
    entries: Vec<[u32; 2]>,
    starts: Vec<usize>,
}

impl Pairs {
    /// The zero matrix with room for `n` diagonal blocks and for each edge.
    pub(super) fn new(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
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
        let numbers = Aligned::zeros(0, LINE * (n + ends.len() + 1));
        Self { n, numbers, ends, slots, entries, starts }
    }

    pub(super) fn n(&self) -> usize {
        self.n
    }

    pub(super) fn nonzeros(&self) -> usize {
        self.n + 2 * self.ends.len()
    }

    /// All coupled pairs.
    pub(super) fn edges(&self) -> Vec<(usize, usize)> {
        self.ends.iter().map(|&[i, j]| (i as usize, j as usize)).collect()
    }

    pub(super) fn clear(&mut self) {
        self.numbers.all_mut().fill(0.0);
    }

    pub(super) fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        assert!(i < self.n, "row {i} of {}", self.n);
        self.add_at(i, block, 1.0);
    }

    pub(super) fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if i == j {
            return;
        }
        let line = self.line(i, j);
        debug_assert!(line.is_some(), "the pattern has no pair ({i}, {j})");
        let Some(line) = line else { return };
        self.add_at(line, block, -1.0);
        self.add_diagonal(i, block);
        self.add_diagonal(j, block);
    }

    pub(super) fn get(&self, i: usize, j: usize) -> Mat3 {
        self.line(i, j).map_or_else(Mat3::zeros, |line| {
            let line = &self.numbers.all()[LINE * line..];
            Mat3::from_fn(|row, column| line[COLUMNS[column] + row])
        })
    }

    /// Cuts all couplings of row `i`, and sets its diagonal block to `scale(trace / 3)` times the
    /// identity.
    pub(super) fn fix(&mut self, i: usize, scale: impl Fn(f64) -> f64) {
        let scale = scale(self.get(i, i).trace() / 3.0);
        for &[line, _] in &self.entries[self.starts[i]..self.starts[i + 1]] {
            self.numbers.all_mut()[LINE * line as usize..][..LINE].fill(0.0);
        }
        self.add_diagonal(i, &Mat3::from_diagonal_element(scale));
    }

    pub(super) fn lines_mut(&mut self) -> PairLines<'_> {
        let Self { n, numbers, ends, slots, .. } = self;
        let (lines, _) = numbers.all_mut().as_chunks_mut::<LINE>();
        let (diagonal, pairs) = lines.split_at_mut(*n);
        PairLines { diagonal, pairs: &mut pairs[..ends.len()], ends, slots }
    }

    /// `xx, xy, xz, yy, yz, zz` of diagonal block `i`.
    #[inline(always)]
    pub(super) fn diagonal(&self, i: usize) -> [f64; 6] {
        six(self.numbers.all().as_chunks::<LINE>().0[i])
    }

    /// The line of block (i, j).
    fn line(&self, i: usize, j: usize) -> Option<usize> {
        if i == j {
            return Some(i);
        }
        let slot = self.ends.binary_search(&[i.min(j) as u32, i.max(j) as u32]).ok()?;
        Some(self.n + slot)
    }

    fn add_at(&mut self, line: usize, block: &Mat3, sign: f64) {
        let line = &mut self.numbers.all_mut()[LINE * line..][..LINE];
        for (number, place) in line.iter_mut().zip(PLACES) {
            *number += sign * block[place];
        }
    }

    /// These rows of `A x`, into `y`.
    pub(super) fn multiply(&self, rows: Range<usize>, x: &[Vec3], y: &mut [Vec3]) {
        pulp::Arch::new().dispatch(Product { matrix: self, first: rows.start, x, y });
    }

    /// The products of `N` rows, from row `first`, with `x`.
    #[inline(always)]
    fn products<const N: usize>(&self, numbers: &[f64], first: usize, x: &[Vec3]) -> [Vec3; N] {
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

/// Lines and columns of the blocks of `n` rows, and the start of each row.
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
    // Pairs rise by their lower row: first the blocks left of the diagonal.
    let pairs = || (n as u32..).zip(ends);
    pairs().for_each(|(line, &[i, j])| push(j, line, i));
    (0..n as u32).for_each(|i| push(i, i, i));
    pairs().for_each(|(line, &[i, j])| push(i, line, j));
    (entries, starts)
}

struct Product<'a> {
    matrix: &'a Pairs,
    /// The row of `y[0]`.
    first: usize,
    x: &'a [Vec3],
    y: &'a mut [Vec3],
}

impl pulp::WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { matrix, first, x, y } = self;
        let numbers = matrix.numbers.all();
        let (groups, rest) = y.as_chunks_mut::<TOGETHER>();
        let first_of_rest = first + TOGETHER * groups.len();
        for (g, y) in groups.iter_mut().enumerate() {
            *y = matrix.products(numbers, first + TOGETHER * g, x);
        }
        for (k, y) in rest.iter_mut().enumerate() {
            [*y] = matrix.products(numbers, first_of_rest + k, x);
        }
    }
}

/// Adds the product of a block with its part of `x`, column by column. The fourth number means
/// nothing.
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
