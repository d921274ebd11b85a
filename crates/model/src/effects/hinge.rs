//! Bending over the edges that two triangles share.
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
//! A hinge at a triangle without area has no angle and exerts no force.

use super::angle::AngularLaw;
use super::elements::{self, Element, Elements, Turn};
use super::registry::{self, Checked, Weave};
use super::{BlockSink, EffectClass, EffectKind, Tangent};
use crate::bounds::{LAST_PARTICLE, MAX_COEFFICIENT};
use crate::error::Violation;
use crate::topology::{InteriorEdge, interior_edges};
use crate::{Mat3, SystemSpec, Vec3};
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
}

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
