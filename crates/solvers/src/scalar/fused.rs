//! Conjugate gradients on a matrix by diagonals, with a diagonal preconditioner, in two sweeps an
//! iteration.

use super::buckets::Buckets;
use super::diagonals::Diagonals;
use super::lanes::ScalarPreconditioner;
use super::simd::{Four, vectorised};
use super::soa::{Block, Coordinates, Padded, block_rows, padded_rows, total};
use crate::pcg::{Norm, Operations, Start};
use crate::vector::{BLOCK, SLOTS};
use crate::{Constraints, ScalarMatrix, Vec3};
use pulp::Arch;

/// The matrix, the preconditioner and the vectors of a solve.
#[derive(Debug)]
pub(super) struct Fused {
    matrix: Diagonals,
    /// `P = D⁻¹`; ones for `P = I`.
    inverse_diagonal: Padded,
    x: Vec<Block>,
    r: Vec<Block>,
    q: Vec<Block>,
    c: Coordinates,
    buckets: Buckets,
    arch: Arch,
}

impl Fused {
    /// Room for solves with the pattern of `a`, or `None` when it does not suit.
    pub(super) fn new(a: &ScalarMatrix) -> Option<Self> {
        let matrix = Diagonals::new(a)?;
        let n = matrix.n();
        let blocks = || vec![Block::ZERO; n.div_ceil(BLOCK)];
        let mut inverse_diagonal = Padded::zeros(n, 0);
        inverse_diagonal.rows_mut()[..n].fill(1.0);
        Some(Self {
            inverse_diagonal,
            x: blocks(),
            r: blocks(),
            q: blocks(),
            c: Coordinates::zeros(n, matrix.reach()),
            buckets: Buckets::new(n),
            matrix,
            arch: Arch::new(),
        })
    }

    /// Takes over the values of `a` and of a diagonal preconditioner.
    pub(super) fn update(&mut self, a: &ScalarMatrix, p: ScalarPreconditioner<'_>) {
        self.matrix.update(a);
        let inverse = &mut self.inverse_diagonal.rows_mut()[..a.n()];
        match p {
            ScalarPreconditioner::Jacobi(jacobi) => {
                inverse.copy_from_slice(jacobi.inverse_diagonal());
            }
            ScalarPreconditioner::Identity | ScalarPreconditioner::Ic0(_) => inverse.fill(1.0),
        }
    }

    /// The operations of one solve.
    pub(super) fn operations<'a>(
        &'a mut self,
        constraints: &'a Constraints,
        b: &'a [Vec3],
        solution: &'a mut [Vec3],
    ) -> FusedSolve<'a> {
        self.buckets.fill(constraints);
        FusedSolve { constraints, b, solution, postponed: None, measure: Measure::NAN, of: self }
    }
}

/// `rᵀr` and `δ = rᵀ P r`, or that of another vector.
#[derive(Clone, Copy, Debug)]
struct Measure {
    square: f64,
    delta: f64,
}

impl Measure {
    const ZERO: Self = Self { square: 0.0, delta: 0.0 };
    const NAN: Self = Self { square: f64::NAN, delta: f64::NAN };

    /// Adds what a block contributes.
    #[inline(always)]
    fn add(&mut self, block: Self) {
        self.square += block.square;
        self.delta += block.delta;
    }

    fn length(&self, norm: Norm) -> f64 {
        match norm {
            Norm::Euclid => self.square.sqrt(),
            Norm::Preconditioned => self.delta.sqrt(),
        }
    }
}

/// One solve.
#[derive(Debug)]
pub(super) struct FusedSolve<'a> {
    constraints: &'a Constraints,
    b: &'a [Vec3],
    solution: &'a mut [Vec3],
    /// `α` of an update of `x` that the next sweep over `c` will do.
    postponed: Option<f64>,
    /// Of the residual.
    measure: Measure,
    of: &'a mut Fused,
}

