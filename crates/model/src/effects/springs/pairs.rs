//! The matrix of a linearised step, and a product with its stiffness, for springs in any order.
//!
//! # How it goes
//!
//! The springs are taken in batches, as in [`super::batch`]: the differences of positions and of a vector `w` are read one
//! spring after the other, blocks `S = σ k [ûûᵀ + (1 − ℓ/L)(I − ûûᵀ)]` and forces are computed for the whole batch, then added one
//! after the other. Where the block of a spring belongs is known beforehand, from a [table](PairBlocks::slots) in the
//! order of the springs. Each block is a line of eight numbers, so that it is added in one go.
//!
//! All sums have the order of the readable way through [`BlockSink`](crate::BlockSink): all stiffnesses of an effect before its
//! damping, spring after spring. So the results are the same bits.
//!
//! # What it costs
//!
//! For a spring the flops of [`super::tangent`], and three lines that are read and written, once more for full damping: two of particles
//! and one of the pair. Where the springs are sorted by their ends, the next ones find these lines in the cache. The table is compared
//! with the springs in each call, 12 bytes a spring, so that a matrix of other springs is never written to.
//!
//! On a sheet of 52 × 52 particles in disorder, one core of a busy Zen 4: a step of Baraff and Witkin's method took 2.0 ms with compressed
//! rows. Of that 29 % was spent on adding blocks, a fourth of it in searches, and 18 % on computing them spring by spring, the
//! stiffness twice: for the matrix and for the product. With the sweep here a step takes 0.95 ms, 21 % of it all of this.

use super::listed::Listed;
use super::sweep::{ListedSprings, Pass};
use super::tangent::{Linearised, unit_block};
use crate::{Effect, Part, Tangent, Vec3};

/// Springs of a batch: the arrays stay in the first-level cache.
const BATCH: usize = 64;

/// The lines of a symmetric matrix of symmetric 3×3 blocks, one for each particle and for each coupled pair: where the
/// springs write to.
///
/// A line holds `xx, xy, xz, yz, zz, xy, yy, yz`: the columns of the block begin at places 0, 5 and 2.
#[derive(Debug)]
pub struct PairBlocks<'a> {
    /// Diagonal blocks, one a particle.
    pub diagonal: &'a mut [[f64; 8]],
    /// Blocks (i, j) of the coupled pairs.
    pub pairs: &'a mut [[f64; 8]],
    /// Both particles of each coupled pair, the lower first.
    pub ends: &'a [[u32; 2]],
    /// Which coupled pair each spring belongs to, in the order in which the effects visit their springs. Of no meaning for
    /// a spring that ties a particle to itself.
    pub slots: &'a [u32],
}

impl PairBlocks<'_> {
    /// Whether the table is that of these springs, and the matrix has one row a particle.
    fn suits<'a>(&self, lists: impl Iterator<Item = &'a Listed>, particles: usize) -> bool {
        let mut slots = self.slots.iter();
        let is_known = |slots: &mut std::slice::Iter<'_, u32>, [i, j]: [u32; 2]| {
            let pair = slots.next().map(|slot| self.ends.get(*slot as usize));
            pair.is_some_and(|pair| i == j || pair == Some(&[i.min(j), i.max(j)]))
        };
        let mut ends = lists.flat_map(|list| &list.ends);
        ends.all(|ends| is_known(&mut slots, *ends))
            && slots.next().is_none()
            && self.ends.len() == self.pairs.len()
            && self.diagonal.len() == particles
    }
}

/// The springs of an effect with its full damping, if they are listed.
pub(crate) fn listed<'a>(effect: &'a dyn Effect, mass: &'a [f64]) -> Option<ListedSprings<'a>> {
    match effect.pass(mass, Part::All)? {
        Pass::Listed(springs) => Some(springs),
        Pass::Springs(_) | Pass::Field(_) => None,
    }
}

/// Overwrites `matrix` with `M + σ K + τ D` and adds `K w` to `out`, unless the table is that of other springs: then it
/// returns `false` and does nothing.
pub(crate) fn add<'a>(
    springs: impl Iterator<Item = ListedSprings<'a>> + Clone,
    mass: &[f64],
    at: &Linearised<'_>,
    mut matrix: PairBlocks<'_>,
    out: &mut [Vec3],
) -> bool {
    assert!([at.x.len(), at.w.len(), out.len()] == [mass.len(); 3], "one vector a particle");
    if !matrix.suits(springs.clone().map(|s| s.list), mass.len()) {
        return false;
    }
    for (line, &m) in matrix.diagonal.iter_mut().zip(mass) {
        *line = diagonal_line(m);
    }
    matrix.pairs.fill([0.0; 8]);
    let mut slots = matrix.slots;
    for ListedSprings { list, law } in springs {
        let (own, rest) = slots.split_at(list.ends.len());
        slots = rest;
        let is_damped = law.is_damped();
        let matrix = &mut matrix;
        pulp::Arch::new().dispatch(Batches { list, is_damped, slots: own, at, matrix, out });
    }
    true
}

