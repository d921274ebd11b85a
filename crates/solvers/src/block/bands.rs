//! Symmetric 3×3 blocks along few diagonals: the matrix of a regular grid, without an index.
//!
//! On a sheet with particles numbered row by row, springs of one kind couple `i` to `i + o` with
//! two offsets `o` ("bands"). Each band has one array for each of the six numbers of a symmetric
//! block. Neighbouring rows therefore lie side by side, and a product computes eight rows at a
//! time.
//!
//! # What it costs
//!
//! With `B` bands a product takes `18 (2B + 1)` flops a row and moves `48 (B + 1)` bytes of matrix
//! and 48 of vectors: 234 flops and 384 bytes on a sheet with tension, shear and bending springs,
//! against 234 and 1036 in compressed rows. The blocks left of the diagonal belong to earlier rows,
//! which are still in the second-level cache.
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
//! At 100 000 rows the matrix comes from main memory: 33 ns with other work on the machine,
//! although the bandwidth alone would allow 14. The processor does not prefetch 42 streams well.

use super::product::{self, GROUP, Place, Term};
use super::symmetric;
use crate::pattern::Pattern;
use crate::{Mat3, Vec3};
use drape_kernels::blocks::{BandPlanes, SIX};
use drape_kernels::lanes::WIDEST;
use drape_kernels::planes::{self, Frame, join};
use std::ops::Range;
use std::sync::Mutex;

/// Zeros behind the last row.
const PADDING: usize = 2 * WIDEST;

/// A symmetric matrix of symmetric 3×3 blocks on the diagonal and along few bands beside it.
#[derive(Debug)]
pub(super) struct Bands {
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
    /// Scratch, one for each part of a product. If other threads hold all, fall back to the
    /// reference form.
    pub(super) windows: Vec<Mutex<Window>>,
}

impl Clone for Bands {
    fn clone(&self) -> Self {
        let mut copy = Self::new(self.n, &self.offsets);
        copy.planes.copy_from_slice(&self.planes);
        copy.reserve_windows(self.windows.len());
        copy
    }
}

impl Bands {
    /// The zero matrix with `n` rows and these bands.
    pub(super) fn new(n: usize, offsets: &[usize]) -> Self {
        let mut offsets = offsets.to_vec();
        offsets.sort_unstable();
        offsets.dedup();
        assert_ne!(offsets.first(), Some(&0), "the diagonal is no band");
        let reach = offsets.last().copied().unwrap_or(0).next_multiple_of(WIDEST);
        let stride = planes::stride(reach + n + PADDING);
        Self {
            n,
            stride,
            lead: reach,
            planes: vec![0.0; 6 * (offsets.len() + 1) * stride],
            terms: product::terms(&offsets, reach, stride),
            windows: vec![Mutex::new(Window::new(n, reach))],
            offsets,
        }
    }

    /// Scratch for so many parts of a product at a time.
    pub(super) fn reserve_windows(&mut self, count: usize) {
        let Self { n, lead, .. } = *self;
        if self.windows.len() < count {
            self.windows.resize_with(count, || Mutex::new(Window::new(n, lead)));
        }
    }

    pub(super) fn n(&self) -> usize {
        self.n
    }

    pub(super) fn nonzeros(&self) -> usize {
        self.n + self.offsets.iter().map(|o| 2 * self.n.saturating_sub(*o)).sum::<usize>()
    }

    pub(super) fn offsets(&self) -> &[usize] {
        &self.offsets
    }

    /// All pairs along the bands.
    pub(super) fn edges(&self) -> Vec<(usize, usize)> {
        let along = |o: &usize| (0..self.n.saturating_sub(*o)).zip(*o..);
        self.offsets.iter().flat_map(along).collect()
    }

    pub(super) fn clear(&mut self) {
        self.planes.fill(0.0);
    }

