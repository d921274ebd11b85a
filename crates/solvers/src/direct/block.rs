//! The direct solver for block matrices.

use crate::block::Rows;
use crate::ordering;
use crate::pattern::Pattern;
use crate::sparse_factor::{FactorKind, SparseFactor};
use crate::tiles::Tiles;
use crate::{BlockMatrix, SolverError, Vec3};

/// Sparse factorisation `A = L Lᵀ` or `A = L D Lᵀ` of a [`BlockMatrix`] as a scalar 3n×3n matrix.
///
/// [`new`](Self::new) finds a fill-reducing order of the particles and the pattern of the factor.
/// For a matrix in compressed rows, [`factorise`](Self::factorise) and [`solve`](Self::solve) then
/// allocate nothing. (In a thread other than the one of `new`, supernodes allocate one small buffer
/// once.) Matrices in other layouts are copied. To solve under constraints, factor a
/// [projected](BlockMatrix::project) matrix; its constrained directions have positive pivots.
/// [`CompleteLdlt`](super::CompleteLdlt) describes the limits of an `L D Lᵀ`.
///
/// ```
/// use drape_solvers::{BlockFactor, BlockMatrix, FactorKind, Mat3, Vec3};
/// # fn main() -> Result<(), drape_solvers::SolverError> {
/// let mut a = BlockMatrix::with_pattern(1, []);
/// a.add_diagonal(0, &Mat3::from_diagonal(&Vec3::new(4.0, -2.0, 1.0)));
/// let mut factor = BlockFactor::new(&a, FactorKind::Ldlt)?;
/// factor.factorise(&a)?;
/// assert_eq!(factor.negative_pivots(), Some(1));
/// let mut x = [Vec3::zeros()];
/// factor.solve(&[Vec3::new(4.0, 4.0, 4.0)], &mut x);
/// assert_eq!(x[0], Vec3::new(1.0, -2.0, 4.0));
/// assert!(BlockFactor::new(&a, FactorKind::Cholesky)?.factorise(&a).is_err());
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct BlockFactor {
    /// The pattern that the factor was made for.
    pattern: Pattern,
    factor: SparseFactor,
    tiles: Tiles<4>,
    /// The particles in the order of elimination.
    nodes: Vec<u32>,
    /// The right-hand side, then the solution, as scalars in that order, and the idle entry of the
    /// tiles.
    scalars: Vec<f64>,
}

impl BlockFactor {
    /// Analyses the pattern of `a` and orders its elimination. The values of `a` do not matter.
    ///
    /// # Errors
    /// [`SolverError::Factorisation`] if the factor does not fit into memory.
    pub fn new(a: &BlockMatrix, kind: FactorKind) -> Result<Self, SolverError> {
        Self::of_rows(&a.rows(), kind)
    }

    pub(crate) fn of_rows(a: &Rows, kind: FactorKind) -> Result<Self, SolverError> {
        let pattern = a.pattern().clone();
        let mut starts = vec![0];
        let mut rows = Vec::new();
        for j in 0..a.n() {
            for coordinate in 0..3 {
                for slot in pattern.lower(j) {
                    let i = pattern.column(slot);
                    rows.extend((0..3).map(|k| (3 * i + k) as u32));
                }
                rows.extend((0..=coordinate).map(|k| (3 * j + k) as u32));
                starts.push(rows.len() as u32);
            }
        }
        let nodes = ordering::fill_reducing(&pattern)?;
        let order: Vec<u32> = nodes.iter().flat_map(|&i| (0..3).map(move |k| 3 * i + k)).collect();
        let factor = SparseFactor::new(kind, starts, rows, &order)?;
        Ok(Self {
            pattern,
            tiles: Tiles::new(factor.symbolic()),
            factor,
            nodes,
            scalars: vec![0.0; 3 * a.n() + 1],
        })
    }

    /// Factors `a`. Only the lower triangle is read.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] for `L Lᵀ` and [`SolverError::Singular`] for `L D Lᵀ`;
    /// there is no factor then. [`SolverError::PatternChanged`] if `a` has another pattern than the
    /// matrix given to [`new`](Self::new). The solver stays ready for the next matrix.
    pub fn factorise(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        self.factorise_rows(&a.rows())
    }