/// The line of a multiple of the identity.
#[inline(always)]
fn diagonal_line(a: f64) -> [f64; 8] {
    [a, 0.0, 0.0, 0.0, a, 0.0, a, 0.0]
}

/// The springs of one effect.
struct Batches<'a, 'b> {
    list: &'a Listed,
    is_damped: bool,
    slots: &'a [u32],
    at: &'a Linearised<'a>,
    matrix: &'a mut PairBlocks<'b>,
    out: &'a mut [Vec3],
}

impl pulp::WithSimd for Batches<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { list, is_damped, slots, at, matrix, out } = self;
        match at.tangent {
            Tangent::Exact => add_stiffness(list, slots, at, |t| t, matrix, out),
            Tangent::Projected => add_stiffness(list, slots, at, |t| t.max(0.0), matrix, out),
        }
        if is_damped {
            for ((ends, slot), c) in list.ends.iter().zip(slots).zip(&list.damping) {
                add_line(matrix, *ends, *slot, &diagonal_line(at.damping_scale * c));
            }
        }
    }
}

/// Adds `S` and the forces of all springs.
#[inline(always)]
fn add_stiffness(
    list: &Listed,
    slots: &[u32],
    at: &Linearised<'_>,
    law: impl Fn(f64) -> f64,
    matrix: &mut PairBlocks<'_>,
    out: &mut [Vec3],
) {
    let mut batch = Batch::default();
    let parameters = list.rest_length.chunks(BATCH).zip(list.stiffness.chunks(BATCH));
    let places = list.ends.chunks(BATCH).zip(slots.chunks(BATCH));
    for ((ends, slots), (rest_length, stiffness)) in places.zip(parameters) {
        batch.read(ends, at);
        batch.compute(rest_length, stiffness, at.stiffness_scale, &law);
        for (t, (&[i, j], &slot)) in ends.iter().zip(slots).enumerate() {
            let [xx, xy, xz, yy, yz, zz] = batch.block.each_ref().map(|plane| plane[t]);
            add_line(matrix, [i, j], slot, &[xx, xy, xz, yz, zz, xy, yy, yz]);
            let force = Vec3::from(batch.force.each_ref().map(|plane| plane[t]));
            out[i as usize] += force;
            out[j as usize] -= force;
        }
    }
}

/// What is computed of some springs, one array a number.
struct Batch {
    /// `x_i − x_j`.
    d: [[f64; BATCH]; 3],
    /// `w_i − w_j`.
    w: [[f64; BATCH]; 3],
    /// `xx, xy, xz, yy, yz, zz` of `S`.
    block: [[f64; BATCH]; 6],
    /// `K w` at the first end.
    force: [[f64; BATCH]; 3],
}

impl Default for Batch {
    fn default() -> Self {
        let three = [[0.0; BATCH]; 3];
        Self { d: three, w: three, block: [[0.0; BATCH]; 6], force: three }
    }
}

impl Batch {
    #[inline(always)]
    fn read(&mut self, ends: &[[u32; 2]], at: &Linearised<'_>) {
        for (t, &[i, j]) in ends.iter().enumerate().take(BATCH) {
            let (i, j) = (i as usize, j as usize);
            let (d, w) = (at.x[i] - at.x[j], at.w[i] - at.w[j]);
            for axis in 0..3 {
                self.d[axis][t] = d[axis];
                self.w[axis][t] = w[axis];
            }
        }
    }

    #[inline(always)]
    fn compute(
        &mut self,
        rest_length: &[f64],
        stiffness: &[f64],
        scale: f64,
        law: &impl Fn(f64) -> f64,
    ) {
        let m = rest_length.len().min(stiffness.len()).min(BATCH);
        let (rest_length, stiffness) = (&rest_length[..m], &stiffness[..m]);
        let Self { d, w, block, force } = self;
        for t in 0..m {
            let k = stiffness[t];
            let direction = unit_block([d[0][t], d[1][t], d[2][t]], rest_length[t], law);
            for c in 0..6 {
                block[c][t] = direction[c] * (scale * k);
            }
            let b = direction.map(|b| b * k);
            let (wx, wy, wz) = (w[0][t], w[1][t], w[2][t]);
            force[0][t] = b[0] * wx + b[1] * wy + b[2] * wz;
            force[1][t] = b[1] * wx + b[3] * wy + b[4] * wz;
            force[2][t] = b[2] * wx + b[4] * wy + b[5] * wz;
        }
    }
}

/// Adds a line at both ends of a spring and subtracts it between them.
#[inline(always)]
fn add_line(matrix: &mut PairBlocks<'_>, [i, j]: [u32; 2], slot: u32, line: &[f64; 8]) {
    if i == j {
        return;
    }
    let pair = &mut matrix.pairs[slot as usize];
    for k in 0..8 {
        pair[k] -= line[k];
    }
    for end in [i, j] {
        let sum = &mut matrix.diagonal[end as usize];
        for k in 0..8 {
            sum[k] += line[k];
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
#[path = "pairs_tests.rs"]
mod tests;