impl Operations for FusedSolve<'_> {
    fn start(&mut self, reference: Option<Norm>) -> Start {
        let Self { constraints, b, solution, of, .. } = self;
        let mut start = Start { reference: f64::NAN, multiplications: 0 };
        let moving = reference.filter(|_| constraints.has_prescribed_motion());
        if let Some(norm) = moving {
            of.take_prescribed(constraints);
            let reference = of.residuals_of_direction(constraints, b, false).0;
            start = Start { reference: reference.length(norm), multiplications: 1 };
        }
        of.load(constraints, solution);
        let load;
        (self.measure, load) = of.residuals_of_direction(constraints, b, moving.is_none());
        if let (Some(norm), None) = (reference, moving) {
            start.reference = load.length(norm);
        }
        start
    }

    fn stop_at_prescribed(&mut self) {
        self.constraints.prescribed_only(self.solution);
    }

    fn residual_norm(&mut self) -> f64 {
        self.measure.square.sqrt()
    }

    fn precondition(&mut self) -> f64 {
        self.measure.delta
    }

    fn refresh(&mut self) -> f64 {
        let Self { constraints, b, of, .. } = self;
        let gap;
        (self.measure, gap) = vectorised!(of.arch, [four,
            of: &'k mut Fused = of,
            constraints: &'k Constraints = constraints,
            b: &'k [Vec3] = b,
            postponed: Option<f64> = self.postponed.take(),
        ] -> (Measure, f64) {
            of.complete(postponed);
            of.new_residuals(four, constraints, b)
        });
        gap.sqrt()
    }

    fn direction(&mut self, beta: Option<f64>) -> f64 {
        let Self { constraints, of, .. } = self;
        vectorised!(of.arch, [four,
            of: &'k mut Fused = of,
            constraints: &'k Constraints = constraints,
            beta: Option<f64> = beta,
            postponed: Option<f64> = self.postponed.take(),
        ] -> f64 {
            of.direction(four, constraints, beta, postponed)
        })
    }

    fn direction_is_zero(&mut self) -> bool {
        let (rows, c) = (padded_rows(self.of.matrix.n()), &self.of.c.0);
        c.iter().all(|c| c.window(0, rows).iter().all(|c| c * c == 0.0))
    }

    fn advance(&mut self, alpha: f64) {
        self.postponed = Some(alpha);
        let of = &mut *self.of;
        self.measure = vectorised!(of.arch, [four,
            of: &'k mut Fused = of,
            alpha: f64 = alpha,
        ] -> Measure {
            of.advance(four, alpha)
        });
    }

    fn finish(&mut self) {
        let of = &mut *self.of;
        vectorised!(of.arch, [_four,
            of: &'k mut Fused = of,
            solution: &'k mut [Vec3] = self.solution,
            postponed: Option<f64> = self.postponed.take(),
        ] -> () {
            of.complete(postponed);
            store(&of.x, solution);
        });
    }
}

impl Fused {
    /// [`residuals`](Self::residuals) for the processor at hand.
    fn residuals_of_direction(
        &mut self,
        constraints: &Constraints,
        b: &[Vec3],
        load: bool,
    ) -> (Measure, Measure) {
        vectorised!(self.arch, [four,
            of: &'k mut Fused = self,
            constraints: &'k Constraints = constraints,
            b: &'k [Vec3] = b,
            load: bool = load,
        ] -> (Measure, Measure) {
            of.residuals(four, constraints, b, load)
        })
    }

    /// Rows that are computed: `n` and some of zeros.
    #[inline(always)]
    fn rows(&self) -> usize {
        padded_rows(self.matrix.n())
    }

    /// `c ← (I − S) z`.
    fn take_prescribed(&mut self, constraints: &Constraints) {
        let rows = self.rows();
        let c = self.c.rows_mut(0, rows);
        for (k, c) in c.into_iter().enumerate() {
            c.fill(0.0);
            for &i in constraints.constrained() {
                c[i as usize] = constraints.prescribed(i as usize)[k];
            }
        }
    }