    pub(super) fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        assert!(i < self.n, "row {i} of {}", self.n);
        self.add_at(self.lead + i, block, 1.0);
    }

    pub(super) fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if i == j {
            return;
        }
        let place = self.place(i, j);
        debug_assert!(place.is_some(), "the pattern has no pair ({i}, {j})");
        let Some(place) = place else { return };
        self.add_at(place, block, -1.0);
        self.add_diagonal(i, block);
        self.add_diagonal(j, block);
    }

    pub(super) fn get(&self, i: usize, j: usize) -> Mat3 {
        self.place(i, j).map_or_else(Mat3::zeros, |at| self.block(at))
    }

    /// The block whose `xx` is at this place.
    #[inline(always)]
    fn block(&self, at: usize) -> Mat3 {
        symmetric(std::array::from_fn(|c| self.planes[c * self.stride + at]))
    }

    /// Whether the places along the bands are those of a pattern.
    pub(super) fn has_pattern(&self, pattern: &Pattern) -> bool {
        let left = |i: usize| self.offsets.iter().rev().filter_map(move |o| i.checked_sub(*o));
        let own = |i: usize| pattern.lower(i).map(|slot| pattern.column(slot));
        pattern.n() == self.n && (0..self.n).all(|i| left(i).eq(own(i)))
    }

    /// Writes the blocks left of the diagonal, row by row. Returns whether all are symmetric.
    pub(super) fn read_lower(&self, lower: &mut [Mat3]) -> bool {
        let bands = self.offsets.iter().enumerate().rev();
        let bands = bands.map(|(b, o)| (*o, 6 * (b + 1) * self.stride + self.lead));
        let row =
            |i: usize| bands.clone().filter(move |(o, _)| *o <= i).map(move |(o, at)| at + i - o);
        for (to, at) in lower.iter_mut().zip((0..self.n).flat_map(row)) {
            *to = self.block(at);
        }
        true
    }

    /// Cuts all couplings of row `i`, and sets its diagonal block to `scale(trace / 3)` times the
    /// identity.
    pub(super) fn fix(&mut self, i: usize, scale: impl Fn(f64) -> f64) {
        let scale = scale(self.get(i, i).trace() / 3.0);
        self.clear_at(self.lead + i);
        for b in 0..self.offsets.len() {
            let (offset, band) = (self.offsets[b], 6 * (b + 1) * self.stride + self.lead);
            let right = (i + offset < self.n).then_some(i);
            for row in [i.checked_sub(offset), right].into_iter().flatten() {
                self.clear_at(band + row);
            }
        }
        self.add_at(self.lead + i, &Mat3::from_diagonal_element(scale), 1.0);
    }

    pub(super) fn planes_mut(&mut self) -> BandPlanes<'_> {
        let Self { planes, stride, lead, offsets, .. } = self;
        BandPlanes { planes, stride: *stride, lead: *lead, offsets }
    }

    /// Zeros before row 0 of each plane.
    pub(super) fn lead(&self) -> usize {
        self.lead
    }

    /// Each plane from its first zero to its last.
    pub(super) fn planes(&self) -> impl Iterator<Item = &[f64]> {
        self.planes.chunks_exact(self.stride).map(|plane| &plane[..self.lead + self.n + PADDING])
    }

    /// The planes `xx, xy, xz, yy, yz, zz` of the diagonal blocks.
    pub(super) fn diagonal(&self) -> [&[f64]; 6] {
        std::array::from_fn(|c| &self.planes[c * self.stride + self.lead..][..self.n])
    }

    /// Place of the `xx` of block (i, j).
    fn place(&self, i: usize, j: usize) -> Option<usize> {
        let row = self.lead + i.min(j);
        match self.offsets.binary_search(&i.abs_diff(j)) {
            _ if i == j => Some(row),
            Ok(band) => Some(6 * (band + 1) * self.stride + row),
            Err(_) => None,
        }
    }

    fn add_at(&mut self, at: usize, block: &Mat3, sign: f64) {
        for (c, place) in SIX.into_iter().enumerate() {
            self.planes[c * self.stride + at] += sign * block[place];
        }
    }

    fn clear_at(&mut self, at: usize) {
        (0..6).for_each(|c| self.planes[c * self.stride + at] = 0.0);
    }

    /// These rows of `A x`, into `y`.
    pub(super) fn multiply(&self, rows: Range<usize>, x: &[Vec3], y: &mut [Vec3]) {
        match self.windows.iter().find_map(|window| window.try_lock().ok()) {
            Some(mut window) => pulp::Arch::new().dispatch(Product {
                matrix: self,
                window: &mut window,
                rows,
                x: bytemuck::cast_slice(x),
                y: bytemuck::cast_slice_mut(y),
            }),
            None => self.multiply_reference(rows, x, y),
        }
    }

    /// The reference form of [`multiply`](Self::multiply), row by row.
    pub(super) fn multiply_reference(&self, rows: Range<usize>, x: &[Vec3], y: &mut [Vec3]) {
        for (i, y) in rows.zip(y) {
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

/// The coordinates of the factor in one array each: a chunk with `reach` particles before and
/// behind it.
#[derive(Debug)]
pub(super) struct Window {
    chunk: usize,
    reach: usize,
    stride: usize,
    planes: Vec<f64>,
}

impl Window {
    fn new(n: usize, reach: usize) -> Self {
        let chunk = n.next_multiple_of(GROUP).min((4 * reach).next_multiple_of(GROUP).max(1024));
        let stride = planes::stride(chunk + 2 * reach + WIDEST);
        Self { chunk, reach, stride, planes: vec![0.0; 3 * stride] }
    }

    /// Moves to the chunk that begins at row `begin`: on from the one before it, or anew.
    #[inline(always)]
    fn read(&mut self, x: &[f64], begin: usize, goes_on: bool) {
        let &mut Self { chunk, reach, stride, ref mut planes } = self;
        let beyond = 2 * reach + WIDEST;
        let kept = if goes_on { beyond } else { 0 };
        let first = begin as isize - reach as isize;
        Frame { first, len: chunk + beyond, kept, moved: chunk }.read(planes, stride, x);
    }
}

struct Product<'a> {
    matrix: &'a Bands,
    window: &'a mut Window,
    rows: Range<usize>,
    x: &'a [f64],
    y: &'a mut [f64],
}

impl pulp::WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { matrix, window, rows, x, y } = self;
        let first = rows.start;
        let mut begin = first;
        while begin < rows.end {
            window.read(x, begin, begin > first);
            let end = rows.end.min(begin + window.chunk);
            for i in (begin..end).step_by(GROUP) {
                let m = GROUP.min(end - i);
                let at = Place {
                    planes: &matrix.planes,
                    stride: matrix.stride,
                    row: i,
                    x: &window.planes,
                    x_stride: window.stride,
                    x_row: i - begin,
                    rows: m.next_multiple_of(WIDEST),
                };
                let mut sums = [[0.0; GROUP]; 3];
                at.add_all(&matrix.terms, &mut sums);
                join(sums.as_flattened(), GROUP, &mut y[3 * (i - first)..][..3 * m]);
            }
            begin += window.chunk;
        }
    }
}
