//! Incomplete Cholesky factorisation without fill, IC(0).

use super::Preconditioner;
use super::jacobi::is_pivot;
use super::wavefront::Wavefront;
use crate::free::FreeRows;
use crate::pattern::Pattern;
use crate::{ScalarMatrix, SolverError, Vec3};
use drape_kernels::lanes::{Four, Lanes};

/// `P = (L Lᵀ)⁻¹`. The lower triangle `L` has non-zeros only where `A` has, and `L Lᵀ = A` holds
/// there. The rows keep their natural order. One factor is used for all three coordinates.
///
/// On an M-matrix, such as a graph Laplacian plus masses, it always exists (Meijerink & van der
/// Vorst 1977). On a tridiagonal matrix it is the complete factor.
#[derive(Clone, Debug)]
pub struct IncompleteCholesky {
    /// The pattern that the factor was made for.
    pattern: Pattern,
    /// First slot of each row of `L`'s strict lower triangle; row `i` is
    /// `starts[i]..starts[i + 1]`.
    starts: Vec<usize>,
    columns: Vec<u32>,
    lower: Vec<f64>,
    /// `1 / Lᵢᵢ`.
    inverse_diagonal: Vec<f64>,
    /// The order of the rows in a solve.
    order: Wavefront,
    /// The offsets `i − j` of regular rows, the farthest first.
    offsets: Vec<usize>,
    /// Whether a row has entries at just these offsets.
    regular: Vec<bool>,
}

impl IncompleteCholesky {
    /// The identity, with memory for a factor with the pattern of `a`.
    pub fn new(a: &ScalarMatrix) -> Self {
        let pattern = a.pattern().clone();
        let (starts, columns) = pattern.lower_triangle();
        let row = |i: usize| &columns[starts[i]..starts[i + 1]];
        let offsets = common_offsets(a.n(), row);
        let regular = |i: usize| row(i).iter().map(|&j| i - j as usize).eq(offsets.iter().copied());
        Self {
            order: Wavefront::new(a.n(), row),
            regular: (0..a.n()).map(regular).collect(),
            offsets,
            lower: vec![0.0; columns.len()],
            inverse_diagonal: vec![1.0; a.n()],
            pattern,
            starts,
            columns,
        }
    }

    /// Factors `a`. Rows that are not `free` keep only their diagonal entry.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] with row and pivot if a pivot is not positive.
    /// [`SolverError::PatternChanged`] if `a` has another pattern than the matrix given to
    /// [`new`](Self::new); the factor then stays as it was.
    ///
    /// # Panics
    /// Unless `free` has one flag for each row.
    pub fn update(&mut self, a: &ScalarMatrix, free: Option<&[bool]>) -> Result<(), SolverError> {
        self.pattern.check(a.pattern())?;
        let rows = FreeRows::new(free, a.n());
        for i in 0..a.n() {
            let pivot = self.factor_row(a, rows, i);
            if !is_pivot(pivot) {
                self.lower.fill(0.0);
                self.inverse_diagonal.fill(1.0);
                return Err(SolverError::NotPositiveDefinite { row: i, pivot: Some(pivot) });
            }
            self.inverse_diagonal[i] = 1.0 / pivot.sqrt();
        }
        Ok(())
    }

    /// Computes row `i` of `L` left of the diagonal from the rows above it,
    /// `Lᵢⱼ = (Aᵢⱼ − Σₖ Lᵢₖ Lⱼₖ) / Lⱼⱼ`, and returns the pivot `Lᵢᵢ² = Aᵢᵢ − Σₖ Lᵢₖ²`.
    fn factor_row(&mut self, a: &ScalarMatrix, rows: FreeRows<'_>, i: usize) -> f64 {
        let start = self.starts[i];
        let a_row = &a.values()[self.pattern.lower(i)];
        let mut pivot = a.diagonal(i);
        for slot in start..self.starts[i + 1] {
            let j = self.columns[slot] as usize;
            self.lower[slot] = if rows.coupled(i, j) {
                let overlap = self.overlap(start..slot, self.starts[j]..self.starts[j + 1]);
                (a_row[slot - start] - overlap) * self.inverse_diagonal[j]
            } else {
                0.0
            };
            pivot -= self.lower[slot] * self.lower[slot];
        }
        pivot
    }