    /// `x ← S x₀ + (I − S) z`, also in `c`.
    fn load(&mut self, constraints: &Constraints, start: &[Vec3]) {
        let rows = self.rows();
        for (k, (x, start)) in self.x.iter_mut().zip(start.chunks(BLOCK)).enumerate() {
            let (first, len) = block_rows(k, rows);
            gather(start, x);
            for &i in self.buckets.block(k) {
                let i = i as usize;
                let value =
                    constraints.filter(i).apply(start[i - first]) + constraints.prescribed(i);
                (0..3).for_each(|k| x.0[k][i - first] = value[k]);
            }
            for (c, x) in self.c.rows_mut(first, len).into_iter().zip(&x.0) {
                c.copy_from_slice(&x[..len]);
            }
        }
    }

    /// `r ← S (b − A c)` and what it measures; likewise `S b` if asked for.
    #[inline(always)]
    fn residuals(
        &mut self,
        four: impl Four,
        constraints: &Constraints,
        b: &[Vec3],
        load: bool,
    ) -> (Measure, Measure) {
        let rows = self.rows();
        let (mut residual, mut reference) = (Measure::ZERO, Measure::ZERO);
        let mut right = Block::ZERO;
        for (k, (r, b)) in self.r.iter_mut().zip(b.chunks(BLOCK)).enumerate() {
            let (first, len) = block_rows(k, rows);
            let inverse = self.inverse_diagonal.window(first as isize, len);
            let constrained = self.buckets.block(k);
            gather(b, &mut right);
            self.matrix.multiply(four, &self.c, first, len, r);
            for (r, b) in r.rows_mut(len).into_iter().zip(&right.0) {
                r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
            }
            project(constraints, constrained, first, r.rows_mut(len));
            residual.add(measure(four, r, inverse));
            if load {
                project(constraints, constrained, first, right.rows_mut(len));
                reference.add(measure(four, &right, inverse));
            }
        }
        (residual, reference)
    }

    /// `q ← c`, `c ← x`.
    #[inline(always)]
    fn swap_direction_for_solution(&mut self) {
        let rows = self.rows();
        for (k, (q, x)) in self.q.iter_mut().zip(&self.x).enumerate() {
            let (first, len) = block_rows(k, rows);
            for ((q, c), x) in
                q.rows_mut(len).into_iter().zip(self.c.rows_mut(first, len)).zip(&x.0)
            {
                q.copy_from_slice(c);
                c.copy_from_slice(&x[..len]);
            }
        }
    }

    /// `c ← q`.
    #[inline(always)]
    fn restore_direction(&mut self) {
        let rows = self.rows();
        for (k, q) in self.q.iter().enumerate() {
            let (first, len) = block_rows(k, rows);
            for (q, c) in q.0.iter().zip(self.c.rows_mut(first, len)) {
                c.copy_from_slice(&q[..len]);
            }
        }
    }

    /// `r ← S (b − A x)`, what it measures, and the square of what this changed.
    #[inline(always)]
    fn new_residuals(
        &mut self,
        four: impl Four,
        constraints: &Constraints,
        b: &[Vec3],
    ) -> (Measure, f64) {
        let rows = self.rows();
        // c makes room for x, of which neighbours are needed.
        self.swap_direction_for_solution();
        let (mut residual, mut gap) = (Measure::ZERO, 0.0);
        let (mut right, mut fresh) = (Block::ZERO, Block::ZERO);
        for (k, (r, b)) in self.r.iter_mut().zip(b.chunks(BLOCK)).enumerate() {
            let (first, len) = block_rows(k, rows);
            gather(b, &mut right);
            self.matrix.multiply(four, &self.c, first, len, &mut fresh);
            for (fresh, b) in fresh.rows_mut(len).into_iter().zip(&right.0) {
                fresh.iter_mut().zip(b).for_each(|(fresh, b)| *fresh = b - *fresh);
            }
            project(constraints, self.buckets.block(k), first, fresh.rows_mut(len));
            for (r, fresh) in r.rows_mut(len).into_iter().zip(&fresh.0) {
                r.iter_mut().zip(fresh).for_each(|(r, fresh)| *r = fresh - *r);
            }
            gap += dot(four, r, r.0.each_ref().map(|r| &r[..len]));
            for (r, fresh) in r.rows_mut(len).into_iter().zip(&fresh.0) {
                r.copy_from_slice(&fresh[..len]);
            }
            residual.add(measure(four, r, self.inverse_diagonal.window(first as isize, len)));
        }
        self.restore_direction();
        (residual, gap)
    }

