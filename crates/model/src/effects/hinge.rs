//! Bending across edges that two triangles share.
//!
//! With the edge `E = x_j − x_i`, the opposite corners `p = x_k − x_i`, `q = x_l − x_i` and the
//! normals `N₁ = E × p`, `N₂ = q × E`, the dihedral angle is (Bridson et al. 2003, Grinspun
//! et al. 2003)
//!
//! ```text
//! θ = atan2((N₁ × N₂)·Ê, N₁·N₂)          U = ½ K (θ − θ₀)²
//! ∇_p θ = −|E| m₁     ∇_q θ = −|E| m₂     ∇_E θ = (p·Ê) m₁ + (q·Ê) m₂          m = N/|N|²
//! ```
//!
//! The second derivatives of `θ` have no block `pq`. With `R = (I − 2 N̂N̂ᵀ)/|N|²`, so that
//! `dm = R dN`, they are
//!
//! ```text
//! pp: −|E| R₁[E]     pE: −m₁Êᵀ + |E| R₁[p]     qq: |E| R₂[E]     qE: −m₂Êᵀ − |E| R₂[q]
//! EE: (m₁ p⊥ᵀ + m₂ q⊥ᵀ)/|E| − (p·Ê) R₁[p] + (q·Ê) R₂[q]
//! p⊥ = p − (p·Ê) Ê     [w] u = w × u
//! ```
//!
//! A hinge has no angle and exerts no force if one of its triangles has no area.

mod folds;

use self::folds::Folds;
use super::angle::AngularLaw;
use super::elements::{self, Element, Elements, Turn};
use super::registry::{self, Checked, Weave};
use super::{BlockSink, EffectClass, EffectKind, Tangent};
use crate::bounds::{LAST_PARTICLE, MAX_COEFFICIENT};
use crate::error::Violation;
use crate::topology::{InteriorEdge, interior_edges};
use crate::{Mat3, SystemSpec, Vec3};
use drape_kernels::lanes::{Four, Lanes};
use drape_kernels::vector::SLOTS;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A triangle whose sine at the edge is smaller than this has no normal.
const DEGENERATE: f64 = 1e-12;
/// An edge must be longer than this to have a direction, m.
const SHORTEST: f64 = 1e-70;

/// The dihedral angle between the triangles `(i, j, k)` and `(i, j, l)`, in a frozen system.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HingeSpec {
    /// First end of the edge.
    #[schemars(range(max = LAST_PARTICLE))]
    pub i: u32,
    /// Second end of the edge.
    #[schemars(range(max = LAST_PARTICLE))]
    pub j: u32,
    /// Corner on one side.
    #[schemars(range(max = LAST_PARTICLE))]
    pub k: u32,
    /// Corner on the other side.
    #[schemars(range(max = LAST_PARTICLE))]
    pub l: u32,
    /// Angle at rest, rad; 0 is flat.
    #[schemars(range(min = -PI, max = PI))]
    pub rest_rad: f64,
    /// Stiffness `K` of this hinge, N m.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_m: f64,
}

/// All hinges of a cloth.
pub type Hinges = Elements<HingeSpec>;

/// Two triangles with a normal.
struct Fold {
    /// `Ê`.
    along: Vec3,
    /// `|E|`, m.
    length: f64,
    /// `p` and `q`, m.
    arm: [Vec3; 2],
    /// `N₁`, `N₂`, m².
    normal: [Vec3; 2],
}

impl Fold {
    fn new([i, j, k, l]: [Vec3; 4]) -> Option<Self> {
        let (e, p, q) = (j - i, k - i, l - i);
        let length = e.norm();
        let normal = [e.cross(&p), q.cross(&e)];
        let is_triangle =
            |n: &Vec3, arm: &Vec3| n.norm() > DEGENERATE * length * arm.norm().max(SHORTEST);
        let is_fold =
            length > SHORTEST && is_triangle(&normal[0], &p) && is_triangle(&normal[1], &q);
        is_fold.then(|| Self { along: e / length, length, arm: [p, q], normal })
    }

    /// `θ`, rad.
    fn angle(&self) -> f64 {
        let [n1, n2] = &self.normal;
        libm::atan2(n1.cross(n2).dot(&self.along), n1.dot(n2))
    }

    /// `m₁`, `m₂`, 1/m².
    fn inverses(&self) -> [Vec3; 2] {
        self.normal.map(|n| n / n.norm_squared())
    }

