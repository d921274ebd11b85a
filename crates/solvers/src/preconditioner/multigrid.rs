//! Algebraic multigrid for block matrices.

mod aggregation;
mod level;
mod sweeps;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;

use self::aggregation::{Prolongation, smoothed};
use self::level::Level;
use super::Preconditioner;
use crate::block::Rows;
use crate::pattern::Pattern;
use crate::{BlockFactor, BlockMatrix, FactorKind, ScalarMatrix, SolverError, Vec3};
use drape_kernels::lanes::Lanes;
use std::cell::RefCell;

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
/// If the couplings give no smaller level, the matrix itself is factorised.
///
/// # What it costs
///
/// Sweeps read half of the matrix, and use each block twice. So the matrix may have any layout: on
/// regular grids products go along bands. All places along a band count as couplings, also those
/// across the ends of the grid's rows, which hold zeros: 1 to 2 % of a cycle.
///
/// A sheet with 12.6 blocks a row, on one core of a Zen 4 with other work beside it, the least of
/// 40, µs:
///
/// | | 52 × 52 particles | 100 × 100 |
/// |---|---|---|
/// | product in compressed rows | 73 | 271 |
/// | product along bands | 29 | 110 |
/// | cycle that reads both triangles, number by number | 257 | 1190 |
/// | half of the matrix, in registers of four numbers | 206 | 790 |
/// | the same without transposes, as all blocks are symmetric | 188 | 710 |
/// | **the same with each column in one load** | 149 | |
/// | keep, from bands | 85 | |
/// | update, from bands | 805 | |
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
/// multigrid.apply(&[Vec3::x(), Vec3::zeros()], &mut z);
/// assert!((z[0] - Vec3::x() * (2.0 / 3.0)).norm() < 1e-15);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Multigrid {
    /// The pattern that the levels were made for.
    pattern: Pattern,
    /// Compressed rows of the matrix of the last update, if that has another layout.
    finest: Option<Rows>,
    /// [`Pattern::mirrors`] of the finest pattern.
    mirrors: Vec<u32>,
    levels: Vec<Level>,
    coarsest: RefCell<BlockFactor>,
    /// The vectors of each level, the coarsest last.
    work: RefCell<Vec<Vectors>>,
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

/// Vectors of a level in a cycle.
#[derive(Debug)]
struct Vectors {
    right: Vec<Lanes>,
    solution: Vec<Lanes>,
    residual: Vec<Lanes>,
}