    /// `x ← x + α c`.
    #[inline(always)]
    fn complete(&mut self, alpha: Option<f64>) {
        let Some(alpha) = alpha else { return };
        let rows = self.rows();
        for (k, x) in self.x.iter_mut().enumerate() {
            let (first, len) = block_rows(k, rows);
            for (x, c) in x.rows_mut(len).into_iter().zip(self.c.rows_mut(first, len)) {
                x.iter_mut().zip(c).for_each(|(x, c)| *x += alpha * *c);
            }
        }
    }

    /// One sweep: `x ← x + α c` as postponed, `c ← S (P r + β c)`, and as soon as the rows that it needs
    /// are known, `q ← S A c` and `cᵀq`.
    #[inline(always)]
    fn direction(
        &mut self,
        four: impl Four,
        constraints: &Constraints,
        beta: Option<f64>,
        postponed: Option<f64>,
    ) -> f64 {
        let (rows, reach) = (self.rows(), self.matrix.reach());
        let (mut curvature, mut multiplied) = (0.0, 0);
        for k in 0..self.r.len() {
            let (first, len) = block_rows(k, rows);
            self.turn(k, (first, len), beta, postponed);
            project(constraints, self.buckets.block(k), first, self.c.rows_mut(first, len));
            let known = first + len;
            while multiplied < self.q.len() {
                let (first, len) = block_rows(multiplied, rows);
                if first + len + reach > known && known < rows {
                    break;
                }
                let q = &mut self.q[multiplied];
                self.matrix.multiply(four, &self.c, first, len, q);
                project(constraints, self.buckets.block(multiplied), first, q.rows_mut(len));
                curvature +=
                    dot(four, q, self.c.0.each_ref().map(|c| c.window(first as isize, len)));
                multiplied += 1;
            }
        }
        curvature
    }

    /// `x ← x + α c`, `c ← P r + β c` in a block.
    #[inline(always)]
    fn turn(
        &mut self,
        k: usize,
        (first, len): (usize, usize),
        beta: Option<f64>,
        postponed: Option<f64>,
    ) {
        let inverse = self.inverse_diagonal.window(first as isize, len);
        let x = self.x[k].rows_mut(len);
        let r = &self.r[k].0;
        for ((x, r), c) in x.into_iter().zip(r).zip(self.c.rows_mut(first, len)) {
            let r = &r[..len];
            match (beta, postponed) {
                (Some(beta), Some(alpha)) => {
                    for i in 0..len {
                        x[i] += alpha * c[i];
                        c[i] = r[i] * inverse[i] + beta * c[i];
                    }
                }
                (beta, postponed) => {
                    if let Some(alpha) = postponed {
                        x.iter_mut().zip(&*c).for_each(|(x, c)| *x += alpha * c);
                    }
                    for i in 0..len {
                        let s = r[i] * inverse[i];
                        c[i] = beta.map_or(s, |beta| s + beta * c[i]);
                    }
                }
            }
        }
    }

