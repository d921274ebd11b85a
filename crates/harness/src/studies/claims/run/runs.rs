//! Runs that are looked at step by step, and the true motion that they are compared with.

use crate::HarnessError;
use crate::methods::{Choice, MethodError};
use crate::run::Simulation;
use crate::run::starts::starts_from;
use crate::stability::gershgorin;
use drape_integrator::{PhaseClock, SolveStatus, StepError, StepReport, TimeStep};
use drape_model::{State, System, SystemSpec};

/// A gain of energy by more than this share of what the scene sets free is an instability.
const STABLE: f64 = 0.02;
/// Step of the true motion over the stability limit.
const SHARE: f64 = 0.25;

/// Takes steps with a method: `before` may move the state ahead of each, `after` sees what it took
/// and where it led. A run that leaves the range of numbers ends there. Returns the last state.
pub(super) fn walk(
    start: &Simulation,
    method: &str,
    step_s: f64,
    steps: u64,
    mut before: impl FnMut(&System, &mut State),
    mut after: impl FnMut(&System, &StepReport, &State),
) -> Result<State, HarnessError> {
    starts_from(start);
    let Simulation { system, state } = start;
    let mut state = state.clone();
    let mut integrator = Choice::parse(method, &[])?.build().map_err(MethodError::from)?;
    let h = TimeStep::new(step_s)?;
    integrator.prepare(system, h)?;
    let mut clock = PhaseClock::off();
    for _ in 0..steps {
        before(system, &mut state);
        match integrator.step(system, &mut state, h, &mut clock) {
            Ok(report) => after(system, &report, &state),
            Err(StepError::Solver(_)) => break,
            Err(error) => return Err(error.into()),
        }
        if !state.is_finite() {
            break;
        }
    }
    Ok(state)
}

/// What a run took and did.
#[derive(Clone, Debug)]
pub(super) struct Track {
    /// CG iterations of all steps.
    pub(super) iterations: u64,
    /// Most CG iterations of a step.
    pub(super) most: u32,
    /// Steps.
    pub(super) steps: u64,
    /// Steps whose solve ended before its tolerance.
    pub(super) unconverged: u64,
    /// Length of the way of the tracked particle, m.
    pub(super) path: f64,
    /// Greatest rise of the energy above its start, J; infinite after a blow-up.
    pub(super) gain: f64,
    /// Last state.
    pub(super) state: State,
}

impl Track {
    /// CG iterations a step.
    pub(super) fn per_step(&self) -> f64 {
        self.iterations as f64 / self.steps as f64
    }

    /// By the energy, against what the scene sets free, J.
    pub(super) fn is_stable(&self, released: f64) -> bool {
        self.gain <= STABLE * released
    }
}

/// Runs a method for `duration_s` (a whole number of steps), following one particle.
pub(super) fn track(
    start: &Simulation,
    method: &str,
    step_s: f64,
    duration_s: f64,
    particle: usize,
) -> Result<Track, HarnessError> {
    let energy = |system: &System, state: &State| {
        system.kinetic_energy(&state.v) + system.potential_energy(&state.x)
    };
    let first = energy(&start.system, &start.state);
    let mut track = Track {
        iterations: 0,
        most: 0,
        steps: 0,
        unconverged: 0,
        path: 0.0,
        gain: 0.0,
        state: start.state.clone(),
    };
    let mut last = start.state.x[particle];
    let steps = (duration_s / step_s).round() as u64;
    let ignore = |_: &System, _: &mut State| ();
    track.state = walk(start, method, step_s, steps, ignore, |system, report, state| {
        track.iterations += u64::from(report.cg_iterations);
        track.most = track.most.max(report.cg_iterations);
        track.unconverged += u64::from(report.solve != SolveStatus::Converged);
        track.steps += 1;
        track.path += (state.x[particle] - last).norm();
        last = state.x[particle];
        let gain = energy(system, state) - first;
        track.gain = if gain.is_nan() { f64::INFINITY } else { track.gain.max(gain) };
    })?;
    if track.steps < steps {
        (track.gain, track.path) = (f64::INFINITY, f64::INFINITY);
    }
    Ok(track)
}

/// The true motion of a particle: symplectic Euler, the same bits everywhere, at a quarter of its
/// stability limit.
pub(super) fn true_motion(
    start: &Simulation,
    duration_s: f64,
    particle: usize,
) -> Result<Track, HarnessError> {
    let (stiffness, damping) = gershgorin(&start.system);
    // Stable for h²λ + 2hδ < 4.
    let limit = 4.0 / (damping + (damping * damping + 4.0 * stiffness).sqrt());
    let steps = (duration_s / (SHARE * limit).min(1e-3)).ceil();
    track(start, "symplectic-euler", duration_s / steps, duration_s, particle)
}

/// Where the true motion is after a while.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    /// By leapfrog, of order 2, at a tenth of its stability limit.
    pub(super) state: State,
    /// Distance of a run with twice the step over the motion: four times its error, about.
    pub(super) doubt: f64,
}

impl Exact {
    pub(super) fn new(start: &Simulation, duration_s: f64) -> Result<Self, HarnessError> {
        let (stiffness, _) = gershgorin(&start.system);
        let at = |share: f64| {
            let steps = (duration_s / (share * 2.0 / stiffness.sqrt()).min(1e-3)).ceil();
            track(start, "leapfrog:solver=cg", duration_s / steps, duration_s, 0)
        };
        let (state, coarse) = (at(0.1)?.state, at(0.2)?.state);
        let doubt = error(start, &coarse, &state);
        Ok(Self { state, doubt })
    }
}

/// Distance between the ends of two runs over the distance that the true motion has gone, both in
/// the norm of the masses.
pub(super) fn error(start: &Simulation, end: &State, exact: &State) -> f64 {
    let (mut off, mut way) = (0.0, 0.0);
    for (i, mass) in start.system.mass().iter().enumerate() {
        off += mass * (end.x[i] - exact.x[i]).norm_squared();
        way += mass * (exact.x[i] - start.state.x[i]).norm_squared();
    }
    let error = (off / way).sqrt();
    if error.is_nan() { f64::INFINITY } else { error }
}

/// The particle in the middle of the edge that lies opposite the pins: nearest to their mean,
/// mirrored at the origin.
pub(super) fn free_edge(spec: &SystemSpec) -> usize {
    let at = |particle: usize| nalgebra::Vector3::from(spec.particles.position_m[particle]);
    let sum = spec
        .pins
        .iter()
        .fold(nalgebra::Vector3::zeros(), |sum, pin| sum + at(pin.particle as usize));
    let target = -sum / (spec.pins.len() as f64).max(1.0);
    let distance = |particle: &usize| (at(*particle) - target).norm();
    let all = 0..spec.particles.position_m.len();
    all.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or_default()
}
