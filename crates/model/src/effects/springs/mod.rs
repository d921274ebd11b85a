//! Linear springs with full or projected damping: tension, shear and bending `(i, i+2)`.
//!
//! This module holds the reference form of the formulas: loops over the springs, one after another.
//! A step runs one of two fast kernels with the same bits: [`sweep`] if the springs lie along few
//! diagonals, as on regular grids, and [`batch`] otherwise.

pub(crate) mod batch;
pub(crate) mod diagonals;
mod energy;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod linearise_tests;
pub(crate) mod listed;
pub(crate) mod pairs;
pub(crate) mod quartets;
pub(crate) mod sweep;
pub(crate) mod tangent;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;

use self::batch::Quads;
use self::diagonals::Diagonals;
use self::listed::Listed;
use self::sweep::{Begin, Law, ListedSprings, Pass, Springs, Windows};
use super::{BlockSink, Effect, EffectKind, LinearSplit, Part, Tangent, TensionVisitor};
use crate::{DampingLaw, Level, Mat3, SpringEffect, SpringSpec, SystemSpec, Vec3};
use std::sync::Mutex;

/// A spring shorter than this fraction of its rest length has no direction: `û = 0`. The zero
/// vector is a subgradient of the length, so the energy theorem of the implicit-explicit split
/// still holds.
pub const COLLAPSED: f64 = 1e-12;

/// One linear spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// First end.
    pub i: u32,
    /// Second end.
    pub j: u32,
    /// Rest length `ℓ`, m.
    pub rest_length: f64,
    /// Stiffness `k`, N/m.
    pub stiffness: f64,
    /// Damping coefficient `c` (EEH: d), N s/m.
    pub damping: f64,
}

impl Spring {
    fn ends(&self) -> (usize, usize) {
        (self.i as usize, self.j as usize)
    }

    /// `ℓ/L`, or 0 for a collapsed spring: then `−k(1 − ℓ/L) d` is the force in every case.
    fn rest_over_length(&self, length: f64) -> f64 {
        if length > COLLAPSED * self.rest_length { self.rest_length / length } else { 0.0 }
    }

    /// `d = x_i − x_j` and the direction `û = d/L`, which is 0 for a collapsed spring.
    fn direction(&self, x: &[Vec3]) -> Vec3 {
        let (i, j) = self.ends();
        direction(self.rest_length, x[i] - x[j])
    }
}

/// Where the springs are kept.
#[derive(Clone, Debug, PartialEq)]
enum Store {
    /// One by one.
    Listed(Listed),
    /// Along diagonals, with shared parameters.
    Diagonals(Diagonals),
}

impl Store {
    /// Visits the springs in the order of the specification.
    #[inline]
    fn each(&self, visit: impl FnMut(&Spring)) {
        match self {
            Self::Listed(springs) => springs.each(visit),
            Self::Diagonals(diagonals) => diagonals.each(visit),
        }
    }

    /// Multiplies all stiffnesses and all damping coefficients.
    fn scale(&mut self, stiffness: f64, damping: f64) {
        match self {
            Self::Listed(springs) => springs.scale(stiffness, damping),
            Self::Diagonals(diagonals) => diagonals.scale(stiffness, damping),
        }
    }
}

/// All linear springs of one effect.
#[derive(Debug)]
pub struct LinearSprings {
    kind: EffectKind,
    store: Store,
    damping: Option<DampingLaw>,
    /// Scratch for one sweep. If another thread holds it, fall back to the reference form.
    memory: Mutex<Memory>,
}

/// Memory of the kernel that fits the springs.
#[derive(Debug)]
enum Memory {
    Windows(Windows),
    Quads(Quads),
}

impl Clone for LinearSprings {
    fn clone(&self) -> Self {
        Self::with_store(self.kind, self.store.clone(), self.damping)
    }
}

impl LinearSprings {
    /// Springs of one kind. If no spring has a damping coefficient above 0, the effect has no
    /// damping pass.
    pub fn new(kind: EffectKind, springs: Vec<Spring>, law: DampingLaw) -> Self {
        let damping = springs.iter().any(|s| s.damping > 0.0).then_some(law);
        let store = match Diagonals::detect(&springs) {
            Some(diagonals) => Store::Diagonals(diagonals),
            None => Store::Listed(Listed::new(&springs)),
        };
        Self::with_store(kind, store, damping)
    }

