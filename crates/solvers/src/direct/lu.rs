//! The direct solver for block matrices that are not symmetric.

use crate::block::Rows;
use crate::ordering;
use crate::pattern::Pattern;
use crate::{Constraints, LinearOperator, Mat3, SolverError, Vec3};

/// A matrix of 3×3 blocks with a symmetric pattern and any values, in compressed rows.
///
/// Discrete gradients have such a matrix: the force between two particles depends on the difference
/// of their positions, but its derivative is not a symmetric block.
#[derive(Clone, Debug)]
pub struct UnsymmetricBlocks(Rows);

impl UnsymmetricBlocks {
    /// The zero matrix with room for `n` diagonal blocks and for (i, j) and (j, i) of each edge.
    /// Edges may be repeated.
    ///
    /// # Panics
    /// When an edge names a row that is not below `n`.
    pub fn with_pattern(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
        Self(Rows::new(n, edges))
    }

    /// Sets all blocks to zero; the pattern stays.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds `block` to diagonal block `i`.
    pub fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.0.add_diagonal(i, block);
    }

    /// Adds `block` at (i, i) and (j, j), and its negative at (i, j) and (j, i): the contribution
    /// of a force that depends on the difference between particles `i` and `j`. For `i = j` it adds
    /// nothing.
    ///
    /// A pair outside the pattern is a bug in the caller: debug builds panic, release builds ignore
    /// the pair.
    pub fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.0.add_pair(i, j, block);
    }

    /// Block (i, j); zero outside the pattern.
    pub fn get(&self, i: usize, j: usize) -> Mat3 {
        self.0.get(i, j)
    }

    /// `A ← S A S + (I − S) D` as [`BlockMatrix::project`](crate::BlockMatrix::project).
    ///
    /// # Panics
    /// If `constraints` is for another number of particles.
    pub fn project(&mut self, constraints: &Constraints) {
        assert_eq!(constraints.len(), self.0.n(), "one filter a block row");
        self.0.project_both_sides(constraints);
    }
}

impl LinearOperator for UnsymmetricBlocks {
    fn size(&self) -> usize {
        self.0.n()
    }

    fn multiply(&self, x: &[Vec3], y: &mut [Vec3]) {
        assert_eq!(x.len(), self.0.n(), "one vector a block row");
        assert_eq!(y.len(), self.0.n(), "one vector a block row");
        self.0.multiply(0..y.len(), x, y);
    }
}

/// Growth of the factor beyond which no digit of a solution is certain: 1/√ε.
const GROWTH_LIMIT: f64 = 67_108_864.0;

/// The inverse of a diagonal block times the largest entry of its row of `A`, beyond which its
/// pivots are rounding errors.
const LOST: f64 = 1.0 / (64.0 * f64::EPSILON);

/// Sparse factorisation `A = L U` of [`UnsymmetricBlocks`], block by block.
///
/// [`new`](Self::new) finds a fill-reducing order of the particles and the pattern of the factor;
/// [`factorise`](Self::factorise) and [`solve`](Self::solve) then allocate nothing. It uses no
/// library, so the bits are the same on every machine. Rows are exchanged only within a 3×3 block,
/// because the pattern of the factor is fixed. A matrix that needs other exchanges is an error.
///
/// ```
/// use drape_solvers::{BlockLu, Mat3, UnsymmetricBlocks, Vec3};
/// # fn main() -> Result<(), drape_solvers::SolverError> {
/// let mut a = UnsymmetricBlocks::with_pattern(1, []);
/// a.add_diagonal(0, &Mat3::new(0.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0));
/// let mut factor = BlockLu::new(&a)?;
/// factor.factorise(&a)?;
/// let mut x = [Vec3::zeros()];
/// factor.solve(&[Vec3::new(4.0, 1.0, 5.0)], &mut x);
/// assert_eq!(x[0], Vec3::new(1.0, 2.0, 3.0));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct BlockLu {
    /// The pattern that the factor was made for.
    pattern: Pattern,
    /// The particles in the order of elimination, and the place of each in it.
    nodes: Vec<u32>,
    places: Vec<u32>,
    /// The pattern of `L + U` in the order of elimination.
    filled: Pattern,
    /// `L` left of the diagonal, the inverse of the diagonal blocks of `U`, and `U` right of them.
    blocks: Vec<Mat3>,
    /// One row of the factor, spread out.
    row: Vec<Mat3>,
    /// A vector in the order of elimination.
    vector: Vec<Vec3>,
    factored: bool,
}