    /// `∇_p θ`, `∇_q θ`, `∇_E θ`, 1/m.
    fn gradient(&self) -> [Vec3; 3] {
        let ([m1, m2], [p, q]) = (self.inverses(), &self.arm);
        let of_edge = m1 * p.dot(&self.along) + m2 * q.dot(&self.along);
        [m1 * -self.length, m2 * -self.length, of_edge]
    }

    /// Second derivatives of `θ`: `pp`, `qq`, `pE`, `qE`, `EE`, 1/m².
    fn hessian(&self) -> [Mat3; 5] {
        let Self { along, length, arm: [p, q], normal } = self;
        let [m1, m2] = self.inverses();
        let [r1, r2] = normal.map(|n| {
            let square = n.norm_squared();
            (Mat3::identity() - n * n.transpose() * (2.0 / square)) / square
        });
        let (ph, qh) = (p.dot(along), q.dot(along));
        let edge = (along * *length).cross_matrix();
        let (r1p, r2q) = (r1 * p.cross_matrix(), r2 * q.cross_matrix());
        let across = |arm: &Vec3, part: f64| (arm - along * part).transpose() / *length;
        [
            r1 * edge * -*length,
            r2 * edge * *length,
            r1p * *length - m1 * along.transpose(),
            -(r2q * *length + m2 * along.transpose()),
            m1 * across(p, ph) + m2 * across(q, qh) - r1p * ph + r2q * qh,
        ]
    }
}

impl HingeSpec {
    fn places(&self) -> [usize; 4] {
        [self.i, self.j, self.k, self.l].map(|i| i as usize)
    }

    fn fold(&self, x: &[Vec3]) -> Option<Fold> {
        Fold::new(self.places().map(|i| x[i]))
    }

    /// `θ − θ₀`, the shorter way round.
    fn excess(&self, fold: &Fold) -> f64 {
        let excess = fold.angle() - self.rest_rad;
        if excess > PI {
            excess - 2.0 * PI
        } else if excess < -PI {
            excess + 2.0 * PI
        } else {
            excess
        }
    }
}

impl Element for HingeSpec {
    const LIST: &'static str = "hinges";
    const REST: (f64, f64) = (-PI, PI);

    fn list(spec: &SystemSpec) -> &[Self] {
        &spec.hinges
    }

    fn list_mut(spec: &mut SystemSpec) -> &mut Vec<Self> {
        &mut spec.hinges
    }

    fn kind(&self) -> EffectKind {
        EffectKind::BendingHinge
    }

    fn particles(&mut self) -> impl Iterator<Item = (&'static str, &mut u32)> {
        let Self { i, j, k, l, .. } = self;
        [("i", i), ("j", j), ("k", k), ("l", l)].into_iter()
    }

    fn rest(&self) -> f64 {
        self.rest_rad
    }

    fn stiffness(&mut self) -> &mut f64 {
        &mut self.stiffness_n_m
    }

    fn energy(&self, x: &[Vec3]) -> Option<f64> {
        let excess = self.excess(&self.fold(x)?);
        Some(0.5 * self.stiffness_n_m * excess * excess)
    }

    /// `f = −K (θ − θ₀) ∇θ`.
    fn add_force(&self, x: &[Vec3], out: &mut [Vec3]) {
        let Some(fold) = self.fold(x) else { return };
        let moment = -self.stiffness_n_m * self.excess(&fold);
        let [fp, fq, fe] = fold.gradient().map(|gradient| gradient * moment);
        let [i, j, k, l] = self.places();
        out[k] += fp;
        out[l] += fq;
        out[j] += fe;
        out[i] -= fp + fq + fe;
    }

    #[inline(always)]
    fn add_forces<F: Four>(four: F, group: &[Self; SLOTS], x: &[Vec3], out: &mut [Vec3]) -> bool {
        let Some(folds) = Folds::new(four, group, x) else { return false };
        folds.add_forces(four, out).is_some()
    }

    #[inline(always)]
    fn energies<F: Four>(four: F, group: &[Self; SLOTS], x: &[Vec3]) -> Option<Lanes> {
        Folds::new(four, group, x)?.energies(four)
    }

