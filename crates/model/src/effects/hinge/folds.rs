//! Four hinges at a time, in registers.
//!
//! Each register holds one number of four hinges. Every number has the order of operations of the
//! readable form in [`Fold`](super::Fold), so both give the same bits. Forces and blocks are added
//! hinge by hinge. A closure would not be compiled for the registers, so there is none.
//!
//! # What bounds the forces
//!
//! On 52 × 52 particles in disorder a hinge takes 16.5 ns, as long as 6.8 springs of a grid (AMD EPYC
//! of family 25, model 17). Four hinges take some 690 instructions in 240 cycles. A tenth of the
//! time gathers positions, an eighth adds forces at the ends. The rest is the angle and its
//! gradient. Their 11 quotients and a root alone keep the divider busy for a quarter of the time.
//! Reciprocals in their place would change the last bits. Two groups at a time, so that one computes
//! while the other waits, were only 4 % faster.

use super::HingeSpec;
use crate::effects::{BlockSink, Tangent};
use crate::{Mat3, Vec3};
use drape_kernels::angle::atan2;
use drape_kernels::lanes::{Four, Lanes};
use drape_kernels::triples::{Triple, Triples, add_in_turn};
use drape_kernels::vector::SLOTS;
use std::f64::consts::PI;

/// Squares of lengths and of normals that are usual: no product of two leaves the range of numbers.
const USUAL: (f64, f64) = (1e-100, 1e100);
/// Squared sine at the edge that is usual: far above [`DEGENERATE`](super::DEGENERATE).
const USUAL_SINE: f64 = 1e-20;

/// Four matrices, row by row.
type Matrices<F> = [Triple<F>; 3];

/// Four hinges whose triangles have normals.
pub(super) struct Folds<F: Four> {
    /// The particles `i`, `j`, `k`, `l` of the four.
    places: [[usize; SLOTS]; 4],
    stiffness: F::Numbers,
    rest: F::Numbers,
    /// `Ê`.
    along: Triple<F>,
    /// `|E|`, m.
    length: F::Numbers,
    /// `p` and `q`, m.
    arm: [Triple<F>; 2],
    /// `N₁`, `N₂`, m².
    normal: [Triple<F>; 2],
    /// `|N|²`.
    square: [F::Numbers; 2],
}

impl<F: Four> Folds<F> {
    /// `None` where one of them has no angle, or is too near to that.
    #[inline(always)]
    pub(super) fn new(four: F, group: &[HingeSpec; SLOTS], x: &[Vec3]) -> Option<Self> {
        let [a, b, c, d] = group;
        let places = [
            [a.i as usize, b.i as usize, c.i as usize, d.i as usize],
            [a.j as usize, b.j as usize, c.j as usize, d.j as usize],
            [a.k as usize, b.k as usize, c.k as usize, d.k as usize],
            [a.l as usize, b.l as usize, c.l as usize, d.l as usize],
        ];
        let from = four.gather(x, places[0]);
        let e = four.minus(four.gather(x, places[1]), from);
        let p = four.minus(four.gather(x, places[2]), from);
        let q = four.minus(four.gather(x, places[3]), from);
        let (n1, n2) = (four.cross(e, p), four.cross(q, e));
        let edge = four.dot(e, e);
        let square = [four.dot(n1, n1), four.dot(n2, n2)];
        let length = four.sqrt(edge);

        let (least, most) = (four.splat(USUAL.0), four.splat(USUAL.1));
        let mut usual = four.if_at_most(least, edge, four.splat(1.0));
        let arms = [four.dot(p, p), four.dot(q, q)];
        for side in 0..2 {
            let narrow = four.mul(four.mul(edge, arms[side]), four.splat(USUAL_SINE));
            usual = four.if_at_most(least, arms[side], usual);
            usual = four.if_at_most(narrow, square[side], usual);
            usual = four.if_at_most(square[side], most, usual);
        }
        if !four.are_ones(usual) {
            return None;
        }
        let stiffness =
            four.load([a.stiffness_n_m, b.stiffness_n_m, c.stiffness_n_m, d.stiffness_n_m]);
        Some(Self {
            places,
            stiffness,
            rest: four.load([a.rest_rad, b.rest_rad, c.rest_rad, d.rest_rad]),
            along: four.over(e, length),
            length,
            arm: [p, q],
            normal: [n1, n2],
            square,
        })
    }

    /// `θ − θ₀`, the shorter way round; `None` where one of the angles is unusual.
    #[inline(always)]
    fn excess(&self, four: F) -> Option<F::Numbers> {
        let [n1, n2] = self.normal;
        let (sine, cosine) = (four.dot(four.cross(n1, n2), self.along), four.dot(n1, n2));
        let (angle, usual) = atan2(four, sine, cosine, four.splat(1.0));
        if !four.are_ones(usual) {
            return None;
        }
        let excess = four.sub(angle, self.rest);
        let turn = four.splat(2.0 * PI);
        let below = four.where_at_most(excess, four.splat(PI), excess, four.sub(excess, turn));
        let above = four.add(excess, turn);
        Some(four.where_at_most(four.splat(-PI), excess, below, above))
    }