impl BlockLu {
    /// Analyses the pattern of `a` and orders its elimination. The values of `a` do not matter.
    ///
    /// # Errors
    /// [`SolverError::Factorisation`] if the factor does not fit into memory.
    pub fn new(a: &UnsymmetricBlocks) -> Result<Self, SolverError> {
        let pattern = a.0.pattern().clone();
        let n = pattern.n();
        let nodes = ordering::fill_reducing(&pattern)?;
        let mut places = vec![0; n];
        for (place, &node) in (0..).zip(&nodes) {
            places[node as usize] = place;
        }
        let filled = Pattern::new(n, ordering::filled(&pattern, &nodes));
        Ok(Self {
            blocks: vec![Mat3::zeros(); filled.nonzeros()],
            row: vec![Mat3::zeros(); n],
            vector: vec![Vec3::zeros(); n],
            factored: false,
            pattern,
            nodes,
            places,
            filled,
        })
    }

    /// Number of blocks of the factor.
    pub fn nonzeros(&self) -> usize {
        self.filled.nonzeros()
    }

    /// Factors `a`.
    ///
    /// # Errors
    /// [`SolverError::Singular`] for a diagonal block without an inverse, for a factor that grows
    /// without limit, and for numbers that are not finite. There is no factor then.
    /// [`SolverError::PatternChanged`] if `a` has another pattern than the matrix given to
    /// [`new`](Self::new).
    pub fn factorise(&mut self, a: &UnsymmetricBlocks) -> Result<(), SolverError> {
        self.factored = false;
        self.pattern.check(a.0.pattern())?;
        let Self { pattern, nodes, places, filled, blocks, row, .. } = self;
        for i in 0..nodes.len() {
            let node = nodes[i] as usize;
            filled.row(i).for_each(|slot| row[filled.column(slot)] = Mat3::zeros());
            let mut largest = 0.0_f64;
            for slot in pattern.row(node) {
                let block = a.0.blocks()[slot];
                largest = largest.max(block.amax());
                row[places[pattern.column(slot)] as usize] = block;
            }
            let mut growth = 0.0_f64;
            for slot in filled.lower(i) {
                let k = filled.column(slot);
                let diagonal = filled.diagonal(k);
                let factor = row[k] * blocks[diagonal]; // L_ik = A_ik U_kk⁻¹
                growth = growth.max(factor.amax());
                blocks[slot] = factor;
                for above in diagonal + 1..filled.row(k).end {
                    row[filled.column(above)] -= factor * blocks[above]; // A_ij − L_ik U_kj
                }
            }
            let bad = SolverError::Singular { row: 3 * node, pivot: None };
            let inverse = row[i].lu().try_inverse().ok_or(bad)?;
            // A product with a number that is not finite fails the comparison, too.
            let is_good = inverse.iter().all(|value| (value * largest).abs() < LOST);
            if !(is_good && growth <= GROWTH_LIMIT) {
                return Err(bad);
            }
            let diagonal = filled.diagonal(i);
            blocks[diagonal] = inverse;
            for slot in diagonal + 1..filled.row(i).end {
                blocks[slot] = row[filled.column(slot)];
            }
        }
        self.factored = true;
        Ok(())
    }

