//! Systems for the tests.

use drape_integrator::{Integrator, PhaseClock, StepReport, TimeStep};
use drape_model::{
    DampingLaw, ObstacleSpec, PinSpec, SpringEffect, SpringSpec, State, System, SystemSpec, Vec3,
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

/// A square net of unequal masses that hangs from two corners if `pinned`, with diagonals, out of its plane and in
/// motion; `k/m` about 400 to 800.
pub(crate) fn net(side: u32, damping: f64, law: DampingLaw, pinned: bool) -> SystemSpec {
    let width = 1.0 / f64::from(side - 1);
    let all = || (0..side * side).map(f64::from);
    let x: Vec<_> = all()
        .map(|i| {
            let (row, column) = ((i / f64::from(side)).floor(), i % f64::from(side));
            Vec3::new(column * width, row * width, 0.05 * (2.3 * i).sin())
        })
        .collect();
    let v: Vec<_> =
        all().map(|i| Vec3::new((1.1 * i).sin(), (2.7 * i).cos(), (0.7 * i).sin())).collect();
    let mass: Vec<_> = all().map(|i| 0.5 + 0.25 * i.sin()).collect();
    let mut spec = particles(&mass, &x, &v);
    spec.damping = law;
    for i in 0..side * side {
        let (right, below) = (i % side + 1 < side, i + side < side * side);
        let mut join = |j, length: f64, share: f64| {
            spec.springs.push(spring((i, j), width * length, 200.0 * share, damping * share));
        };
        if right {
            join(i + 1, 1.0, 1.0);
        }
        if below {
            join(i + side, 1.0, 1.0);
        }
        if right && below {
            join(i + side + 1, 2.0_f64.sqrt(), 0.3);
        }
    }
    if pinned {
        spec.pins = vec![pin(0), pin(side - 1)];
        for corner in [0, side - 1] {
            spec.particles.velocity_m_s[corner as usize] = [0.0; 3];
        }
    }
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