    /// `m₁`, `m₂`, 1/m².
    #[inline(always)]
    fn inverses(&self, four: F) -> [Triple<F>; 2] {
        let Self { normal, square, .. } = self;
        [four.over(normal[0], square[0]), four.over(normal[1], square[1])]
    }

    /// `∇_p θ`, `∇_q θ`, `∇_E θ`, 1/m.
    #[inline(always)]
    fn gradient(&self, four: F) -> [Triple<F>; 3] {
        let Self { along, length, arm, .. } = self;
        let [m1, m2] = self.inverses(four);
        let (ph, qh) = (four.dot(arm[0], *along), four.dot(arm[1], *along));
        let of_edge = four.plus(four.times(m1, ph), four.times(m2, qh));
        let shorter = four.neg(*length);
        [four.times(m1, shorter), four.times(m2, shorter), of_edge]
    }

    /// Adds the forces; `None`, and nothing is added, where one of the angles is unusual.
    #[inline(always)]
    pub(super) fn add_forces(&self, four: F, out: &mut [Vec3]) -> Option<()> {
        let moment = four.mul(four.neg(self.stiffness), self.excess(four)?);
        let [gp, gq, ge] = self.gradient(four);
        let (fp, fq, fe) = (four.times(gp, moment), four.times(gq, moment), four.times(ge, moment));
        let sum = four.plus(four.plus(fp, fq), fe);
        let opposite = [four.neg(sum[0]), four.neg(sum[1]), four.neg(sum[2])];
        let forces = [four.apart(opposite), four.apart(fe), four.apart(fp), four.apart(fq)];
        add_in_turn(self.places, &forces, out);
        Some(())
    }

    /// The energies, J.
    #[inline(always)]
    pub(super) fn energies(&self, four: F) -> Option<Lanes> {
        let excess = self.excess(four)?;
        let half = four.mul(four.splat(0.5), self.stiffness);
        Some(four.store(four.mul(four.mul(half, excess), excess)))
    }

    /// Adds the blocks; `None`, and nothing is added, where an angle that matters is unusual.
    #[inline(always)]
    pub(super) fn add_stiffness(
        &self,
        four: F,
        scale: f64,
        tangent: Tangent,
        sink: &mut dyn BlockSink,
    ) -> Option<()> {
        let stiffness = four.mul(four.splat(scale), self.stiffness);
        let [gp, gq, ge] = self.gradient(four);
        let mut pp = scaled(four, outer(four, gp, gp), stiffness);
        let mut qq = scaled(four, outer(four, gq, gq), stiffness);
        let mut pe = scaled(four, outer(four, gp, ge), stiffness);
        let mut qe = scaled(four, outer(four, gq, ge), stiffness);
        let mut ee = scaled(four, outer(four, ge, ge), stiffness);
        let pq = scaled(four, outer(four, gp, gq), stiffness);
        if tangent == Tangent::Exact {
            let moment = four.mul(stiffness, self.excess(four)?);
            let [second_pp, second_qq, second_pe, second_qe, second_ee] = self.hessian(four);
            pp = sum(four, pp, scaled(four, second_pp, moment));
            qq = sum(four, qq, scaled(four, second_qq, moment));
            pe = sum(four, pe, scaled(four, second_pe, moment));
            qe = sum(four, qe, scaled(four, second_qe, moment));
            ee = sum(four, ee, scaled(four, second_ee, moment));
        }
        let [i, j, k, l] = self.places;
        let (qp, ep, eq) = (transposed(pq), transposed(pe), transposed(qe));
        let blocks = [
            (k, l, apart(four, opposite(four, pq))),
            (k, j, apart(four, opposite(four, pe))),
            (l, j, apart(four, opposite(four, qe))),
            (k, i, apart(four, sum(four, sum(four, pp, pq), pe))),
            (l, i, apart(four, sum(four, sum(four, qq, qp), qe))),
            (j, i, apart(four, sum(four, sum(four, ee, ep), eq))),
        ];
        for slot in 0..SLOTS {
            for (a, b, numbers) in &blocks {
                let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = numbers;
                let block = Mat3::new(
                    xx[slot], xy[slot], xz[slot], yx[slot], yy[slot], yz[slot], zx[slot], zy[slot],
                    zz[slot],
                );
                sink.add_general_pair(a[slot], b[slot], &block);
            }
        }
        Some(())
    }

