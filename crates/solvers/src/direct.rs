//! The direct solver for block matrices: sparse Cholesky.

use faer::sparse::linalg::SupernodalThreshold;

use crate::pattern::Pattern;
use crate::sparse_llt::SparseLlt;
use crate::{BlockMatrix, SolverError, Vec3};

/// Sparse Cholesky factorisation of a [`BlockMatrix`] as a scalar 3n×3n matrix.
///
/// [`new`](Self::new) finds a fill-reducing order (AMD), the pattern of the factor, and whether it
/// pays to work on dense panels (supernodes). [`factorise`](Self::factorise) and
/// [`solve`](Self::solve) then allocate nothing (in another thread than that of `new`, supernodes
/// take one small buffer once). To solve under constraints, factor a matrix that
/// was [projected](BlockMatrix::project).
///
/// ```
/// use drape_solvers::{BlockCholesky, BlockMatrix, Mat3, Vec3};
/// # fn main() -> Result<(), drape_solvers::SolverError> {
/// let mut a = BlockMatrix::with_pattern(1, []);
/// a.add_diagonal(0, &(4.0 * Mat3::identity()));
/// let mut cholesky = BlockCholesky::new(&a)?;
/// cholesky.factorise(&a)?;
/// let mut x = [Vec3::zeros()];
/// cholesky.solve(&[Vec3::new(4.0, 8.0, 12.0)], &mut x);
/// assert_eq!(x[0], Vec3::new(1.0, 2.0, 3.0));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct BlockCholesky {
    /// The pattern that the factor was made for.
    pattern: Pattern,
    llt: SparseLlt,
    /// The right-hand side, and then the solution, as scalars.
    scalars: Vec<f64>,
}

impl BlockCholesky {
    /// Analyses the pattern of `a`; its values do not matter.
    ///
    /// # Errors
    /// [`SolverError::Factorisation`] when the factor does not fit into memory.
    pub fn new(a: &BlockMatrix) -> Result<Self, SolverError> {
        Self::with_threshold(a, SupernodalThreshold::AUTO)
    }

    /// As [`new`](Self::new), with the flop ratio from which on supernodes are used.
    fn with_threshold(
        a: &BlockMatrix,
        threshold: SupernodalThreshold,
    ) -> Result<Self, SolverError> {
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
        Ok(Self {
            pattern,
            llt: SparseLlt::new(starts, rows, threshold)?,
            scalars: vec![0.0; 3 * a.n()],
        })
    }

    /// Factors `a`, of which the lower triangle is read.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`]; [`SolverError::PatternChanged`] when `a` has another
    /// pattern than the matrix given to [`new`](Self::new). After the former there is no factor;
    /// both leave this solver ready for the next matrix.
    pub fn factorise(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        self.pattern.check(a.pattern())?;
        let (pattern, blocks) = (&self.pattern, a.blocks());
        // Column (j, c) of the upper triangle is row (j, c) of the lower one.
        let upper = (0..a.n()).flat_map(|j| {
            (0..3).flat_map(move |c| {
                let left = pattern
                    .lower(j)
                    .flat_map(move |slot| (0..3).map(move |k| blocks[slot][(c, k)]));
                let corner = &blocks[pattern.diagonal(j)];
                left.chain((0..=c).map(move |k| corner[(c, k)]))
            })
        });
        self.llt.factorise(upper)
    }

