//! The graph-Laplacian matrix: a scalar n×n matrix that acts on each coordinate in the same way.
//!
//! A graph with weighted edges has the Laplacian `Σ w (eᵢ − eⱼ)(eᵢ − eⱼ)ᵀ`. With a positive
//! diagonal added it is symmetric, strictly diagonally dominant and has no positive off-diagonal
//! entry (an M-matrix), so Cholesky and incomplete Cholesky never break down on it. Because one
//! scalar entry is used for three coordinates, the matrix takes a ninth of the memory of a matrix
//! of 3×3 blocks.

use crate::pattern::Pattern;
use crate::{LinearOperator, Vec3};

/// A symmetric scalar matrix in compressed rows, both triangles stored.
///
/// ```
/// use drape_solvers::{LinearOperator, ScalarMatrix, Vec3};
/// let mut a = ScalarMatrix::with_pattern(2, [(0, 1)]);
/// a.add_diagonal(0, 1.0);
/// a.add_diagonal(1, 1.0);
/// a.add_edge(0, 1, 10.0);
/// assert_eq!(a.get(0, 1), -10.0);
/// let mut y = [Vec3::zeros(); 2];
/// a.multiply(&[Vec3::x(), Vec3::zeros()], &mut y);
/// assert_eq!(y, [Vec3::x() * 11.0, Vec3::x() * -10.0]);
/// ```
#[derive(Clone, Debug)]
pub struct ScalarMatrix {
    pattern: Pattern,
    values: Vec<f64>,
}

impl ScalarMatrix {
    /// The zero matrix with room for the diagonal of `n` rows and for each edge. Edges may be
    /// repeated, and may join a node to itself.
    ///
    /// # Panics
    /// If an edge names a node that is not below `n`.
    pub fn with_pattern(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
        let pattern = Pattern::new(n, edges);
        let values = vec![0.0; pattern.nonzeros()];
        Self { pattern, values }
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.pattern.n()
    }

    /// Number of stored entries, both triangles and the diagonal.
    pub fn nonzeros(&self) -> usize {
        self.pattern.nonzeros()
    }

    /// Sets all entries to zero; the pattern stays.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds `value` to the diagonal entry of row `i`.
    pub fn add_diagonal(&mut self, i: usize, value: f64) {
        self.values[self.pattern.diagonal(i)] += value;
    }

    /// Adds `weight (eᵢ − eⱼ)(eᵢ − eⱼ)ᵀ`. For `i = j` this adds nothing.
    ///
    /// An edge outside the pattern is a bug in the caller: debug builds panic, release builds
    /// ignore the edge.
    pub fn add_edge(&mut self, i: usize, j: usize, weight: f64) {
        if i == j {
            return;
        }
        let (Some(ij), Some(ji)) = (self.pattern.slot(i, j), self.pattern.slot(j, i)) else {
            debug_assert!(false, "the pattern has no edge ({i}, {j})");
            return;
        };
        self.values[ij] -= weight;
        self.values[ji] -= weight;
        self.add_diagonal(i, weight);
        self.add_diagonal(j, weight);
    }

    /// The diagonal entry of row `i`.
    pub fn diagonal(&self, i: usize) -> f64 {
        self.values[self.pattern.diagonal(i)]
    }

    /// Entry (i, j); zero outside the pattern.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.pattern.slot(i, j).map_or(0.0, |slot| self.values[slot])
    }

    /// Columns, in increasing order, and values of row `i`.
    #[inline(always)]
    pub fn row(&self, i: usize) -> (&[u32], &[f64]) {
        let row = self.pattern.row(i);
        (&self.pattern.columns()[row.clone()], &self.values[row])
    }

    /// Whether the pattern has room for entry (i, j).
    pub fn pattern_contains(&self, i: usize, j: usize) -> bool {
        self.pattern.slot(i, j).is_some()
    }

    /// The pattern.
    pub(crate) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The values, in the slots of the pattern.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }
}

impl LinearOperator for ScalarMatrix {
    fn size(&self) -> usize {
        self.n()
    }

    /// Each row is summed from its first column to its last.
    fn multiply(&self, x: &[Vec3], y: &mut [Vec3]) {
        assert_eq!(x.len(), self.n(), "one vector a row");
        assert_eq!(y.len(), self.n(), "one vector a row");
        for (i, y) in y.iter_mut().enumerate() {
            let (columns, values) = self.row(i);
            let mut sum = [0.0; 3];
            for (&j, &value) in columns.iter().zip(values) {
                let x = &x[j as usize];
                for k in 0..3 {
                    sum[k] += value * x[k];
                }
            }
            *y = Vec3::from(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{Random, dense, flat, graph};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn assembly_and_product_match_the_dense_laplacian((n, edges) in graph(12)) {
            let mut random = Random::new(5);
            let mut a = ScalarMatrix::with_pattern(n, edges.iter().copied());
            let mut expected = nalgebra::DMatrix::<f64>::zeros(n, n);
            for i in 0..n {
                let mass = 0.5 + random.unit().abs();
                a.add_diagonal(i, mass);
                expected[(i, i)] += mass;
            }
            for &(i, j) in &edges {
                let weight = random.unit().abs();
                a.add_edge(i, j, weight);
                let mut e = nalgebra::DVector::<f64>::zeros(n);
                e[i] += 1.0;
                e[j] -= 1.0;
                expected += weight * &e * e.transpose();
            }
            prop_assert!((dense(&a) - &expected).norm() < 1e-13);
            for i in 0..n {
                prop_assert!(a.row(i).0.is_sorted());
                prop_assert_eq!(a.diagonal(i), a.get(i, i));
                for j in 0..n {
                    let edge = i == j || edges.contains(&(i, j)) || edges.contains(&(j, i));
                    prop_assert_eq!(a.pattern_contains(i, j), edge);
                }
            }
            let x = random.vectors(n);
            let mut y = random.vectors(n);
            a.multiply(&x, &mut y);
            let by_hand = expected.kronecker(&nalgebra::DMatrix::identity(3, 3)) * flat(&x);
            prop_assert!((flat(&y) - by_hand).norm() < 1e-13);
            a.clear();
            prop_assert_eq!(dense(&a).norm(), 0.0);
        }
    }

    #[test]
    fn duplicate_edges_and_loops_take_one_slot() {
        let a = ScalarMatrix::with_pattern(3, [(0, 1), (1, 0), (0, 1), (2, 2)]);
        assert_eq!((a.n(), a.nonzeros()), (3, 5));
    }

    #[test]
    #[cfg_attr(debug_assertions, should_panic(expected = "no edge (0, 2)"))]
    fn an_edge_outside_the_pattern_stops_debug_builds_and_is_left_out_of_others() {
        let mut a = ScalarMatrix::with_pattern(3, [(0, 1)]);
        a.add_edge(0, 2, 1.0);
        assert_eq!(dense(&a).norm(), 0.0);
    }
}
