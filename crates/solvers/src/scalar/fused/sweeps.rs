//! The sweeps over a band of blocks.

use super::super::buckets::Buckets;
use super::super::diagonals::{Diagonals, Put};
use super::super::soa::{Block, PaddedRow, Rows, RowsMut, block_rows, padded_rows, total};
use super::sums::{Measure, Meter, dot, measure, square};
use crate::pcg::Norm;
use crate::vector::{BLOCK, SLOTS, extrapolate};
use crate::{Constraints, StartValue, Vec3};
use drape_kernels::lanes::Four;
use std::ops::Range;

/// The data that all bands read: the matrix, the preconditioner and the constrained particles by
/// block. The vectors of a sweep begin with the first block of its band, those of [`Rows`] with row
/// 0.
#[derive(Debug)]
pub(super) struct Operator {
    pub(super) matrix: Diagonals,
    /// `P = D⁻¹`; ones for `P = I`.
    pub(super) inverse_diagonal: PaddedRow,
    pub(super) buckets: Buckets,
}

impl Operator {
    /// Number of blocks.
    fn blocks(&self) -> usize {
        self.matrix.n().div_ceil(BLOCK)
    }

    /// First row and number of rows of block `k`, with the rows of zeros after the last.
    #[inline(always)]
    fn block_rows(&self, k: usize) -> (usize, usize) {
        block_rows(k, padded_rows(self.matrix.n()))
    }

    /// `P` in a block.
    #[inline(always)]
    fn inverse_diagonal(&self, k: usize) -> &[f64] {
        let (first, len) = self.block_rows(k);
        self.inverse_diagonal.window(first as isize, len)
    }

    /// `x ← S x` in block `k`.
    #[inline(always)]
    fn project(&self, constraints: &Constraints, k: usize, x: [&mut [f64]; 3]) {
        for &i in self.buckets.block(k) {
            let at = i as usize - k * BLOCK;
            let filtered =
                constraints.filter(i as usize).apply(Vec3::new(x[0][at], x[1][at], x[2][at]));
            (0..3).for_each(|k| x[k][at] = filtered[k]);
        }
    }

    /// End of the blocks that can be multiplied when block `k` and all before it are known.
    #[inline(always)]
    fn multipliable(&self, k: usize) -> usize {
        if k + 1 == self.blocks() {
            k + 1
        } else {
            ((k + 1) * BLOCK).saturating_sub(self.matrix.reach()) / BLOCK
        }
    }

    /// The blocks of a band with all neighbours in the band; the others are its rim.
    #[inline(always)]
    pub(super) fn interior(&self, band: &Range<usize>) -> Range<usize> {
        let first = match band.start {
            0 => 0,
            start => start + self.matrix.reach().div_ceil(BLOCK),
        };
        let end = self.multipliable(band.end - 1);
        if first < end { first..end } else { band.start..band.start }
    }

    /// `c ← (I − S) z`.
    #[inline(always)]
    pub(super) fn take_prescribed(
        &self,
        constraints: &Constraints,
        band: Range<usize>,
        mut c: RowsMut<'_>,
    ) {
        for k in band {
            let (first, len) = self.block_rows(k);
            let mut c = c.window(first, len);
            c.iter_mut().for_each(|c| c.fill(0.0));
            for &i in self.buckets.block(k) {
                let value = constraints.prescribed(i as usize);
                (0..3).for_each(|k| c[k][i as usize - first] = value[k]);
            }
        }
    }

    /// `x ← S x₀ + (I − S) z`, also in `c`. `x₀` is the start value, which may be `x`.
    #[inline(always)]
    pub(super) fn load(
        &self,
        constraints: &Constraints,
        band: Range<usize>,
        start: StartValue<'_>,
        x: &mut [Block],
        mut c: RowsMut<'_>,
    ) {
        for (k, x) in band.zip(x) {
            let (first, len) = self.block_rows(k);
            match start {
                StartValue::Given => {} // in `x` already
                StartValue::At(start) => gather(particles(start, k), x.rows_mut(len)),
                StartValue::Extrapolated { last, before } => {
                    let mut next = [Vec3::zeros(); BLOCK];
                    let last = particles(last, k);
                    let next = &mut next[..last.len()];
                    extrapolate(last, particles(before, k), next);
                    gather(next, x.rows_mut(len));
                }
            }
            for &i in self.buckets.block(k) {
                let (i, at) = (i as usize, i as usize - first);
                let start = Vec3::new(x.0[0][at], x.0[1][at], x.0[2][at]);
                let value = constraints.filter(i).apply(start) + constraints.prescribed(i);
                (0..3).for_each(|k| x.0[k][at] = value[k]);
            }
            for (c, x) in c.window(first, len).into_iter().zip(&x.0) {
                c.copy_from_slice(&x[..len]);
            }
        }
    }

