//! Filtered conjugate gradients on a [`ScalarMatrix`] by fused SIMD kernels.
//!
//! [`filtered_pcg`](crate::filtered_pcg) sweeps about eight times an iteration over vectors of
//! [`Vec3`]. Here an iteration takes two sweeps, in blocks of [`BLOCK`](crate::vector::BLOCK)
//! particles, the blocks of the documented order of sums:
//!
//! 1. `x ← x + α c` of the iteration before, and `c ← S (P r + β c)`. As soon as the farthest
//!    neighbour is known, `q ← S A c` of a block and its part of `cᵀq` follow, while the block is
//!    in cache. The part is summed in registers during the product; a block with constrained
//!    particles takes a pass of its own.
//! 2. `r ← r − α q`, `rᵀr` and, for a diagonal `P`, `rᵀ P r`, without storing `P r`.
//!
//! Only loops and layouts differ from the readable kernels. Each number comes from the same
//! operations in the same order, so all bits are the same (negative zeros too: an absent entry of a
//! diagonal adds a zero to a sum that began with a positive one). Infinite and undefined numbers
//! end a solve alike, but may stand in other places of `x`.
//!
//! # Counts
//!
//! An iteration with three coordinates, for a mesh with two offsets (five entries a row), per
//! particle:
//!
//! | layout | preconditioner | flops | bytes from memory | held by a solver, bytes |
//! |---|---|---|---|---|
//! | diagonals | Jacobi | 30 product, 6 `cᵀq`, 6 `x`, 9 `c`, 6 `r`, 6 + 9 sums: 72 | 280: `x`, `c`, `r` read and written (`r` read twice), `q` written and read, matrix 24, `P` twice | 96 vectors, 24 matrix, 8 `P` |
//! | rows | Jacobi | 96, a lane in four idle | 444: `x`, `c`, `r`, `q` of 32, matrix 60 with columns, row starts 8, `P` twice | 128 vectors |
//! | rows | IC(0) | 128 | as above with `s` (96), factor twice (80) | 160 vectors |
//!
//! # What was tried
//!
//! Nanoseconds a particle and iteration, least of many repetitions on one core of an AMD EPYC (Zen
//! 4) with other work on the machine, square mesh of `N²` particles. AVX2: 512-bit registers would
//! change the bits of the factorisations that share the SIMD library.
//!
//! | what | predicted | measured |
//! |---|---|---|
//! | readable kernels, Jacobi | | N = 52: 9.0; 1000: 20–22 |
//! | diagonals, plain loops behind a closure | 3 | 6.8: the closure was not inlined into code for AVX2, and all ran on SSE2 |
//! | sums by loops over `[f64; 4]` | as below | 6.4: they were compiled to scalar operations |
//! | sums by explicit operations on four numbers | 3 | N = 52: 3.3; 1000: 13.7 |
//! | a cache line between the coordinates of a block | less | not told from the noise |
//! | product by slices of variable length | | 3.3 or 7.2, as the compiler finds bounds or not |
//! | product by pieces of fixed length | 3.3 | 3.3, always |
//! | three coordinates in one pass over the coefficients | 2.8 (20 loads instead of 30) | N = 20: 3.1; 52: 3.0; 100: 3.0 |
//! | `cᵀq` and `rᵀr` summed in the registers of the product | 2.5 (six loads in 50 fewer) | N = 52: 2.7; 100: 2.9 |
//! | … updated and multiplied in turns of 64 rows, while in the first-level cache | 2.4 | 2.8 |
//! | rows of four numbers, Jacobi | 5 | N = 52: 6.2 |
//! | … right-hand sides loaded from their particles, not from a register's worth just stored in pieces | less | the first residual: a third of its time |
//! | … lengths of rows known to the compiler | less | not told from the noise |
//! | rows of four numbers, IC(0), row after row | 16 | 16.4 (readable 17–21) |
//! | eight lines of the mesh in turns | 9 | 14.6: not the chain but the instructions a row were the limit |
//! | … with rows of equal offsets by constant offsets | 9 | 12.9 |

mod buckets;
mod diagonals;
mod fused;
mod padded;
mod soa;

use crate::bands::bands;
use crate::pcg::{Norm, Operations, conjugate_gradients};
use crate::{
    Constraints, LinearOperator, PcgReport, PcgSettings, Reference, ScalarMatrix, StartValue, Vec3,
};
use fused::Fused;
use padded::Padded;
pub use padded::ScalarPreconditioner;

/// [`filtered_pcg`](crate::filtered_pcg) for a scalar matrix, with the same bits and the same
/// report. It stores the vectors, and if useful the matrix, in a layout of its own.
#[derive(Debug)]
pub struct ScalarPcg(Layout);

#[derive(Debug)]
enum Layout {
    Diagonals(Box<Fused>),
    Rows(Padded),
}

/// The layouts of [`ScalarPcg`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalarLayout {
    /// The matrix by diagonals and each coordinate in an array: for diagonal preconditioners, and
    /// patterns with few offsets between row and column, such as the mesh of a regular sheet.
    Diagonals,
    /// Compressed rows, and particles padded to four numbers: for all matrices.
    Rows,
}

impl ScalarPcg {
    /// Room for solves with the pattern of `a`, in the best layout. `diagonal` states that the
    /// preconditioner is [`Identity`](ScalarPreconditioner::Identity) or
    /// [`Jacobi`](ScalarPreconditioner::Jacobi).
    pub fn new(a: &ScalarMatrix, diagonal: bool) -> Self {
        Self::with_layout(a, diagonal, ScalarLayout::Diagonals)
            .unwrap_or_else(|| Self(Layout::Rows(Padded::new(a, diagonal))))
    }

