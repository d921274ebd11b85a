//! Algebraic multigrid for block matrices.

mod aggregation;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;

use std::cell::RefCell;
use std::ops::Range;

use self::aggregation::{Prolongation, smoothed};
use super::Preconditioner;
use crate::block::Rows;
use crate::pattern::Pattern;
use crate::{BlockFactor, BlockMatrix, FactorKind, Mat3, ScalarMatrix, SolverError, Vec3};
use std::borrow::Cow;

/// A level of at most this many particles is solved directly.
const COARSEST: usize = 64;
/// A level above this part of the finer one does not pay.
const LEAST_SHRINKAGE: f64 = 0.8;

/// One V-cycle of multigrid by smoothed aggregation, with a sweep of block Gauss-Seidel before and
/// after.
///
/// Smooth motions of many particles make conjugate gradients slow on a stiff sheet. A coarse
/// particle stands for an aggregate of fine particles and moves them smoothly. Every smooth motion
/// is an oscillation on one of a few ever coarser levels, where a sweep of Gauss-Seidel damps it.
///
/// [`new`](Self::new) computes the weights `P` of a level once from a scalar matrix, such as the
/// stiffnesses of the springs as a Laplacian. The weights are the same for all three coordinates.
/// [`update`](Self::update) computes the coarse matrices of a new matrix, Galerkin's `Pᵀ A P`.
/// Every coarse motion is a motion of the fine particles, so `P` needs no directions: across the
/// springs, where a cloth hardly resists, the coarse diagonal blocks are as soft as the cloth.
///
/// After P. Vaněk, J. Mandel, M. Brezina, *Algebraic multigrid by smoothed aggregation for second
/// and fourth order elliptic problems* (1996); for cloth R. Tamstorf, T. Jones, S. McCormick,
/// *Smoothed aggregation multigrid for cloth simulation* (2015), who choose the coarse motions by
/// the matrix.
///
/// A cycle on a sheet with 12.6 blocks a row costs about as much as 2.3 products, an update about
/// ten. Sums in registers of four numbers were no faster on 52 × 52 particles: a cycle reads their
/// 2.5 MB twice. If the couplings give no smaller level, the matrix itself is factorised.
///
/// ```
/// use drape_solvers::{BlockMatrix, Mat3, Multigrid, Preconditioner, ScalarMatrix, Vec3};
/// # fn main() -> Result<(), drape_solvers::SolverError> {
/// let mut a = BlockMatrix::with_pattern(2, [(0, 1)]);
/// (0..2).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
/// a.add_pair(0, 1, &Mat3::identity());
/// let mut springs = ScalarMatrix::with_pattern(2, [(0, 1)]);
/// springs.add_edge(0, 1, 1.0);
/// let mut multigrid = Multigrid::new(&a, &springs)?;
/// multigrid.update(&a)?;
/// // So few particles are solved directly.
/// let mut z = [Vec3::zeros(); 2];
/// multigrid.on(&a).apply(&[Vec3::x(), Vec3::zeros()], &mut z);
/// assert!((z[0] - Vec3::x() * (2.0 / 3.0)).norm() < 1e-15);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Multigrid {
    /// The pattern that the levels were made for.
    pattern: Pattern,
    levels: Vec<Level>,
    coarsest: RefCell<BlockFactor>,
    ready: bool,
    products: Products,
}

/// Work, as a number of products of the finest matrix with a vector, rounded up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Products {
    /// Work of a cycle.
    pub cycle: usize,
    /// Work of an [update](Multigrid::update).
    pub update: usize,
}

/// The step from one level to the next.
#[derive(Debug)]
struct Level {
    prolongation: Prolongation,
    restriction: Prolongation,
    /// `A P` by rows: starts of their slots, columns, and blocks.
    starts: Vec<u32>,
    columns: Vec<u32>,
    product: Vec<Mat3>,
    /// Inverse diagonal blocks of `A`.
    inverse_diagonal: Vec<Mat3>,
    /// `Pᵀ A P`.
    coarse: Rows,
    /// Slot of each column in the present row.
    slots: Vec<u32>,
    work: RefCell<Work>,
}

