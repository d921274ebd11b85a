//! Systems for the tests.

use drape_integrator::{Integrator, PhaseClock, StepReport, TimeStep};
use drape_model::{
    ObstacleSpec, PinSpec, SpringEffect, SpringSpec, State, System, SystemSpec, Vec3,
};
use drape_oracle::scenes;
pub(crate) use drape_oracle::scenes::{GRAVITY, gravity, particles};

pub(crate) fn spring((i, j): (u32, u32), rest: f64, stiffness: f64, damping: f64) -> SpringSpec {
    let ends = (i as usize, j as usize);
    scenes::spring(SpringEffect::Tension, ends, rest, stiffness, damping)
}

pub(crate) fn pin(particle: u32) -> PinSpec {
    scenes::pin(particle as usize)
}

pub(crate) fn floor(restitution: f64) -> ObstacleSpec {
    ObstacleSpec::plane([0.0; 3], [0.0, 0.0, 1.0], restitution)
}

/// A horizontal square sheet of 1 m that hangs from two corners: springs of the given `k/m` along warp and weft, a tenth
/// of it along the diagonals, 10 g a particle, no damping.
pub(crate) fn sheet(side: u32, stiffness_over_mass: f64) -> SystemSpec {
    let width = 1.0 / f64::from(side - 1);
    let at = |i: u32| Vec3::new(f64::from(i % side), f64::from(i / side), 0.0) * width;
    let x: Vec<_> = (0..side * side).map(at).collect();
    let count = x.len();
    let mut spec = particles(&vec![0.01; count], &x, &vec![Vec3::zeros(); count]);
    let stiffness = 0.01 * stiffness_over_mass;
    for i in 0..side * side {
        let (left, right, below) = (i % side > 0, i % side + 1 < side, i + side < side * side);
        let mut join = |joins: bool, j: u32, effect, length: f64, stiffness: f64| {
            if joins {
                let rest = width * length;
                spec.springs.push(SpringSpec { effect, ..spring((i, j), rest, stiffness, 0.0) });
            }
        };
        join(right, i + 1, SpringEffect::Tension, 1.0, stiffness);
        join(below, i + side, SpringEffect::Tension, 1.0, stiffness);
        join(right && below, i + side + 1, SpringEffect::Shear, 2.0_f64.sqrt(), 0.1 * stiffness);
        join(left && below, i + side - 1, SpringEffect::Shear, 2.0_f64.sqrt(), 0.1 * stiffness);
    }
    spec.pins = vec![pin(0), pin(side - 1)];
    spec.effects.gravity = gravity();
    spec
}

/// An integrator on its system.
pub(crate) struct Run<I> {
    pub(crate) integrator: I,
    pub(crate) system: System,
    pub(crate) state: State,
    pub(crate) h: f64,
}

impl<I: Integrator> Run<I> {
    pub(crate) fn new(integrator: I, spec: &SystemSpec, h: f64) -> Self {
        let (system, state) = spec.build().expect("valid");
        Self::of(integrator, system, state, h)
    }

    pub(crate) fn of(mut integrator: I, system: System, state: State, h: f64) -> Self {
        integrator.prepare(&system, TimeStep::new(h).expect("positive")).expect("supported");
        Self { integrator, system, state, h }
    }

    pub(crate) fn step(&mut self) -> StepReport {
        let h = TimeStep::new(self.h).expect("positive");
        let Self { integrator, system, state, .. } = self;
        integrator.step(system, state, h, &mut PhaseClock::off()).expect("a step")
    }

    pub(crate) fn steps(&mut self, count: usize) -> StepReport {
        (0..count).fold(StepReport::default(), |_, _| self.step())
    }
}