    /// `c ← v`.
    #[inline(always)]
    pub(super) fn take(&self, band: Range<usize>, v: &[Vec3], mut c: RowsMut<'_>) {
        for k in band {
            let (first, len) = self.block_rows(k);
            gather(particles(v, k), c.window(first, len));
        }
    }

    /// `A c`, to particles. The first block of `q` is scratch memory.
    #[inline(always)]
    pub(super) fn product(
        &self,
        four: impl Four,
        band: Range<usize>,
        c: Rows<'_>,
        (q, out): (&mut [Block], &mut [Vec3]),
    ) {
        let Some(product) = q.first_mut() else { return };
        for (k, out) in band.zip(out.chunks_mut(BLOCK)) {
            self.matrix.multiply(four, c, self.block_rows(k), &mut Product(product));
            scatter(product, out);
        }
    }

    /// `r ← S (b − A c)` in a block, and its measure.
    #[inline(always)]
    fn residual(
        &self,
        four: impl Four,
        constraints: &Constraints,
        k: usize,
        c: Rows<'_>,
        b: &Block,
        r: &mut Block,
    ) -> Measure {
        let (first, len) = self.block_rows(k);
        let inverse = self.inverse_diagonal(k);
        let meter = Meter::new(four);
        let mut residual = Residual { b, r, inverse: inverse.as_chunks().0, meter };
        self.matrix.multiply(four, c, (first, len), &mut residual);
        if self.buckets.block(k).is_empty() {
            return residual.meter.read(four);
        }
        self.project(constraints, k, r.rows_mut(len));
        measure(four, r, inverse)
    }

