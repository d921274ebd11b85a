//! The matrix of a linearised step, and a product with its stiffness, for springs in any order.
//!
//! # How it goes
//!
//! The springs come in batches, as in [`super::batch`]. A batch reads the differences of positions
//! and of a vector `w` spring by spring, and computes the blocks and forces of all its springs. With
//! full damping, or none, the block of a spring is `a I + κ q qᵀ`:
//!
//! `a = σ k (1 − ℓ/L) + τ c`, `q = √(σ k ℓ/(L κ)) û`
//!
//! (`ℓ/L` is at most 1 with [`Tangent::Projected`]). `κ` is `σ k` of the first spring that has
//! stiffness, so `q` has no unit. With `2ⁿ` times the mass, stiffness and damping a cloth therefore
//! moves with the same bits. Each spring has a block of its own, which the sweep writes once, in the
//! place that a [table](SpringBlocks::slots) gives. Nothing is summed but the forces, spring after
//! spring as in the reference form.
//!
//! # What it costs
//!
//! A spring takes the flops of [`super::tangent`] and another square root. It writes 32 bytes and
//! reads two particles. If the springs are sorted by their ends, the next springs find these in the
//! cache, and each effect writes its blocks one after the other. Each call compares the table with
//! the springs, 12 bytes per spring, so that it never writes to a matrix of other springs.
//!
//! On a sheet of 316 × 316 particles in disorder the sweep takes about a quarter of a step of Baraff
//! and Witkin's method.

use super::listed::Listed;
use super::sweep::{ListedSprings, Pass};
use super::tangent::{Linearised, StiffnessProduct, unit_block, unit_direction};
use crate::{Effect, Part, Tangent, Vec3};
use drape_kernels::blocks::{SpringBlock, SpringBlocks};

/// A smaller unit is none: its inverse might leave the range of numbers.
const LEAST_UNIT: f64 = 1e-100;
/// Springs of a batch: the arrays stay in the first-level cache.
const BATCH: usize = 64;

/// Whether the table of the matrix belongs to these springs, and the matrix has one row per
/// particle.
fn suits<'a>(
    matrix: &SpringBlocks<'_>,
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
        && matrix.ends.len() == matrix.springs.len()
        && matrix.own.len() == particles
}

/// The springs of an effect with its full damping, if they are listed.
pub(crate) fn listed<'a>(effect: &'a dyn Effect, mass: &'a [f64]) -> Option<ListedSprings<'a>> {
    match effect.pass(mass, Part::All)? {
        Pass::Listed(springs) => Some(springs),
        Pass::Springs(_) | Pass::Field(_) => None,
    }
}

/// Overwrites `matrix` with `M + σ K + τ D` and adds `K w` to `product`, if it is given. Returns
/// `false` and does nothing if the table of the matrix belongs to other springs, or for a negative
/// `σ`.
pub(crate) fn add<'a>(
    springs: impl Iterator<Item = ListedSprings<'a>> + Clone,
    mass: &[f64],
    at: &Linearised<'_>,
    matrix: SpringBlocks<'_>,
    mut product: Option<StiffnessProduct<'_>>,
) -> bool {
    let n = mass.len();
    let lengths = product.as_ref().map_or([n; 2], |p| [p.w.len(), p.out.len()]);
    assert!(at.x.len() == n && lengths == [n; 2], "one vector a particle");
    if at.stiffness_scale < 0.0 || !suits(&matrix, springs.clone().map(|s| s.list), n) {
        return false;
    }
    matrix.own.copy_from_slice(mass);
    matrix.general.clear();
    let mut stiffnesses = springs.clone().flat_map(|springs| &springs.list.stiffness);
    let first = stiffnesses.find(|k| **k > 0.0).map_or(0.0, |k| at.stiffness_scale * k);
    *matrix.unit = if first > LEAST_UNIT { first } else { 1.0 };
    let inverse_unit = 1.0 / *matrix.unit;
    let mut slots = matrix.slots;
    for ListedSprings { list, law } in springs {
        let (own, rest) = slots.split_at(list.ends.len());
        slots = rest;
        let damping_scale = if law.is_damped() { at.damping_scale } else { 0.0 };
        let blocks = &mut *matrix.springs;
        // Without a product the kernel computes the forces of any vector, and nothing reads them.
        let (w, out) = match &mut product {
            Some(StiffnessProduct { w, out }) => (*w, Some(&mut **out)),
            None => (at.x, None),
        };
        let at = Linearised { damping_scale, ..*at };
        pulp::Arch::new().dispatch(Batches { list, slots: own, at, blocks, inverse_unit, w, out });
    }
    true
}