    /// `x ← A⁻¹ rhs`, with the matrix of the last [`factorise`](Self::factorise).
    ///
    /// # Panics
    /// If no factorisation has succeeded, or if a length differs from the number of particles.
    pub fn solve(&mut self, rhs: &[Vec3], x: &mut [Vec3]) {
        assert!(self.factored, "solve needs a factorisation that succeeded");
        let n = self.nodes.len();
        assert!(rhs.len() == n && x.len() == n, "one vector a block row");
        let Self { nodes, filled, blocks, vector, .. } = self;
        for i in 0..n {
            let mut sum = rhs[nodes[i] as usize];
            filled.lower(i).for_each(|slot| sum -= blocks[slot] * vector[filled.column(slot)]);
            vector[i] = sum; // L y = rhs
        }
        for i in (0..n).rev() {
            let mut sum = vector[i];
            let diagonal = filled.diagonal(i);
            for slot in diagonal + 1..filled.row(i).end {
                sum -= blocks[slot] * vector[filled.column(slot)];
            }
            vector[i] = blocks[diagonal] * sum; // U x = y
            x[nodes[i] as usize] = vector[i];
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::{Random, flat, graph, grid_edges, random_filter};
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    fn random(n: usize, edges: &[(usize, usize)], random: &mut Random) -> UnsymmetricBlocks {
        let mut a = UnsymmetricBlocks::with_pattern(n, edges.iter().copied());
        (0..n).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
        for &(i, j) in edges {
            let (d, e) = (random.vector(), random.vector());
            a.add_pair(i, j, &(0.4 * d * e.transpose() + 0.5 * Mat3::identity()));
        }
        a
    }

    fn dense(a: &UnsymmetricBlocks) -> DMatrix<f64> {
        let n = 3 * a.size();
        DMatrix::from_fn(n, n, |i, j| a.get(i / 3, j / 3)[(i % 3, j % 3)])
    }

    proptest! {
        #[test]
        fn solutions_are_those_of_a_dense_factor((n, edges) in graph(10), seed in 0..10_000_u64) {
            let mut numbers = Random::new(seed);
            let a = random(n, &edges, &mut numbers);
            let b = numbers.vectors(n);
            let mut factor = BlockLu::new(&a).unwrap();
            factor.factorise(&a).unwrap();
            let mut x = numbers.vectors(n);
            factor.solve(&b, &mut x);
            let residual = dense(&a) * flat(&x) - flat(&b);
            prop_assert!(residual.norm() < 1e-11 * (1.0 + dense(&a).norm() * flat(&x).norm()));
        }
    }

    #[test]
    fn a_grid_is_solved_to_round_off_and_refactored_in_place() {
        let (n, edges) = (144, grid_edges(12));
        let mut numbers = Random::new(5);
        let mut factor = BlockLu::new(&random(n, &edges, &mut numbers)).unwrap();
        for _ in 0..3 {
            let a = random(n, &edges, &mut numbers);
            assert!((dense(&a) - dense(&a).transpose()).norm() > 1.0, "not symmetric");
            factor.factorise(&a).unwrap();
            let x = numbers.vectors(n);
            let (mut b, mut solution) = (x.clone(), x.clone());
            a.multiply(&x, &mut b);
            factor.solve(&b, &mut solution);
            assert!((flat(&solution) - flat(&x)).norm() < 1e-12 * flat(&x).norm());
        }
    }

    #[test]
    fn a_projected_matrix_gives_a_solution_that_obeys_the_constraints() {
        let (n, edges) = (16, grid_edges(4));
        let mut numbers = Random::new(20);
        let mut a = random(n, &edges, &mut numbers);
        let mut constraints = Constraints::free(n);
        (0..n).for_each(|i| constraints.set(i, random_filter(&mut numbers), Vec3::zeros()));
        let mut b = numbers.vectors(n);
        constraints.project(&mut b);
        let unprojected = a.clone();
        a.project(&constraints);
        let mut factor = BlockLu::new(&a).unwrap();
        factor.factorise(&a).unwrap();
        let mut x = numbers.vectors(n);
        factor.solve(&b, &mut x);
        let mut filtered = x.clone();
        constraints.project(&mut filtered);
        assert!((flat(&filtered) - flat(&x)).norm() < 1e-12);
        let mut residual = b.clone();
        unprojected.multiply(&x, &mut residual);
        constraints.project(&mut residual);
        assert!((flat(&residual) - flat(&b)).norm() < 1e-11);
    }

    #[test]
    fn singular_matrices_and_other_patterns_are_refused_and_the_next_one_is_solved() {
        let mut numbers = Random::new(7);
        let good = random(16, &grid_edges(4), &mut numbers);
        let mut factor = BlockLu::new(&good).unwrap();
        for bad in [f64::NAN, f64::INFINITY] {
            let mut a = good.clone();
            a.add_diagonal(5, &(bad * Mat3::identity()));
            assert!(matches!(factor.factorise(&a), Err(SolverError::Singular { .. })));
        }
        // Without masses translations cost nothing.
        let mut a = UnsymmetricBlocks::with_pattern(16, grid_edges(4));
        grid_edges(4).iter().for_each(|&(i, j)| a.add_pair(i, j, &Mat3::identity()));
        assert!(matches!(factor.factorise(&a), Err(SolverError::Singular { .. })));
        let other = UnsymmetricBlocks::with_pattern(16, [(0, 15)]);
        assert!(matches!(factor.factorise(&other), Err(SolverError::PatternChanged { .. })));
        factor.factorise(&good).unwrap();
        let x = numbers.vectors(16);
        let (mut b, mut solution) = (x.clone(), x.clone());
        good.multiply(&x, &mut b);
        factor.solve(&b, &mut solution);
        assert!((flat(&solution) - flat(&x)).norm() < 1e-12);
    }
}
