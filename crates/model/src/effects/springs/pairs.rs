//! The matrix of a linearised step, and a product with its stiffness, for springs in any order.
//!
//! # How it goes
//!
//! The springs come in batches, as in [`super::batch`]. A batch reads the differences of positions
//! and of a vector `w` spring by spring. It computes the blocks
//! `S = σ k [ûûᵀ + (1 − ℓ/L)(I − ûûᵀ)]` and the forces of all its springs, then adds them one after
//! the other. A [table](PairLines::slots) in the order of the springs gives the place of each
//! block. A block is a line of eight numbers, which one operation adds.
//!
//! All sums have the order of the reference form through [`BlockSink`](crate::BlockSink): spring
//! after spring, all stiffnesses of an effect before its damping. So both forms give the same bits.
//!
//! # What it costs
//!
//! A spring takes the flops of [`super::tangent`]. It reads and writes three lines, two of
//! particles and one of the pair, and once more for full damping. If the springs are sorted by
//! their ends, the next springs find these lines in the cache. Each call compares the table with
//! the springs, 12 bytes per spring, so that it never writes to a matrix of other springs.
//!
//! On a sheet of 52 × 52 particles in disorder, one core of a busy Zen 4, a step of Baraff and
//! Witkin's method:
//!
//! | matrix | a step | of it adding blocks | computing them |
//! |---|---|---|---|
//! | compressed rows | 2.0 ms | 29 % | 18 % |
//! | this sweep | 0.95 ms | 21 % with computing | |

use super::listed::Listed;
use super::sweep::{ListedSprings, Pass};
use super::tangent::{Linearised, StiffnessProduct, unit_block};
use crate::{Effect, Part, Tangent, Vec3};
use drape_kernels::blocks::{LINE, Line, PairLines, line};

/// Springs of a batch: the arrays stay in the first-level cache.
const BATCH: usize = 64;

/// Whether the table of the matrix belongs to these springs, and the matrix has one row per
/// particle.
fn suits<'a>(
    matrix: &PairLines<'_>,
    lists: impl Iterator<Item = &'a Listed>,
    particles: usize,
) -> bool {
    let mut slots = matrix.slots.iter();
    let is_known = |slots: &mut std::slice::Iter<'_, u32>, [i, j]: [u32; 2]| {
        let pair = slots.next().map(|slot| matrix.ends.get(*slot as usize));
        pair.is_some_and(|pair| i == j || pair == Some(&[i.min(j), i.max(j)]))
    };
    let mut ends = lists.flat_map(|list| &list.ends);
    ends.all(|ends| is_known(&mut slots, *ends))
        && slots.next().is_none()
        && matrix.ends.len() == matrix.pairs.len()
        && matrix.diagonal.len() == particles
}

/// The springs of an effect with its full damping, if they are listed.
pub(crate) fn listed<'a>(effect: &'a dyn Effect, mass: &'a [f64]) -> Option<ListedSprings<'a>> {
    match effect.pass(mass, Part::All)? {
        Pass::Listed(springs) => Some(springs),
        Pass::Springs(_) | Pass::Field(_) => None,
    }
}

/// Overwrites `matrix` with `M + σ K + τ D` and adds `K w` to `product`, if it is given. Returns
/// `false` and does nothing if the table of the matrix belongs to other springs.
pub(crate) fn add<'a>(
    springs: impl Iterator<Item = ListedSprings<'a>> + Clone,
    mass: &[f64],
    at: &Linearised<'_>,
    mut matrix: PairLines<'_>,
    mut product: Option<StiffnessProduct<'_>>,
) -> bool {
    let n = mass.len();
    let lengths = product.as_ref().map_or([n; 2], |p| [p.w.len(), p.out.len()]);
    assert!(at.x.len() == n && lengths == [n; 2], "one vector a particle");
    if !suits(&matrix, springs.clone().map(|s| s.list), n) {
        return false;
    }
    for (line, &m) in matrix.diagonal.iter_mut().zip(mass) {
        *line = diagonal_line(m);
    }
    matrix.pairs.fill([0.0; LINE]);
    let mut slots = matrix.slots;
    for ListedSprings { list, law } in springs {
        let (own, rest) = slots.split_at(list.ends.len());
        slots = rest;
        let (is_damped, matrix) = (law.is_damped(), &mut matrix);
        // Without a product the kernel computes the forces of any vector, and nothing reads them.
        let (w, out) = match &mut product {
            Some(StiffnessProduct { w, out }) => (*w, Some(&mut **out)),
            None => (at.x, None),
        };
        pulp::Arch::new().dispatch(Batches { list, is_damped, slots: own, at, matrix, w, out });
    }
    true
}

