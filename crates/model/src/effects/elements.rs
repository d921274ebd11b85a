//! Effects that sum an energy over many small elements. Angles and hinges share this code.

use super::registry::Checked;
use super::{BlockSink, Effect, EffectKind, Tangent};
use crate::bounds::{coefficient, index, within};
use crate::error::Violation;
use crate::{Mat3, SystemSpec, Vec3};
use std::fmt::Debug;

/// Most particles of an element.
const MOST: usize = 4;

/// An energy `½ K (θ − θ₀)²` of a few particles, as a frozen system lists it.
pub(crate) trait Element: Copy + Debug + Send + Sync + 'static {
    /// Name of the list in a frozen system.
    const LIST: &'static str;
    /// Least and greatest angle at rest, rad.
    const REST: (f64, f64);

    /// The list in a frozen system.
    fn list(spec: &SystemSpec) -> &[Self];
    /// The same list, to be extended.
    fn list_mut(spec: &mut SystemSpec) -> &mut Vec<Self>;
    fn kind(&self) -> EffectKind;
    /// Its particles, each with its key.
    fn particles(&mut self) -> impl Iterator<Item = (&'static str, &mut u32)>;
    /// `θ₀`, rad.
    fn rest(&self) -> f64;
    /// `K`, N m.
    fn stiffness(&mut self) -> &mut f64;
    /// The energy at `x`, J; `None` where the angle is not defined.
    fn energy(&self, x: &[Vec3]) -> Option<f64>;
    /// Adds the force at `x`, N.
    fn add_force(&self, x: &[Vec3], out: &mut [Vec3]);
    /// Its angle with its particles at `x`, in the order of [`particles`](Self::particles); `None`
    /// where the angle has no gradient.
    fn turn(&self, x: &[Vec3; 4]) -> Option<Turn>;
    /// Visits all pairs of its particles.
    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize));
    /// Adds `scale · (−∂f/∂x)`, N/m.
    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink);
}

/// An angle of three or four particles, against its angle at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// `θ − θ₀`, rad.
    pub excess: f64,
    /// `∇θ` for each of the particles, 1/m; 0 beyond the last.
    pub gradient: [Vec3; 4],
    /// Stiffness `K`, N m.
    pub stiffness: f64,
}

/// The angles of an effect one by one: for methods that take each as a constraint of its own, or
/// move one particle at a time.
pub trait Stencils {
    /// Calls `visit` with the three or four particles of each angle.
    fn visit(&self, visit: &mut dyn FnMut(&[u32]));

    /// An angle, by its place in that order, with its particles at `x`, m; a fourth place beside
    /// three particles is ignored. `None` where the angle has no gradient.
    fn turn(&self, place: usize, x: &[Vec3; 4]) -> Option<Turn>;

    /// Force of an angle, by its place in that order, on one of its particles at `x`, N, and the
    /// particle's block `−∂f/∂x` on the diagonal, N/m, [projected](Tangent::Projected).
    fn local(&self, place: usize, particle: usize, x: &[Vec3]) -> (Vec3, Mat3);
}

/// All elements of one kind.
#[derive(Clone, Debug)]
pub struct Elements<E> {
    kind: EffectKind,
    list: Vec<E>,
}

impl<E> Elements<E> {
    /// Elements of one kind. Their values must be in range.
    pub fn new(kind: EffectKind, list: Vec<E>) -> Self {
        Self { kind, list }
    }
}

