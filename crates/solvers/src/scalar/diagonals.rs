//! A symmetric scalar matrix by diagonals: for patterns whose entries (i, j) have few offsets j − i.
//!
//! The mesh of a regular sheet, numbered row by row, has the offsets 1 and one row, with diagonal
//! springs also one row ± 1. Then a product needs no column indices, each entry serves twice, and
//! consecutive rows read consecutive numbers: the loop over rows is a SIMD loop.

use super::simd::Four;
use super::soa::{Block, Padded, ROWS, Rows};
use crate::ScalarMatrix;
use crate::vector::SLOTS;
use std::array::from_fn;

/// Most offsets above the diagonal.
pub(super) const MOST_OFFSETS: usize = 8;

/// The diagonal and the upper diagonals of a symmetric matrix, zero where the pattern has no entry.
#[derive(Debug)]
pub(super) struct Diagonals {
    n: usize,
    /// Offsets of the upper diagonals, increasing.
    offsets: Vec<usize>,
    diagonal: Padded,
    /// Entry (i, i + offset) at place `i` of its diagonal.
    upper: Vec<Padded>,
}

impl Diagonals {
    /// Room for the entries of `a`, or `None` when its pattern has more than [`MOST_OFFSETS`] offsets or
    /// fills less than two thirds of its diagonals.
    pub(super) fn new(a: &ScalarMatrix) -> Option<Self> {
        let n = a.n();
        let mut offsets: Vec<usize> = Vec::with_capacity(MOST_OFFSETS + 1);
        for i in 0..n {
            for &j in a.row(i).0 {
                let Some(offset) = (j as usize).checked_sub(i).filter(|&offset| offset > 0) else {
                    continue;
                };
                if let Err(place) = offsets.binary_search(&offset) {
                    offsets.insert(place, offset);
                    if offsets.len() > MOST_OFFSETS {
                        return None;
                    }
                }
            }
        }
        let filled = (a.nonzeros() - n) / 2;
        if 3 * filled < 2 * n * offsets.len() {
            return None;
        }
        let reach = offsets.last().copied().unwrap_or(0);
        Some(Self {
            n,
            diagonal: Padded::zeros(n, 0),
            upper: offsets.iter().map(|_| Padded::zeros(n, reach)).collect(),
            offsets,
        })
    }

    /// Takes over the values of `a`, which has the pattern that this was made for.
    pub(super) fn update(&mut self, a: &ScalarMatrix) {
        for i in 0..self.n {
            let (columns, values) = a.row(i);
            let mut d = 0;
            for (&j, &value) in columns.iter().zip(values) {
                let j = j as usize;
                if j == i {
                    self.diagonal.rows_mut()[i] = value;
                } else if j > i {
                    while self.offsets[d] != j - i {
                        d += 1;
                    }
                    self.upper[d].rows_mut()[i] = value;
                }
            }
        }
    }

    /// Number of rows.
    pub(super) fn n(&self) -> usize {
        self.n
    }

    /// The farthest row that a row is coupled to.
    pub(super) fn reach(&self) -> usize {
        self.offsets.last().copied().unwrap_or(0)
    }

    /// `out ← A x` in the `len` rows from `first`; each row is summed from its first column to its last.
    #[inline(always)]
    pub(super) fn multiply(
        &self,
        four: impl Four,
        x: Rows<'_>,
        first: usize,
        len: usize,
        out: &mut Block,
    ) {
        match self.offsets.len() {
            0 => self.multiply_by::<0>(four, x, first, len, out),
            1 => self.multiply_by::<1>(four, x, first, len, out),
            2 => self.multiply_by::<2>(four, x, first, len, out),
            3 => self.multiply_by::<3>(four, x, first, len, out),
            4 => self.multiply_by::<4>(four, x, first, len, out),
            5 => self.multiply_by::<5>(four, x, first, len, out),
            6 => self.multiply_by::<6>(four, x, first, len, out),
            7 => self.multiply_by::<7>(four, x, first, len, out),
            _ => self.multiply_by::<8>(four, x, first, len, out),
        }
    }

    /// [`multiply`](Self::multiply) with `D` offsets, by pieces of a length that the compiler knows.
    #[inline(always)]
    fn multiply_by<const D: usize>(
        &self,
        four: impl Four,
        x: Rows<'_>,
        first: usize,
        len: usize,
        out: &mut Block,
    ) {
        const LONG: usize = 4 * ROWS;
        let mut done = 0;
        while done + LONG <= len {
            self.multiply_piece::<D, LONG>(four, x, first + done, out.piece(done));
            done += LONG;
        }
        while done + ROWS <= len {
            self.multiply_piece::<D, ROWS>(four, x, first + done, out.piece(done));
            done += ROWS;
        }
    }

    /// `C` rows from `first`.
    #[inline(always)]
    fn multiply_piece<const D: usize, const C: usize>(
        &self,
        four: impl Four,
        x: Rows<'_>,
        first: usize,
        out: [&mut [f64; C]; 3],
    ) {
        let first = first as isize;
        let offset = |d: usize| self.offsets[d] as isize;
        let below: [&[f64; C]; D] = from_fn(|d| self.upper[d].piece(first - offset(d)));
        let above: [&[f64; C]; D] = from_fn(|d| self.upper[d].piece(first));
        let diagonal: &[f64; C] = self.diagonal.piece(first);
        let x_below: [[&[f64; C]; D]; 3] = from_fn(|k| from_fn(|d| x.piece(k, first - offset(d))));
        let x_above: [[&[f64; C]; D]; 3] = from_fn(|k| from_fn(|d| x.piece(k, first + offset(d))));
        let x: [&[f64; C]; 3] = from_fn(|k| x.piece(k, first));
        for g in 0..C / SLOTS {
            let at = |numbers: &[f64; C]| four.load(from_fn(|s| numbers[SLOTS * g + s]));
            let mut sums = [four.splat(0.0); 3];
            for d in (0..D).rev() {
                let value = at(below[d]);
                for k in 0..3 {
                    sums[k] = four.add(sums[k], four.mul(value, at(x_below[k][d])));
                }
            }
            let value = at(diagonal);
            for k in 0..3 {
                sums[k] = four.add(sums[k], four.mul(value, at(x[k])));
            }
            for d in 0..D {
                let value = at(above[d]);
                for k in 0..3 {
                    sums[k] = four.add(sums[k], four.mul(value, at(x_above[k][d])));
                }
            }
            for k in 0..3 {
                let sum = four.store(sums[k]);
                (0..SLOTS).for_each(|s| out[k][SLOTS * g + s] = sum[s]);
            }
        }
    }
}