    fn with_store(kind: EffectKind, store: Store, damping: Option<DampingLaw>) -> Self {
        let memory = match &store {
            Store::Listed(springs) => Memory::Quads(Quads::new(springs.particles)),
            Store::Diagonals(diagonals) => {
                Memory::Windows(Windows::new(1, std::iter::once(diagonals)))
            }
        };
        Self { kind, store, damping, memory: Mutex::new(memory) }
    }

    /// Visits the springs in the order of the specification.
    pub fn each(&self, visit: impl FnMut(&Spring)) {
        self.store.each(visit);
    }

    /// The springs in the form that a sweep takes.
    fn as_pass(&self, law: Law) -> Pass<'_> {
        match &self.store {
            Store::Listed(list) => Pass::Listed(ListedSprings { list, law }),
            Store::Diagonals(diagonals) => Pass::Springs(Springs { diagonals, law }),
        }
    }

    /// The law of a part of the forces. Absent damping has none, nor have force and projected
    /// damping as one.
    fn law(&self, part: Part) -> Option<Law> {
        match (part, self.damping) {
            (Part::All, Some(DampingLaw::Full)) => Some(Law::DampedSpring),
            (Part::All, None) | (Part::Force, _) => Some(Law::Spring),
            (Part::Nonlinear, _) => Some(Law::Nonlinear),
            (Part::Linear, _) => Some(Law::Linear),
            (Part::Damping, Some(DampingLaw::Full)) | (Part::LinearDamping, _) => {
                Some(Law::Damping)
            }
            (Part::Damping, Some(DampingLaw::Projected)) => Some(Law::Projected),
            (Part::All, Some(DampingLaw::Projected)) | (Part::Damping, None) => None,
        }
    }

    /// Adds the force of every spring after the law, with the kernel that fits.
    fn add(&self, law: Law, x: &[Vec3], v: &[Vec3], out: &mut [Vec3]) {
        let passes = [Some(self.as_pass(law))];
        match self.memory.try_lock().as_deref_mut() {
            Ok(Memory::Windows(windows)) => {
                sweep::add(&passes, windows, x, v, out, Begin::Present, None);
            }
            Ok(Memory::Quads(quads)) => batch::add(&passes, quads, x, v, out, Begin::Present),
            Err(_) => self.add_reference(law, x, v, out),
        }
    }

    /// The reference form of [`add`](Self::add): EEH (11), (13), (12) and (14), each with the
    /// opposite sign.
    pub(crate) fn add_reference(&self, law: Law, x: &[Vec3], v: &[Vec3], out: &mut [Vec3]) {
        self.each(|s| {
            let (i, j) = s.ends();
            let stretch = || {
                let d = x[i] - x[j];
                d * law.stiffness(s.stiffness, s.rest_over_length(d.norm()))
            };
            let damping = || (v[i] - v[j]) * s.damping;
            let f = match law {
                Law::Spring | Law::Nonlinear | Law::Linear => stretch(),
                Law::DampedSpring => stretch() + damping(),
                Law::Damping => damping(),
                Law::Projected => projected(s.rest_length, s.damping, x[i] - x[j], v[i] - v[j]),
            };
            out[i] -= f;
            out[j] += f;
        });
    }

    /// The reference form of the energy, J.
    pub(crate) fn energy_reference(&self, x: &[Vec3]) -> f64 {
        let mut sum = -0.0;
        self.each(|s| {
            let (i, j) = s.ends();
            let stretch = (x[i] - x[j]).norm() - s.rest_length;
            sum += 0.5 * s.stiffness * stretch * stretch;
        });
        sum
    }
}

/// `d/L`, which is 0 for a collapsed spring.
fn direction(rest_length: f64, d: Vec3) -> Vec3 {
    let length = d.norm();
    if length > COLLAPSED * rest_length { d / length } else { Vec3::zeros() }
}