    fn turn(&self, x: &[Vec3; 4]) -> Option<Turn> {
        let fold = Fold::new(*x)?;
        let [p, q, e] = fold.gradient();
        let gradient = [-(p + q + e), e, p, q];
        Some(Turn { excess: self.excess(&fold), gradient, stiffness: self.stiffness_n_m })
    }

    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize)) {
        let [i, j, k, l] = self.places();
        for (a, b) in [(k, l), (k, j), (l, j), (k, i), (l, i), (j, i)] {
            visit(a, b);
        }
    }

    /// `K ∇θ ∇θᵀ`. The exact tangent adds `K (θ − θ₀) ∇²θ`.
    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink) {
        let Some(fold) = self.fold(x) else { return };
        let stiffness = scale * self.stiffness_n_m;
        let [gp, gq, ge] = fold.gradient();
        let outer = |a: &Vec3, b: &Vec3| a * b.transpose() * stiffness;
        let [mut pp, mut qq, mut pe, mut qe, mut ee] =
            [outer(&gp, &gp), outer(&gq, &gq), outer(&gp, &ge), outer(&gq, &ge), outer(&ge, &ge)];
        let pq = outer(&gp, &gq);
        if tangent == Tangent::Exact {
            let moment = stiffness * self.excess(&fold);
            let parts = [&mut pp, &mut qq, &mut pe, &mut qe, &mut ee];
            for (part, second) in parts.into_iter().zip(fold.hessian()) {
                *part += second * moment;
            }
        }
        let [i, j, k, l] = self.places();
        sink.add_general_pair(k, l, &-pq);
        sink.add_general_pair(k, j, &-pe);
        sink.add_general_pair(l, j, &-qe);
        sink.add_general_pair(k, i, &(pp + pq + pe));
        sink.add_general_pair(l, i, &(qq + pq.transpose() + qe));
        sink.add_general_pair(j, i, &(ee + pe.transpose() + qe.transpose()));
    }

    #[inline(always)]
    fn add_stiffnesses<F: Four>(
        four: F,
        group: &[Self; SLOTS],
        x: &[Vec3],
        scale: f64,
        tangent: Tangent,
        sink: &mut dyn BlockSink,
    ) -> bool {
        let Some(folds) = Folds::new(four, group, x) else { return false };
        folds.add_stiffness(four, scale, tangent, sink).is_some()
    }

    /// Takes angle and gradient once, and only the blocks that the particle's own block adds up.
    fn local(&self, place: usize, x: &[Vec3; 4]) -> (Vec3, Mat3) {
        let Some(fold) = Fold::new(*x) else { return (Vec3::zeros(), Mat3::zeros()) };
        let [gp, gq, ge] = fold.gradient();
        let moment = -self.stiffness_n_m * self.excess(&fold);
        let [fp, fq, fe] = [gp, gq, ge].map(|gradient| gradient * moment);
        let outer = |a: &Vec3, b: &Vec3| a * b.transpose() * self.stiffness_n_m;
        let (pq, pe, qe) = (outer(&gp, &gq), outer(&gp, &ge), outer(&gq, &ge));
        let to_i = |of: usize| match of {
            K => outer(&gp, &gp) + pq + pe,
            L => outer(&gq, &gq) + pq.transpose() + qe,
            _ => outer(&ge, &ge) + pe.transpose() + qe.transpose(),
        };
        // The order of the sums is that of the pairs in `add_stiffness`.
        let zero = Mat3::zeros();
        let (force, block) = match place {
            K => (fp, zero + -pq + -pe + to_i(K)),
            L => (fq, zero + (-pq).transpose() + -qe + to_i(L)),
            J => (fe, zero + (-pe).transpose() + (-qe).transpose() + to_i(J)),
            _ => {
                let blocks = [K, L, J].map(|of| to_i(of).transpose());
                (-(fp + fq + fe), zero + blocks[0] + blocks[1] + blocks[2])
            }
        };
        (Vec3::zeros() + force, block)
    }
}

/// Places of `j`, `k` and `l` among the particles of a hinge.
const J: usize = 1;
const K: usize = 2;
const L: usize = 3;

/// The effect of all hinges.
pub(crate) struct Entry;

impl registry::Entry for Entry {
    type Value = AngularLaw;
    const CLASS: EffectClass = EffectClass::Stencils;
    const PIECES: [u64; 2] = [3, 3];

