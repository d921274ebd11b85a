//! Sums over a block, in the documented order.

use super::super::soa::{Block, total};
use crate::pcg::Norm;
use crate::vector::SLOTS;
use drape_kernels::lanes::Four;

/// `rᵀr` and `δ = rᵀ P r` of a residual or another vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measure {
    square: f64,
    pub(super) delta: f64,
}

impl Measure {
    pub(super) const ZERO: Self = Self { square: 0.0, delta: 0.0 };
    pub(super) const NAN: Self = Self { square: f64::NAN, delta: f64::NAN };

    /// Adds the blocks' contributions, from the first to the last.
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

/// Partial sums over a block, one for each slot and coordinate.
#[derive(Clone, Copy)]
pub(super) struct Meter<N> {
    squares: [N; 3],
    deltas: [N; 3],
}

impl<N: Copy> Meter<N> {
    #[inline(always)]
    pub(super) fn new(four: impl Four<Numbers = N>) -> Self {
        Self { squares: [four.splat(0.0); 3], deltas: [four.splat(0.0); 3] }
    }

    /// Adds coordinate `k` of a group.
    #[inline(always)]
    pub(super) fn add(&mut self, four: impl Four<Numbers = N>, k: usize, r: N, inverse: N) {
        self.squares[k] = four.add(self.squares[k], four.mul(r, r));
        self.deltas[k] = four.add(self.deltas[k], four.mul(r, four.mul(r, inverse)));
    }

    #[inline(always)]
    pub(super) fn read(&self, four: impl Four<Numbers = N>) -> Measure {
        Measure {
            square: total(&self.squares.map(|sum| four.store(sum))),
            delta: total(&self.deltas.map(|sum| four.store(sum))),
        }
    }
}

/// `rᵀr` and `rᵀ P r` over the rows of a block that `inverse` has.
#[inline(always)]
pub(super) fn measure(four: impl Four, r: &Block, inverse: &[f64]) -> Measure {
    let mut meter = Meter::new(four);
    for (g, &inverse) in inverse.as_chunks().0.iter().enumerate() {
        let inverse = four.load(inverse);
        for k in 0..3 {
            meter.add(four, k, four.load(*r.group(k, g)), inverse);
        }
    }
    meter.read(four)
}

/// `rᵀr` alone, over the first `rows` of a block.
#[inline(always)]
pub(super) fn square(four: impl Four, r: &Block, rows: usize) -> Measure {
    Measure { square: dot(four, r, r.rows(rows)), delta: f64::NAN }
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
