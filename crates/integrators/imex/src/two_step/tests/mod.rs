//! What the two-step methods must do, from their coefficients to small scenes.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

mod coefficients;
mod contact;
mod contract;
mod laws;
mod order;
mod recurrence;

use super::*;
use drape_integrator::{Integrator, PhaseClock, StepReport, TimeStep};
use drape_model::{DampingLaw, PinSpec, SpringEffect, SpringSpec, State, System, SystemSpec, Vec3};
use drape_oracle::scenes::{self, GRAVITY, gravity, particles};

const SCHEMES: [Scheme; 4] = [Scheme::Sbdf2, Scheme::Cnab2, Scheme::Mcnab2, Scheme::Cnlf];
/// Those with coefficients for a varying step.
const VARIABLE: [Scheme; 3] = [Scheme::Sbdf2, Scheme::Cnab2, Scheme::Mcnab2];
/// A power of two, so that `θ = h²k/m` and `η = hc/m` are met exactly.
const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;

/// `k` and `c` of one anchored spring with the given `θ` and `η`.
fn coefficients_of(theta: f64, eta: f64) -> (f64, f64) {
    (theta * MASS / (H * H), eta * MASS / H)
}

fn seconds(h: f64) -> TimeStep {
    TimeStep::new(h).unwrap()
}

fn method(scheme: Scheme, text: &str) -> ImexTwoStep {
    let pairs = text.split(',').filter_map(|pair| pair.split_once('='));
    ImexTwoStep::new(ImexTwoStepSettings::from_pairs(scheme, pairs).unwrap())
}

/// A prepared method with its system and state.
struct Run {
    method: ImexTwoStep,
    system: System,
    state: State,
    h: TimeStep,
}

impl Run {
    fn new(scheme: Scheme, text: &str, (system, state): (System, State), h: f64) -> Self {
        let (mut method, h) = (method(scheme, text), seconds(h));
        method.prepare(&system, h).unwrap();
        Self { method, system, state, h }
    }

    fn step(&mut self) -> StepReport {
        let mut clock = PhaseClock::off();
        self.method.step(&self.system, &mut self.state, self.h, &mut clock).unwrap()
    }

    fn steps(&mut self, count: usize) {
        for _ in 0..count {
            self.step();
        }
    }
}

fn spring(
    effect: SpringEffect,
    ends: (usize, usize),
    rest_length: f64,
    (stiffness, damping): (f64, f64),
) -> SpringSpec {
    scenes::spring(effect, ends, rest_length, stiffness, damping)
}

fn pin(particle: u32) -> PinSpec {
    scenes::pin(particle as usize)
}

/// A square sheet in the plane z = 0 with unequal masses, pinned at two corners, with tension along the
/// edges and shear across; stiffness and damping over mass in 1/s² and 1/s.
fn sheet(side: usize, stiffness: f64, damping: f64, law: DampingLaw) -> SystemSpec {
    let width = 1.0 / (side - 1) as f64;
    let at = |k: usize| Vec3::new((k % side) as f64 * width, (k / side) as f64 * width, 0.0);
    let positions: Vec<Vec3> = (0..side * side).map(at).collect();
    let mass: Vec<f64> = (0..side * side).map(|k| MASS * (1.0 + 0.1 * (k % 3) as f64)).collect();
    let mut spec = particles(&mass, &positions, &vec![Vec3::zeros(); mass.len()]);
    let mut join = |effect, i: usize, j: usize, share: f64| {
        let rest = (positions[i] - positions[j]).norm();
        let law = (share * stiffness * MASS, share * damping * MASS);
        spec.springs.push(spring(effect, (i, j), rest, law));
    };
    for k in 0..side * side {
        let (right, up) = (k % side + 1 < side, k / side + 1 < side);
        if right {
            join(SpringEffect::Tension, k, k + 1, 1.0);
        }
        if up {
            join(SpringEffect::Tension, k, k + side, 1.0);
        }
        if right && up {
            join(SpringEffect::Shear, k, k + side + 1, 0.25);
            join(SpringEffect::Shear, k + 1, k + side, 0.25);
        }
    }
    spec.damping = law;
    spec.pins = vec![pin(0), pin(side as u32 - 1)];
    spec.effects.gravity = gravity();
    spec
}

/// Puts a sheet into motion: out of the plane, where springs across have no force.
fn stir(spec: &SystemSpec) -> (System, State) {
    let (system, mut state) = spec.build().unwrap();
    for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
        let phase = i as f64;
        state.x[i].z += 0.02 * phase.sin();
        state.v[i] = Vec3::new(phase.sin(), (2.0 * phase).cos(), (3.0 * phase).sin());
    }
    (system, state)
}

fn bits(state: &State) -> Vec<u64> {
    let numbers = state.x.iter().chain(&state.v).flat_map(|a| a.iter().copied());
    numbers.map(f64::to_bits).collect()
}