/// Vectors of a cycle.
#[derive(Debug)]
struct Work {
    residual: Vec<Vec3>,
    coarse_residual: Vec<Vec3>,
    coarse_solution: Vec<Vec3>,
}

impl Multigrid {
    /// Chooses the levels for the pattern of `a`. `couplings` is a scalar matrix over the same
    /// particles: a Laplacian with any additions to its diagonal.
    ///
    /// # Errors
    /// [`SolverError::Factorisation`] if the factor of the coarsest level does not fit into memory.
    ///
    /// # Panics
    /// When the sizes differ.
    pub fn new(a: &BlockMatrix, couplings: &ScalarMatrix) -> Result<Self, SolverError> {
        assert_eq!(a.n(), couplings.n(), "one row of the couplings a block row");
        let a = &*a.rows();
        let mut levels: Vec<Level> = Vec::new();
        let mut couplings = couplings.clone();
        loop {
            let finest = levels.last().map_or(a, |level| &level.coarse);
            let n = finest.n();
            let is_worth_it = |p: &Prolongation| p.columns() as f64 <= LEAST_SHRINKAGE * n as f64;
            let prolongation = (n > COARSEST).then(|| smoothed(&couplings)).filter(is_worth_it);
            let Some(prolongation) = prolongation else {
                let coarsest = RefCell::new(BlockFactor::of_rows(finest, FactorKind::Cholesky)?);
                let products = Products::of(a.pattern(), &levels, n);
                let pattern = a.pattern().clone();
                return Ok(Self { pattern, levels, coarsest, ready: false, products });
            };
            couplings = prolongation.galerkin(&couplings);
            levels.push(Level::new(finest.pattern(), prolongation));
        }
    }

    /// Computes the coarse matrices of `a`.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] if a diagonal block or the coarsest matrix is not
    /// positive definite, with a row of its level. [`SolverError::PatternChanged`] if `a` has
    /// another pattern than the matrix given to [`new`](Self::new).
    pub fn update(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        self.ready = false;
        let a = a.rows();
        self.pattern.check(a.pattern())?;
        let mut fine = &*a;
        for level in &mut self.levels {
            level.update(fine)?;
            fine = &level.coarse;
        }
        self.coarsest.get_mut().factorise_rows(fine)?;
        self.ready = true;
        Ok(())
    }

    /// Uses the coarse matrices of the last [`update`](Self::update) for `a`. The cycle stays
    /// symmetric and positive definite, and is effective as long as `a` is similar to the matrix of
    /// that update.
    ///
    /// # Errors
    /// As [`update`](Self::update), which is called if there are no coarse matrices.
    pub fn keep(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        if !self.ready {
            return self.update(a);
        }
        self.ready = false;
        let a = a.rows();
        self.pattern.check(a.pattern())?;
        if let Some(finest) = self.levels.first_mut() {
            finest.invert_diagonal(&a)?;
        } else {
            self.coarsest.get_mut().factorise_rows(&a)?;
        }
        self.ready = true;
        Ok(())
    }

    /// The cycle for the matrix of the last [`update`](Self::update) or [`keep`](Self::keep). It is
    /// the identity if there was none, or if the last one failed.
    pub fn on<'a>(&'a self, a: &'a BlockMatrix) -> Cycle<'a> {
        Cycle { multigrid: self, a: a.rows() }
    }

    /// The costs of a cycle and of an update.
    pub fn products(&self) -> Products {
        self.products
    }

    /// Number of particles of each level, from the finest to the coarsest.
    pub fn sizes(&self) -> impl Iterator<Item = usize> {
        let coarse = self.levels.iter().map(|level| level.prolongation.columns());
        std::iter::once(self.pattern.n()).chain(coarse)
    }