/// Checks the elements of one kind in a frozen system.
pub(super) fn check<E: Element>(
    kind: EffectKind,
    spec: &SystemSpec,
) -> Result<Option<Box<dyn Checked>>, Violation> {
    let mut list: Vec<E> = Vec::new();
    for (position, element) in E::list(spec).iter().enumerate() {
        if element.kind() != kind {
            continue;
        }
        let mut element = *element;
        let path = format!("{}[{position}]", E::LIST);
        let mut before: Vec<(&str, u32)> = Vec::new();
        for (key, particle) in element.particles() {
            index(format_args!("{path}.{key}"), *particle, spec.particles.mass_kg.len())?;
            if let Some((other, _)) = before.iter().find(|(_, other)| other == particle) {
                let expected = format!("another particle than `{other}`, which is {particle}");
                return Err(Violation::new(format!("{path}.{key}"), particle, expected));
            }
            before.push((key, *particle));
        }
        within(format_args!("{path}.rest_rad"), element.rest(), E::REST.0, E::REST.1)?;
        coefficient(format_args!("{path}.stiffness_n_m"), *element.stiffness())?;
        list.push(element);
    }
    Ok((!list.is_empty()).then(|| Box::new(Elements { kind, list }) as Box<dyn Checked>))
}

impl<E: Element> Checked for Elements<E> {
    fn visit_particles(&mut self, visit: &mut dyn FnMut(&mut u32)) {
        for element in &mut self.list {
            element.particles().for_each(|(_, particle)| visit(particle));
        }
    }

    fn assemble(self: Box<Self>) -> Box<dyn Effect> {
        self
    }
}

impl<E: Element> Effect for Elements<E> {
    fn kind(&self) -> EffectKind {
        self.kind
    }

    fn energy(&self, _mass: &[f64], x: &[Vec3]) -> f64 {
        self.list.iter().filter_map(|element| element.energy(x)).sum()
    }

    fn add_force(&self, _mass: &[f64], x: &[Vec3], out: &mut [Vec3]) {
        self.list.iter().for_each(|element| element.add_force(x, out));
    }

    fn has_jacobian(&self) -> bool {
        true
    }

    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize)) {
        self.list.iter().for_each(|element| element.visit_pairs(visit));
    }

    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink) {
        self.list.iter().for_each(|element| element.add_stiffness(x, scale, tangent, sink));
    }

    fn stencils(&self) -> Option<&dyn Stencils> {
        Some(self)
    }

    fn scale_stiffness(&mut self, factor: f64) -> bool {
        self.list.iter_mut().for_each(|element| *element.stiffness() *= factor);
        true
    }

    fn describe(&self, spec: &mut SystemSpec) -> bool {
        E::list_mut(spec).extend_from_slice(&self.list);
        true
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

impl<E: Element> Stencils for Elements<E> {
    fn visit(&self, visit: &mut dyn FnMut(&[u32])) {
        for element in &self.list {
            let (mut element, mut particles, mut count) = (*element, [0; MOST], 0);
            for (slot, (_, particle)) in particles.iter_mut().zip(element.particles()) {
                *slot = *particle;
                count += 1;
            }
            visit(&particles[..count]);
        }
    }

    /// Evaluates the whole element on copies of its particles, and keeps the part of one of them.
    fn local(&self, stencil: usize, place: usize, x: &[Vec3]) -> (Vec3, Mat3) {
        let mut element = self.list[stencil];
        let (mut near, mut force) = ([Vec3::zeros(); MOST], [Vec3::zeros(); MOST]);
        for ((slot, own), (_, particle)) in near.iter_mut().zip(0..).zip(element.particles()) {
            *slot = x[*particle as usize];
            *particle = own;
        }
        element.add_force(&near, &mut force);
        let mut sink = OneBlock { place, block: Mat3::zeros() };
        element.add_stiffness(&near, 1.0, Tangent::Projected, &mut sink);
        (force[place], sink.block)
    }

    fn turn(&self, place: usize, x: &[Vec3; 4]) -> Option<Turn> {
        self.list.get(place)?.turn(x)
    }
}

/// Keeps one block of the diagonal.
struct OneBlock {
    place: usize,
    block: Mat3,
}

impl BlockSink for OneBlock {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_general_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_diagonal(i, block);
        self.add_diagonal(j, &block.transpose());
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        if i == self.place {
            self.block += block;
        }
    }
}
