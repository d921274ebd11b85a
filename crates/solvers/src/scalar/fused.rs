//! Conjugate gradients on a matrix by diagonals, with a diagonal preconditioner, in two sweeps an
//! iteration.
//!
//! # Threads
//!
//! A sweep runs in bands of consecutive blocks, [several a thread](crate::bands). Each block has a
//! place of its own for its sums. When all bands are done, these are added from the first block to
//! the last: the order of the readable kernels, for any number of bands.
//!
//! The product in a block needs directions from up to [`Diagonals::reach`] rows away. A band
//! multiplies behind its own updates while these are its own rows. The blocks of its rim wait until
//! all bands have their directions, and take a third, short sweep. All products after all updates
//! would read the directions once more from memory: 24 of 280 bytes a particle.

mod sums;
mod sweeps;

use self::sums::Measure;
use self::sweeps::{Operator, scatter};
use super::buckets::Buckets;
use super::diagonals::Diagonals;
use super::padded::ScalarPreconditioner;
use super::soa::{Block, Coordinates, PaddedRow, Rows, RowsMut};
use crate::bands::{Divisible, PerBlock, in_bands};
use crate::pcg::{Norm, Operations, StartReport};
use crate::vector::BLOCK;
use crate::{Constraints, ScalarMatrix, StartValue, Vec3};
use drape_kernels::lanes::{four_wide, vectorised};
use pulp::Arch;
use std::ops::Range;

/// The matrix, the preconditioner and the vectors of a solve.
#[derive(Debug)]
pub(super) struct Fused {
    operator: Operator,
    x: Vec<Block>,
    r: Vec<Block>,
    q: Vec<Block>,
    c: Coordinates,
    sums: Sums,
    arch: Arch,
    bands: usize,
}

/// Contributions of each block to the sums.
#[derive(Debug)]
struct Sums {
    /// Of the residual.
    residual: Vec<Measure>,
    /// Of the right-hand side.
    load: Vec<Measure>,
    /// Of `cᵀq`, or of the square of a difference.
    product: Vec<f64>,
}

impl Fused {
    /// Room for solves with the pattern of `a`; `None` when it does not suit.
    pub(super) fn new(a: &ScalarMatrix) -> Option<Self> {
        let matrix = Diagonals::new(a)?;
        let n = matrix.n();
        let count = n.div_ceil(BLOCK);
        let (blocks, measures) = (|| vec![Block::ZERO; count], || vec![Measure::ZERO; count]);
        let mut inverse_diagonal = PaddedRow::zeros(n, 0);
        inverse_diagonal.rows_mut()[..n].fill(1.0);
        Some(Self {
            x: blocks(),
            r: blocks(),
            q: blocks(),
            c: Coordinates::zeros(n, matrix.reach()),
            sums: Sums { residual: measures(), load: measures(), product: vec![0.0; count] },
            operator: Operator { matrix, inverse_diagonal, buckets: Buckets::new(n) },
            arch: four_wide(),
            bands: 1,
        })
    }

    /// Copies the values of `a` and of a diagonal preconditioner.
    pub(super) fn update(&mut self, a: &ScalarMatrix, p: ScalarPreconditioner<'_>) {
        let Operator { matrix, inverse_diagonal, .. } = &mut self.operator;
        matrix.update(a);
        let inverse = &mut inverse_diagonal.rows_mut()[..a.n()];
        match p {
            ScalarPreconditioner::Jacobi(jacobi) => {
                inverse.copy_from_slice(jacobi.inverse_diagonal());
            }
            ScalarPreconditioner::Identity | ScalarPreconditioner::Ic0(_) => inverse.fill(1.0),
        }
    }

    /// Number of particles.
    pub(super) fn n(&self) -> usize {
        self.operator.matrix.n()
    }

    /// Sets the number of bands.
    pub(super) fn set_bands(&mut self, bands: usize) {
        self.bands = bands;
    }

    /// The residual, to particles.
    pub(super) fn residual(&self, out: &mut [Vec3]) {
        for (out, r) in out.chunks_mut(BLOCK).zip(&self.r) {
            scatter(r, out);
        }
    }

    /// The operations of one solve.
    pub(super) fn operations<'a>(
        &'a mut self,
        constraints: &'a Constraints,
        b: &'a [Vec3],
        start: StartValue<'a>,
        solution: &'a mut [Vec3],
    ) -> FusedSolve<'a> {
        self.operator.buckets.fill(constraints);
        let (postponed, measure) = (None, Measure::NAN);
        FusedSolve { constraints, b, start, solution, postponed, measure, of: self }
    }
}