    pub(crate) fn factorise_rows(&mut self, a: &Rows) -> Result<(), SolverError> {
        self.pattern.check(a.pattern())?;
        let (pattern, blocks) = (&self.pattern, a.blocks());
        self.factor.factorise(|mut values| {
            // Column (j, c) of the upper triangle is row (j, c) of the lower one.
            for j in 0..a.n() {
                let left = &blocks[pattern.lower(j)];
                let corner = &blocks[pattern.diagonal(j)];
                for c in 0..3 {
                    let (column, rest) = values.split_at_mut(3 * left.len() + c + 1);
                    let (rows, end) = column.as_chunks_mut::<3>();
                    let (above, corners) = rows.split_at_mut(left.len());
                    for (row, block) in above.iter_mut().zip(left) {
                        *row = [0, 1, 2].map(|k| block[(c, k)]);
                    }
                    let corners = corners.as_flattened_mut().iter_mut().chain(end);
                    corners.enumerate().for_each(|(k, slot)| *slot = corner[(c, k)]);
                    values = rest;
                }
            }
            debug_assert!(values.is_empty(), "fewer values than the pattern has");
        })?;
        self.tiles.fill(self.factor.symbolic(), self.factor.kind(), self.factor.factor());
        Ok(())
    }

    /// Number of negative scalar pivots of `L D Lᵀ`, which equals the number of negative
    /// eigenvalues of `A`; `None` without a factor.
    pub fn negative_pivots(&self) -> Option<usize> {
        self.factor.negative_pivots()
    }

    /// `x ← A⁻¹ rhs`, with the matrix of the last [`factorise`](Self::factorise).
    ///
    /// # Panics
    /// If no factorisation has succeeded, or if a length differs from the number of particles.
    pub fn solve(&mut self, rhs: &[Vec3], x: &mut [Vec3]) {
        assert_eq!(rhs.len(), self.pattern.n(), "one vector a block row");
        assert_eq!(x.len(), self.pattern.n(), "one vector a block row");
        self.solve_each(|i| rhs[i].into(), |i, solution| x[i] = Vec3::from(solution));
    }

