//! For tests: random numbers, and the comparison of two forms of a kernel bit by bit.

use crate::{Mat3, Vec3};
use std::fmt::Debug;

/// A small generator of reproducible numbers (Marsaglia's xorshift).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A generator with a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// Uniform in [-1, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A whole number from 0 to `n − 1`.
    pub fn below(&mut self, n: usize) -> usize {
        (((0.5 * self.unit() + 0.5) * n as f64) as usize).min(n.saturating_sub(1))
    }

    /// `n` numbers.
    pub fn units(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.unit()).collect()
    }

    /// A vector of three numbers.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }

    /// `n` vectors.
    pub fn vectors(&mut self, n: usize) -> Vec<Vec3> {
        (0..n).map(|_| self.vector()).collect()
    }
}

/// Edges of a grid that is numbered row by row: from each node to the nodes so many rows below and
/// columns to the right.
pub fn mesh_edges(rows: usize, columns: usize, steps: &[(usize, isize)]) -> Vec<(usize, usize)> {
    let mut edges = Vec::new();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        for &(down, right) in steps {
            let to = column as isize + right;
            if row + down < rows && (0..columns as isize).contains(&to) {
                edges.push((row * columns + column, (row + down) * columns + to as usize));
            }
        }
    }
    edges
}

/// A value whose bits can be compared, NaN and the sign of zero included.
pub trait Bits {
    /// Appends the bits.
    fn collect_bits(&self, bits: &mut Vec<u64>);

    /// All bits.
    fn bits(&self) -> Vec<u64> {
        let mut bits = Vec::new();
        self.collect_bits(&mut bits);
        bits
    }
}

impl Bits for f64 {
    fn collect_bits(&self, bits: &mut Vec<u64>) {
        bits.push(self.to_bits());
    }
}

impl<T: Bits> Bits for [T] {
    fn collect_bits(&self, bits: &mut Vec<u64>) {
        self.iter().for_each(|item| item.collect_bits(bits));
    }
}

impl<T: Bits, const N: usize> Bits for [T; N] {
    fn collect_bits(&self, bits: &mut Vec<u64>) {
        self.as_slice().collect_bits(bits);
    }
}

impl<T: Bits> Bits for Vec<T> {
    fn collect_bits(&self, bits: &mut Vec<u64>) {
        self.as_slice().collect_bits(bits);
    }
}

impl Bits for Vec3 {
    fn collect_bits(&self, bits: &mut Vec<u64>) {
        self.as_slice().collect_bits(bits);
    }
}

impl Bits for Mat3 {
    fn collect_bits(&self, bits: &mut Vec<u64>) {
        self.as_slice().collect_bits(bits);
    }
}

impl<T: Bits> Bits for Option<T> {
    fn collect_bits(&self, bits: &mut Vec<u64>) {
        bits.push(u64::from(self.is_some()));
        self.iter().for_each(|item| item.collect_bits(bits));
    }
}

impl<A: Bits + ?Sized, B: Bits + ?Sized> Bits for (&A, &B) {
    fn collect_bits(&self, bits: &mut Vec<u64>) {
        self.0.collect_bits(bits);
        self.1.collect_bits(bits);
    }
}

/// Checks that the fast form of a kernel gives the bits of its reference form.
///
/// # Panics
/// If they differ, with the name of the case and the first number that differs.
#[track_caller]
pub fn assert_same_bits<T: Bits + ?Sized>(case: impl Debug, reference: &T, fast: &T) {
    let (reference, fast) = (reference.bits(), fast.bits());
    assert_eq!(reference.len(), fast.len(), "{case:?}: numbers of the reference and the fast form");
    if let Some(at) = (0..fast.len()).find(|&at| reference[at] != fast[at]) {
        let [expected, found] = [reference[at], fast[at]].map(f64::from_bits);
        panic!("{case:?}: number {at} is {found:e}, and {expected:e} in the reference form");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_comparison_sees_zeros_of_another_sign_and_numbers_that_are_none() {
        assert_same_bits("same", &[f64::NAN, -0.0], &[f64::NAN, -0.0]);
        let differs = |a: &[f64], b: &[f64]| {
            std::panic::catch_unwind(|| assert_same_bits("other", a, b)).is_err()
        };
        assert!(differs(&[0.0], &[-0.0]));
        assert!(differs(&[1.0], &[1.0 + f64::EPSILON]));
        assert!(differs(&[1.0], &[1.0, 1.0]));
        assert!(differs(&[f64::NAN], &[-f64::NAN]));
    }
}