    fn cycle(&self, depth: usize, a: &Rows, r: &[Vec3], z: &mut [Vec3]) {
        let Some(level) = self.levels.get(depth) else {
            return self.coarsest.borrow_mut().solve(r, z);
        };
        let work = &mut *level.work.borrow_mut();
        level.smooth_from_zero(a, r, z, &mut work.residual);
        for (coarse, row) in work.coarse_residual.iter_mut().zip(0..) {
            *coarse = level.restriction.sum(row, &work.residual);
        }
        self.cycle(depth + 1, &level.coarse, &work.coarse_residual, &mut work.coarse_solution);
        for (z, row) in z.iter_mut().zip(0..) {
            *z += level.prolongation.sum(row, &work.coarse_solution);
        }
        level.smooth_backward(a, r, z);
    }
}

impl Products {
    /// Blocks that are read over those of the finest matrix. A factor of `m` particles of a planar
    /// mesh has some `10 m` blocks, and takes `40 m^1.5` of them to make.
    fn of(finest: &Pattern, levels: &[Level], coarsest: usize) -> Self {
        let blocks = Pattern::nonzeros;
        let (mut cycle, mut update) = (20 * coarsest, 40 * coarsest * coarsest.isqrt());
        let mut fine = finest;
        for level in levels {
            cycle += 2 * blocks(fine) + 2 * level.columns.len() / 3;
            let entries = |&column: &u32| level.prolongation.row(column as usize).len();
            update += fine.columns().iter().map(entries).sum::<usize>();
            let rows = 0..level.restriction.rows();
            let entries = rows.flat_map(|row| level.restriction.row(row));
            update += entries.map(|&(i, _)| level.row(i as usize).len()).sum::<usize>() / 2;
            fine = level.coarse.pattern();
        }
        let of_finest = |count: usize| count.div_ceil(blocks(finest).max(1));
        Self { cycle: of_finest(cycle), update: of_finest(update) }
    }
}

/// A V-cycle on a matrix.
#[derive(Clone, Debug)]
pub struct Cycle<'a> {
    multigrid: &'a Multigrid,
    a: Cow<'a, Rows>,
}

impl Preconditioner for Cycle<'_> {
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        assert_eq!([r.len(), z.len()], [self.a.n(); 2], "one vector a block row");
        if self.multigrid.ready {
            self.multigrid.cycle(0, &self.a, r, z);
        } else {
            z.copy_from_slice(r);
        }
    }
}

impl Prolongation {
    /// A row times a vector.
    #[inline(always)]
    fn sum(&self, row: usize, x: &[Vec3]) -> Vec3 {
        let mut sum = Vec3::zeros();
        for &(column, weight) in self.row(row) {
            sum += x[column as usize] * weight;
        }
        sum
    }
}