/// The springs of one effect.
struct Batches<'a> {
    list: &'a Listed,
    slots: &'a [u32],
    at: Linearised<'a>,
    blocks: &'a mut [SpringBlock],
    /// `1/κ`.
    inverse_unit: f64,
    w: &'a [Vec3],
    out: Option<&'a mut [Vec3]>,
}

impl pulp::WithSimd for Batches<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        match self.at.tangent {
            Tangent::Exact => self.write(|t| t),
            Tangent::Projected => self.write(|t| t.max(0.0)),
        }
    }
}

impl Batches<'_> {
    /// Writes the blocks and adds the forces of all springs.
    #[inline(always)]
    fn write(self, law: impl Fn(f64) -> f64) {
        let Self { list, slots, at, blocks, inverse_unit, w, mut out } = self;
        let mut batch = Batch::default();
        let places = list.ends.chunks(BATCH).zip(slots.chunks(BATCH));
        for (b, (ends, slots)) in places.enumerate() {
            let range = b * BATCH..b * BATCH + ends.len();
            batch.read(ends, at.x, w);
            let parameters = [&list.rest_length, &list.stiffness, &list.damping];
            batch.compute(parameters.map(|p| &p[range.clone()]), &at, inverse_unit, &law);
            for (t, (&[i, j], &slot)) in ends.iter().zip(slots).enumerate() {
                if i == j {
                    continue;
                }
                blocks[slot as usize] = batch.block.each_ref().map(|plane| plane[t]);
                if let Some(out) = &mut out {
                    let force = Vec3::from(batch.force.each_ref().map(|plane| plane[t]));
                    out[i as usize] += force;
                    out[j as usize] -= force;
                }
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
    /// [`SpringBlock`]s.
    block: [[f64; BATCH]; 4],
    /// `K w` at the first end.
    force: [[f64; BATCH]; 3],
}

impl Default for Batch {
    fn default() -> Self {
        let three = [[0.0; BATCH]; 3];
        Self { d: three, w: three, block: [[0.0; BATCH]; 4], force: three }
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
        [rest_length, stiffness, damping]: [&[f64]; 3],
        at: &Linearised<'_>,
        inverse_unit: f64,
        law: &impl Fn(f64) -> f64,
    ) {
        let m = rest_length.len().min(stiffness.len()).min(damping.len()).min(BATCH);
        let (rest_length, stiffness, damping) = (&rest_length[..m], &stiffness[..m], &damping[..m]);
        let Self { d, w, block, force } = self;
        for t in 0..m {
            let k = stiffness[t];
            let (u, across) = unit_direction([d[0][t], d[1][t], d[2][t]], rest_length[t], law);
            let scaled = at.stiffness_scale * k;
            let root = (scaled * inverse_unit * (1.0 - across)).sqrt();
            for axis in 0..3 {
                block[axis][t] = u[axis] * root;
            }
            block[3][t] = scaled * across + at.damping_scale * damping[t];
            let b = unit_block(u, across).map(|b| b * k);
            let (wx, wy, wz) = (w[0][t], w[1][t], w[2][t]);
            force[0][t] = b[0] * wx + b[1] * wy + b[2] * wz;
            force[1][t] = b[1] * wx + b[3] * wy + b[4] * wz;
            force[2][t] = b[2] * wx + b[4] * wy + b[5] * wz;
        }
    }
}
