//! Effects that sum an energy over many small elements. Angles and hinges share this code.

use super::registry::Checked;
use super::{BlockSink, Effect, EffectKind, Tangent};
use crate::bounds::{coefficient, index, within};
use crate::error::Violation;
use crate::{SystemSpec, Vec3};
use std::fmt::Debug;

/// An energy `½ K (θ − θ₀)²` of a few particles, as a frozen system lists it.
pub(crate) trait Element: Copy + Debug + Send + Sync + 'static {
    /// Name of the list in a frozen system.
    const LIST: &'static str;
    /// Least and greatest angle at rest, rad.
    const REST: (f64, f64);

    /// The list in a frozen system.
    fn list(spec: &SystemSpec) -> &[Self];
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
    /// Visits all pairs of its particles.
    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize));
    /// Adds `scale · (−∂f/∂x)`, N/m.
    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink);
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

    fn scale_stiffness(&mut self, factor: f64) -> bool {
        self.list.iter_mut().for_each(|element| *element.stiffness() *= factor);
        true
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
