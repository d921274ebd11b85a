//! Sweeps over vectors in contiguous bands of blocks, some bands per thread.
//!
//! The unit is the [`BLOCK`] of the documented order of sums. A band sums whole blocks, and
//! afterwards the sums of the blocks are added from the first to the last. So results do not depend
//! on the number of bands.
//!
//! # What threads cost
//!
//! A sweep takes some tens of microseconds to some milliseconds, and all threads meet after each.
//! Four things then decide how much another thread gains:
//!
//! * Cores are not equally fast at every moment, because other programs use them too. With one band
//!   per thread, all wait for the slowest band. With [`BANDS_PER_THREAD`] a thread that is done
//!   takes over a band of another thread.
//! * A thread of the pool that finds nothing to do goes to sleep after some tens of microseconds,
//!   and waking it takes as long again. The owner of the pool can keep its threads awake for the
//!   duration of a run, as the harness's `Team` does.
//! * The scheduler may let two threads take turns on one processor beside an idle one, for a tenth
//!   of a second or for a whole run. A `Team` that uses all processors binds each thread to one of
//!   them.
//! * Cores share the path to memory. If vectors do not stay in caches, the number of reads and
//!   writes limits the speed, whatever the number of threads.
//!
//! The table shows the gain of two threads over one for IMEX Euler on 316 × 316 particles: medians
//! of eight pairs, in two series on two shared cores of a Zen 5. The threads were not bound to
//! processors.
//!
//! | bands per thread | threads sleep | threads stay awake |
//! |---|---|---|
//! | 1 | 1.35, 1.66 | 1.26, 1.77 |
//! | 4 | 1.39, 1.87 | 1.96, 2.02 |
//!
//! The bench `threads` measures the gain beside the limit of the machine.

use crate::vector::BLOCK;
use std::ops::Range;

/// Fewest particles that threads share. A sweep takes about a nanosecond per particle, and waking
/// another thread takes some microseconds. Half of a sweep over this many particles takes longer
/// than that.
pub const LEAST_FOR_THREADS: usize = 16_384;
/// Bands for each thread, given enough particles.
pub const BANDS_PER_THREAD: usize = 4;
/// Fewest particles of a band, if there is more than one.
const LEAST_OF_A_BAND: usize = 4096;

/// Number of bands for `threads` and `particles`; 1 if either is too small.
pub fn bands(threads: usize, particles: usize) -> usize {
    bands_of(threads, particles, 0)
}

/// As [`bands`], if no band should have fewer than `least` particles.
pub fn bands_of(threads: usize, particles: usize, least: usize) -> usize {
    if threads < 2 || particles < LEAST_FOR_THREADS {
        return 1;
    }
    let most = particles / LEAST_OF_A_BAND.max(least);
    (BANDS_PER_THREAD * threads).min(most).max(1)
}

/// Memory that a sweep writes, and that can be split between blocks.
pub trait Divisible: Send + Sized {
    /// Splits off the part of the first `blocks` blocks of particles; returns it and the rest.
    fn split(self, blocks: usize) -> (Self, Self);
}

/// One item per particle.
impl<T: Send> Divisible for &mut [T] {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        self.split_at_mut(blocks * BLOCK)
    }
}

/// One item a block of particles.
#[derive(Debug)]
pub struct PerBlock<'a, T>(pub &'a mut [T]);

impl<T: Send> Divisible for PerBlock<'_, T> {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        let (left, right) = self.0.split_at_mut(blocks);
        (Self(left), Self(right))
    }
}

/// Splits each of some slices, as the planes of a vector, before the item `at`; a shorter one stays
/// whole.
pub fn split_each<T, const N: usize>(slices: [&mut [T]; N], at: usize) -> [[&mut [T]; N]; 2] {
    let mut others = [(); N].map(|()| <&mut [T]>::default());
    let mut places = others.iter_mut();
    let slices = slices.map(|slice| {
        let (slice, other) = slice.split_at_mut(at.min(slice.len()));
        if let Some(place) = places.next() {
            *place = other;
        }
        slice
    });
    [slices, others]
}

impl<A: Divisible, B: Divisible> Divisible for (A, B) {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        let (a, b) = (self.0.split(blocks), self.1.split(blocks));
        ((a.0, b.0), (a.1, b.1))
    }
}

impl<A: Divisible, B: Divisible, C: Divisible> Divisible for (A, B, C) {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        let (a, b, c) = (self.0.split(blocks), self.1.split(blocks), self.2.split(blocks));
        ((a.0, b.0, c.0), (a.1, b.1, c.1))
    }
}

impl<A: Divisible, B: Divisible, C: Divisible, D: Divisible> Divisible for (A, B, C, D) {
    #[inline]
    fn split(self, blocks: usize) -> (Self, Self) {
        let ((a, b), (c, d)) = ((self.0, self.1).split(blocks), (self.2, self.3).split(blocks));
        ((a.0, a.1, c.0, c.1), (b.0, b.1, d.0, d.1))
    }
}

/// Splits `particles` and `part` into [`bands`] and passes each band to `sweep`, on the current
/// [`rayon`] pool. The caller runs a single band itself, without the pool. This function allocates
/// nothing.
///
/// ```
/// use drape_kernels::bands::in_bands;
/// let mut squares = vec![0; 1000];
/// in_bands(3, 1000, &mut squares[..], &|particles, squares: &mut [usize]| {
///     for (i, square) in particles.zip(squares) {
///         *square = i * i;
///     }
/// });
/// assert_eq!(squares[999], 999 * 999);
/// ```
pub fn in_bands<P: Divisible>(
    bands: usize,
    particles: usize,
    part: P,
    sweep: &(impl Fn(Range<usize>, P) + Sync),
) {
    cut(bands, 0..particles, BLOCK, part, sweep);
}

/// As [`in_bands`], for items that are not particles and can be split anywhere. `part` is split at
/// a number of items.
pub fn in_items<P: Divisible>(
    bands: usize,
    items: usize,
    part: P,
    sweep: &(impl Fn(Range<usize>, P) + Sync),
) {
    cut(bands, 0..items, 1, part, sweep);
}

fn cut<P: Divisible>(
    bands: usize,
    items: Range<usize>,
    block: usize,
    part: P,
    sweep: &(impl Fn(Range<usize>, P) + Sync),
) {
    let blocks = items.len().div_ceil(block);
    if bands < 2 || blocks < 2 {
        return sweep(items, part);
    }
    let few = bands / 2;
    let before = (blocks * few / bands).max(1);
    let (left, right) = part.split(before);
    let middle = items.start + before * block;
    rayon::join(
        || cut(few, items.start..middle, block, left, sweep),
        || cut(bands - few, middle..items.end, block, right, sweep),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_neither_short_nor_many() {
        assert_eq!(bands(1, 1_000_000), 1);
        assert_eq!(bands(8, LEAST_FOR_THREADS - 1), 1);
        assert_eq!(bands(2, LEAST_FOR_THREADS), 4);
        assert_eq!(bands(2, 100_000), 8);
        assert_eq!(bands(64, 100_000), 24);
        assert_eq!(bands_of(8, 100_000, 30_000), 3);
        assert_eq!(bands_of(8, 100_000, 1_000_000), 1);
    }
}