    /// `r ← S (b − A c)` and its measure; also that of `S b`, if a norm is given. The first block
    /// of `q` is scratch memory for `b`.
    #[inline(always)]
    pub(super) fn residuals(
        &self,
        four: impl Four,
        constraints: &Constraints,
        band: Range<usize>,
        (b, c, norm): (&[Vec3], Rows<'_>, Option<Norm>),
        (r, q): (&mut [Block], &mut [Block]),
        (measures, loads): (&mut [Measure], &mut [Measure]),
    ) {
        let Some(right) = q.first_mut() else { return };
        for (k, (r, (measured, load))) in band.zip(r.iter_mut().zip(measures.iter_mut().zip(loads)))
        {
            gather(particles(b, k), right.rows_mut(self.block_rows(k).1));
            *measured = self.residual(four, constraints, k, c, right, r);
            let Some(norm) = norm else { continue };
            let inverse = self.inverse_diagonal(k);
            self.project(constraints, k, right.rows_mut(inverse.len()));
            *load = match norm {
                Norm::Euclid => square(four, right, inverse.len()),
                Norm::Preconditioned => measure(four, right, inverse),
            };
        }
    }

    /// The postponed `x ← x + α c`, then `q ← c`, `c ← x`.
    #[inline(always)]
    pub(super) fn swap_direction_for_solution(
        &self,
        band: Range<usize>,
        postponed: Option<f64>,
        x: &mut [Block],
        q: &mut [Block],
        mut c: RowsMut<'_>,
    ) {
        for (k, (x, q)) in band.zip(x.iter_mut().zip(q)) {
            let (first, len) = self.block_rows(k);
            let rows = x.rows_mut(len).into_iter().zip(q.rows_mut(len));
            for ((x, q), c) in rows.zip(c.window(first, len)) {
                if let Some(alpha) = postponed {
                    x.iter_mut().zip(&*c).for_each(|(x, c)| *x += alpha * c);
                }
                q.copy_from_slice(c);
                c.copy_from_slice(x);
            }
        }
    }

    /// `c ← q`.
    #[inline(always)]
    pub(super) fn restore_direction(&self, band: Range<usize>, q: &[Block], mut c: RowsMut<'_>) {
        for k in band {
            let (first, len) = self.block_rows(k);
            for (q, c) in q[k].0.iter().zip(c.window(first, len)) {
                c.copy_from_slice(&q[..len]);
            }
        }
    }

    /// `r ← S (b − A c)`, its measure, and the square of its change.
    #[inline(always)]
    pub(super) fn new_residuals(
        &self,
        four: impl Four,
        constraints: &Constraints,
        band: Range<usize>,
        (b, c): (&[Vec3], Rows<'_>),
        r: &mut [Block],
        (measures, gaps): (&mut [Measure], &mut [f64]),
    ) {
        let (mut right, mut fresh) = (Block::ZERO, Block::ZERO);
        for (k, (r, (measured, gap))) in band.zip(r.iter_mut().zip(measures.iter_mut().zip(gaps))) {
            let (_, len) = self.block_rows(k);
            gather(particles(b, k), right.rows_mut(len));
            *measured = self.residual(four, constraints, k, c, &right, &mut fresh);
            for (r, fresh) in r.rows_mut(len).into_iter().zip(&fresh.0) {
                r.iter_mut().zip(fresh).for_each(|(r, fresh)| *r = fresh - *r);
            }
            *gap = dot(four, r, r.rows(len));
            for (r, fresh) in r.rows_mut(len).into_iter().zip(&fresh.0) {
                r.copy_from_slice(&fresh[..len]);
            }
        }
    }

    /// One sweep: the postponed `x ← x + α c`, then `c ← S (P r + β c)`. In the interior of the
    /// band also `q ← S A c` and `cᵀq`, as soon as the needed rows are known.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the parts of a band in several arrays")]
    pub(super) fn direction(
        &self,
        four: impl Four,
        constraints: &Constraints,
        band: Range<usize>,
        (beta, postponed): (Option<f64>, Option<f64>),
        r: &[Block],
        (x, mut c): (&mut [Block], RowsMut<'_>),
        (q, curvatures): (&mut [Block], &mut [f64]),
    ) {
        let (start, interior) = (band.start, self.interior(&band));
        let mut multiplied = interior.start;
        for k in band {
            let (first, len) = self.block_rows(k);
            let inverse = self.inverse_diagonal(k);
            turn(beta, postponed, inverse, &r[k], &mut x[k - start], c.window(first, len));
            self.project(constraints, k, c.window(first, len));
            let end = self.multipliable(k).min(interior.end);
            while multiplied < end {
                let at = multiplied - start;
                curvatures[at] =
                    self.curvature(four, constraints, multiplied, c.read(), &mut q[at]);
                multiplied += 1;
            }
        }
    }

    /// `q ← S A c` and `cᵀq` in the rim of a band.
    #[inline(always)]
    pub(super) fn rim(
        &self,
        four: impl Four,
        constraints: &Constraints,
        band: Range<usize>,
        c: Rows<'_>,
        q: &mut [Block],
        curvatures: &mut [f64],
    ) {
        let interior = self.interior(&band);
        for k in (band.start..interior.start).chain(interior.end..band.end) {
            let at = k - band.start;
            curvatures[at] = self.curvature(four, constraints, k, c, &mut q[at]);
        }
    }

    /// `q ← S A c` and `cᵀq` in a block.
    #[inline(always)]
    fn curvature(
        &self,
        four: impl Four,
        constraints: &Constraints,
        k: usize,
        c: Rows<'_>,
        q: &mut Block,
    ) -> f64 {
        let (first, len) = self.block_rows(k);
        let mut curvature = Curvature { q, sums: [four.splat(0.0); 3] };
        self.matrix.multiply(four, c, (first, len), &mut curvature);
        if self.buckets.block(k).is_empty() {
            return total(&curvature.sums.map(|sum| four.store(sum)));
        }
        self.project(constraints, k, q.rows_mut(len));
        dot(four, q, c.window(first, len))
    }

    /// `r ← r − α q` and its measure.
    #[inline(always)]
    pub(super) fn advance(
        &self,
        four: impl Four,
        band: Range<usize>,
        alpha: f64,
        q: &[Block],
        r: &mut [Block],
        measures: &mut [Measure],
    ) {
        let minus_alpha = four.splat(-alpha);
        for (k, (r, measured)) in band.zip(r.iter_mut().zip(measures)) {
            let q = &q[k];
            let mut meter = Meter::new(four);
            for (g, &inverse) in self.inverse_diagonal(k).as_chunks().0.iter().enumerate() {
                let inverse = four.load(inverse);
                for k in 0..3 {
                    let (q, r) = (four.load(*q.group(k, g)), r.group_mut(k, g));
                    let new = four.add(four.load(*r), four.mul(minus_alpha, q));
                    *r = four.store(new);
                    meter.add(four, k, new, inverse);
                }
            }
            *measured = meter.read(four);
        }
    }

    /// The postponed `x + α c`, to particles. The first block of `q` is scratch memory.
    #[inline(always)]
    pub(super) fn store(
        &self,
        band: Range<usize>,
        postponed: Option<f64>,
        (x, c): (&[Block], Rows<'_>),
        (q, solution): (&mut [Block], &mut [Vec3]),
    ) {
        let Some(last) = q.first_mut() else { return };
        for (k, solution) in band.zip(solution.chunks_mut(BLOCK)) {
            let (first, len) = self.block_rows(k);
            let x = match postponed {
                None => &x[k],
                Some(alpha) => {
                    let rows = last.rows_mut(len).into_iter().zip(&x[k].0);
                    for ((last, x), c) in rows.zip(c.window(first, len)) {
                        for ((last, x), c) in last.iter_mut().zip(x).zip(c) {
                            *last = x + alpha * c;
                        }
                    }
                    &*last
                }
            };
            scatter(x, solution);
        }
    }
}

/// Turns a product into a residual, and measures it.
struct Residual<'a, N> {
    b: &'a Block,
    r: &'a mut Block,
    inverse: &'a [[f64; SLOTS]],
    meter: Meter<N>,
}

impl<F: Four> Put<F> for Residual<'_, F::Numbers> {
    #[inline(always)]
    fn put(&mut self, four: F, g: usize, _x: [F::Numbers; 3], product: [F::Numbers; 3]) {
        let inverse = four.load(self.inverse[g]);
        for k in 0..3 {
            let new = four.sub(four.load(*self.b.group(k, g)), product[k]);
            *self.r.group_mut(k, g) = four.store(new);
            self.meter.add(four, k, new, inverse);
        }
    }
}

/// Keeps a product `q = A c`, and sums `cᵀq`.
struct Curvature<'a, N> {
    q: &'a mut Block,
    sums: [N; 3],
}

impl<F: Four> Put<F> for Curvature<'_, F::Numbers> {
    #[inline(always)]
    fn put(&mut self, four: F, g: usize, c: [F::Numbers; 3], product: [F::Numbers; 3]) {
        for k in 0..3 {
            *self.q.group_mut(k, g) = four.store(product[k]);
            self.sums[k] = four.add(self.sums[k], four.mul(product[k], c[k]));
        }
    }
}

