//! Springs whose tension is piecewise linear in the strain, or that buckle: tension as Kawabata's
//! machine measures it.
//!
//! ```text
//! f_i = −T(L) û        −∂f_i/∂x_i = T' ûûᵀ + (T/L)(I − ûûᵀ)
//! ```
//!
//! In the split `f = −L_K x + F2(x)`, `K` is the steepest slope of the spring's curve, a constant.
//! Then `½ K L² − U` is convex, and the energy theorem of IMEX Euler and the descent of updated CG
//! hold as for linear springs. The price is artificial damping `h K`, across and along every spring
//! whose present slope is below `K`. [`visit_slopes`](LinearSplit::visit_slopes) offers the present
//! slope instead.

mod buckling;
mod law;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;

pub(crate) use buckling::Buckling;
pub(crate) use law::Curve;
pub use law::TensionLaw;

use super::springs::quartets::{self, Kernel, Quartet};
use super::springs::{COLLAPSED, LinearSprings, Spring};
use super::{BlockSink, Effect, EffectKind, LinearSplit, Tangent, TensionVisitor};
use crate::{DampingLaw, Level, Mat3, Vec3};
use drape_kernels::lanes::Four;
use drape_kernels::triples::{Triple, Triples};

/// All springs of one effect; at least one is not linear.
#[derive(Clone, Debug)]
pub struct PiecewiseSprings {
    /// Springs with the steepest stiffness of each curve. They give the linear part of the split,
    /// and the damping.
    majorant: LinearSprings,
    laws: Vec<TensionLaw>,
    /// Index into `laws` for each spring, in the order of the specification.
    law_of: Vec<u32>,
}

/// A spring at some positions.
struct Stretched<'a> {
    i: usize,
    j: usize,
    /// `x_i − x_j`, m.
    d: Vec3,
    /// `|d|`, m.
    length: f64,
    rest: f64,
    /// Steepest stiffness `K`, N/m.
    majorant: f64,
    damping: f64,
    law: &'a TensionLaw,
}

impl<'a> Stretched<'a> {
    fn new(spring: &Spring, law: &'a TensionLaw, x: &[Vec3]) -> Self {
        let (i, j) = (spring.i as usize, spring.j as usize);
        let d = x[i] - x[j];
        Self {
            i,
            j,
            d,
            length: d.norm(),
            rest: spring.rest_length,
            majorant: spring.stiffness,
            damping: spring.damping,
            law,
        }
    }

    /// Whether it has no direction. Then its force is `−T'(0) d`.
    fn is_collapsed(&self) -> bool {
        self.length <= COLLAPSED * self.rest
    }

    fn slope(&self) -> f64 {
        self.law.slope(self.rest, self.length)
    }

    /// `T/L`, N/m.
    fn secant(&self) -> f64 {
        if self.is_collapsed() { self.slope() } else { self.law.secant(self.rest, self.length) }
    }
}

impl PiecewiseSprings {
    /// Springs of one kind, each with the law `laws[law_of[…]]`. Their own stiffness is ignored.
    pub(crate) fn new(
        kind: EffectKind,
        mut springs: Vec<Spring>,
        law_of: Vec<u32>,
        laws: Vec<TensionLaw>,
        damping: DampingLaw,
    ) -> Self {
        for (spring, &law) in springs.iter_mut().zip(&law_of) {
            spring.stiffness = laws[law as usize].steepest();
        }
        Self { majorant: LinearSprings::new(kind, springs, damping), laws, law_of }
    }

    /// Visits the springs at `x` in the order of the specification.
    fn each(&self, x: &[Vec3], mut visit: impl FnMut(&Stretched<'_>)) {
        let mut law_of = self.law_of.iter();
        self.majorant.each(|s| {
            let Some(&law) = law_of.next() else { return };
            visit(&Stretched::new(s, &self.laws[law as usize], x));
        });
    }

    /// Adds `−T/L (x_i − x_j)` of every spring, four at a time; without its linear part on request.
    fn add(&self, is_remainder: bool, x: &[Vec3], out: &mut [Vec3]) {
        quartets::add(|visit| self.majorant.each(visit), &Bent { all: self, is_remainder, x }, out);
    }

    /// The law of a spring, by its place in the list.
    fn law_at(&self, place: usize) -> &TensionLaw {
        &self.laws[self.law_of[place] as usize]
    }
}

/// `g (x_i − x_j)` with `g = T/L`, or `T/L − K` for the remainder.
struct Bent<'a> {
    all: &'a PiecewiseSprings,
    is_remainder: bool,
    x: &'a [Vec3],
}

impl Kernel for Bent<'_> {
    fn one(&self, spring: &Spring, place: usize) -> Vec3 {
        let stretched = Stretched::new(spring, self.all.law_at(place), self.x);
        let secant = stretched.secant();
        stretched.d * if self.is_remainder { secant - stretched.majorant } else { secant }
    }

    /// None of the four may buckle.
    #[inline(always)]
    fn four<F: Four>(&self, four: F, springs: &Quartet, place: usize) -> Option<Triple<F>> {
        let all = self.all;
        let laws = [all.law_at(place), all.law_at(place + 1), all.law_at(place + 2)];
        let laws = [laws[0], laws[1], laws[2], all.law_at(place + 3)];
        let d = springs.difference(four, self.x);
        let length = four.sqrt(four.dot(d, d));
        let rest = four.load(springs.rest);
        let collapsed = four.mul(four.splat(COLLAPSED), rest);
        let none = four.where_at_most(length, collapsed, four.splat(0.0), four.splat(1.0));
        if !four.are_ones(four.if_at_most(length, four.splat(f64::MAX), none)) {
            return None;
        }
        let tension = TensionLaw::tensions(four, laws, rest, length)?;
        let secant = four.div(tension, length);
        let stiffness = four.load(springs.stiffness);
        let g = if self.is_remainder { four.sub(secant, stiffness) } else { secant };
        Some(four.times(d, g))
    }
}