impl Vectors {
    fn new(n: usize) -> Self {
        let [right, solution, residual] = [(); 3].map(|()| vec![[0.0; 4]; n]);
        Self { right, solution, residual }
    }
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
        let is_in_rows = a.as_rows().is_some();
        let a = a.rows();
        assert!(a.pattern().nonzeros() < u32::MAX as usize, "more blocks than a u32 can number");
        let mut levels: Vec<Level> = Vec::new();
        let mut work = Vec::new();
        let mut couplings = couplings.clone();
        let coarsest = loop {
            let finest = levels.last().map_or(&*a, Level::coarse);
            let n = finest.n();
            work.push(Vectors::new(n));
            let is_worth_it = |p: &Prolongation| p.columns() as f64 <= LEAST_SHRINKAGE * n as f64;
            let prolongation = (n > COARSEST).then(|| smoothed(&couplings)).filter(is_worth_it);
            let Some(prolongation) = prolongation else {
                break BlockFactor::of_rows(finest, FactorKind::Cholesky)?;
            };
            couplings = prolongation.galerkin(&couplings);
            levels.push(Level::new(finest.pattern(), prolongation));
        };
        Ok(Self {
            products: Products::of(a.pattern(), &levels),
            pattern: a.pattern().clone(),
            mirrors: a.pattern().mirrors(),
            finest: (!is_in_rows).then(|| a.into_owned()),
            levels,
            coarsest: RefCell::new(coarsest),
            work: RefCell::new(work),
            ready: false,
        })
    }

    /// Copies `a`, and computes its coarse matrices. A change of `a` is not seen until the next
    /// update. The first update in a layout other than that given to [`new`](Self::new) may
    /// allocate.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] if a diagonal block or the coarsest matrix is not
    /// positive definite, with a row of its level. [`SolverError::PatternChanged`] if `a` has
    /// another pattern than the matrix given to [`new`](Self::new).
    pub fn update(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        self.read(a)?;
        let mut fine = match a.as_rows() {
            Some(rows) => rows,
            None => {
                let rows =
                    self.finest.get_or_insert_with(|| Rows::of_pattern(self.pattern.clone()));
                match self.levels.first() {
                    Some(level) => rows.write_lower(level.lower(), |i| a.get(i, i), &self.mirrors),
                    None => rows.fill(|i, j| a.get(i, j)),
                }
                rows
            }
        };
        let mut levels = self.levels.iter_mut().peekable();
        while let Some(level) = levels.next() {
            level.coarsen(fine);
            fine = level.coarse();
            if let Some(next) = levels.peek_mut() {
                next.read(fine)?;
            }
        }
        self.coarsest.get_mut().factorise_rows(fine)?;
        self.ready = true;
        Ok(())
    }

    /// Copies `a`, and keeps the coarse matrices of the last [`update`](Self::update). The cycle
    /// stays symmetric and positive definite, and is effective as long as `a` is similar to the
    /// matrix of that update.
    ///
    /// # Errors
    /// As [`update`](Self::update), which is called if there are no coarse matrices.
    pub fn keep(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        if !self.ready || self.levels.is_empty() {
            return self.update(a);
        }
        self.read(a)?;
        self.ready = true;
        Ok(())
    }

    /// Reads the finest matrix.
    fn read(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        self.ready = false;
        if !a.has_pattern(&self.pattern) {
            return Err(self.pattern.changed(a.n(), a.nonzeros()));
        }
        self.levels.first_mut().map_or(Ok(()), |level| level.read(a))
    }

    /// The costs of a cycle and of an update.
    pub fn products(&self) -> Products {
        self.products
    }

    /// Number of particles of each level, from the finest to the coarsest.
    pub fn sizes(&self) -> impl Iterator<Item = usize> {
        let coarse = self.levels.iter().map(|level| level.coarse().n());
        std::iter::once(self.pattern.n()).chain(coarse)
    }

    /// A cycle, from the right-hand side to the solution of the first level's vectors.
    fn cycle(&self, vectors: &mut [Vectors]) {
        for (depth, level) in self.levels.iter().enumerate() {
            if let [fine, coarse, ..] = &mut vectors[depth..] {
                level.descend(fine, &mut coarse.right);
            }
        }
        if let Some(Vectors { right, solution, .. }) = vectors.last_mut() {
            let write = |i: usize, [x, y, z]: [f64; 3]| solution[i] = [x, y, z, 0.0];
            self.coarsest
                .borrow_mut()
                .solve_each(|i| [right[i][0], right[i][1], right[i][2]], write);
        }
        for (depth, level) in self.levels.iter().enumerate().rev() {
            if let [fine, coarse, ..] = &mut vectors[depth..] {
                level.ascend(&coarse.solution, fine);
            }
        }
    }
}

impl Preconditioner for Multigrid {
    /// A cycle for the matrix of the last [`update`](Multigrid::update) or
    /// [`keep`](Multigrid::keep). It is the identity if there was none, or if the last one failed.
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        assert_eq!([r.len(), z.len()], [self.pattern.n(); 2], "one vector a block row");
        if !self.ready {
            return z.copy_from_slice(r);
        }
        let vectors = &mut *self.work.borrow_mut();
        for (to, r) in vectors[0].right.iter_mut().zip(r) {
            *to = [r.x, r.y, r.z, 0.0];
        }
        self.cycle(vectors);
        for (z, from) in z.iter_mut().zip(&vectors[0].solution) {
            *z = Vec3::new(from[0], from[1], from[2]);
        }
    }
}

impl Products {
    /// Blocks that are multiplied over those of the finest matrix. A factor of `m` particles of a
    /// planar mesh has some `10 m` blocks, and takes `40 m^1.5` of them to make.
    fn of(finest: &Pattern, levels: &[Level]) -> Self {
        let blocks = Pattern::nonzeros;
        let coarsest = levels.last().map_or(finest.n(), |level| level.coarse().n());
        let (mut cycle, mut update) = (20 * coarsest, 40 * coarsest * coarsest.isqrt());
        let mut fine = finest;
        for level in levels {
            let (own, coarsening) = level.blocks(fine);
            cycle += own;
            update += coarsening;
            fine = level.coarse().pattern();
        }
        let of_finest = |count: usize| count.div_ceil(blocks(finest).max(1));
        Self { cycle: of_finest(cycle), update: of_finest(update) }
    }
}