/// The line of a multiple of the identity.
#[inline(always)]
fn diagonal_line(a: f64) -> Line {
    line([a, 0.0, 0.0, a, 0.0, a])
}

/// The springs of one effect.
struct Batches<'a, 'b> {
    list: &'a Listed,
    is_damped: bool,
    slots: &'a [u32],
    at: &'a Linearised<'a>,
    matrix: &'a mut PairLines<'b>,
    w: &'a [Vec3],
    out: Option<&'a mut [Vec3]>,
}

impl pulp::WithSimd for Batches<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { list, is_damped, slots, at, matrix, w, out } = self;
        let at = (at, w);
        match at.0.tangent {
            Tangent::Exact => add_stiffness(list, slots, at, |t| t, matrix, out),
            Tangent::Projected => add_stiffness(list, slots, at, |t| t.max(0.0), matrix, out),
        }
        if is_damped {
            for ((ends, slot), c) in list.ends.iter().zip(slots).zip(&list.damping) {
                add_line(matrix, *ends, *slot, &diagonal_line(at.0.damping_scale * c));
            }
        }
    }
}

/// Adds `S` and the forces of all springs.
#[inline(always)]
fn add_stiffness(
    list: &Listed,
    slots: &[u32],
    (at, w): (&Linearised<'_>, &[Vec3]),
    law: impl Fn(f64) -> f64,
    matrix: &mut PairLines<'_>,
    mut out: Option<&mut [Vec3]>,
) {
    let mut batch = Batch::default();
    let parameters = list.rest_length.chunks(BATCH).zip(list.stiffness.chunks(BATCH));
    let places = list.ends.chunks(BATCH).zip(slots.chunks(BATCH));
    for ((ends, slots), (rest_length, stiffness)) in places.zip(parameters) {
        batch.read(ends, at.x, w);
        batch.compute(rest_length, stiffness, at.stiffness_scale, &law);
        for (t, (&[i, j], &slot)) in ends.iter().zip(slots).enumerate() {
            let block = batch.block.each_ref().map(|plane| plane[t]);
            add_line(matrix, [i, j], slot, &line(block));
            if let Some(out) = &mut out {
                let force = Vec3::from(batch.force.each_ref().map(|plane| plane[t]));
                out[i as usize] += force;
                out[j as usize] -= force;
            }
        }
    }
}

/// Results for some springs, one array per number.
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
    fn read(&mut self, ends: &[[u32; 2]], x: &[Vec3], w: &[Vec3]) {
        for (t, &[i, j]) in ends.iter().enumerate().take(BATCH) {
            let (i, j) = (i as usize, j as usize);
            let (d, w) = (x[i] - x[j], w[i] - w[j]);
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
fn add_line(matrix: &mut PairLines<'_>, [i, j]: [u32; 2], slot: u32, line: &Line) {
    if i == j {
        return;
    }
    let pair = &mut matrix.pairs[slot as usize];
    for k in 0..LINE {
        pair[k] -= line[k];
    }
    for end in [i, j] {
        let sum = &mut matrix.diagonal[end as usize];
        for k in 0..LINE {
            sum[k] += line[k];
        }
    }
}