    /// `r ← r − α q` and what it measures.
    #[inline(always)]
    fn advance(&mut self, four: impl Four, alpha: f64) -> Measure {
        let rows = self.rows();
        let mut residual = Measure::ZERO;
        let minus_alpha = four.splat(-alpha);
        for (k, (r, q)) in self.r.iter_mut().zip(&self.q).enumerate() {
            let (first, len) = block_rows(k, rows);
            let inverse = self.inverse_diagonal.window(first as isize, len);
            residual.add(measure_of(four, inverse, |k, g| {
                let r = &mut r.0[k].as_chunks_mut::<SLOTS>().0[g];
                let q = q.0[k].as_chunks::<SLOTS>().0[g];
                let new = four.add(four.load(*r), four.mul(minus_alpha, four.load(q)));
                *r = four.store(new);
                new
            }));
        }
        residual
    }
}

/// Particles to coordinates; zeros after the last.
#[inline(always)]
fn gather(from: &[Vec3], to: &mut Block) {
    let [x, y, z] = to.rows_mut(from.len());
    for (i, from) in from.iter().enumerate() {
        (x[i], y[i], z[i]) = (from.x, from.y, from.z);
    }
    to.0.iter_mut().for_each(|x| x[from.len()..].fill(0.0));
}

/// Coordinates to particles.
#[inline(always)]
fn store(from: &[Block], to: &mut [Vec3]) {
    for (from, to) in from.iter().zip(to.chunks_mut(BLOCK)) {
        let [x, y, z] = from.0.each_ref().map(|x| &x[..to.len()]);
        for (i, to) in to.iter_mut().enumerate() {
            *to = Vec3::new(x[i], y[i], z[i]);
        }
    }
}

/// `x ← S x` for the constrained particles of a block that begins with row `first`.
#[inline(always)]
fn project(constraints: &Constraints, particles: &[u32], first: usize, x: [&mut [f64]; 3]) {
    for &i in particles {
        let at = i as usize - first;
        let filtered =
            constraints.filter(i as usize).apply(Vec3::new(x[0][at], x[1][at], x[2][at]));
        (0..3).for_each(|k| x[k][at] = filtered[k]);
    }
}

/// `rᵀr` and `rᵀ P r` over the rows of a block that `inverse` has.
#[inline(always)]
fn measure(four: impl Four, r: &Block, inverse: &[f64]) -> Measure {
    measure_of(four, inverse, |k, g| four.load(r.0[k].as_chunks::<SLOTS>().0[g]))
}

/// [`measure`] of the vector whose group `g` of coordinate `k` is `r(k, g)`.
#[inline(always)]
fn measure_of<F: Four>(
    four: F,
    inverse: &[f64],
    mut r: impl FnMut(usize, usize) -> F::Numbers,
) -> Measure {
    let (mut squares, mut deltas) = ([four.splat(0.0); 3], [four.splat(0.0); 3]);
    let groups = (inverse.len() / SLOTS).min(BLOCK / SLOTS);
    for (g, &inverse) in inverse.as_chunks::<SLOTS>().0[..groups].iter().enumerate() {
        let inverse = four.load(inverse);
        for k in 0..3 {
            let r = r(k, g);
            squares[k] = four.add(squares[k], four.mul(r, r));
            deltas[k] = four.add(deltas[k], four.mul(r, four.mul(r, inverse)));
        }
    }
    Measure {
        square: total(&squares.map(|sum| four.store(sum))),
        delta: total(&deltas.map(|sum| four.store(sum))),
    }
}

/// The dot product over the rows of a block that `b` has.
#[inline(always)]
fn dot(four: impl Four, a: &Block, b: [&[f64]; 3]) -> f64 {
    let groups = b[0].len() / SLOTS;
    let a = a.0.each_ref().map(|a| &a.as_chunks::<SLOTS>().0[..groups]);
    let b = b.map(|b| &b.as_chunks::<SLOTS>().0[..groups]);
    let mut sums = [four.splat(0.0); 3];
    for g in 0..groups {
        for k in 0..3 {
            sums[k] = four.add(sums[k], four.mul(four.load(a[k][g]), four.load(b[k][g])));
        }
    }
    total(&sums.map(|sum| four.store(sum)))
}
