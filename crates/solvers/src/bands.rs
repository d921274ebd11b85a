//! Sweeps over vectors in contiguous bands of blocks, one band a thread.
//!
//! The unit is the [`BLOCK`] of the documented order of sums: a thread sums whole blocks, and the
//! blocks' sums are added from the first to the last afterwards. So the number of bands leaves no trace in the
//! results.

use crate::vector::BLOCK;
use std::ops::Range;

/// Fewest particles that are shared among threads. A sweep takes about a nanosecond a particle, and to wake another thread
/// some microseconds, which half of such a sweep is worth.
pub const LEAST_FOR_THREADS: usize = 16_384;

/// Into how many bands as many `particles` are cut for so many threads: one where there are too few.
pub fn bands(threads: usize, particles: usize) -> usize {
    if particles < LEAST_FOR_THREADS { 1 } else { threads.max(1) }
}

/// What a sweep writes.
pub trait Part: Send + Sized {
    /// What belongs to the first `blocks` blocks of particles, and the rest.
    fn split(self, blocks: usize) -> (Self, Self);
}

/// One item a particle.
impl<T: Send> Part for &mut [T] {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        self.split_at_mut(blocks * BLOCK)
    }
}

/// One item a block of particles.
#[derive(Debug)]
pub struct PerBlock<'a, T>(pub &'a mut [T]);

impl<T: Send> Part for PerBlock<'_, T> {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        let (left, right) = self.0.split_at_mut(blocks);
        (Self(left), Self(right))
    }
}

impl<A: Part, B: Part> Part for (A, B) {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        let (a, b) = (self.0.split(blocks), self.1.split(blocks));
        ((a.0, b.0), (a.1, b.1))
    }
}

impl<A: Part, B: Part, C: Part> Part for (A, B, C) {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        let (a, b, c) = (self.0.split(blocks), self.1.split(blocks), self.2.split(blocks));
        ((a.0, b.0, c.0), (a.1, b.1, c.1))
    }
}

impl<A: Part, B: Part, C: Part, D: Part> Part for (A, B, C, D) {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        let ((a, b), (c, d)) = ((self.0, self.1).split(blocks), (self.2, self.3).split(blocks));
        ((a.0, a.1, c.0, c.1), (b.0, b.1, d.0, d.1))
    }
}

/// Cuts `particles` and `part` into so many bands and hands each to `sweep`, on the current [`rayon`] pool; one band is
/// swept by the caller, without a word to the pool. Nothing is allocated here.
///
/// ```
/// use drape_solvers::bands::in_bands;
/// let mut squares = vec![0; 1000];
/// in_bands(3, 1000, &mut squares[..], &|particles, squares: &mut [usize]| {
///     for (i, square) in particles.zip(squares) {
///         *square = i * i;
///     }
/// });
/// assert_eq!(squares[999], 999 * 999);
/// ```
pub fn in_bands<P: Part>(
    bands: usize,
    particles: usize,
    part: P,
    sweep: &(impl Fn(Range<usize>, P) + Sync),
) {
    cut(bands, 0..particles, part, sweep);
}

fn cut<P: Part>(
    bands: usize,
    particles: Range<usize>,
    part: P,
    sweep: &(impl Fn(Range<usize>, P) + Sync),
) {
    let blocks = particles.len().div_ceil(BLOCK);
    if bands < 2 || blocks < 2 {
        return sweep(particles, part);
    }
    let few = bands / 2;
    let before = (blocks * few / bands).max(1);
    let (left, right) = part.split(before);
    let middle = particles.start + before * BLOCK;
    rayon::join(
        || cut(few, particles.start..middle, left, sweep),
        || cut(bands - few, middle..particles.end, right, sweep),
    );
}
