//! A column of the exponential of a small matrix, by Taylor series over parts of the way on which
//! the matrix is small. Unlike a full exponential it takes products with vectors only.

use drape_solvers::lanes::{Four, Lanes, four_wide, vectorised};
use drape_solvers::vector::SLOTS;

/// Most terms of a Taylor series; `4⁵⁰/50!` is far below round-off.
const MAX_TERMS: u32 = 50;
/// Rows of a product that are summed at the same time, each from the first column to the last.
const ROWS: usize = 16;

/// The upper Hessenberg matrix `H` by columns, with zeros below, and the vectors of a series.
#[derive(Debug)]
pub(crate) struct Series {
    /// Numbers of a column, a multiple of [`ROWS`].
    stride: usize,
    columns: Vec<f64>,
    /// A column of the exponential, a term of its series, and the next one.
    small: [Vec<f64>; 3],
}

impl Series {
    /// For matrices of up to `most` columns.
    pub(crate) fn new(most: usize) -> Self {
        let stride = (most + 3).next_multiple_of(ROWS);
        let numbers = || vec![0.0; stride];
        Self { stride, columns: vec![0.0; stride * most], small: [numbers(), numbers(), numbers()] }
    }

    /// Column `j` of `H`. Its rows beyond `j + 1` must remain 0.
    pub(crate) fn column(&mut self, j: usize) -> &mut [f64] {
        &mut self.columns[j * self.stride..][..self.stride]
    }

    /// Element `H_ij`.
    pub(crate) fn element(&self, i: usize, j: usize) -> f64 {
        self.columns[j * self.stride + i]
    }

    /// The greatest sum of a column's absolute values among the first `m` rows and columns.
    pub(crate) fn norm(&self, m: usize) -> f64 {
        let column = |j: usize| &self.columns[j * self.stride..][..m.min(j + 2)];
        (0..m).map(|j| column(j).iter().map(|a| a.abs()).sum::<f64>()).fold(0.0, f64::max)
    }

    /// The last column of
    ///
    /// ```text
    ///     [hH e₁ 0]
    /// exp [0  0  1]
    ///     [0  0  0]
    /// ```
    ///
    /// with the first `m` rows and columns of `H` and `k` more, in so many parts. For `k = 2` it is
    /// `(φ₂(hH) e₁, 1, 1)`.
    pub(crate) fn last_column(&mut self, [m, k]: [usize; 2], h: f64, parts: u64) -> &[f64] {
        let Self { stride, columns, small } = self;
        vectorised!(four_wide(), [four,
            shape: [usize; 3] = [m, m + k, *stride],
            columns: &'k [f64] = columns,
            h: f64 = h,
            parts: u64 = parts,
            small: &'k mut [Vec<f64>; 3] = small,
        ] -> () {
            sum_parts(four, shape, columns, h, parts, small);
        });
        &self.small[0][..m]
    }
}

#[inline(always)]
fn sum_parts<F: Four>(
    four: F,
    [m, n, stride]: [usize; 3],
    columns: &[f64],
    h: f64,
    parts: u64,
    [sum, term, next]: &mut [Vec<f64>; 3],
) {
    let scale = 1.0 / parts as f64;
    sum[..n].fill(0.0);
    sum[n - 1] = 1.0;
    for _ in 0..parts {
        term[..n].copy_from_slice(&sum[..n]);
        for power in 1..=MAX_TERMS {
            multiply(four, columns, stride, h, &term[..m], next);
            next[0] += term[m];
            next[m..n - 1].copy_from_slice(&term[m + 1..n]);
            next[n - 1] = 0.0;
            let factor = scale / f64::from(power);
            let [largest, change] =
                add_term(four, factor, &next[..n], &mut term[..n], &mut sum[..n]);
            if change <= 0.25 * f64::EPSILON * largest {
                break;
            }
        }
    }
}