    /// Second derivatives of `θ`: `pp`, `qq`, `pE`, `qE`, `EE`, 1/m².
    #[inline(always)]
    fn hessian(&self, four: F) -> [Matrices<F>; 5] {
        let Self { along, length, arm: [p, q], normal, square, .. } = self;
        let (along, length) = (*along, *length);
        let [m1, m2] = self.inverses(four);
        let r1 = mirror(four, normal[0], square[0]);
        let r2 = mirror(four, normal[1], square[1]);
        let (ph, qh) = (four.dot(*p, along), four.dot(*q, along));
        let edge = cross_matrix(four, four.times(along, length));
        let r1p = product(four, r1, cross_matrix(four, *p));
        let r2q = product(four, r2, cross_matrix(four, *q));
        let across_p = four.over(four.minus(*p, four.times(along, ph)), length);
        let across_q = four.over(four.minus(*q, four.times(along, qh)), length);
        let across = sum(four, outer(four, m1, across_p), outer(four, m2, across_q));
        let of_p = difference(four, across, scaled(four, r1p, ph));
        [
            scaled(four, product(four, r1, edge), four.neg(length)),
            scaled(four, product(four, r2, edge), length),
            difference(four, scaled(four, r1p, length), outer(four, m1, along)),
            opposite(four, sum(four, scaled(four, r2q, length), outer(four, m2, along))),
            sum(four, of_p, scaled(four, r2q, qh)),
        ]
    }
}

/// `(I − 2 N̂N̂ᵀ)/|N|²`.
#[inline(always)]
fn mirror<F: Four>(four: F, normal: Triple<F>, square: F::Numbers) -> Matrices<F> {
    let twice = four.div(four.splat(2.0), square);
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] =
        scaled(four, outer(four, normal, normal), twice);
    let (one, zero) = (four.splat(1.0), four.splat(0.0));
    [
        four.over([four.sub(one, xx), four.sub(zero, xy), four.sub(zero, xz)], square),
        four.over([four.sub(zero, yx), four.sub(one, yy), four.sub(zero, yz)], square),
        four.over([four.sub(zero, zx), four.sub(zero, zy), four.sub(one, zz)], square),
    ]
}

/// `[w]` with `[w] u = w × u`.
#[inline(always)]
fn cross_matrix<F: Four>(four: F, [x, y, z]: Triple<F>) -> Matrices<F> {
    let zero = four.splat(0.0);
    [[zero, four.neg(z), y], [z, zero, four.neg(x)], [four.neg(y), x, zero]]
}

/// `a bᵀ`.
#[inline(always)]
fn outer<F: Four>(four: F, a: Triple<F>, b: Triple<F>) -> Matrices<F> {
    [four.times(b, a[0]), four.times(b, a[1]), four.times(b, a[2])]
}

#[inline(always)]
fn product<F: Four>(four: F, a: Matrices<F>, b: Matrices<F>) -> Matrices<F> {
    [row_times(four, a[0], b), row_times(four, a[1], b), row_times(four, a[2], b)]
}

/// `aᵀ B`.
#[inline(always)]
fn row_times<F: Four>(four: F, a: Triple<F>, b: Matrices<F>) -> Triple<F> {
    let two = four.plus(four.times(b[0], a[0]), four.times(b[1], a[1]));
    four.plus(two, four.times(b[2], a[2]))
}

#[inline(always)]
fn scaled<F: Four>(four: F, a: Matrices<F>, s: F::Numbers) -> Matrices<F> {
    [four.times(a[0], s), four.times(a[1], s), four.times(a[2], s)]
}

#[inline(always)]
fn sum<F: Four>(four: F, a: Matrices<F>, b: Matrices<F>) -> Matrices<F> {
    [four.plus(a[0], b[0]), four.plus(a[1], b[1]), four.plus(a[2], b[2])]
}

#[inline(always)]
fn difference<F: Four>(four: F, a: Matrices<F>, b: Matrices<F>) -> Matrices<F> {
    [four.minus(a[0], b[0]), four.minus(a[1], b[1]), four.minus(a[2], b[2])]
}

#[inline(always)]
fn opposite<F: Four>(four: F, a: Matrices<F>) -> Matrices<F> {
    let [x, y, z] = a;
    [
        [four.neg(x[0]), four.neg(x[1]), four.neg(x[2])],
        [four.neg(y[0]), four.neg(y[1]), four.neg(y[2])],
        [four.neg(z[0]), four.neg(z[1]), four.neg(z[2])],
    ]
}

#[inline(always)]
fn transposed<N: Copy>([x, y, z]: [[N; 3]; 3]) -> [[N; 3]; 3] {
    [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
}

/// The numbers of each matrix, hinge by hinge.
#[inline(always)]
fn apart<F: Four>(four: F, [x, y, z]: Matrices<F>) -> [[Lanes; 3]; 3] {
    [
        [four.store(x[0]), four.store(x[1]), four.store(x[2])],
        [four.store(y[0]), four.store(y[1]), four.store(y[2])],
        [four.store(z[0]), four.store(z[1]), four.store(z[2])],
    ]
}