    /// `x ← A⁻¹ rhs`, with the matrix of the last [`factorise`](Self::factorise).
    ///
    /// # Panics
    /// When there was no successful factorisation, or a length is not the number of particles.
    pub fn solve(&mut self, rhs: &[Vec3], x: &mut [Vec3]) {
        assert_eq!(rhs.len(), self.pattern.n(), "one vector a block row");
        assert_eq!(x.len(), self.pattern.n(), "one vector a block row");
        for (scalars, v) in self.scalars.chunks_exact_mut(3).zip(rhs) {
            scalars.copy_from_slice(v.as_slice());
        }
        self.llt.solve_in_place(&mut self.scalars);
        for (v, scalars) in x.iter_mut().zip(self.scalars.chunks_exact(3)) {
            v.copy_from_slice(scalars);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::{
        Random, dense_blocks, flat, graph, grid_edges, random_blocks, random_filter,
    };
    use crate::{Constraints, LinearOperator, Mat3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn both_kinds_of_factor_solve_like_a_dense_one((n, edges) in graph(10)) {
            let mut random = Random::new(17);
            let a = random_blocks(n, &edges, &mut random);
            let b = random.vectors(n);
            let expected = dense_blocks(&a).cholesky().unwrap().solve(&flat(&b));
            for threshold in [
                SupernodalThreshold::FORCE_SIMPLICIAL,
                SupernodalThreshold::FORCE_SUPERNODAL,
            ] {
                let mut cholesky = BlockCholesky::with_threshold(&a, threshold).unwrap();
                cholesky.factorise(&a).unwrap();
                let mut x = random.vectors(n);
                cholesky.solve(&b, &mut x);
                prop_assert!((flat(&x) - &expected).norm() < 1e-11);
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
            let cholesky = cholesky.get_or_insert_with(|| BlockCholesky::new(&a).unwrap());
            cholesky.factorise(&a).unwrap();
            let x = random.vectors(n);
            let (mut b, mut solution) = (x.clone(), x.clone());
            a.multiply(&x, &mut b);
            cholesky.solve(&b, &mut solution);
            assert!((flat(&solution) - flat(&x)).norm() < 1e-12 * flat(&x).norm());
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused_and_the_next_one_is_solved() {
        let mut random = Random::new(19);
        let edges = grid_edges(4);
        for threshold in
            [SupernodalThreshold::FORCE_SIMPLICIAL, SupernodalThreshold::FORCE_SUPERNODAL]
        {
            let good = random_blocks(16, &edges, &mut random);
            let mut cholesky = BlockCholesky::with_threshold(&good, threshold).unwrap();
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
    }

    #[test]
    fn the_row_of_a_decoupled_negative_block_is_named() {
        let mut a = BlockMatrix::with_pattern(4, [(0, 1), (2, 3)]);
        for i in 0..4 {
            a.add_diagonal(i, &Mat3::identity());
        }
        a.add_diagonal(2, &Mat3::from_diagonal(&Vec3::new(0.0, -2.0, 0.0)));
        let error = BlockCholesky::new(&a).unwrap().factorise(&a).unwrap_err();
        assert!(matches!(error, SolverError::NotPositiveDefinite { row: 7, .. }));
    }

    #[test]
    fn a_projected_matrix_gives_a_solution_that_obeys_the_constraints() {
        let n = 16;
        let mut random = Random::new(20);
        let mut a = random_blocks(n, &grid_edges(4), &mut random);
        let mut constraints = Constraints::free(n);
        for i in 0..n {
            constraints.set(i, random_filter(&mut random), Vec3::zeros());
        }
        let mut b = random.vectors(n);
        constraints.project(&mut b);
        let unprojected = a.clone();
        a.project(&constraints);
        let mut cholesky = BlockCholesky::new(&a).unwrap();
        cholesky.factorise(&a).unwrap();
        let mut x = random.vectors(n);
        cholesky.solve(&b, &mut x);
        let mut filtered = x.clone();
        constraints.project(&mut filtered);
        assert!((flat(&filtered) - flat(&x)).norm() < 1e-12);
        let mut residual = b.clone();
        unprojected.multiply(&x, &mut residual);
        constraints.project(&mut residual);
        assert!((flat(&residual) - flat(&b)).norm() < 1e-11);
    }

    #[test]
    fn another_pattern_is_refused() {
        let a = BlockMatrix::with_pattern(3, [(0, 1)]);
        let other = BlockMatrix::with_pattern(3, [(0, 2)]);
        let error = BlockCholesky::new(&a).unwrap().factorise(&other).unwrap_err();
        assert!(matches!(error, SolverError::PatternChanged { .. }));
    }

    #[test]
    #[should_panic(expected = "solve needs a factorisation that succeeded")]
    fn solving_without_a_factor_is_refused() {
        let a = BlockMatrix::with_pattern(1, []);
        BlockCholesky::new(&a).unwrap().solve(&[Vec3::zeros()], &mut [Vec3::zeros()]);
    }
}
