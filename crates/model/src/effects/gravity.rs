//! Uniform gravity.

use super::registry::{self, Checked, Weave};
use super::{Effect, EffectClass, EffectKind, Field, Part, Pass};
use crate::bounds::{MAX_COORDINATE, vector};
use crate::error::Violation;
use crate::{SystemSpec, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Uniform gravity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravitySpec {
    /// Acceleration, m/s².
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub m_s2: [f64; 3],
}

/// Energy `U = −Σ m_i g·x_i`, J, and forces `f_i = m_i g`, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gravity {
    /// Acceleration `g`, m/s².
    pub acceleration: Vec3,
}

impl Effect for Gravity {
    fn kind(&self) -> EffectKind {
        EffectKind::Gravity
    }

    fn energy(&self, mass: &[f64], x: &[Vec3]) -> f64 {
        -mass.iter().zip(x).map(|(&m, x)| m * self.acceleration.dot(x)).sum::<f64>()
    }

    fn add_force(&self, mass: &[f64], _x: &[Vec3], out: &mut [Vec3]) {
        for (f, &m) in out.iter_mut().zip(mass) {
            *f += self.acceleration * m;
        }
    }

    fn pass<'a>(&'a self, mass: &'a [f64], part: Part) -> Option<Pass<'a>> {
        let is_force = matches!(part, Part::All | Part::Force | Part::Nonlinear);
        is_force.then_some(Pass::Field(Field { acceleration: self.acceleration, mass }))
    }

    fn describe(&self, spec: &mut SystemSpec) -> bool {
        spec.effects.gravity = Some(GravitySpec { m_s2: self.acceleration.into() });
        true
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(*self)
    }
}

/// The effect of gravity.
pub(crate) struct Entry;

impl registry::Entry for Entry {
    type Value = GravitySpec;
    const CLASS: EffectClass = EffectClass::Uniform;

    fn freeze(
        law: &GravitySpec,
        _kind: EffectKind,
        _cloth: Weave<'_>,
        spec: &mut SystemSpec,
    ) -> Result<(), Violation> {
        spec.effects.gravity = Some(*law);
        Ok(())
    }

    fn check(_kind: EffectKind, spec: &SystemSpec) -> Result<Option<Box<dyn Checked>>, Violation> {
        let Some(gravity) = spec.effects.gravity else { return Ok(None) };
        let acceleration = vector("effects.gravity.m_s2", gravity.m_s2)?;
        Ok(Some(Box::new(Gravity { acceleration })))
    }
}

impl Checked for Gravity {
    fn visit_particles(&mut self, _visit: &mut dyn FnMut(&mut u32)) {}

    fn assemble(self: Box<Self>) -> Box<dyn Effect> {
        self
    }
}
