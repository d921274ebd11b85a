//! A column of the exponential of a small matrix, by Taylor series over parts of the way on which
//! the matrix is small. Few parts take products with vectors only. Many parts go by squares of the
//! exponential of one part (Moler and Van Loan 2003, method 3).

use drape_solvers::lanes::{Four, Lanes, four_wide, vectorised};
use drape_solvers::vector::SLOTS;

/// Most terms of a Taylor series; `4⁵⁰/50!` is far below round-off.
const MAX_TERMS: u32 = 50;
/// Rows of a product that are summed at the same time, each from the first column to the last.
const ROWS: usize = 16;
/// A part takes about 17 products of a triangle with a vector, so the matrix of one part costs as
/// much as one part for each column, and a square as much as an eighth of that. Squares cost less
/// from about two and a half parts a column on, and a quarter with as many as this. Shorter ways keep
/// the bits that they had by parts.
const PARTS_A_COLUMN: u64 = 8;

/// The upper Hessenberg matrix `H` by columns, with zeros below, and the vectors of a series.
#[derive(Debug)]
pub(crate) struct Series {
    /// Numbers of a column, a multiple of [`ROWS`].
    stride: usize,
    columns: Vec<f64>,
    /// A column of the exponential, a term of its series, and the next one.
    small: [Vec<f64>; 3],
    /// The exponential of some parts by columns, and its square. Empty until they are needed.
    squares: [Vec<f64>; 2],
}

impl Series {
    /// For matrices of up to `most` columns.
    pub(crate) fn new(most: usize) -> Self {
        let stride = (most + 3).next_multiple_of(ROWS);
        let numbers = || vec![0.0; stride];
        let small = [numbers(), numbers(), numbers()];
        Self { stride, columns: vec![0.0; stride * most], small, squares: [Vec::new(), Vec::new()] }
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
    /// with the first `m` rows and columns of `H` and `k` more, in so many parts or more. For `k = 2`
    /// it is `(φ₂(hH) e₁, 1, 1)`.
    pub(crate) fn last_column(&mut self, [m, k]: [usize; 2], h: f64, parts: u64) -> &[f64] {
        let Self { stride, columns, small, squares } = self;
        let n = m + k;
        let by_squares = parts > PARTS_A_COLUMN * n as u64;
        if by_squares {
            squares.iter_mut().for_each(|square| square.resize(n * *stride, 0.0));
        }
        vectorised!(four_wide(), [four,
            shape: [usize; 3] = [m, n, *stride],
            columns: &'k [f64] = columns,
            h: f64 = h,
            parts: u64 = if by_squares { parts.next_power_of_two() } else { parts },
            small: &'k mut [Vec<f64>; 3] = small,
            squares: Option<&'k mut [Vec<f64>; 2]> = by_squares.then_some(squares),
        ] -> () {
            match squares {
                Some(squares) => square_parts(four, shape, columns, h, parts, small, squares),
                None => sum_parts(four, shape, columns, h, parts, small),
            }
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
    small: &mut [Vec<f64>; 3],
) {
    small[0][..n].fill(0.0);
    small[0][n - 1] = 1.0;
    for _ in 0..parts {
        go_on(four, [m, n, stride], columns, h, 1.0 / parts as f64, small);
    }
}

/// Takes a vector along a part of the way.
#[inline(always)]
fn go_on<F: Four>(
    four: F,
    [m, n, stride]: [usize; 3],
    columns: &[f64],
    h: f64,
    part: f64,
    [sum, term, next]: &mut [Vec<f64>; 3],
) {
    term[..n].copy_from_slice(&sum[..n]);
    for power in 1..=MAX_TERMS {
        multiply::<F, true>(four, columns, stride, h, &term[..m], next);
        next[0] += term[m];
        next[m..n - 1].copy_from_slice(&term[m + 1..n]);
        next[n - 1] = 0.0;
        let factor = part / f64::from(power);
        let [largest, change] = add_term(four, factor, &next[..n], &mut term[..n], &mut sum[..n]);
        if change <= 0.25 * f64::EPSILON * largest {
            break;
        }
    }
}

/// The exponential of one part, column by column, then of two, four, eight.
#[inline(always)]
fn square_parts<F: Four>(
    four: F,
    [m, n, stride]: [usize; 3],
    columns: &[f64],
    h: f64,
    parts: u64,
    small: &mut [Vec<f64>; 3],
    [known, square]: &mut [Vec<f64>; 2],
) {
    for (j, column) in known.chunks_exact_mut(stride).take(n).enumerate() {
        small[0][..n].fill(0.0);
        small[0][j] = 1.0;
        go_on(four, [m, n, stride], columns, h, 1.0 / parts as f64, small);
        column[..n].copy_from_slice(&small[0][..n]);
        column[n..].fill(0.0);
    }
    for _ in 1..parts.ilog2() {
        for (own, column) in known.chunks_exact(stride).zip(square.chunks_exact_mut(stride)).take(n)
        {
            multiply::<F, false>(four, known, stride, 1.0, &own[..n], column);
        }
        std::mem::swap(known, square);
    }
    multiply::<F, false>(four, known, stride, 1.0, &known[(n - 1) * stride..][..n], &mut small[0]);
}

/// `next = h H term` for as many columns as `term` has numbers. Writes whole groups of [`ROWS`].
/// Where a term overflows, the zeros below `H` make NaN of it. Such a subspace serves no step of
/// this length.
#[inline(always)]
fn multiply<F: Four, const IS_HESSENBERG: bool>(
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
        // Columns of a Hessenberg matrix further left are 0 here.
        let first = if IS_HESSENBERG { top.saturating_sub(1) } else { 0 };
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

    /// Squares go as far as parts do, whatever was computed with the same numbers before.
    #[test]
    fn many_parts_go_by_squares_to_the_same_column() {
        let mut random = Random::new(12);
        let mut series = Series::new(40);
        for m in [3, 40, 17, 16, 32, 1] {
            // A tridiagonal matrix with imaginary eigenvalues up to 2, and some damping.
            for j in 0..m {
                let column = series.column(j);
                column.fill(0.0);
                column[j] = -0.01;
                column[j + 1] = random.between(0.5, 1.0);
            }
            for j in 1..m {
                let below = series.element(j, j - 1);
                series.column(j)[j - 1] = -below;
            }
            for (k, h, parts) in [(2, 300.0, 1500), (3, 2000.0, 2048), (2, 2000.0, 2049)] {
                let expected = readable(h, parts, [m, k], |i, j| series.element(i, j));
                assert!(parts > PARTS_A_COLUMN * (m + k) as u64);
                let found = series.last_column([m, k], h, parts);
                let size = expected.iter().fold(0.0_f64, |size, a| size.max(a.abs()));
                for (a, b) in expected.iter().zip(found) {
                    assert!((a - b).abs() <= 1e-11 * size, "{m} {k}: {a:e} {b:e} of {size:e}");
                }
            }
        }
    }
}