/// `next = h H term` for as many columns as `term` has numbers. Writes whole groups of [`ROWS`].
/// Where a term overflows, the zeros below `H` make NaN of it. Such a subspace serves no step of
/// this length.
#[inline(always)]
fn multiply<F: Four>(
    four: F,
    columns: &[f64],
    stride: usize,
    h: f64,
    term: &[f64],
    next: &mut [f64],
) {
    let rows_of_next = next.as_chunks_mut::<ROWS>().0;
    for (group, next) in rows_of_next.iter_mut().enumerate().take(term.len().div_ceil(ROWS)) {
        let top = ROWS * group;
        // Columns further left are 0 here.
        let first = top.saturating_sub(1);
        let mut sums = [four.splat(0.0); ROWS / SLOTS];
        for (column, term) in columns.chunks_exact(stride).zip(term).skip(first) {
            let weight = four.splat(h * term);
            let rows = column[top..top + ROWS].as_chunks::<SLOTS>().0;
            for (sum, a) in sums.iter_mut().zip(rows) {
                *sum = four.add(*sum, four.mul(four.load(*a), weight));
            }
        }
        for (next, sum) in next.as_chunks_mut::<SLOTS>().0.iter_mut().zip(sums) {
            *next = four.store(sum);
        }
    }
}

/// `term = factor · next`, which is added to `sum`. Returns the greatest absolute values of `sum`
/// and `term`.
#[inline(always)]
fn add_term<F: Four>(
    four: F,
    factor: f64,
    next: &[f64],
    term: &mut [f64],
    sum: &mut [f64],
) -> [f64; 2] {
    let (next, next_rest) = next.as_chunks::<SLOTS>();
    let (term, term_rest) = term.as_chunks_mut::<SLOTS>();
    let (sum, sum_rest) = sum.as_chunks_mut::<SLOTS>();
    let by = four.splat(factor);
    let (mut largest, mut change) = (four.splat(0.0), four.splat(0.0));
    for ((next, term), sum) in next.iter().zip(term).zip(sum) {
        let product = four.mul(four.load(*next), by);
        let total = four.add(four.load(*sum), product);
        (*term, *sum) = (four.store(product), four.store(total));
        let (size, part) = (four.abs(total), four.abs(product));
        largest = four.where_at_most(largest, size, size, largest);
        change = four.where_at_most(change, part, part, change);
    }
    let (mut largest, mut change) = (greatest(four.store(largest)), greatest(four.store(change)));
    for ((next, term), sum) in next_rest.iter().zip(term_rest).zip(sum_rest) {
        *term = next * factor;
        *sum += *term;
        (largest, change) = (largest.max(sum.abs()), change.max(term.abs()));
    }
    [largest, change]
}

#[inline(always)]
fn greatest([a, b, c, d]: Lanes) -> f64 {
    a.max(b).max(c.max(d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_oracle::Random;

    /// The column one number after the other.
    fn readable(
        h: f64,
        parts: u64,
        [m, k]: [usize; 2],
        element: impl Fn(usize, usize) -> f64,
    ) -> Vec<f64> {
        let n = m + k;
        let mut sum = vec![0.0; n];
        sum[n - 1] = 1.0;
        for _ in 0..parts {
            let mut term = sum.clone();
            for power in 1..=MAX_TERMS {
                let mut next = vec![0.0; n];
                for j in 0..m {
                    for i in 0..m.min(j + 2) {
                        next[i] += element(i, j) * (h * term[j]);
                    }
                }
                next[0] += term[m];
                next[m..n - 1].copy_from_slice(&term[m + 1..n]);
                let factor = 1.0 / parts as f64 / f64::from(power);
                let (mut largest, mut change) = (0.0_f64, 0.0_f64);
                for i in 0..n {
                    term[i] = next[i] * factor;
                    sum[i] += term[i];
                    (largest, change) = (largest.max(sum[i].abs()), change.max(term[i].abs()));
                }
                if change <= 0.25 * f64::EPSILON * largest {
                    break;
                }
            }
        }
        sum.truncate(m);
        sum
    }

    #[test]
    fn the_fast_form_gives_the_bits_of_the_readable_one() {
        let mut random = Random::new(11);
        let mut series = Series::new(50);
        for m in (1..20).chain([31, 32, 33, 48, 50]).rev() {
            for j in 0..m {
                // The last column has a number below the matrix.
                series.column(j)[..j + 2].fill_with(|| random.between(-1.0, 1.0));
            }
            for k in [2, 3] {
                let expected = readable(0.7, 5, [m, k], |i, j| series.element(i, j));
                let found = series.last_column([m, k], 0.7, 5);
                let bits =
                    |numbers: &[f64]| numbers.iter().map(|a| a.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&expected), bits(found), "{m} {k}");
            }
        }
    }
}
