//! One array ("plane") per coordinate, so that neighbouring particles fill a vector register.

use crate::lanes::WIDEST;
use std::fmt;

/// Distance between two planes with room for `len` numbers.
///
/// It is a number of whole memory pages plus five cache lines. Otherwise the same index in all
/// planes would map to the same cache set.
pub const fn stride(len: usize) -> usize {
    len.next_multiple_of(512) + 40
}

/// Splits the vectors in `from` into one plane per coordinate, `stride` apart.
#[inline(always)]
pub fn split(planes: &mut [f64], stride: usize, from: &[f64]) {
    let (x, rest) = planes.split_at_mut(stride);
    let (y, z) = rest.split_at_mut(stride);
    let m = from.len() / 3;
    split_three(&mut x[..m], &mut y[..m], &mut z[..m], from);
}

#[inline(always)]
fn split_three(x: &mut [f64], y: &mut [f64], z: &mut [f64], from: &[f64]) {
    for (((x, y), z), from) in x.iter_mut().zip(y).zip(z).zip(from.as_chunks::<3>().0) {
        (*x, *y, *z) = (from[0], from[1], from[2]);
    }
}

/// The inverse of [`split`]: as many vectors as `to` has room for.
#[inline(always)]
pub fn join(planes: &[f64], stride: usize, to: &mut [f64]) {
    let m = to.len() / 3;
    join_three(&planes[..m], &planes[stride..][..m], &planes[2 * stride..][..m], to);
}

#[inline(always)]
fn join_three(x: &[f64], y: &[f64], z: &[f64], to: &mut [f64]) {
    for (((x, y), z), to) in x.iter().zip(y).zip(z).zip(to.as_chunks_mut::<3>().0) {
        *to = [*x, *y, *z];
    }
}

/// The particles that three planes show at a time.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The particle at place 0; it may lie before the first one.
    pub first: isize,
    /// Number of places.
    pub len: usize,
    /// Number of leading places whose data the planes already hold, [`moved`](Self::moved) places
    /// further on.
    pub kept: usize,
    /// Number of places by which the planes move.
    pub moved: usize,
}

impl Frame {
    /// Fills three planes, `stride` apart, with the coordinates in `from`, three numbers per
    /// particle. Places before the first particle and behind the last one get zeros.
    #[inline(always)]
    pub fn read(self, planes: &mut [f64], stride: usize, from: &[f64]) {
        let Self { first, len, kept, moved } = self;
        let n = from.len() / 3;
        let before = first.min(0).unsigned_abs();
        for plane in planes.chunks_exact_mut(stride) {
            if kept > 0 {
                plane.copy_within(moved..moved + kept, 0);
            } else {
                plane[..before].fill(0.0);
            }
        }
        let particle = |place: usize| (first + place as isize) as usize;
        let place = |particle: usize| (particle as isize - first) as usize;
        let there = particle(kept.max(before)).min(n);
        let end = particle(len).min(n).max(there);
        split(&mut planes[place(there)..], stride, &from[3 * there..3 * end]);
        for plane in planes.chunks_exact_mut(stride) {
            plane[place(end)..len].fill(0.0);
        }
    }
}

/// Numbers that begin at a cache line, so that a register of eight is read from one line.
#[derive(Default)]
pub struct Aligned {
    memory: Vec<f64>,
    start: usize,
    len: usize,
}

impl Aligned {
    /// `len` zeros, after unused memory for `lead` numbers.
    pub fn zeros(lead: usize, len: usize) -> Self {
        let memory = vec![0.0; lead + len + WIDEST - 1];
        let bytes = size_of::<[f64; WIDEST]>();
        let aligned = memory[lead..].as_ptr().align_offset(bytes).min(WIDEST - 1);
        Self { memory, start: lead + aligned, len }
    }

    /// How many numbers there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The numbers.
    #[inline(always)]
    pub fn all(&self) -> &[f64] {
        &self.memory[self.start..][..self.len]
    }

    /// The numbers, to be written.
    #[inline(always)]
    pub fn all_mut(&mut self) -> &mut [f64] {
        &mut self.memory[self.start..][..self.len]
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Self {
        let mut copy = Self::zeros(0, self.len);
        copy.all_mut().copy_from_slice(self.all());
        copy
    }
}

impl fmt::Debug for Aligned {
    /// The place in memory differs from run to run and is left out.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Aligned").field("len", &self.len).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_shows_its_particles_and_zeros_around_them() {
        let stride = 64;
        for n in [0, 1, 5, 20, 47] {
            let from: Vec<f64> = (0..3 * n).map(|k| 1.0 + k as f64).collect();
            let mut planes = vec![f64::NAN; 3 * stride];
            for (step, begin) in (0..n.max(1)).step_by(16).enumerate() {
                let first = begin as isize - 8;
                let kept = if step == 0 { 0 } else { 20 };
                Frame { first, len: 36, kept, moved: 16 }.read(&mut planes, stride, &from);
                for (place, axis) in (0..36).flat_map(|place| (0..3).map(move |a| (place, a))) {
                    let particle = usize::try_from(first + place as isize).ok().filter(|i| *i < n);
                    let expected = particle.map_or(0.0, |i| from[3 * i + axis]);
                    assert_eq!(planes[axis * stride + place], expected, "{n} {begin} {place}");
                }
            }
            let (mut split_back, m) = (vec![0.0; 3 * n], n.min(stride));
            split(&mut planes, stride, &from[..3 * m]);
            join(&planes, stride, &mut split_back[..3 * m]);
            assert_eq!(split_back[..3 * m], from[..3 * m]);
        }
    }

    #[test]
    fn aligned_numbers_begin_a_cache_line() {
        for (lead, len) in [(0, 0), (0, 5), (3, 17)] {
            let mut numbers = Aligned::zeros(lead, len);
            numbers.all_mut().fill(2.0);
            for numbers in [&numbers, &numbers.clone()] {
                assert_eq!(numbers.all(), vec![2.0; len]);
                assert!(numbers.is_empty() || numbers.all().as_ptr().addr().is_multiple_of(64));
            }
        }
    }
}