/// One solve.
#[derive(Debug)]
pub(super) struct FusedSolve<'a> {
    constraints: &'a Constraints,
    b: &'a [Vec3],
    start: StartValue<'a>,
    solution: &'a mut [Vec3],
    /// `α` of an update of `x` that the next sweep over `c` performs.
    postponed: Option<f64>,
    /// Of the residual.
    measure: Measure,
    of: &'a mut Fused,
}

impl Operations for FusedSolve<'_> {
    fn start(&mut self, reference: Option<Norm>) -> StartReport {
        let Self { constraints, b, start: from, solution, of, .. } = self;
        let mut start = StartReport { reference: f64::NAN, multiplications: 0 };
        let moving = reference.filter(|_| constraints.has_prescribed_motion());
        if let Some(norm) = moving {
            of.take_prescribed(constraints);
            of.residuals(constraints, b, None);
            let reference = Measure::sum(&of.sums.residual).length(norm);
            start = StartReport { reference, multiplications: 1 };
        }
        let from = match *from {
            StartValue::Given => StartValue::At(solution),
            elsewhere => elsewhere,
        };
        of.load(constraints, from);
        of.residuals(constraints, b, reference.filter(|_| moving.is_none()));
        self.measure = Measure::sum(&of.sums.residual);
        if let (Some(norm), None) = (reference, moving) {
            start.reference = Measure::sum(&of.sums.load).length(norm);
        }
        start
    }

    fn stop_at_prescribed(&mut self) {
        self.constraints.prescribed_only(self.solution);
    }

    fn residual_norm(&mut self) -> f64 {
        self.measure.length(Norm::Euclid)
    }

    fn precondition(&mut self) -> f64 {
        self.measure.delta
    }

    fn refresh(&mut self) -> f64 {
        // x takes the place of c, since the product needs neighbours.
        self.of.swap_direction_for_solution(self.postponed.take());
        self.of.new_residuals(self.constraints, self.b);
        self.of.restore_direction();
        self.measure = Measure::sum(&self.of.sums.residual);
        sum(&self.of.sums.product).sqrt()
    }

    fn direction(&mut self, beta: Option<f64>) -> f64 {
        self.of.direction(self.constraints, beta, self.postponed.take());
        if self.of.bands > 1 {
            self.of.rims(self.constraints);
        }
        sum(&self.of.sums.product)
    }

    fn direction_is_zero(&mut self) -> bool {
        let c = self.of.c.rows().window(0, self.of.n());
        c.iter().all(|c| c.iter().all(|c| c * c == 0.0))
    }

    fn advance(&mut self, alpha: f64) {
        self.postponed = Some(alpha);
        self.of.advance(alpha);
        self.measure = Measure::sum(&self.of.sums.residual);
    }

    fn finish(&mut self) {
        self.of.store(self.postponed.take(), self.solution);
    }
}

/// The sum of the blocks' contributions, from the first to the last.
fn sum(blocks: &[f64]) -> f64 {
    blocks.iter().fold(0.0, |sum, block| sum + block)
}

/// Runs a call over the blocks of all bands, compiled for the present processor. A band writes
/// `part`; all bands read the other values.
macro_rules! sweep {
    (
        $fused:ident.[$($field:ident),*],
        |$four:ident, $operator:ident, $band:ident|
        $part:ident: $part_type:ty = $written:expr;
        [$($name:ident: $type:ty = $value:expr),* $(,)?] $call:expr
    ) => {{
        let Self { operator: $operator, arch, bands, $($field,)* .. } = $fused;
        over_blocks(*bands, $operator, $written, &|$band, $part| {
            vectorised!(arch, [$four,
                $operator: &'k Operator = $operator,
                $band: Range<usize> = $band,
                $part: $part_type = $part,
                $($name: $type = $value,)*
            ] -> () { $call })
        });
    }};
}

/// One array for each block, in bands.
type Blocks<'k> = PerBlock<'k, Block>;
type Measures<'k> = PerBlock<'k, Measure>;
type Numbers<'k> = PerBlock<'k, f64>;