impl Level {
    fn new(fine: &Pattern, prolongation: Prolongation) -> Self {
        let restriction = prolongation.transposed();
        let (n, coarse) = (prolongation.rows(), prolongation.columns());
        let (mut starts, mut columns): (_, Vec<u32>) = (vec![0], Vec::new());
        for i in 0..n {
            let neighbours = fine.columns()[fine.row(i)].iter();
            let mut row: Vec<u32> = neighbours
                .flat_map(|&j| prolongation.row(j as usize).iter().map(|entry| entry.0))
                .collect();
            row.sort_unstable();
            row.dedup();
            columns.extend(row);
            starts.push(columns.len() as u32);
        }
        let mut edges = Vec::new();
        for row in 0..coarse {
            for &(i, _) in restriction.row(row) {
                let slots = starts[i as usize] as usize..starts[i as usize + 1] as usize;
                let left = columns[slots].iter().map(|&column| column as usize);
                edges.extend(left.take_while(|&column| column < row).map(|column| (column, row)));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let zeros = |n| vec![Vec3::zeros(); n];
        Self {
            product: vec![Mat3::zeros(); columns.len()],
            inverse_diagonal: vec![Mat3::zeros(); n],
            coarse: Rows::new(coarse, edges),
            slots: vec![0; coarse],
            work: RefCell::new(Work {
                residual: zeros(n),
                coarse_residual: zeros(coarse),
                coarse_solution: zeros(coarse),
            }),
            prolongation,
            restriction,
            starts,
            columns,
        }
    }

    /// Slots of a row of `A P`.
    #[inline(always)]
    fn row(&self, i: usize) -> Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    fn invert_diagonal(&mut self, a: &Rows) -> Result<(), SolverError> {
        let (pattern, blocks) = (a.pattern(), a.blocks());
        for (i, inverse) in self.inverse_diagonal.iter_mut().enumerate() {
            let block = &blocks[pattern.diagonal(i)];
            let factor = block.cholesky();
            let bad = SolverError::NotPositiveDefinite { row: 3 * i, pivot: None };
            *inverse = factor.ok_or(bad)?.inverse();
        }
        Ok(())
    }

    /// Inverse diagonal blocks, `A P`, and the lower triangle of `Pᵀ (A P)` with its mirror.
    fn update(&mut self, a: &Rows) -> Result<(), SolverError> {
        self.invert_diagonal(a)?;
        let (pattern, blocks) = (a.pattern(), a.blocks());
        self.product.fill(Mat3::zeros());
        for i in 0..a.n() {
            for slot in self.row(i) {
                self.slots[self.columns[slot] as usize] = slot as u32;
            }
            for slot in pattern.row(i) {
                for &(column, weight) in self.prolongation.row(pattern.column(slot)) {
                    let to = self.slots[column as usize] as usize;
                    add_scaled(&mut self.product[to], weight, &blocks[slot]);
                }
            }
        }
        self.coarse.clear();
        for row in 0..self.restriction.rows() {
            let slots = self.coarse.pattern().row(row);
            for slot in slots {
                self.slots[self.coarse.pattern().column(slot)] = slot as u32;
            }
            for &(i, weight) in self.restriction.row(row) {
                let own = self.row(i as usize);
                for (&column, block) in self.columns[own.clone()].iter().zip(&self.product[own]) {
                    if column as usize > row {
                        break;
                    }
                    let to = self.slots[column as usize] as usize;
                    add_scaled(self.coarse.block_mut(to), weight, block);
                }
            }
        }
        self.coarse.mirror_lower();
        Ok(())
    }

    /// Solves `(D + L) z = r`, and writes the residual `r − A z = −U z`.
    fn smooth_from_zero(&self, a: &Rows, r: &[Vec3], z: &mut [Vec3], left: &mut [Vec3]) {
        let (pattern, blocks) = (a.pattern(), a.blocks());
        for i in 0..a.n() {
            let mut sum = r[i];
            for slot in pattern.lower(i) {
                sum -= blocks[slot] * z[pattern.column(slot)];
            }
            z[i] = self.inverse_diagonal[i] * sum;
        }
        for (i, left) in left.iter_mut().enumerate() {
            let mut sum = Vec3::zeros();
            for slot in pattern.diagonal(i) + 1..pattern.row(i).end {
                sum -= blocks[slot] * z[pattern.column(slot)];
            }
            *left = sum;
        }
    }

    /// `z_i ← D_i⁻¹ (r_i − Σ_{j≠i} A_ij z_j)` from the last row to the first.
    fn smooth_backward(&self, a: &Rows, r: &[Vec3], z: &mut [Vec3]) {
        let (pattern, blocks) = (a.pattern(), a.blocks());
        for i in (0..a.n()).rev() {
            let mut sum = r[i];
            for slot in pattern.lower(i) {
                sum -= blocks[slot] * z[pattern.column(slot)];
            }
            for slot in pattern.diagonal(i) + 1..pattern.row(i).end {
                sum -= blocks[slot] * z[pattern.column(slot)];
            }
            z[i] = self.inverse_diagonal[i] * sum;
        }
    }
}

/// `to ← to + w block`.
#[inline(always)]
fn add_scaled(to: &mut Mat3, w: f64, block: &Mat3) {
    for (to, from) in to.as_mut_slice().iter_mut().zip(block.as_slice()) {
        *to += w * from;
    }
}
