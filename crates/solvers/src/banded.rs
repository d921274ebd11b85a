//! Symmetric 3×3 blocks along few diagonals: the matrix of a regular grid, without an index.
//!
//! On a sheet whose particles are numbered row by row, springs of one kind couple `i` to `i + o` with two offsets `o`
//! ("bands"). [`BandedMatrix`] stores one array for each band and each of the six numbers of a symmetric block, so that
//! neighbouring rows lie side by side and a product takes eight rows at a time.
//!
//! # One result
//!
//! A row is summed as [`BlockMatrix`](crate::BlockMatrix) sums it, from its first scalar column to its last. Places
//! without a coupling hold zeros, which change no sum of finite numbers. So both matrices give the same bits, and so do
//! registers of any width: Rust contracts no product and sum into one rounding.
//!
//! # What it costs
//!
//! With `B` bands a product takes `18 (2B + 1)` flops a row and moves `48 (B + 1)` bytes of matrix and 48 of vectors: 234 flops and
//! 384 bytes on a sheet with tension, shear and bending springs, against 234 and 1036 in compressed rows. The
//! blocks left of the diagonal are those of earlier rows, which the second-level cache still has.
//!
//! | tried on 400 to 10 000 rows, six bands, one core of a Zen 4 | ns a row |
//! |---|---|
//! | from the loads alone: 189 cache lines for 8 rows, one a cycle | 6.5 |
//! | groups of 128 rows, 3 blocks a pass | 12.0 |
//! | 512 rows, 1 block a pass: each reads and writes the sums | 14.4 |
//! | 512 rows, 3 blocks | 11.1 |
//! | **512 rows, 4 blocks** | 10.4 |
//! | 512 rows, 6 blocks: no longer vectorised | 38 |
//!
//! At 100 000 rows the matrix comes from main memory: 33 ns beside other work on the machine, 14 from its bandwidth alone. The
//! 42 arrays are more streams than the processor fetches ahead well.

use crate::{LinearOperator, Mat3, Vec3};
use std::sync::Mutex;

/// Rows whose sums are kept in the first-level cache; a page of each plane.
const GROUP: usize = 512;
/// Groups are computed in multiples of this many rows; vector registers hold so many numbers or fewer.
const LANES: usize = 8;
/// Zeros behind the last row.
const PADDING: usize = 2 * LANES;
/// Blocks of each row that one pass over a group takes: the sums stay in registers meanwhile.
const TOGETHER: usize = 4;

/// A symmetric matrix of symmetric 3×3 blocks on the diagonal and along few bands beside it.
///
/// ```
/// use drape_solvers::{BandedMatrix, LinearOperator, Mat3, Vec3};
/// let mut a = BandedMatrix::new(3, [1]);
/// (0..3).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
/// a.add_pair(1, 2, &(10.0 * Vec3::x() * Vec3::x().transpose()));
/// let mut y = [Vec3::zeros(); 3];
/// a.multiply(&[Vec3::zeros(), Vec3::new(1.0, 1.0, 0.0), Vec3::zeros()], &mut y);
/// assert_eq!(y, [Vec3::zeros(), Vec3::new(11.0, 1.0, 0.0), Vec3::new(-10.0, 0.0, 0.0)]);
/// ```
#[derive(Debug)]
pub struct BandedMatrix {
    n: usize,
    /// `j − i` of the bands, rising.
    offsets: Vec<usize>,
    /// Distance of two planes.
    stride: usize,
    /// Zeros before row 0 of each plane, at least the largest offset.
    lead: usize,
    /// `xx, xy, xz, yy, yz, zz` of the diagonal, then of each band.
    planes: Vec<f64>,
    /// The blocks of a row in the order of their columns.
    terms: Vec<Term>,
    /// Memory of a product. Whoever finds it taken goes through the rows one by one.
    window: Mutex<Window>,
}

/// The blocks of one diagonal, left or right of the main one, that rows are multiplied with.
#[derive(Clone, Copy, Debug, Default)]
struct Term {
    /// Where the `xx` of row 0 is in the planes.
    block: usize,
    /// Where the factor of the first row of a chunk is in a plane of the window.
    x: usize,
}

/// The planes of a [`BandedMatrix`], for those who fill many rows at a time.
#[derive(Debug)]
pub struct BandPlanes<'a> {
    /// Six planes for the diagonal, then six for each band: `xx, xy, xz, yy, yz, zz`.
    pub planes: &'a mut [f64],
    /// Distance of two planes.
    pub stride: usize,
    /// Where row 0 is in a plane; before it and behind row `n − 1` there are zeros that have to stay.
    pub lead: usize,
    /// The offsets of the bands, rising: block (i, i + o) is at row i.
    pub offsets: &'a [usize],
}