    /// The dot product of two pieces of rows of `L`, over their common columns.
    fn overlap(&self, left: std::ops::Range<usize>, right: std::ops::Range<usize>) -> f64 {
        let (mut p, mut q) = (left.start, right.start);
        let mut sum = 0.0;
        while p < left.end && q < right.end {
            match self.columns[p].cmp(&self.columns[q]) {
                std::cmp::Ordering::Less => p += 1,
                std::cmp::Ordering::Greater => q += 1,
                std::cmp::Ordering::Equal => {
                    sum += self.lower[p] * self.lower[q];
                    p += 1;
                    q += 1;
                }
            }
        }
        sum
    }

    /// Columns and values of row `i` of `L` left of the diagonal.
    #[inline(always)]
    fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let row = self.starts[i]..self.starts[i + 1];
        self.columns[row.clone()]
            .iter()
            .zip(&self.lower[row])
            .map(|(&j, &value)| (j as usize, value))
    }

    /// [`apply`](Preconditioner::apply) to particles of four numbers, in the order of the
    /// wavefront.
    #[inline(always)]
    pub(crate) fn apply_to_lanes(&self, four: impl Four, r: &[Lanes], z: &mut [Lanes]) {
        match *self.offsets {
            [a, b] => self.apply_with(four, [a, b], r, z),
            [a, b, c, d] => self.apply_with(four, [a, b, c, d], r, z),
            [a, b, c, d, e, f] => self.apply_with(four, [a, b, c, d, e, f], r, z),
            _ => self.apply_with(four, [], r, z),
        }
    }

    /// [`apply_to_lanes`](Self::apply_to_lanes), where regular rows have these `D` offsets.
    #[inline(always)]
    fn apply_with<const D: usize>(
        &self,
        four: impl Four,
        offsets: [usize; D],
        r: &[Lanes],
        z: &mut [Lanes],
    ) {
        let n = self.pattern.n();
        let (inverse, regular) = (&self.inverse_diagonal[..n], &self.regular[..n]);
        let (starts, r, z) = (&self.starts[..n], &r[..n], &mut z[..n]);
        self.order.forward(|i| {
            let mut sum = four.load(r[i]);
            if regular[i] {
                let values = &self.lower[starts[i]..starts[i] + D];
                for (offset, value) in offsets.iter().zip(values) {
                    sum = four.sub(sum, four.mul(four.load(z[i - offset]), four.splat(*value)));
                }
            } else {
                for (j, value) in self.row(i) {
                    sum = four.sub(sum, four.mul(four.load(z[j]), four.splat(value)));
                }
            }
            z[i] = four.store(four.mul(sum, four.splat(inverse[i])));
        });
        self.order.backward(|i| {
            let zi = four.mul(four.load(z[i]), four.splat(inverse[i]));
            z[i] = four.store(zi);
            if regular[i] {
                let values = &self.lower[starts[i]..starts[i] + D];
                for (offset, value) in offsets.iter().zip(values) {
                    let j = i - offset;
                    z[j] = four.store(four.sub(four.load(z[j]), four.mul(zi, four.splat(*value))));
                }
            } else {
                for (j, value) in self.row(i) {
                    z[j] = four.store(four.sub(four.load(z[j]), four.mul(zi, four.splat(value))));
                }
            }
        });
    }
}

/// The offsets `i − j` that most rows have, the farthest first; empty unless half of the rows share
/// a set of two, four or six.
fn common_offsets<'a>(n: usize, row: impl Fn(usize) -> &'a [u32]) -> Vec<usize> {
    // On a mesh the row in the middle of the middle line is as good as any.
    let offsets = |i: usize| row(i).iter().map(move |&j| i - j as usize);
    let of: Vec<usize> = (n / 2..n.min(n / 2 + 3))
        .map(|i| offsets(i).collect::<Vec<_>>())
        .max_by_key(Vec::len)
        .unwrap_or_default();
    let shared = (0..n).filter(|&i| offsets(i).eq(of.iter().copied())).count();
    if matches!(of.len(), 2 | 4 | 6) && 2 * shared > n { of } else { Vec::new() }
}

