//! Sums over a block, in the documented order.

use super::super::simd::Four;
use super::super::soa::{Block, total};
use crate::pcg::Norm;
use crate::vector::{BLOCK, SLOTS};

/// `rᵀr` and `δ = rᵀ P r`, or that of another vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measure {
    square: f64,
    pub(super) delta: f64,
}

impl Measure {
    pub(super) const ZERO: Self = Self { square: 0.0, delta: 0.0 };
    pub(super) const NAN: Self = Self { square: f64::NAN, delta: f64::NAN };

    /// Adds what the blocks contribute, from the first to the last.
    pub(super) fn sum(blocks: &[Self]) -> Self {
        blocks.iter().fold(Self::ZERO, |sum, block| Self {
            square: sum.square + block.square,
            delta: sum.delta + block.delta,
        })
    }

    pub(super) fn length(&self, norm: Norm) -> f64 {
        match norm {
            Norm::Euclid => self.square.sqrt(),
            Norm::Preconditioned => self.delta.sqrt(),
        }
    }
}

/// `rᵀr` and `rᵀ P r` over the rows of a block that `inverse` has.
#[inline(always)]
pub(super) fn measure(four: impl Four, r: &Block, inverse: &[f64]) -> Measure {
    measure_of(four, inverse, |k, g| four.load(r.0[k].as_chunks::<SLOTS>().0[g]))
}

/// [`measure`] of the vector whose group `g` of coordinate `k` is `r(k, g)`.
#[inline(always)]
pub(super) fn measure_of<F: Four>(
    four: F,
    inverse: &[f64],
    mut r: impl FnMut(usize, usize) -> F::Numbers,
) -> Measure {
    let (mut squares, mut deltas) = ([four.splat(0.0); 3], [four.splat(0.0); 3]);
    let groups = (inverse.len() / SLOTS).min(BLOCK / SLOTS);
    for (g, &inverse) in inverse.as_chunks::<SLOTS>().0[..groups].iter().enumerate() {
        let inverse = four.load(inverse);
        for k in 0..3 {
            let r = r(k, g);
            squares[k] = four.add(squares[k], four.mul(r, r));
            deltas[k] = four.add(deltas[k], four.mul(r, four.mul(r, inverse)));
        }
    }
    Measure {
        square: total(&squares.map(|sum| four.store(sum))),
        delta: total(&deltas.map(|sum| four.store(sum))),
    }
}

/// The dot product over the rows of a block that `b` has.
#[inline(always)]
pub(super) fn dot(four: impl Four, a: &Block, b: [&[f64]; 3]) -> f64 {
    let groups = b[0].len() / SLOTS;
    let a = a.0.each_ref().map(|a| &a.as_chunks::<SLOTS>().0[..groups]);
    let b = b.map(|b| &b.as_chunks::<SLOTS>().0[..groups]);
    let mut sums = [four.splat(0.0); 3];
    for g in 0..groups {
        for k in 0..3 {
            sums[k] = four.add(sums[k], four.mul(four.load(a[k][g]), four.load(b[k][g])));
        }
    }
    total(&sums.map(|sum| four.store(sum)))
}
