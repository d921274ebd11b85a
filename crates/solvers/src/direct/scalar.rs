//! The direct solver for scalar matrices that may be indefinite.

use crate::free::FreeRows;
use crate::scalar_factor::ScalarFactor;
use crate::sparse_factor::FactorKind;
use crate::{ScalarMatrix, SolverError, Vec3};

/// Sparse factorisation `A = L D Lᵀ` of a [`ScalarMatrix`] that may be indefinite, with ones on the
/// diagonal of `L`, a diagonal `D`, and a fill-reducing order of the rows.
///
/// No pivot is clamped, shifted or replaced, and no rows are exchanged for larger pivots. So some
/// invertible matrices, such as `[[0, 1], [1, 0]]`, have no such factors. Three faults give the
/// error [`SolverError::Singular`]:
///
/// * A pivot is zero, or not finite.
/// * A pivot is the difference of numbers that agree in all but their last digits (64 ε), as in a
///   matrix that is singular up to round-off. The check does not find all such matrices, because
///   rounding errors accumulate. The last pivot of a Laplacian without masses was up to n ε / 2 in
///   size, and passed the check on most grids of 10⁴ nodes and more.
/// * A pivot is so small that a term `lᵢₖ² |dₖ|` exceeds the largest entry of `A` by a factor of
///   more than 1/√ε. Below that limit the factors belong to a matrix that differs from `A` by some
///   10⁻⁸ of its largest entry at worst (Higham 2002, theorem 11.3), commonly by 10⁻¹⁵.
///
/// By Sylvester's law of inertia, the number of negative pivots equals the number of negative
/// eigenvalues; see [`negative_pivots`](Self::negative_pivots).
///
/// One factor serves the three coordinates. It is not a [`Preconditioner`](crate::Preconditioner),
/// because conjugate gradients need a positive definite one: with an indefinite `P`, `rᵀ P r` may
/// vanish though `r` does not.
///
/// ```
/// use drape_solvers::{CompleteLdlt, ScalarMatrix, Vec3};
/// # fn main() -> Result<(), drape_solvers::SolverError> {
/// let mut a = ScalarMatrix::with_pattern(2, [(0, 1)]);
/// a.add_diagonal(0, 1.0);
/// a.add_diagonal(1, 1.0);
/// a.add_edge(0, 1, -2.0); // [[-1, 2], [2, -1]], eigenvalues 1 and -3
/// let mut ldlt = CompleteLdlt::new(&a)?;
/// ldlt.update(&a, None)?;
/// assert_eq!(ldlt.negative_pivots(), Some(1));
/// let mut x = [Vec3::zeros(); 2];
/// ldlt.solve(&[Vec3::x(), Vec3::x()], &mut x);
/// assert_eq!(x, [Vec3::x(); 2]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct CompleteLdlt {
    factor: ScalarFactor,
    /// Pinned rows with a negative diagonal entry, which is their pivot.
    negative_pinned: usize,
}

impl CompleteLdlt {
    /// Analyses the pattern of `a` and orders its elimination. The values of `a` do not matter.
    ///
    /// # Errors
    /// [`SolverError::Factorisation`] if the factor does not fit into memory.
    pub fn new(a: &ScalarMatrix) -> Result<Self, SolverError> {
        Ok(Self { factor: ScalarFactor::new(a, FactorKind::Ldlt)?, negative_pinned: 0 })
    }

    /// Factors `a`. Rows that are not `free` keep their diagonal entry alone.
    ///
    /// # Errors
    /// [`SolverError::Singular`]; there is no factor then. [`SolverError::PatternChanged`] if `a`
    /// has another pattern than the matrix given to [`new`](Self::new); the factor then stays as it
    /// was. The solver stays ready for the next matrix.
    ///
    /// # Panics
    /// Unless `free` has one flag for each row.
    pub fn update(&mut self, a: &ScalarMatrix, free: Option<&[bool]>) -> Result<(), SolverError> {
        let rows = FreeRows::new(free, a.n());
        self.factor.update(a, rows)?;
        self.negative_pinned = (0..a.n()).filter(|&i| !rows.free(i) && a.diagonal(i) < 0.0).count();
        Ok(())
    }

    /// `x ← A⁻¹ rhs`, with the matrix of the last [`update`](Self::update). Rows that were not free
    /// are divided by their diagonal entry, up to round-off.
    ///
    /// # Panics
    /// If no update has succeeded, or if a length differs from the number of rows.
    pub fn solve(&self, rhs: &[Vec3], x: &mut [Vec3]) {
        assert_eq!(rhs.len(), self.factor.n(), "one vector a row");
        assert_eq!(x.len(), self.factor.n(), "one vector a row");
        self.factor.solve(rhs, x);
    }

