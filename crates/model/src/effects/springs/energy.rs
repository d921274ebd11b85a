//! The energy of springs along diagonals, with the bits of a loop over the springs.
//!
//! A root takes as long as ten sums, but the sum of the energies must be taken in order. So the
//! energies of a chunk of springs are computed first, several in a register, and then added.

use super::diagonals::{Diagonal, Diagonals, MAX_DIAGONALS};
use crate::Vec3;
use drape_kernels::lanes::vectorised;

/// Particles of a chunk.
const CHUNK: usize = 64;

/// `Σ ½ k (L − ℓ)²`, J, spring by spring in their order.
pub(super) fn sum(springs: &Diagonals, x: &[Vec3]) -> f64 {
    vectorised!(pulp::Arch::new(), [_four,
        springs: &'k Diagonals = springs,
        x: &'k [Vec3] = x,
    ] -> f64 { sum_in_chunks(springs, x) })
}

#[inline(always)]
fn sum_in_chunks(springs: &Diagonals, x: &[Vec3]) -> f64 {
    let mut sum = -0.0;
    let mut energies = [[0.0; CHUNK]; MAX_DIAGONALS];
    for first in (0..springs.particles).step_by(CHUNK) {
        let count = CHUNK.min(springs.particles - first);
        for (diagonal, energies) in springs.list.iter().zip(&mut energies) {
            write(diagonal, first, count, x, energies);
        }
        let energies = &energies[..springs.list.len()];
        for n in 0..count {
            // The energy of an absent spring is 0, which changes no bit of a sum.
            for own in energies {
                sum += own[n];
            }
        }
    }
    sum
}

/// Writes the energies of the springs of a diagonal that begin at `count` particles from `first` on,
/// J; 0 for absent ones.
#[inline(always)]
fn write(diagonal: &Diagonal, first: usize, count: usize, x: &[Vec3], out: &mut [f64; CHUNK]) {
    let far = x.get(first + diagonal.offset..).unwrap_or_default();
    let mut squares = [0.0; CHUNK];
    for ((square, a), b) in squares[..count].iter_mut().zip(&x[first..]).zip(far) {
        *square = (a - b).norm_squared();
    }
    let multiples = &diagonal.multiple[first..first + count];
    for ((out, square), multiple) in out.iter_mut().zip(&squares).zip(multiples) {
        let stretch = square.sqrt() - diagonal.rest_length;
        let stiffness = f64::from(*multiple) * diagonal.stiffness;
        let energy = 0.5 * stiffness * stretch * stretch;
        // Not a product with 0: far ends that are infinitely far away would give NaN.
        *out = if *multiple > 0 { energy } else { 0.0 };
    }
}