/// The sweeps over all bands.
impl Fused {
    fn take_prescribed(&mut self, constraints: &Constraints) {
        sweep!(self.[c], |_four, operator, band|
            c: RowsMut<'k> = c.rows_mut();
            [constraints: &'k Constraints = constraints]
            operator.take_prescribed(constraints, band, c));
    }

    /// `out ← A v`.
    pub(super) fn multiply(&mut self, v: &[Vec3], out: &mut [Vec3]) {
        sweep!(self.[c], |_four, operator, band|
            c: RowsMut<'k> = c.rows_mut();
            [v: &'k [Vec3] = v]
            operator.take(band, v, c));
        sweep!(self.[c, q], |four, operator, band|
            to: (Blocks<'k>, &'k mut [Vec3]) = (PerBlock(q), &mut *out);
            [c: Rows<'k> = c.rows()]
            operator.product(four, band, c, (to.0.0, to.1)));
    }

    fn load(&mut self, constraints: &Constraints, start: StartValue<'_>) {
        sweep!(self.[x, c], |_four, operator, band|
            to: (Blocks<'k>, RowsMut<'k>) = (PerBlock(x), c.rows_mut());
            [constraints: &'k Constraints = constraints, start: StartValue<'k> = start]
            operator.load(constraints, band, start, to.0.0, to.1));
    }

    fn residuals(&mut self, constraints: &Constraints, b: &[Vec3], norm: Option<Norm>) {
        sweep!(self.[r, q, c, sums], |four, operator, band|
            to: ((Blocks<'k>, Blocks<'k>), Measures<'k>, Measures<'k>) = (
            (PerBlock(r), PerBlock(q)),
            PerBlock(&mut sums.residual),
            PerBlock(&mut sums.load),
        );
        [
            constraints: &'k Constraints = constraints,
            from: (&'k [Vec3], Rows<'k>, Option<Norm>) = (b, c.rows(), norm),
        ]
        operator.residuals(
            four, constraints, band, from, (to.0.0.0, to.0.1.0), (to.1.0, to.2.0),
        ));
    }

    fn swap_direction_for_solution(&mut self, postponed: Option<f64>) {
        sweep!(self.[x, q, c], |_four, operator, band|
            to: (Blocks<'k>, Blocks<'k>, RowsMut<'k>) = (PerBlock(x), PerBlock(q), c.rows_mut());
            [postponed: Option<f64> = postponed]
            operator.swap_direction_for_solution(band, postponed, to.0.0, to.1.0, to.2));
    }

    fn restore_direction(&mut self) {
        sweep!(self.[q, c], |_four, operator, band|
            c: RowsMut<'k> = c.rows_mut();
            [q: &'k [Block] = q]
            operator.restore_direction(band, q, c));
    }

    fn new_residuals(&mut self, constraints: &Constraints, b: &[Vec3]) {
        sweep!(self.[r, c, sums], |four, operator, band|
            to: (Blocks<'k>, Measures<'k>, Numbers<'k>) =
                (PerBlock(r), PerBlock(&mut sums.residual), PerBlock(&mut sums.product));
            [
                constraints: &'k Constraints = constraints,
                from: (&'k [Vec3], Rows<'k>) = (b, c.rows()),
            ]
            operator.new_residuals(four, constraints, band, from, to.0.0, (to.1.0, to.2.0)));
    }

    fn direction(&mut self, constraints: &Constraints, beta: Option<f64>, postponed: Option<f64>) {
        sweep!(self.[x, r, q, c, sums], |four, operator, band|
            to: (Blocks<'k>, RowsMut<'k>, Blocks<'k>, Numbers<'k>) =
            (PerBlock(x), c.rows_mut(), PerBlock(q), PerBlock(&mut sums.product));
        [
            constraints: &'k Constraints = constraints,
            factors: (Option<f64>, Option<f64>) = (beta, postponed),
            r: &'k [Block] = r,
        ]
        operator.direction(
            four, constraints, band, factors, r, (to.0.0, to.1), (to.2.0, to.3.0),
        ));
    }

    fn rims(&mut self, constraints: &Constraints) {
        sweep!(self.[q, c, sums], |four, operator, band|
            to: (Blocks<'k>, Numbers<'k>) = (PerBlock(q), PerBlock(&mut sums.product));
            [constraints: &'k Constraints = constraints, c: Rows<'k> = c.rows()]
            operator.rim(four, constraints, band, c, to.0.0, to.1.0));
    }

    fn advance(&mut self, alpha: f64) {
        sweep!(self.[r, q, sums], |four, operator, band|
            to: (Blocks<'k>, Measures<'k>) = (PerBlock(r), PerBlock(&mut sums.residual));
            [alpha: f64 = alpha, q: &'k [Block] = q]
            operator.advance(four, band, alpha, q, to.0.0, to.1.0));
    }

    fn store(&mut self, postponed: Option<f64>, solution: &mut [Vec3]) {
        sweep!(self.[x, q, c], |_four, operator, band|
            to: (Blocks<'k>, &'k mut [Vec3]) = (PerBlock(q), solution);
            [postponed: Option<f64> = postponed, from: (&'k [Block], Rows<'k>) = (&x[..], c.rows())]
            operator.store(band, postponed, from, (to.0.0, to.1)));
    }
}

/// [`in_bands`] by blocks.
fn over_blocks<P: Divisible>(
    bands: usize,
    operator: &Operator,
    part: P,
    sweep: &(impl Fn(Range<usize>, P) + Sync),
) {
    in_bands(bands, operator.matrix.n(), part, &|particles, part| {
        sweep(particles.start / BLOCK..particles.end.div_ceil(BLOCK), part);
    });
}
