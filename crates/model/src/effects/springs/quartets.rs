//! Four springs at a time, in the order of the list, for forces that no sweep takes: curves.
//!
//! The springs are copied in chunks. Registers hold one number of four springs, and each number has
//! the order of operations of the readable form, [`Kernel::one`]. The forces are added one after
//! the other. So both forms give the same bits.

use super::Spring;
use crate::Vec3;
use drape_kernels::lanes::{Four, Lanes, Plain, Wide, four_wide};
use drape_kernels::triples::{Triple, Triples, add_in_turn};
use drape_kernels::vector::SLOTS;
use pulp::{Simd, WithSimd};

/// Springs of a chunk.
const CHUNK: usize = 64;

/// A force `−f` on the first end of each spring, and `f` on the other.
pub(crate) trait Kernel {
    /// `f` of a spring, by its place in the list, N.
    fn one(&self, spring: &Spring, place: usize) -> Vec3;

    /// `f` of four springs, from this place on; `None` where one of them takes the readable form.
    fn four<F: Four>(&self, four: F, springs: &Quartet, place: usize) -> Option<Triple<F>>;
}

/// Four springs, number by number.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Quartet {
    /// The first ends, then the second ones.
    pub(crate) ends: [[usize; SLOTS]; 2],
    pub(crate) rest: Lanes,
    pub(crate) stiffness: Lanes,
}

impl Quartet {
    fn new([a, b, c, d]: &[Spring; SLOTS]) -> Self {
        Self {
            ends: [
                [a.i as usize, b.i as usize, c.i as usize, d.i as usize],
                [a.j as usize, b.j as usize, c.j as usize, d.j as usize],
            ],
            rest: [a.rest_length, b.rest_length, c.rest_length, d.rest_length],
            stiffness: [a.stiffness, b.stiffness, c.stiffness, d.stiffness],
        }
    }

    /// `x_i − x_j` of each spring.
    #[inline(always)]
    pub(crate) fn difference<F: Four>(&self, four: F, x: &[Vec3]) -> Triple<F> {
        four.minus(four.gather(x, self.ends[0]), four.gather(x, self.ends[1]))
    }
}

/// Adds the forces of springs, N; `each` visits them in the order of the list.
pub(crate) fn add<K: Kernel>(
    each: impl FnOnce(&mut dyn FnMut(&Spring)),
    kernel: &K,
    out: &mut [Vec3],
) {
    let empty = Spring { i: 0, j: 0, rest_length: 0.0, stiffness: 0.0, damping: 0.0 };
    let (mut springs, mut count, mut first) = ([empty; CHUNK], 0, 0);
    each(&mut |spring| {
        springs[count] = *spring;
        count += 1;
        if count == CHUNK {
            four_wide().dispatch(Chunk { springs: &springs, first, kernel, out });
            (count, first) = (0, first + CHUNK);
        }
    });
    four_wide().dispatch(Chunk { springs: &springs[..count], first, kernel, out });
}

/// As [`add`], one spring after the other.
#[cfg(test)]
pub(crate) fn add_reference<K: Kernel>(
    each: impl FnOnce(&mut dyn FnMut(&Spring)),
    kernel: &K,
    out: &mut [Vec3],
) {
    let mut first = 0;
    each(&mut |spring| {
        Chunk { springs: &[*spring], first, kernel, out }.reference();
        first += 1;
    });
}

/// Springs from a place of the list on.
struct Chunk<'a, K> {
    springs: &'a [Spring],
    first: usize,
    kernel: &'a K,
    out: &'a mut [Vec3],
}

impl<K: Kernel> Chunk<'_, K> {
    fn reference(self) {
        for (place, spring) in (self.first..).zip(self.springs) {
            let (i, j) = spring.ends();
            let f = self.kernel.one(spring, place);
            self.out[i] -= f;
            self.out[j] += f;
        }
    }

    #[inline(always)]
    fn fast<F: Four>(self, four: F) {
        let Self { springs, mut first, kernel, out } = self;
        let (groups, rest) = springs.as_chunks();
        for group in groups {
            let quartet = Quartet::new(group);
            match kernel.four(four, &quartet, first) {
                Some(f) => {
                    let opposite = [four.neg(f[0]), four.neg(f[1]), four.neg(f[2])];
                    add_in_turn(quartet.ends, &[four.apart(opposite), four.apart(f)], out);
                }
                None => Chunk { springs: group, first, kernel, out }.reference(),
            }
            first += SLOTS;
        }
        Chunk { springs: rest, first, kernel, out }.reference();
    }
}

impl<K: Kernel> WithSimd for Chunk<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::F64_LANES == SLOTS { self.fast(Wide(simd)) } else { self.fast(Plain) }
    }
}