    /// As [`solve`](Self::solve). Reads and writes the vectors particle by particle.
    pub(crate) fn solve_each(
        &mut self,
        read: impl Fn(usize) -> [f64; 3],
        mut write: impl FnMut(usize, [f64; 3]),
    ) {
        assert!(self.factor.factored(), "solve needs a factorisation that succeeded");
        let (scalars, _) = self.scalars.as_chunks_mut::<3>();
        for (scalars, &i) in scalars.iter_mut().zip(&self.nodes) {
            *scalars = read(i as usize);
        }
        self.tiles.solve(&mut self.scalars);
        let (scalars, _) = self.scalars.as_chunks::<3>();
        for (scalars, &i) in scalars.iter().zip(&self.nodes) {
            write(i as usize, *scalars);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::{
        Random, dense_blocks, flat, graph, grid_edges, indefinite_blocks, negative_eigenvalues,
        random_blocks, random_filter,
    };
    use crate::{Constraints, Coupling, LinearOperator, Mat3};
    use drape_kernels::testing::assert_same_bits;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn all_factors_solve_like_a_dense_one((n, edges) in graph(10)) {
            let mut random = Random::new(17);
            let a = random_blocks(n, &edges, &mut random);
            let b = random.vectors(n);
            let expected = dense_blocks(&a).cholesky().unwrap().solve(&flat(&b));
            for kind in [FactorKind::Cholesky, FactorKind::Ldlt] {
                let mut factor = BlockFactor::new(&a, kind).unwrap();
                factor.factorise(&a).unwrap();
                let mut x = random.vectors(n);
                factor.solve(&b, &mut x);
                prop_assert!((flat(&x) - &expected).norm() < 1e-11);
            }
        }

        #[test]
        fn indefinite_matrices_are_solved_and_their_inertia_is_counted(
            (n, edges) in graph(10),
            seed in 0..1_000_000_u64,
        ) {
            let mut random = Random::new(seed);
            let a = indefinite_blocks(n, &edges, &mut random);
            let dense = dense_blocks(&a);
            let b = random.vectors(n);
            let mut factor = BlockFactor::new(&a, FactorKind::Ldlt).unwrap();
            if let Err(error) = factor.factorise(&a) {
                // A small pivot can turn up by chance.
                let singular = matches!(error, SolverError::Singular { .. });
                prop_assert!(singular);
                return Ok(());
            }
            let mut x = random.vectors(n);
            factor.solve(&b, &mut x);
            let residual = &dense * flat(&x) - flat(&b);
            // The cost of the largest growth that passes the check.
            prop_assert!(residual.norm() < 1e-6 * dense.norm() * flat(&x).norm());
            if let Some(negative) = negative_eigenvalues(dense.clone(), 1e-6) {
                prop_assert_eq!(factor.negative_pivots(), Some(negative));
            }
        }
    }

    #[test]
    fn a_grid_is_solved_to_round_off_and_refactored_in_place() {
        let n = 144;
        let mut random = Random::new(18);
        let edges = grid_edges(12);
        let mut cholesky = None;
        for _ in 0..3 {
            let a = random_blocks(n, &edges, &mut random);
            let cholesky =
                cholesky.get_or_insert_with(|| BlockFactor::new(&a, FactorKind::Cholesky).unwrap());
            cholesky.factorise(&a).unwrap();
            let x = random.vectors(n);
            let (mut b, mut solution) = (x.clone(), x.clone());
            a.multiply(&x, &mut b);
            cholesky.solve(&b, &mut solution);
            assert!((flat(&solution) - flat(&x)).norm() < 1e-12 * flat(&x).norm());
        }
    }

    #[test]
    fn an_indefinite_grid_is_solved_to_round_off() {
        let n = 144;
        let mut random = Random::new(21);
        let edges = grid_edges(12);
        let pattern = BlockMatrix::with_pattern(n, edges.iter().copied());
        let mut factor = BlockFactor::new(&pattern, FactorKind::Ldlt).unwrap();
        for _ in 0..3 {
            let a = indefinite_blocks(n, &edges, &mut random);
            let dense = dense_blocks(&a);
            factor.factorise(&a).unwrap();
            let b = random.vectors(n);
            let mut x = random.vectors(n);
            factor.solve(&b, &mut x);
            let residual = &dense * flat(&x) - flat(&b);
            assert!(residual.norm() < 1e-11 * dense.norm() * flat(&x).norm());
            let negative = negative_eigenvalues(dense, 1e-9).unwrap();
            assert!(negative > 50);
            assert_eq!(factor.negative_pivots(), Some(negative));
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused_by_cholesky_and_the_next_one_is_solved() {
        let mut random = Random::new(19);
        let good = random_blocks(16, &grid_edges(4), &mut random);
        let mut cholesky = BlockFactor::new(&good, FactorKind::Cholesky).unwrap();
        for value in [-100.0, f64::NAN, f64::INFINITY] {
            let mut bad = good.clone();
            bad.add_diagonal(5, &(value * Mat3::identity()));
            let error = cholesky.factorise(&bad).unwrap_err();
            assert!(matches!(error, SolverError::NotPositiveDefinite { .. }));
        }
        cholesky.factorise(&good).unwrap();
        let x = random.vectors(16);
        let (mut b, mut solution) = (x.clone(), x.clone());
        good.multiply(&x, &mut b);
        cholesky.solve(&b, &mut solution);
        assert!((flat(&solution) - flat(&x)).norm() < 1e-12);
    }

    #[test]
    fn a_singular_matrix_is_refused_and_the_next_one_is_solved() {
        let mut random = Random::new(22);
        let good = indefinite_blocks(16, &grid_edges(4), &mut random);
        // No masses: translations cost nothing.
        let mut bad = BlockMatrix::with_pattern(16, grid_edges(4));
        for (i, j) in grid_edges(4) {
            let d = random.vector();
            bad.add_pair(i, j, &(random.unit() * Mat3::identity() + d * d.transpose()));
        }
        let mut ldlt = BlockFactor::new(&good, FactorKind::Ldlt).unwrap();
        let error = ldlt.factorise(&bad).unwrap_err();
        assert!(matches!(error, SolverError::Singular { pivot: Some(_), .. }), "{error:?}");
        assert_eq!(ldlt.negative_pivots(), None);
        ldlt.factorise(&good).unwrap();
        let x = random.vectors(16);
        let (mut b, mut solution) = (x.clone(), x.clone());
        good.multiply(&x, &mut b);
        ldlt.solve(&b, &mut solution);
        assert!((flat(&solution) - flat(&x)).norm() < 1e-11);
    }

    #[test]
    fn the_row_of_a_bad_pivot_is_named() {
        for row in 0..12 {
            for (kind, bad) in
                [(FactorKind::Cholesky, -1.0), (FactorKind::Cholesky, 0.0), (FactorKind::Ldlt, 0.0)]
            {
                let mut a = BlockMatrix::with_pattern(4, [(0, 1), (2, 3)]);
                for i in 0..4 {
                    let mut block = Mat3::identity();
                    if i == row / 3 {
                        block[(row % 3, row % 3)] = bad;
                    }
                    a.add_diagonal(i, &block);
                }
                let mut factor = BlockFactor::new(&a, kind).unwrap();
                let expected = match kind {
                    FactorKind::Cholesky => SolverError::NotPositiveDefinite { row, pivot: None },
                    FactorKind::Ldlt => SolverError::Singular { row, pivot: None },
                };
                assert_eq!(factor.factorise(&a).unwrap_err(), expected);
            }
        }
    }

    #[test]
    fn the_row_of_a_pivot_lost_in_round_off_is_named() {
        // The lower right 2×2 of a block is singular but for a rounding error.
        let third = 1.0 / 3.0;
        let singular = Mat3::new(1.0, 0.0, 0.0, 0.0, 3.0, 1.0, 0.0, 1.0, third + 1e-16);
        let mut a = BlockMatrix::with_pattern(3, []);
        for i in 0..3 {
            a.add_diagonal(i, &if i == 1 { singular } else { Mat3::identity() });
        }
        let mut factor = BlockFactor::new(&a, FactorKind::Ldlt).unwrap();
        let error = factor.factorise(&a).unwrap_err();
        assert!(matches!(error, SolverError::Singular { row: 4 | 5, .. }), "{error:?}");
    }

    #[test]
    fn a_projected_matrix_gives_a_solution_that_obeys_the_constraints() {
        let n = 16;
        let mut random = Random::new(20);
        let mut definite = random_blocks(n, &grid_edges(4), &mut random);
        let mut indefinite = indefinite_blocks(n, &grid_edges(4), &mut random);
        let mut constraints = Constraints::free(n);
        for i in 0..n {
            constraints.set(i, random_filter(&mut random), Vec3::zeros());
        }
        let mut b = random.vectors(n);
        constraints.project(&mut b);
        for (kind, a) in
            [(FactorKind::Cholesky, &mut definite), (FactorKind::Ldlt, &mut indefinite)]
        {
            let unprojected = a.clone();
            a.project(&constraints);
            let mut factor = BlockFactor::new(a, kind).unwrap();
            factor.factorise(a).unwrap();
            let mut x = random.vectors(n);
            factor.solve(&b, &mut x);
            let mut filtered = x.clone();
            constraints.project(&mut filtered);
            assert!((flat(&filtered) - flat(&x)).norm() < 1e-12);
            let mut residual = b.clone();
            unprojected.multiply(&x, &mut residual);
            constraints.project(&mut residual);
            assert!((flat(&residual) - flat(&b)).norm() < 1e-11);
        }
    }

    #[test]
    fn another_pattern_and_a_missing_factor_are_refused() {
        for kind in [FactorKind::Cholesky, FactorKind::Ldlt] {
            let a = BlockMatrix::with_pattern(3, [(0, 1)]);
            let other = BlockMatrix::with_pattern(3, [(0, 2)]);
            let mut factor = BlockFactor::new(&a, kind).unwrap();
            let error = factor.factorise(&other).unwrap_err();
            assert!(matches!(error, SolverError::PatternChanged { .. }));
            let mut solve = || factor.solve(&[Vec3::zeros(); 3], &mut [Vec3::zeros(); 3]);
            let solve = std::panic::AssertUnwindSafe(&mut solve);
            let panic = std::panic::catch_unwind(solve).unwrap_err();
            let text = panic.downcast_ref::<&str>().unwrap();
            assert!(text.contains("solve needs a factorisation that succeeded"));
        }
    }

    #[test]
    fn bands_have_the_factor_of_their_rows() {
        let (n, edges) = (20, (1..20).map(|i| (i - 1, i)).collect::<Vec<_>>());
        let mut random = Random::new(23);
        let b = random.vectors(n);
        let solutions = [Coupling::Rows, Coupling::Bands(vec![1])].map(|layout| {
            let mut a = BlockMatrix::new(n, &layout, edges.iter().copied());
            (0..n).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
            edges.iter().for_each(|&(i, j)| a.add_pair(i, j, &(b[i] * b[i].transpose())));
            let mut factor = BlockFactor::new(&a, FactorKind::Cholesky).unwrap();
            factor.factorise(&a).unwrap();
            let mut x = b.clone();
            factor.solve(&b, &mut x);
            x
        });
        assert_same_bits("bands", &solutions[0], &solutions[1]);
    }
}