impl Effect for PiecewiseSprings {
    fn kind(&self) -> EffectKind {
        self.majorant.kind()
    }

    fn energy(&self, _mass: &[f64], x: &[Vec3]) -> f64 {
        let mut sum = -0.0;
        self.each(x, |s| sum += s.law.energy(s.rest, s.length));
        sum
    }

    /// `f_i = −T û`.
    fn add_force(&self, _mass: &[f64], x: &[Vec3], out: &mut [Vec3]) {
        self.add(false, x, out);
    }

    fn has_damping(&self) -> bool {
        self.majorant.has_damping()
    }

    fn add_damping_force(&self, at: Level<'_>, out: &mut [Vec3]) {
        self.majorant.add_damping_force(at, out);
    }

    fn has_jacobian(&self) -> bool {
        true
    }

    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize)) {
        self.majorant.visit_pairs(visit);
    }

    /// `−∂f_i/∂x_i = T' ûûᵀ + (T/L)(I − ûûᵀ)`: eigenvalues `T'`, never negative, along the spring
    /// and `T/L`, twice, across it. [`Tangent::Projected`] drops the latter in compression.
    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink) {
        self.each(x, |s| {
            let transverse = match tangent {
                Tangent::Exact => s.secant(),
                Tangent::Projected => s.secant().max(0.0),
            };
            let u = if s.is_collapsed() { Vec3::zeros() } else { s.d / s.length };
            let block = u * u.transpose() * (s.slope() - transverse)
                + Mat3::from_diagonal_element(transverse);
            sink.add_pair(s.i, s.j, &(block * scale));
        });
    }

    fn add_damping(&self, lagged: Level<'_>, scale: f64, sink: &mut dyn BlockSink) {
        self.majorant.add_damping(lagged, scale, sink);
    }

    fn add_damping_turn(&self, at: Level<'_>, w: &[Vec3], out: &mut [Vec3]) {
        self.majorant.add_damping_turn(at, w, out);
    }

    fn has_damping_turn(&self) -> bool {
        self.majorant.has_damping_turn()
    }

    fn split(&self) -> Option<&dyn LinearSplit> {
        Some(self)
    }

    fn scale_stiffness(&mut self, factor: f64) -> bool {
        self.laws.iter_mut().for_each(|law| law.scale(factor));
        self.majorant.scale_stiffness(factor)
    }

    fn scale_damping(&mut self, factor: f64) -> bool {
        self.majorant.scale_damping(factor)
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

impl LinearSplit for PiecewiseSprings {
    fn visit_weights(&self, visit: &mut dyn FnMut(usize, usize, f64, f64)) {
        self.majorant.visit_weights(visit);
    }

    fn has_one_slope(&self) -> bool {
        false
    }

    fn law(&self, spring: usize) -> Option<&TensionLaw> {
        self.laws.get(*self.law_of.get(spring)? as usize)
    }

    fn visit_slopes(&self, x: &[Vec3], visit: &mut dyn FnMut(usize, usize, f64, f64)) {
        self.each(x, |s| visit(s.i, s.j, s.slope(), s.damping));
    }

    fn visit_rest_lengths(&self, visit: &mut dyn FnMut(usize, usize, f64)) {
        self.majorant.visit_rest_lengths(visit);
    }

    fn visit_secants(&self, x: &[Vec3], visit: &mut dyn FnMut(usize, usize, f64)) {
        self.each(x, |s| visit(s.i, s.j, s.secant()));
    }

    fn visit_tensions(&self, visit: &mut TensionVisitor<'_>) {
        let mut law_of = self.law_of.iter();
        self.majorant.each(|s| {
            let Some(&law) = law_of.next() else { return };
            let law = &self.laws[law as usize];
            let tension = |length| law.tension(s.rest_length, length);
            visit(s.i as usize, s.j as usize, s.stiffness, &tension);
        });
    }

    fn visit_discrete_gradients(
        &self,
        from: &[Vec3],
        to: &[Vec3],
        visit: &mut dyn FnMut(usize, usize, f64, f64),
    ) {
        self.each(from, |s| {
            let length = (to[s.i] - to[s.j]).norm();
            let sum = s.length + length;
            if sum <= COLLAPSED * s.rest {
                return visit(s.i, s.j, 0.5 * s.slope(), 0.0);
            }
            let (mean, slope) = s.law.mean_tension(s.rest, s.length, length);
            let g = mean / sum;
            visit(s.i, s.j, g, (slope - g) / sum);
        });
    }

    /// `F2_i = (K − T/L) d`.
    fn add_nonlinear_force(&self, x: &[Vec3], out: &mut [Vec3]) {
        self.add(true, x, out);
    }

    fn add_linear_force(&self, x: &[Vec3], out: &mut [Vec3]) {
        self.majorant.add_linear_force(x, out);
    }

    fn add_linear_damping(&self, v: &[Vec3], out: &mut [Vec3]) {
        self.majorant.add_linear_damping(v, out);
    }

    fn has_damping_remainder(&self) -> bool {
        self.majorant.has_damping_remainder()
    }

    fn add_damping_remainder(&self, x: &[Vec3], v: &[Vec3], out: &mut [Vec3]) {
        self.majorant.add_damping_remainder(x, v, out);
    }
}