    /// As [`new`](Self::new), in a given layout; `None` if that layout does not suit the matrix or
    /// the preconditioner.
    pub fn with_layout(a: &ScalarMatrix, diagonal: bool, layout: ScalarLayout) -> Option<Self> {
        Some(Self(match layout {
            ScalarLayout::Diagonals if diagonal => Layout::Diagonals(Box::new(Fused::new(a)?)),
            ScalarLayout::Diagonals => return None,
            ScalarLayout::Rows => Layout::Rows(Padded::new(a, diagonal)),
        }))
    }

    /// The layout in use.
    pub fn layout(&self) -> ScalarLayout {
        match self.0 {
            Layout::Diagonals(_) => ScalarLayout::Diagonals,
            Layout::Rows(_) => ScalarLayout::Rows,
        }
    }

    /// Copies the values of `a`, which must have the pattern given to [`new`](Self::new), and of
    /// the preconditioner. Call it after each change of the matrix or the preconditioner.
    pub fn update(&mut self, a: &ScalarMatrix, p: ScalarPreconditioner<'_>) {
        if let Layout::Diagonals(fused) = &mut self.0 {
            fused.update(a, p);
        }
    }

    /// Lets solves use this many threads of the current [`rayon`] pool, if there are enough
    /// particles. The number of threads does not change any bit. Only the layout
    /// [`Diagonals`](ScalarLayout::Diagonals) uses threads: the sweeps of IC(0) need a fixed order,
    /// and [`Rows`](ScalarLayout::Rows) stay on the caller's thread.
    pub fn set_threads(&mut self, threads: usize) {
        if let Layout::Diagonals(fused) = &mut self.0 {
            fused.set_bands(bands(threads, fused.n()));
        }
    }

    /// `out ← A x` with the matrix of the last [`update`](Self::update). If all numbers are finite,
    /// the result has the same bits as [`multiply`](crate::LinearOperator::multiply) of the matrix.
    ///
    /// # Panics
    /// When the sizes of the arguments differ.
    pub fn multiply(&mut self, a: &ScalarMatrix, x: &[Vec3], out: &mut [Vec3]) {
        assert!([x.len(), out.len()] == [a.n(); 2], "one vector a row of the matrix");
        match &mut self.0 {
            Layout::Diagonals(fused) => fused.multiply(x, out),
            Layout::Rows(_) => a.multiply(x, out),
        }
    }

    /// As [`filtered_pcg`](crate::filtered_pcg) from `start`, with the matrix and the
    /// preconditioner of the last [`update`](Self::update).
    #[expect(
        clippy::too_many_arguments,
        reason = "a linear solve has this many independent parts; each call names them in order"
    )]
    pub fn solve(
        &mut self,
        a: &ScalarMatrix,
        p: ScalarPreconditioner<'_>,
        constraints: &Constraints,
        b: &[Vec3],
        start: StartValue<'_>,
        x: &mut [Vec3],
        reference: Reference,
        settings: &PcgSettings,
    ) -> PcgReport {
        let n = a.n();
        assert!(
            [constraints.len(), b.len(), x.len()] == [n; 3] && start.fits(n),
            "matrix, constraints and vectors are for different numbers of particles"
        );
        match &mut self.0 {
            Layout::Diagonals(fused) => {
                let mut operations = fused.operations(constraints, b, start, x);
                conjugate_gradients(&mut operations, reference, settings)
            }
            Layout::Rows(padded) => {
                start.write(x);
                let mut operations = padded.operations(a, p, constraints, b, x);
                conjugate_gradients(&mut operations, reference, settings)
            }
        }
    }
}

/// Euclidean norms of the residual and of its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualNorms {
    /// Norm of `S (b − A x)`.
    pub residual: f64,
    /// Norm of `S (b − A (I − S) z)`; `None` unless it was requested.
    pub reference: Option<f64>,
}

impl ScalarPcg {
    /// The norms for a vector `x` that obeys the constraints, with the matrix of the last
    /// [`update`](Self::update). This takes one product, or two with a reference and prescribed
    /// motion.
    ///
    /// # Panics
    /// When the sizes of the arguments differ.
    pub fn residual_norms(
        &mut self,
        a: &ScalarMatrix,
        constraints: &Constraints,
        b: &[Vec3],
        x: &mut [Vec3],
        with_reference: bool,
    ) -> ResidualNorms {
        assert!(
            [constraints.len(), b.len(), x.len()] == [a.n(); 3],
            "matrix, constraints and vectors are for different numbers of particles"
        );
        fn norms(mut operations: impl Operations, with_reference: bool) -> ResidualNorms {
            let start = operations.start(with_reference.then_some(Norm::Euclid));
            let reference = with_reference.then_some(start.reference);
            ResidualNorms { residual: operations.residual_norm(), reference }
        }
        match &mut self.0 {
            Layout::Diagonals(fused) => {
                let start = StartValue::Given;
                norms(fused.operations(constraints, b, start, x), with_reference)
            }
            Layout::Rows(padded) => {
                let p = ScalarPreconditioner::Identity;
                norms(padded.operations(a, p, constraints, b, x), with_reference)
            }
        }
    }

    /// Writes the residual of the last call of [`residual_norms`](Self::residual_norms):
    /// `out ← S (b − A x)`.
    ///
    /// # Panics
    /// Unless `out` has one vector per particle.
    pub fn residual(&self, out: &mut [Vec3]) {
        let n = match &self.0 {
            Layout::Diagonals(fused) => fused.n(),
            Layout::Rows(padded) => padded.n(),
        };
        assert_eq!(out.len(), n, "one vector a particle");
        match &self.0 {
            Layout::Diagonals(fused) => fused.residual(out),
            Layout::Rows(padded) => padded.residual(out),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;
