//! The methods at work.

mod contact;
mod laws;
mod order;
mod past;
mod recurrence;

use crate::{AdamsBashforth, AdamsBashforthSettings, Bdf, BdfSettings, Steps};
use drape_integrator::{Integrator, PhaseClock, StageSettings, StepReport, TimeStep};
use drape_model::{DampingLaw, PinSpec, SpringEffect, SpringSpec, State, System, SystemSpec, Vec3};
use drape_oracle::scenes::{self, gravity, particles};

const STEPS: [Steps; 3] = [Steps::One, Steps::Two, Steps::Three];

fn adams(steps: Steps) -> Box<dyn Integrator> {
    Box::new(AdamsBashforth::new(AdamsBashforthSettings { steps }))
}

fn bdf_to(residual: f64) -> impl Fn(Steps) -> Box<dyn Integrator> {
    move |steps| {
        let stage = StageSettings { residual, ..StageSettings::default() };
        Box::new(Bdf::new(BdfSettings { steps, stage, tolerance: 0.0 }))
    }
}

fn bdf(steps: Steps) -> Box<dyn Integrator> {
    bdf_to(1e-16)(steps)
}

type Family = fn(Steps) -> Box<dyn Integrator>;

/// Both families with each number of steps.
fn all() -> impl Iterator<Item = (Family, Steps)> {
    let families: [Family; 2] = [adams, bdf];
    families.into_iter().flat_map(|family| STEPS.map(|steps| (family, steps)))
}

fn seconds(h: f64) -> TimeStep {
    TimeStep::new(h).expect("positive and finite")
}

/// An integrator prepared for a system.
#[derive(Debug)]
struct Run {
    integrator: Box<dyn Integrator>,
    system: System,
    state: State,
    h: TimeStep,
}

impl Run {
    fn new(mut integrator: Box<dyn Integrator>, (system, state): (System, State), h: f64) -> Self {
        let h = seconds(h);
        integrator.prepare(&system, h).expect("supported");
        Self { integrator, system, state, h }
    }

    fn step(&mut self) -> StepReport {
        let Self { integrator, system, state, h } = self;
        integrator.step(system, state, *h, &mut PhaseClock::off()).expect("a step")
    }

    fn step_by(&mut self, h: f64) -> StepReport {
        self.h = seconds(h);
        self.step()
    }
}

fn spring((i, j): (u32, u32), rest_length: f64, stiffness: f64, damping: f64) -> SpringSpec {
    let ends = (i as usize, j as usize);
    scenes::spring(SpringEffect::Tension, ends, rest_length, stiffness, damping)
}

fn pin(particle: u32) -> PinSpec {
    scenes::pin(particle as usize)
}

fn build(spec: &SystemSpec) -> (System, State) {
    spec.build().expect("valid")
}

/// Four particles of unequal mass on six springs in space, the first one pinned, under gravity.
fn tetrahedron(law: DampingLaw) -> SystemSpec {
    let position = [
        Vec3::zeros(),
        Vec3::new(0.6, 0.1, -0.1),
        Vec3::new(0.2, 0.5, 0.0),
        Vec3::new(0.3, 0.2, -0.6),
    ];
    let velocity =
        [Vec3::zeros(), Vec3::new(0.2, -0.8, 0.3), Vec3::new(-0.5, 0.1, 0.9), Vec3::x() * 0.7];
    let mut spec = particles(&[1.0, 0.7, 1.1, 0.5], &position, &velocity);
    spec.damping = law;
    spec.pins = vec![pin(0)];
    spec.effects.gravity = gravity();
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    spec.springs = pairs.map(|pair| spring(pair, 0.55, 60.0, 0.6)).to_vec();
    spec
}

fn bits(state: &State) -> Vec<u64> {
    let vectors = state.x.iter().chain(&state.v);
    vectors.flat_map(|a| a.iter()).chain([&state.t]).map(|a| a.to_bits()).collect()
}