/// Keeps a product.
struct Product<'a>(&'a mut Block);

impl<F: Four> Put<F> for Product<'_> {
    #[inline(always)]
    fn put(&mut self, four: F, g: usize, _x: [F::Numbers; 3], product: [F::Numbers; 3]) {
        for k in 0..3 {
            *self.0.group_mut(k, g) = four.store(product[k]);
        }
    }
}

/// The particles of block `k`.
#[inline(always)]
fn particles(all: &[Vec3], k: usize) -> &[Vec3] {
    &all[k * BLOCK..all.len().min((k + 1) * BLOCK)]
}

/// `x ← x + α c`, `c ← P r + β c` in a block.
#[inline(always)]
fn turn(
    beta: Option<f64>,
    postponed: Option<f64>,
    inverse: &[f64],
    r: &Block,
    x: &mut Block,
    c: [&mut [f64]; 3],
) {
    let len = inverse.len();
    for ((x, r), c) in x.rows_mut(len).into_iter().zip(&r.0).zip(c) {
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

/// Copies particles to the rows of their block, and zeros to the rows after the last.
#[inline(always)]
fn gather(from: &[Vec3], to: [&mut [f64]; 3]) {
    let [(x, after_x), (y, after_y), (z, after_z)] = to.map(|to| to.split_at_mut(from.len()));
    for (i, from) in from.iter().enumerate() {
        (x[i], y[i], z[i]) = (from.x, from.y, from.z);
    }
    [after_x, after_y, after_z].into_iter().for_each(|after| after.fill(0.0));
}

/// Copies coordinates to particles.
#[inline(always)]
pub(super) fn scatter(from: &Block, to: &mut [Vec3]) {
    let [x, y, z] = from.rows(to.len());
    for (i, to) in to.iter_mut().enumerate() {
        *to = Vec3::new(x[i], y[i], z[i]);
    }
}
