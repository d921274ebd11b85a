//! Systems and runs for the unit tests.

use crate::{BaraffWitkin, BaraffWitkinSettings};
use drape_integrator::{Integrator, PhaseClock, StepError, StepReport, TimeStep};
use drape_model::{DampingLaw, GravitySpec, SpringEffect, State, System, SystemSpec, Vec3, parse};
pub(crate) use drape_oracle::scenes::{particles, pin, spring};

pub(crate) const H: f64 = 0.01;

/// Settings from `key=value,…`.
pub(crate) fn settings(text: &str) -> BaraffWitkinSettings {
    let pairs = text.split(',').filter_map(|pair| pair.split_once('='));
    BaraffWitkinSettings::from_pairs(pairs).unwrap_or_else(|error| panic!("{error}"))
}

/// A prepared integrator with its system and state.
pub(crate) struct Run {
    pub(crate) integrator: BaraffWitkin,
    pub(crate) system: System,
    pub(crate) state: State,
    pub(crate) h: f64,
}

impl Run {
    pub(crate) fn new(text: &str, (system, state): (System, State), h: f64) -> Self {
        let mut integrator = BaraffWitkin::new(settings(text));
        integrator.prepare(&system, step_size(h)).unwrap_or_else(|error| panic!("{error}"));
        Self { integrator, system, state, h }
    }

    pub(crate) fn try_step(&mut self) -> Result<StepReport, StepError> {
        let Self { integrator, system, state, h } = self;
        integrator.step(system, state, step_size(*h), &mut PhaseClock::off())
    }

    pub(crate) fn step(&mut self) -> StepReport {
        self.try_step().unwrap_or_else(|error| panic!("{error}"))
    }
}

fn step_size(h: f64) -> TimeStep {
    TimeStep::new(h).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn gravity(z: f64) -> Option<GravitySpec> {
    Some(GravitySpec { m_s2: [0.0, 0.0, z] })
}

pub(crate) fn build(spec: &SystemSpec) -> (System, State) {
    spec.build().unwrap_or_else(|violation| panic!("{violation}"))
}

/// Builds a spec above (or in) the floor `z = 0`.
pub(crate) fn build_on_floor(spec: &SystemSpec, restitution: f64) -> (System, State) {
    let text = format!(
        r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": [1], "position_m": [[0, 0, 0]] }},
        "obstacles": [{{ "plane": {{ "point_m": [0, 0, 0], "normal": [0, 0, 1], "restitution": {restitution} }} }}] }}"#
    );
    let floor = parse("floor", &text).unwrap_or_else(|error| panic!("{error}"));
    build(&SystemSpec { obstacles: floor.spec().obstacles.clone(), ..spec.clone() })
}

/// A sheet of `side × side` particles of unequal masses, displaced at random by `disorder` mesh widths and in
/// random motion, with tension, shear and bending springs; two corners are pinned.
pub(crate) fn rough_sheet(
    side: usize,
    stiffness: f64,
    disorder: f64,
    law: DampingLaw,
) -> SystemSpec {
    let mut random = drape_oracle::Random::new(5);
    let width = 1.0 / (side - 1) as f64;
    let (mut mass, mut x, mut v) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..side * side {
        mass.push(random.between(0.5e-3, 1.5e-3));
        let (row, column) = ((i / side) as f64, (i % side) as f64);
        x.push(Vec3::new(column, row, 0.0) * width + random.vector() * (disorder * width));
        v.push(random.vector());
    }
    let mut spec = particles(&mass, &x, &v);
    spec.damping = law;
    let diagonal = width * 2.0_f64.sqrt();
    let steps = [
        (SpringEffect::Tension, 0, 1, width, 1.0),
        (SpringEffect::Tension, 1, 0, width, 1.0),
        (SpringEffect::Shear, 1, 1, diagonal, 0.3),
        (SpringEffect::Bending, 0, 2, 2.0 * width, 0.1),
        (SpringEffect::Bending, 2, 0, 2.0 * width, 0.1),
    ];
    for (effect, down, right, rest, part) in steps {
        for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
            if row + down < side && column + right < side {
                let ends = (row * side + column, (row + down) * side + column + right);
                let k = 1e-3 * stiffness * part;
                spec.springs.push(spring(effect, ends, rest, k, 5e-3 * part));
            }
        }
    }
    spec.pins = vec![pin(0), pin(side - 1)];
    spec.effects.gravity = gravity(-9.81);
    spec
}