/// Projected damping, `c ûûᵀw`, of a spring with the differences `d` and `w` of its ends.
fn projected(rest_length: f64, damping: f64, d: Vec3, w: Vec3) -> Vec3 {
    let u = direction(rest_length, d);
    u * (damping * u.dot(&w))
}

impl Effect for LinearSprings {
    fn kind(&self) -> EffectKind {
        self.kind
    }

    /// `U = Σ ½ k (L − ℓ)²`.
    fn energy(&self, _mass: &[f64], x: &[Vec3]) -> f64 {
        match &self.store {
            Store::Diagonals(diagonals) => energy::sum(diagonals, x),
            Store::Listed(_) => self.energy_reference(x),
        }
    }

    /// `f_i = −k (L − ℓ) û`: the negative of EEH (11).
    #[doc(alias = "EEH 11")]
    fn add_force(&self, _mass: &[f64], x: &[Vec3], out: &mut [Vec3]) {
        self.add(Law::Spring, x, x, out);
    }

    fn pass<'a>(&'a self, _mass: &'a [f64], part: Part) -> Option<Pass<'a>> {
        Some(self.as_pass(self.law(part)?))
    }

    /// Force and full damping of each spring are added as one.
    fn add_part(&self, part: Part, mass: &[f64], at: Level<'_>, out: &mut [Vec3]) {
        if let Some(law) = self.law(part) {
            return self.add(law, at.x, at.v, out);
        }
        if part == Part::All {
            self.add_force(mass, at.x, out);
        }
        self.add_damping_force(at, out);
    }

    fn has_damping(&self) -> bool {
        self.damping.is_some()
    }

    /// Full: `f_i = −c (v_i − v_j)`, the negative of EEH (14). Projected:
    /// `f_i = −c ûûᵀ(v_i − v_j)`.
    #[doc(alias = "EEH 14")]
    fn add_damping_force(&self, Level { x, v, .. }: Level<'_>, out: &mut [Vec3]) {
        match self.damping {
            None => {}
            Some(DampingLaw::Full) => self.add(Law::Damping, x, v, out),
            Some(DampingLaw::Projected) => self.add(Law::Projected, x, v, out),
        }
    }