impl BandedMatrix {
    /// The zero matrix with `n` rows and these bands.
    ///
    /// # Panics
    /// When an offset is 0.
    pub fn new(n: usize, offsets: impl IntoIterator<Item = usize>) -> Self {
        let mut offsets: Vec<usize> = offsets.into_iter().collect();
        offsets.sort_unstable();
        offsets.dedup();
        assert_ne!(offsets.first(), Some(&0), "the diagonal is no band");
        let reach = offsets.last().copied().unwrap_or(0).next_multiple_of(LANES);
        // Five cache lines more than a page, lest the same row of all planes falls into the same set of the cache.
        let stride = (reach + n + PADDING).next_multiple_of(512) + 40;
        let planes = vec![0.0; 6 * (offsets.len() + 1) * stride];
        let window = Window::new(n, reach);
        let band = |b: usize| 6 * (b + 1) * stride + reach;
        let numbered = || offsets.iter().copied().enumerate();
        let mut terms: Vec<Term> =
            numbered().rev().map(|(b, o)| Term { block: band(b) - o, x: reach - o }).collect();
        terms.push(Term { block: reach, x: reach });
        terms.extend(numbered().map(|(b, o)| Term { block: band(b), x: reach + o }));
        Self { n, stride, lead: reach, planes, terms, window: Mutex::new(window), offsets }
    }

    /// Number of block rows.
    pub fn n(&self) -> usize {
        self.n
    }

    /// The offsets of the bands, rising.
    pub fn offsets(&self) -> &[usize] {
        &self.offsets
    }

    /// Sets all blocks to zero.
    pub fn clear(&mut self) {
        self.planes.fill(0.0);
    }

    /// Adds the symmetric `block` to diagonal block `i`.
    pub fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        assert!(i < self.n, "row {i} of {}", self.n);
        self.add_at(self.lead + i, block, 1.0);
    }

    /// Adds the symmetric `block` at (i, i) and (j, j), and its negative at (i, j) and (j, i). A pair on no band is a
    /// mistake of the caller: it stops a debug build, and a release build leaves the pair out.
    pub fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if i == j {
            return;
        }
        let band = self.offsets.binary_search(&i.abs_diff(j));
        debug_assert!(band.is_ok(), "the pair ({i}, {j}) is on no band");
        let Ok(band) = band else { return };
        self.add_at(6 * (band + 1) * self.stride + self.lead + i.min(j), block, -1.0);
        self.add_diagonal(i, block);
        self.add_diagonal(j, block);
    }

    /// Block (i, j); zero outside the bands.
    pub fn get(&self, i: usize, j: usize) -> Mat3 {
        let at = |first: usize| {
            let b = self.six(first + self.lead + i.min(j));
            Mat3::new(b[0], b[1], b[2], b[1], b[3], b[4], b[2], b[4], b[5])
        };
        match self.offsets.binary_search(&i.abs_diff(j)) {
            _ if i == j => at(0),
            Ok(band) => at(6 * (band + 1) * self.stride),
            Err(_) => Mat3::zeros(),
        }
    }

    /// All numbers, for those who fill many rows at a time.
    pub fn planes_mut(&mut self) -> BandPlanes<'_> {
        let Self { planes, stride, lead, offsets, .. } = self;
        BandPlanes { planes, stride: *stride, lead: *lead, offsets }
    }

    /// The planes `xx, xy, xz, yy, yz, zz` of the diagonal blocks, with at least `n` and a multiple of eight numbers.
    pub(crate) fn diagonal(&self) -> [&[f64]; 6] {
        let length = self.n.next_multiple_of(LANES);
        std::array::from_fn(|c| &self.planes[c * self.stride + self.lead..][..length])
    }

    fn six(&self, at: usize) -> [f64; 6] {
        std::array::from_fn(|c| self.planes[c * self.stride + at])
    }

    fn add_at(&mut self, at: usize, block: &Mat3, sign: f64) {
        for (c, (row, column)) in SIX.into_iter().enumerate() {
            self.planes[c * self.stride + at] += sign * block[(row, column)];
        }
    }

    /// The readable form of [`multiply`](LinearOperator::multiply).
    fn multiply_row_by_row(&self, x: &[Vec3], y: &mut [Vec3]) {
        for (i, y) in y.iter_mut().enumerate() {
            let left = self.offsets.iter().rev().filter_map(|o| i.checked_sub(*o));
            let right = self.offsets.iter().map(|o| i + o).filter(|j| *j < self.n);
            let mut sum = [0.0; 3];
            for j in left.chain([i]).chain(right) {
                let block = self.get(i, j);
                for column in 0..3 {
                    for row in 0..3 {
                        sum[row] += block[(row, column)] * x[j][column];
                    }
                }
            }
            *y = Vec3::from(sum);
        }
    }
}

/// Rows and columns of the six numbers.
const SIX: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

impl LinearOperator for BandedMatrix {
    fn size(&self) -> usize {
        self.n
    }

    /// Each row is summed from its first scalar column to its last.
    fn multiply(&self, x: &[Vec3], y: &mut [Vec3]) {
        assert_eq!(x.len(), self.n, "one vector a block row");
        assert_eq!(y.len(), self.n, "one vector a block row");
        match self.window.try_lock() {
            Ok(mut window) => pulp::Arch::new().dispatch(Product {
                matrix: self,
                window: &mut window,
                x: bytemuck::cast_slice(x),
                y: bytemuck::cast_slice_mut(y),
            }),
            Err(_) => self.multiply_row_by_row(x, y),
        }
    }
}

