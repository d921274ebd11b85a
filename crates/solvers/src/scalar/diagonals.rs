//! A symmetric scalar matrix by diagonals, for patterns whose entries (i, j) have few offsets j −
//! i.
//!
//! The mesh of a regular sheet, numbered row by row, has the offsets 1 and one row; with diagonal
//! springs also one row ± 1. Then a product needs no column indices, each entry serves twice, and
//! consecutive rows read consecutive numbers: the loop over rows is a SIMD loop.

use super::soa::{PaddedRow, ROWS, Rows};
use crate::ScalarMatrix;
use crate::vector::SLOTS;
use drape_kernels::lanes::Four;
use std::array::from_fn;

/// Most offsets above the diagonal.
pub(super) const MOST_OFFSETS: usize = 8;

/// The diagonal and the upper diagonals of a symmetric matrix, zero where the pattern has no entry.
#[derive(Debug)]
pub(super) struct Diagonals {
    n: usize,
    /// Offsets of the upper diagonals, increasing.
    offsets: Vec<usize>,
    diagonal: PaddedRow,
    /// Entry (i, i + offset) at place `i` of its diagonal.
    upper: Vec<PaddedRow>,
}

/// The receiver of a product.
pub(super) trait Put<F: Four> {
    /// Takes the product in group `g` of the rows, coordinate by coordinate, and the multiplied
    /// vector.
    fn put(&mut self, four: F, g: usize, x: [F::Numbers; 3], product: [F::Numbers; 3]);
}

impl Diagonals {
    /// Room for the entries of `a`. `None` when its pattern has more than [`MOST_OFFSETS`] offsets
    /// or fills less than two thirds of its diagonals.
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
            diagonal: PaddedRow::zeros(n, 0),
            upper: offsets.iter().map(|_| PaddedRow::zeros(n, reach)).collect(),
            offsets,
        })
    }

    /// Copies the values of `a`, which must have the pattern given to [`new`](Self::new).
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

    /// `A x` in the `len` rows from `first`; each row is summed from its first column to its last.
    /// `put` gets all groups of rows.
    #[inline(always)]
    pub(super) fn multiply<F: Four>(
        &self,
        four: F,
        x: Rows<'_>,
        (first, len): (usize, usize),
        put: &mut impl Put<F>,
    ) {
        match self.offsets.len() {
            0 => self.multiply_by::<0, F>(four, x, (first, len), put),
            1 => self.multiply_by::<1, F>(four, x, (first, len), put),
            2 => self.multiply_by::<2, F>(four, x, (first, len), put),
            3 => self.multiply_by::<3, F>(four, x, (first, len), put),
            4 => self.multiply_by::<4, F>(four, x, (first, len), put),
            5 => self.multiply_by::<5, F>(four, x, (first, len), put),
            6 => self.multiply_by::<6, F>(four, x, (first, len), put),
            7 => self.multiply_by::<7, F>(four, x, (first, len), put),
            _ => self.multiply_by::<8, F>(four, x, (first, len), put),
        }
    }

    /// [`multiply`](Self::multiply) with `D` offsets, by pieces of constant length.
    #[inline(always)]
    fn multiply_by<const D: usize, F: Four>(
        &self,
        four: F,
        x: Rows<'_>,
        (first, len): (usize, usize),
        put: &mut impl Put<F>,
    ) {
        const LONG: usize = 4 * ROWS;
        let mut done = 0;
        while done + LONG <= len {
            self.multiply_piece::<D, LONG, F>(four, x, (first, done), put);
            done += LONG;
        }
        while done + ROWS <= len {
            self.multiply_piece::<D, ROWS, F>(four, x, (first, done), put);
            done += ROWS;
        }
    }

    /// `C` rows, at this distance after `first`.
    #[inline(always)]
    fn multiply_piece<const D: usize, const C: usize, F: Four>(
        &self,
        four: F,
        x: Rows<'_>,
        (first, done): (usize, usize),
        put: &mut impl Put<F>,
    ) {
        let first = (first + done) as isize;
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
            let (value, x) = (at(diagonal), x.map(at));
            for k in 0..3 {
                sums[k] = four.add(sums[k], four.mul(value, x[k]));
            }
            for d in 0..D {
                let value = at(above[d]);
                for k in 0..3 {
                    sums[k] = four.add(sums[k], four.mul(value, at(x_above[k][d])));
                }
            }
            put.put(four, done / SLOTS + g, x, sums);
        }
    }
}