    fn has_jacobian(&self) -> bool {
        true
    }

    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize)) {
        self.each(|s| {
            let (i, j) = s.ends();
            visit(i, j);
        });
    }

    /// `−∂f_i/∂x_i = k [ûûᵀ + (1 − ℓ/L)(I − ûûᵀ)]`: eigenvalues `k` along the spring and
    /// `k (1 − ℓ/L)`, twice, across it; the latter are negative exactly when it is compressed.
    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink) {
        self.each(|s| {
            let (i, j) = s.ends();
            let d = x[i] - x[j];
            let length = d.norm();
            let transverse = match (1.0 - s.rest_over_length(length), tangent) {
                (t, Tangent::Exact) => t,
                (t, Tangent::Projected) => t.max(0.0),
            };
            let u = s.direction(x);
            let block = (u * u.transpose() * (1.0 - transverse)
                + Mat3::from_diagonal_element(transverse))
                * (scale * s.stiffness);
            sink.add_pair(i, j, &block);
        });
    }

    fn add_damping(&self, lagged: Level<'_>, scale: f64, sink: &mut dyn BlockSink) {
        let Some(law) = self.damping else { return };
        self.each(|s| {
            let (i, j) = s.ends();
            let block = match law {
                DampingLaw::Full => Mat3::from_diagonal_element(scale * s.damping),
                DampingLaw::Projected => {
                    let u = s.direction(lagged.x);
                    u * u.transpose() * (scale * s.damping)
                }
            };
            sink.add_pair(i, j, &block);
        });
    }

    /// `f_i = −c û (û·v)` turns by `−c (δû (û·v) + û (δû·v))`, `δû = (I − ûûᵀ) δd/L`.
    fn add_damping_turn(&self, Level { x, v, .. }: Level<'_>, w: &[Vec3], out: &mut [Vec3]) {
        if !self.has_damping_turn() {
            return;
        }
        self.each(|s| {
            let (i, j) = s.ends();
            let (u, length) = (s.direction(x), (x[i] - x[j]).norm());
            let turned = w[i] - w[j];
            let turn = if u == Vec3::zeros() { u } else { (turned - u * u.dot(&turned)) / length };
            let rate = v[i] - v[j];
            let f = (turn * u.dot(&rate) + u * turn.dot(&rate)) * s.damping;
            out[i] -= f;
            out[j] += f;
        });
    }

    fn has_damping_turn(&self) -> bool {
        self.damping == Some(DampingLaw::Projected)
    }

    fn split(&self) -> Option<&dyn LinearSplit> {
        Some(self)
    }

    fn scale_stiffness(&mut self, factor: f64) -> bool {
        self.store.scale(factor, 1.0);
        true
    }

    fn scale_damping(&mut self, factor: f64) -> bool {
        self.store.scale(1.0, factor);
        true
    }

    fn describe(&self, spec: &mut SystemSpec) -> bool {
        let of_kind = |effect: &SpringEffect| EffectKind::from(*effect) == self.kind;
        let Some(effect) = SpringEffect::ALL.into_iter().find(of_kind) else { return false };
        spec.damping = self.damping.unwrap_or(spec.damping);
        self.each(|s| {
            spec.springs.push(SpringSpec {
                effect,
                i: s.i,
                j: s.j,
                rest_length_m: s.rest_length,
                stiffness_n_per_m: s.stiffness,
                damping_n_s_per_m: s.damping,
                ..SpringSpec::default()
            });
        });
        true
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

impl LinearSplit for LinearSprings {
    fn visit_weights(&self, visit: &mut dyn FnMut(usize, usize, f64, f64)) {
        self.each(|s| {
            let (i, j) = s.ends();
            visit(i, j, s.stiffness, s.damping);
        });
    }

    fn visit_rest_lengths(&self, visit: &mut dyn FnMut(usize, usize, f64)) {
        self.each(|s| {
            let (i, j) = s.ends();
            visit(i, j, s.rest_length);
        });
    }

    fn visit_secants(&self, x: &[Vec3], visit: &mut dyn FnMut(usize, usize, f64)) {
        self.each(|s| {
            let (i, j) = s.ends();
            let length = (x[i] - x[j]).norm();
            visit(i, j, s.stiffness * (1.0 - s.rest_over_length(length)));
        });
    }

    fn visit_tensions(&self, visit: &mut TensionVisitor<'_>) {
        self.each(|s| {
            let (i, j) = s.ends();
            visit(i, j, s.stiffness, &|length| s.stiffness * (length - s.rest_length));
        });
    }

    fn visit_discrete_gradients(
        &self,
        from: &[Vec3],
        to: &[Vec3],
        visit: &mut dyn FnMut(usize, usize, f64, f64),
    ) {
        self.each(|s| {
            let (i, j) = s.ends();
            let sum = (from[i] - from[j]).norm() + (to[i] - to[j]).norm();
            let rest_over_sum = s.rest_over_length(sum);
            let slope = if rest_over_sum > 0.0 { s.stiffness * rest_over_sum / sum } else { 0.0 };
            visit(i, j, s.stiffness * (0.5 - rest_over_sum), slope);
        });
    }

    /// `F2_i = +k ℓ û`: constant in size, the negative of EEH (13).
    #[doc(alias = "EEH 13")]
    fn add_nonlinear_force(&self, x: &[Vec3], out: &mut [Vec3]) {
        self.add(Law::Nonlinear, x, x, out);
    }

    fn add_linear_force(&self, x: &[Vec3], out: &mut [Vec3]) {
        self.add(Law::Linear, x, x, out);
    }

    fn add_linear_damping(&self, v: &[Vec3], out: &mut [Vec3]) {
        self.add(Law::Damping, v, v, out);
    }

    fn has_damping_remainder(&self) -> bool {
        self.damping == Some(DampingLaw::Projected)
    }

    fn add_damping_remainder(&self, x: &[Vec3], v: &[Vec3], out: &mut [Vec3]) {
        if !self.has_damping_remainder() {
            return;
        }
        self.each(|s| {
            let (i, j) = s.ends();
            let rate = v[i] - v[j];
            let u = s.direction(x);
            let f = (rate - u * u.dot(&rate)) * s.damping;
            out[i] += f;
            out[j] -= f;
        });
    }
}