    /// Number of negative pivots of free rows, which is the number of negative eigenvalues of the
    /// matrix of the free rows; `None` without a factor. Each pivot applies to all three
    /// coordinates.
    pub fn negative_pivots(&self) -> Option<usize> {
        self.factor.negative_pivots().map(|all| all - self.negative_pinned)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::LinearOperator;
    use crate::test_support::{
        Random, dense, diagonal, flat, graph, grid_edges, laplacian, negative_eigenvalues,
    };
    use proptest::prelude::*;

    /// `‖A x − b‖ / (‖A‖ ‖x‖)`.
    fn relative_residual(a: &ScalarMatrix, x: &[Vec3], b: &[Vec3]) -> f64 {
        let mut ax = x.to_vec();
        a.multiply(x, &mut ax);
        (flat(&ax) - flat(b)).norm() / (dense(a).norm() * flat(x).norm())
    }

    proptest! {
        #[test]
        fn indefinite_matrices_are_solved_and_their_inertia_is_counted(
            (n, edges) in graph(20),
            seed in 0..1_000_000_u64,
        ) {
            let mut random = Random::new(seed);
            let a = laplacian(n, &edges, 0.1, || random.unit());
            let mut ldlt = CompleteLdlt::new(&a).unwrap();
            match ldlt.update(&a, None) {
                Ok(()) => {
                    let b = random.vectors(n);
                    let mut x = random.vectors(n);
                    ldlt.solve(&b, &mut x);
                    // The cost of the largest growth that passes the check.
                    prop_assert!(relative_residual(&a, &x, &b) < 1e-6);
                    if let Some(negative) = negative_eigenvalues(dense(&a), 1e-6) {
                        prop_assert_eq!(ldlt.negative_pivots(), Some(negative));
                    }
                }
                // A small pivot can turn up by chance.
                Err(error) => {
                    let singular = matches!(error, SolverError::Singular { .. });
                    prop_assert!(singular);
                }
            }
        }
    }

    #[test]
    fn indefinite_grids_are_solved_to_round_off() {
        let (n, edges) = (144, grid_edges(12));
        let mut random = Random::new(30);
        let mut ldlt = CompleteLdlt::new(&laplacian(n, &edges, 0.0, || 0.0)).unwrap();
        for _ in 0..20 {
            let a = laplacian(n, &edges, 0.5, || random.unit());
            ldlt.update(&a, None).unwrap();
            let b = random.vectors(n);
            let mut x = random.vectors(n);
            ldlt.solve(&b, &mut x);
            assert!(relative_residual(&a, &x, &b) < 1e-11);
            let negative = negative_eigenvalues(dense(&a), 1e-9).unwrap();
            assert!(negative > 20);
            assert_eq!(ldlt.negative_pivots(), Some(negative));
        }
    }

    #[test]
    fn a_positive_definite_matrix_has_no_negative_pivot() {
        let a = laplacian(25, &grid_edges(5), 0.1, || 1.0);
        let mut ldlt = CompleteLdlt::new(&a).unwrap();
        assert_eq!(ldlt.negative_pivots(), None);
        ldlt.update(&a, None).unwrap();
        assert_eq!(ldlt.negative_pivots(), Some(0));
    }

    #[test]
    fn pinned_rows_keep_their_diagonal_alone_and_do_not_count() {
        let edges = grid_edges(5);
        let mut random = Random::new(31);
        let mut a = laplacian(25, &edges, 0.3, || random.unit());
        let free: Vec<bool> = (0..25).map(|i| i != 7 && i != 12 && i != 20).collect();
        for (i, value) in [(7, -3.0), (12, -2.0), (20, 4.0)] {
            a.add_diagonal(i, value - a.diagonal(i));
        }
        let mut ldlt = CompleteLdlt::new(&a).unwrap();
        ldlt.update(&a, Some(&free)).unwrap();
        let b = random.vectors(25);
        let mut x = random.vectors(25);
        ldlt.solve(&b, &mut x);
        for (i, value) in [(7, -3.0), (12, -2.0), (20, 4.0)] {
            assert!((x[i] - b[i] / value).norm() < 1e-15);
        }

        let kept: Vec<usize> = (0..25).filter(|&i| free[i]).collect();
        let reduced = dense(&a).select_rows(&kept).select_columns(&kept);
        for k in 0..3 {
            let expected = reduced
                .clone()
                .lu()
                .solve(&nalgebra::DVector::from_fn(kept.len(), |i, _| b[kept[i]][k]))
                .unwrap();
            for (i, &row) in kept.iter().enumerate() {
                assert!((x[row][k] - expected[i]).abs() < 1e-11);
            }
        }
        assert_eq!(ldlt.negative_pivots(), negative_eigenvalues(reduced, 1e-9));
    }

    #[test]
    fn the_row_of_a_bad_pivot_is_named() {
        for row in 0..4 {
            for (bad, pivot) in [
                (0.0, None),
                (f64::NEG_INFINITY, Some(f64::NEG_INFINITY)),
                (f64::INFINITY, Some(f64::INFINITY)),
            ] {
                let mut values = [1.0, -2.0, 3.0, -4.0];
                values[row] = bad;
                let a = diagonal(&values);
                let error = CompleteLdlt::new(&a).unwrap().update(&a, None).unwrap_err();
                assert_eq!(error, SolverError::Singular { row, pivot });
            }
        }
        let a = diagonal(&[1.0, f64::NAN]);
        let error = CompleteLdlt::new(&a).unwrap().update(&a, None).unwrap_err();
        assert!(matches!(error, SolverError::Singular { row: 1, pivot: Some(_) }));
    }

    #[test]
    fn a_matrix_without_factors_is_refused_though_it_is_invertible() {
        let mut a = ScalarMatrix::with_pattern(2, [(0, 1)]);
        a.add_edge(0, 1, 1.0);
        a.add_diagonal(0, -1.0);
        a.add_diagonal(1, -1.0);
        assert_eq!(dense(&a).determinant(), -1.0);
        let error = CompleteLdlt::new(&a).unwrap().update(&a, None).unwrap_err();
        assert!(matches!(error, SolverError::Singular { pivot: None, .. }));
        // The same but for a rounding error in the diagonal.
        a.add_diagonal(0, 1e-15);
        a.add_diagonal(1, 1e-15);
        let error = CompleteLdlt::new(&a).unwrap().update(&a, None).unwrap_err();
        assert!(matches!(error, SolverError::Singular { pivot: Some(_), .. }));
    }

    /// A graph Laplacian annihilates constants, so its last pivot is zero up to rounding errors.
    #[test]
    fn a_component_without_mass_is_found_singular() {
        let mut random = Random::new(32);
        for side in [2, 3, 5, 10] {
            let n = side * side;
            let second = grid_edges(side).into_iter().map(|(i, j)| (i + n, j + n));
            let edges: Vec<_> = grid_edges(side).into_iter().chain(second).collect();
            let mut a = laplacian(2 * n, &edges, 0.0, || random.unit() + 2.0);
            a.add_diagonal(3, 1e-3);
            let error = CompleteLdlt::new(&a).unwrap().update(&a, None).unwrap_err();
            assert!(matches!(error, SolverError::Singular { row, .. } if row >= n), "{error:?}");
            a.add_diagonal(n + 1, 1e-3);
            CompleteLdlt::new(&a).unwrap().update(&a, None).unwrap();
        }
    }

    #[test]
    fn after_a_failed_update_the_next_one_succeeds() {
        let mut random = Random::new(33);
        let good = laplacian(16, &grid_edges(4), 0.2, || random.unit());
        let mut bad = good.clone();
        bad.add_diagonal(6, f64::NAN);
        let mut ldlt = CompleteLdlt::new(&good).unwrap();
        ldlt.update(&good, None).unwrap();
        let b = random.vectors(16);
        let (mut first, mut second) = (b.clone(), b.clone());
        ldlt.solve(&b, &mut first);
        assert!(matches!(ldlt.update(&bad, None), Err(SolverError::Singular { row: 6, .. })));
        assert_eq!(ldlt.negative_pivots(), None);
        ldlt.update(&good, None).unwrap();
        let other = laplacian(16, &[(0, 15)], 1.0, || 1.0);
        assert!(matches!(ldlt.update(&other, None), Err(SolverError::PatternChanged { .. })));
        ldlt.solve(&b, &mut second);
        assert_eq!(first, second);
    }

    #[test]
    #[should_panic(expected = "solve needs a factorisation that succeeded")]
    fn solving_without_a_factor_is_refused() {
        let a = diagonal(&[1.0]);
        CompleteLdlt::new(&a).unwrap().solve(&[Vec3::zeros()], &mut [Vec3::zeros()]);
    }
}