/// The coordinates of the factor in one array each: `reach` particles before a chunk, the chunk, and as many behind it.
#[derive(Debug)]
struct Window {
    chunk: usize,
    reach: usize,
    stride: usize,
    planes: Vec<f64>,
}

impl Window {
    fn new(n: usize, reach: usize) -> Self {
        let chunk = n.next_multiple_of(GROUP).min((4 * reach).next_multiple_of(GROUP).max(1024));
        let stride = (chunk + 2 * reach + LANES).next_multiple_of(512) + 40;
        Self { chunk, reach, stride, planes: vec![0.0; 3 * stride] }
    }

    /// Moves on to the chunk that begins at row `begin`.
    #[inline(always)]
    fn read(&mut self, x: &[f64], begin: usize) {
        let &mut Self { chunk, reach, stride, ref mut planes } = self;
        let n = x.len() / 3;
        // The first row of which something is read, and where it goes.
        let (from, at) = if begin == 0 { (0, reach) } else { (begin + reach, 2 * reach) };
        let to = (begin + chunk + reach).min(n).max(from.min(n));
        let from = from.min(n);
        let (px, rest) = planes.split_at_mut(stride);
        let (py, pz) = rest.split_at_mut(stride);
        for plane in [&mut *px, &mut *py, &mut *pz] {
            if begin == 0 {
                plane[..reach].fill(0.0);
            } else {
                plane.copy_within(chunk..chunk + 2 * reach, 0);
            }
            plane[at + to - from..chunk + 2 * reach + LANES].fill(0.0);
        }
        let m = to - from;
        split(&x[3 * from..3 * to], &mut px[at..][..m], &mut py[at..][..m], &mut pz[at..][..m]);
    }
}

struct Product<'a> {
    matrix: &'a BandedMatrix,
    window: &'a mut Window,
    x: &'a [f64],
    y: &'a mut [f64],
}

impl pulp::WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { matrix, window, x, y } = self;
        let (terms, rest) = matrix.terms.as_chunks::<TOGETHER>();
        let mut begin = 0;
        while begin < matrix.n {
            window.read(x, begin);
            let end = matrix.n.min(begin + window.chunk);
            for i in (begin..end).step_by(GROUP) {
                let m = GROUP.min(end - i);
                let at = Place {
                    planes: &matrix.planes,
                    stride: matrix.stride,
                    row: i,
                    x: &window.planes,
                    x_stride: window.stride,
                    x_row: i - begin,
                    rows: m.next_multiple_of(LANES),
                };
                let mut sums = [[0.0; GROUP]; 3];
                terms.iter().for_each(|terms| at.add(terms, &mut sums));
                rest.iter().for_each(|term| at.add(&[*term], &mut sums));
                join(&sums, &mut y[3 * i..3 * (i + m)]);
            }
            begin += window.chunk;
        }
    }
}

/// Where a group of rows finds its blocks and factors.
#[derive(Clone, Copy)]
struct Place<'a> {
    planes: &'a [f64],
    stride: usize,
    row: usize,
    x: &'a [f64],
    x_stride: usize,
    x_row: usize,
    rows: usize,
}

impl<'a> Place<'a> {
    /// Adds the products with some blocks of each row, one after the other.
    #[inline(always)]
    fn add<const N: usize>(&self, terms: &[Term; N], sums: &mut [[f64; GROUP]; 3]) {
        let m = self.rows.min(GROUP);
        let blocks: [[&[f64]; 6]; N] =
            std::array::from_fn(|k| std::array::from_fn(|c| self.block(terms[k], c, m)));
        let x: [[&[f64]; 3]; N] =
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
    fn block(&self, term: Term, c: usize, m: usize) -> &'a [f64] {
        &self.planes[term.block + c * self.stride + self.row..][..m]
    }

    #[inline(always)]
    fn factor(&self, term: Term, axis: usize, m: usize) -> &'a [f64] {
        &self.x[term.x + axis * self.x_stride + self.x_row..][..m]
    }
}

/// Vectors into one array a coordinate.
#[inline(always)]
pub(crate) fn split(from: &[f64], x: &mut [f64], y: &mut [f64], z: &mut [f64]) {
    let m = x.len();
    let (y, z, from) = (&mut y[..m], &mut z[..m], &from[..3 * m]);
    for t in 0..m {
        x[t] = from[3 * t];
        y[t] = from[3 * t + 1];
        z[t] = from[3 * t + 2];
    }
}

/// The inverse of [`split`], as long as `to`.
#[inline(always)]
pub(crate) fn join<const G: usize>(planes: &[[f64; G]; 3], to: &mut [f64]) {
    let m = to.len() / 3;
    let (x, y, z) = (&planes[0][..m], &planes[1][..m], &planes[2][..m]);
    for t in 0..m {
        to[3 * t] = x[t];
        to[3 * t + 1] = y[t];
        to[3 * t + 2] = z[t];
    }
}

#[cfg(test)]
#[path = "banded_tests.rs"]
mod tests;