    /// Hinges over the interior edges of the triangles, at rest in the start positions:
    /// `K = 3 k |E|²/(A₁ + A₂)` (Grinspun et al. 2003).
    fn freeze(
        law: &AngularLaw,
        kind: EffectKind,
        _cloth: Weave<'_>,
        spec: &mut SystemSpec,
    ) -> Result<(), Violation> {
        let stiffness = law.check(kind)?;
        hinges(spec, &format!("effects.{kind}"), |_| stiffness)
    }

    fn check(kind: EffectKind, spec: &SystemSpec) -> Result<Option<Box<dyn Checked>>, Violation> {
        elements::check::<HingeSpec>(kind, spec)
    }
}

/// Adds the hinges of the triangles; `stiffness` (N m) is that of the law at each edge, by its ends.
/// Messages call the key `path`.
pub(crate) fn hinges(
    spec: &mut SystemSpec,
    path: &str,
    stiffness: impl Fn([u32; 2]) -> f64,
) -> Result<(), Violation> {
    for InteriorEdge { ends: [i, j], opposite: [k, l] } in interior_edges(&spec.triangles) {
        let corners = [i, j, k, l].map(|i| Vec3::from(spec.particles.position_m[i as usize]));
        let Some(fold) = Fold::new(corners) else {
            let found = format!("given for triangles without area at the edge from {i} to {j}");
            let expected = "triangles with an area";
            return Err(Violation::new(path, found, expected));
        };
        let [a, b, c, d] = corners;
        let e = b - a;
        let doubled_area = e.cross(&(c - a)).norm() + e.cross(&(d - a)).norm();
        let stiffness_n_m = stiffness([i, j]) * (6.0 * e.norm_squared() / doubled_area);
        spec.hinges.push(HingeSpec { i, j, k, l, rest_rad: fold.angle(), stiffness_n_m });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::elements::tests::{compare, positions, sheet};
    use super::*;
    use drape_kernels::testing::{Random, assert_same_bits};

    #[test]
    fn the_part_of_one_particle_has_the_bits_of_the_whole_hinge() {
        let mut random = Random::new(9);
        let hinge = HingeSpec { i: 0, j: 1, k: 2, l: 3, rest_rad: 0.2, stiffness_n_m: 0.7 };
        let mut folds = 0;
        for x in (0..20).flat_map(|_| positions(&mut random, 4)) {
            let x: [Vec3; 4] = std::array::from_fn(|k| x[k]);
            folds += usize::from(Fold::new(x).is_some());
            for place in 0..4 {
                let (force, block) = hinge.local(place, &x);
                let (expected, expected_block) = elements::whole(&hinge, place, &x);
                let numbers = |force: &Vec3, block: &Mat3| -> Vec<f64> {
                    let number = |a: &f64| if a.is_nan() { f64::NAN } else { *a };
                    force.iter().chain(block.iter()).map(number).collect()
                };
                assert_same_bits(
                    (place, x),
                    &numbers(&expected, &expected_block),
                    &numbers(&force, &block),
                );
            }
        }
        assert!(folds > 20, "{folds}");
    }

    #[test]
    fn four_hinges_at_a_time_give_the_bits_of_one_after_the_other() {
        let mut random = Random::new(8);
        let mut fast = 0;
        for count in (0..10).chain([60]) {
            let n = 5 + count;
            let list: Vec<_> = (0..count)
                .map(|k| {
                    let [i, j, k, l] = [0, 1, 2, 3].map(|step| ((k * 3 + step) % n) as u32);
                    let rest_rad = [0.0, 0.4, -3.1, 3.1][l as usize % 4];
                    HingeSpec { i, j, k, l, rest_rad, stiffness_n_m: 0.3 + f64::from(k) }
                })
                .collect();
            for x in positions(&mut random, n) {
                fast += compare(&list, &mut random, &x);
            }
        }
        assert!(fast > 50, "{fast}");
    }

    /// The edges of a flat sheet at rest are usual.
    #[test]
    fn a_sheet_at_rest_takes_the_fast_form() {
        let hinge = |i, j, k, l| HingeSpec { i, j, k, l, rest_rad: 0.0, stiffness_n_m: 1.0 };
        let hinges = [hinge(1, 3, 0, 4), hinge(2, 4, 1, 5), hinge(1, 4, 3, 2), hinge(3, 1, 0, 4)];
        assert_eq!(compare(&hinges, &mut Random::new(1), &sheet()), 1);
    }
}