impl Preconditioner for IncompleteCholesky {
    /// Solves `L y = r` row by row, then `Lᵀ z = y` column by column, in place.
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        let n = self.pattern.n();
        assert_eq!(r.len(), n, "one vector a row");
        assert_eq!(z.len(), n, "one vector a row");
        for i in 0..n {
            let mut sum = r[i];
            for (j, value) in self.row(i) {
                sum -= z[j] * value;
            }
            z[i] = sum * self.inverse_diagonal[i];
        }
        for i in (0..n).rev() {
            let zi = z[i] * self.inverse_diagonal[i];
            z[i] = zi;
            for (j, value) in self.row(i) {
                z[j] -= zi * value;
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::{Random, dense, flat, graph, grid_edges, laplacian};
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    fn dense_factor(p: &IncompleteCholesky) -> DMatrix<f64> {
        let n = p.pattern.n();
        let mut l = DMatrix::zeros(n, n);
        for i in 0..n {
            l[(i, i)] = 1.0 / p.inverse_diagonal[i];
            for (j, value) in p.row(i) {
                l[(i, j)] = value;
            }
        }
        l
    }

    proptest! {
        #[test]
        fn the_product_of_the_factors_is_the_matrix_on_its_pattern((n, edges) in graph(14)) {
            let mut random = Random::new(10);
            let a = laplacian(n, &edges, 0.3, || random.unit().abs());
            let mut p = IncompleteCholesky::new(&a);
            p.update(&a, None).unwrap();
            let l = dense_factor(&p);
            let product = &l * l.transpose();
            for i in 0..n {
                for j in 0..n {
                    if a.pattern_contains(i, j) {
                        prop_assert!((product[(i, j)] - a.get(i, j)).abs() < 1e-12);
                    } else {
                        prop_assert_eq!(l[(i, j)], 0.0);
                    }
                }
            }
            let r = random.vectors(n);
            let mut z = random.vectors(n);
            p.apply(&r, &mut z);
            let back = product.kronecker(&DMatrix::identity(3, 3)) * flat(&z);
            prop_assert!((back - flat(&r)).norm() < 1e-11);
        }

    }

    #[test]
    fn on_a_tridiagonal_matrix_it_is_the_complete_factor() {
        let n = 50;
        let mut random = Random::new(12);
        let chain: Vec<_> = (1..n).map(|i| (i - 1, i)).collect();
        let a = laplacian(n, &chain, 0.1, || 1.0 + random.unit().abs());
        let mut p = IncompleteCholesky::new(&a);
        p.update(&a, None).unwrap();
        let complete = dense(&a).cholesky().unwrap().l();
        assert!((dense_factor(&p) - complete).norm() < 1e-12);
    }

    #[test]
    fn on_a_grid_it_is_not_the_complete_factor() {
        let a = laplacian(16, &grid_edges(4), 0.1, || 1.0);
        let mut p = IncompleteCholesky::new(&a);
        p.update(&a, None).unwrap();
        let complete = dense(&a).cholesky().unwrap().l();
        assert!((dense_factor(&p) - complete).norm() > 0.1);
    }

    #[test]
    fn a_breakdown_names_row_and_pivot_and_leaves_the_identity() {
        let mut a = laplacian(3, &[(0, 1), (1, 2)], 1.0, || 1.0);
        let mut p = IncompleteCholesky::new(&a);
        p.update(&a, None).unwrap();
        a.add_diagonal(1, -3.0);
        let error = p.update(&a, None).unwrap_err();
        let SolverError::NotPositiveDefinite { row: 1, pivot: Some(pivot) } = error else {
            panic!("{error:?}");
        };
        assert!((pivot + 0.5).abs() < 1e-15);
        let r = Random::new(13).vectors(3);
        let mut z = vec![Vec3::zeros(); 3];
        p.apply(&r, &mut z);
        assert_eq!(z, r);
        a.add_diagonal(1, f64::NAN);
        assert!(p.update(&a, None).is_err());
    }
}
