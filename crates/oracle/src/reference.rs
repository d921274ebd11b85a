//! The solution of the differential equation itself, with a stated error.
//!
//! An adaptive Runge–Kutta method of order 8 (DOP853 of Hairer, Nørsett and Wanner) integrates
//! `M x'' = f(x, v)` twice. The run with the looser tolerance gives the error of the run with the
//! tighter one. The reference shares only the forces with the integrators.
//!
//! Static pins are supported. Pins on paths are refused, because the motion has no eighth
//! derivative where a path bends, and the stated error would be wrong. Contacts are refused too:
//! their velocity constraints belong to the step of a method and have no differential equation.

use drape_model::{Level, State, System, Vec3};
use nalgebra::DVector;
use ode_solvers::dop_shared::IntegrationError;
use ode_solvers::{Dop853, OutputType};
use std::cell::RefCell;

/// Tolerance and step limit of a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceSettings {
    /// Tolerance of each step, both relative and absolute (in m and m/s).
    pub tolerance: f64,
    /// Largest number of steps in all.
    pub max_steps: u32,
}

impl Default for ReferenceSettings {
    fn default() -> Self {
        Self { tolerance: 1e-12, max_steps: 1_000_000 }
    }
}

/// States on the exact trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// One state at each requested time.
    pub states: Vec<State>,
    /// Largest distance between the positions of a particle in this run and in the run with ten
    /// times the tolerance, m. It is an upper estimate of the error of the positions.
    pub position_error: f64,
    /// Likewise for velocities, m/s.
    pub velocity_error: f64,
}

/// Why there is no reference.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The scene has obstacles.
    #[error("the scene has {0} obstacle(s); contacts have no reference trajectory: leave them out")]
    Contact(usize),
    /// Pins of the scene follow paths.
    #[error(
        "{0} pin(s) of the scene follow paths; such a motion has no reference trajectory: hold them"
    )]
    MovingPins(usize),
    /// The state does not fit the system.
    #[error("the state has {found} particles, the system {expected}")]
    SizeMismatch {
        /// Particles of the system.
        expected: usize,
        /// Particles of the state.
        found: usize,
    },
    /// The times do not increase from the start.
    #[error("time {next} s follows {last} s; expected finite and rising times after the start")]
    Times {
        /// A time, s.
        last: f64,
        /// The time after it, s.
        next: f64,
    },
    /// The tolerance is out of range.
    #[error("the tolerance is {0}; expected a number from 1e-15 to 0.1")]
    Tolerance(f64),
    /// The step limit was reached.
    #[error("{steps} steps reach only {time} s; allow more steps or ask for less time")]
    StepLimit {
        /// Number of steps taken.
        steps: u32,
        /// Time reached, s.
        time: f64,
    },
    /// No step is small enough, because the motion or a force is not finite.
    #[error("no step is small enough at {time} s; the motion or a force is not finite there")]
    NotFinite {
        /// Time reached, s.
        time: f64,
    },
}

/// `(x, v)' = (v, M⁻¹ f)`, with pinned particles at rest. It allocates its scratch once.
///
/// Where forces change with time, time is one more unknown, `t' = 1`. The library that takes the
/// steps evaluates their last stage at the time of their start (`c₁₂` is 0 instead of 1 in version
/// 0.6.2), so with its own times the method would be of order 1.
struct Motion<'a> {
    system: &'a System,
    has_clock: bool,
    scratch: RefCell<Scratch>,
}

/// Positions, velocities and forces of one evaluation, and the number of evaluations so far.
struct Scratch {
    x: Vec<Vec3>,
    v: Vec<Vec3>,
    force: Vec<Vec3>,
    evaluations: u64,
}

impl<'a> Motion<'a> {
    fn new(system: &'a System) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let scratch = Scratch { x: zeros(), v: zeros(), force: zeros(), evaluations: 0 };
        let has_clock = system.effects().any(|effect| effect.changes_with_time());
        Self { system, has_clock, scratch: RefCell::new(scratch) }
    }

    fn evaluations(&self) -> u64 {
        self.scratch.borrow().evaluations
    }

    fn pack(&self, state: &State) -> DVector<f64> {
        let vectors = state.x.iter().chain(&state.v).flat_map(|a| a.iter().copied());
        let numbers: Vec<f64> = vectors.chain(self.has_clock.then_some(state.t)).collect();
        DVector::from_vec(numbers)
    }
}

impl ode_solvers::System<f64, DVector<f64>> for &Motion<'_> {
    fn system(&self, t: f64, y: &DVector<f64>, dy: &mut DVector<f64>) {
        let Scratch { x, v, force, evaluations } = &mut *self.scratch.borrow_mut();
        *evaluations += 1;
        let (positions, rest) = y.as_slice().split_at(3 * x.len());
        let (velocities, clock) = rest.split_at(3 * v.len());
        let t = clock.first().copied().unwrap_or(t);
        for (to, from) in [(&mut *x, positions), (&mut *v, velocities)] {
            for (to, from) in to.iter_mut().zip(from.chunks_exact(3)) {
                to.copy_from_slice(from);
            }
        }
        self.system.forces(Level { t, x, v }, force);
        let (dx, rest) = dy.as_mut_slice().split_at_mut(3 * x.len());
        let (dv, clock) = rest.split_at_mut(3 * v.len());
        clock.fill(1.0);
        let rates = dx.chunks_exact_mut(3).zip(dv.chunks_exact_mut(3));
        let particles = self.system.mass().iter().zip(self.system.pinned());
        for (i, ((dx, dv), (mass, is_pinned))) in rates.zip(particles).enumerate() {
            let (velocity, acceleration) =
                if *is_pinned { (Vec3::zeros(), Vec3::zeros()) } else { (v[i], force[i] / *mass) };
            dx.copy_from_slice(velocity.as_slice());
            dv.copy_from_slice(acceleration.as_slice());
        }
    }
}

fn unpack(t: f64, y: &DVector<f64>) -> State {
    let vectors: Vec<Vec3> = y.as_slice().chunks_exact(3).map(Vec3::from_column_slice).collect();
    let (x, v) = vectors.split_at(vectors.len() / 2);
    State { t, x: x.to_vec(), v: v.to_vec() }
}

/// Steps after which a run drops the solver's record of intermediate states, which would grow
/// without limit.
const STEPS_A_LEG: u32 = 256;

/// One run through all times.
fn run(
    motion: &Motion<'_>,
    start: &State,
    times: &[f64],
    tolerance: f64,
    max_steps: u32,
) -> Result<(Vec<State>, u32), ReferenceError> {
    let (mut t, mut y) = (start.t, motion.pack(start));
    let mut steps = 0;
    let mut states = Vec::new();
    for &end in times {
        while t < end {
            let leg = STEPS_A_LEG.min(max_steps - steps);
            let no_stiffness_test = u32::MAX;
            let mut solver = Dop853::from_param(
                motion,
                t,
                end,
                end - t,
                y.clone(),
                tolerance,
                tolerance,
                0.9,
                0.0,
                0.333,
                6.0,
                end - t,
                0.0,
                leg,
                no_stiffness_test,
                OutputType::Sparse,
            );
            let outcome = solver.integrate();
            if let (Some(&last_t), Some(last_y)) = (solver.x_out().last(), solver.y_out().last()) {
                (t, y) = (last_t, last_y.clone());
            }
            match outcome {
                Ok(stats) => {
                    steps += stats.accepted_steps + stats.rejected_steps;
                    t = end;
                }
                Err(IntegrationError::MaxNumStepReached { .. }) => steps += leg,
                Err(_) => return Err(ReferenceError::NotFinite { time: t }),
            }
            if t < end && steps >= max_steps {
                return Err(ReferenceError::StepLimit { steps, time: t });
            }
            if y.iter().any(|a| !a.is_finite()) {
                return Err(ReferenceError::NotFinite { time: t });
            }
        }
        states.push(unpack(end, &y));
    }
    Ok((states, steps))
}

fn check(system: &System, start: &State, tolerance: f64) -> Result<(), ReferenceError> {
    if !system.obstacles().is_empty() {
        return Err(ReferenceError::Contact(system.obstacles().len()));
    }
    if !system.moving_pins().is_empty() {
        return Err(ReferenceError::MovingPins(system.moving_pins().len()));
    }
    if [start.x.len(), start.v.len()] != [system.len(); 2] {
        let found = start.v.len().min(start.x.len());
        return Err(ReferenceError::SizeMismatch { expected: system.len(), found });
    }
    if !(1e-15..=0.1).contains(&tolerance) {
        return Err(ReferenceError::Tolerance(tolerance));
    }
    Ok(())
}

fn with_pins_at_rest(system: &System, start: &State) -> State {
    let mut start = start.clone();
    system.clear_pinned(&mut start.v);
    start
}

/// One run of the adaptive method, as a user of a library would make it.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveRun {
    /// The last state.
    pub state: State,
    /// Number of steps taken, including rejected ones.
    pub steps: u32,
    /// Number of evaluations of all forces.
    pub evaluations: u64,
}

/// One run of DOP853 over `duration` seconds with the tolerance of `settings`. The error of the run
/// is not computed.
///
/// # Errors
/// As [`reference()`].
pub fn adaptive(
    system: &System,
    start: &State,
    duration: f64,
    settings: ReferenceSettings,
) -> Result<AdaptiveRun, ReferenceError> {
    let ReferenceSettings { tolerance, max_steps } = settings;
    check(system, start, tolerance)?;
    let start = with_pins_at_rest(system, start);
    let end = start.t + duration;
    if !(duration > 0.0 && end.is_finite()) {
        return Err(ReferenceError::Times { last: start.t, next: end });
    }
    let motion = Motion::new(system);
    let (mut states, steps) = run(&motion, &start, &[end], tolerance, max_steps)?;
    let state = states.pop().unwrap_or(start);
    Ok(AdaptiveRun { state, steps, evaluations: motion.evaluations() })
}

/// The exact motion of `system` from `start`, at increasing `times`, s.
///
/// # Errors
/// [`ReferenceError`] if the scene has contacts, if the start or the times do not fit, if there are
/// too many steps, or if the motion blows up.
pub fn reference(
    system: &System,
    start: &State,
    times: &[f64],
    settings: ReferenceSettings,
) -> Result<Reference, ReferenceError> {
    let ReferenceSettings { tolerance, max_steps } = settings;
    check(system, start, tolerance)?;
    let mut last = start.t;
    for &next in times {
        if next <= last || !next.is_finite() {
            return Err(ReferenceError::Times { last, next });
        }
        last = next;
    }
    let start = with_pins_at_rest(system, start);
    let motion = Motion::new(system);
    let (states, _) = run(&motion, &start, times, tolerance, max_steps)?;
    let (looser, _) = run(&motion, &start, times, 10.0 * tolerance, max_steps)?;
    let farthest = |pick: fn(&State) -> &[Vec3]| {
        let pairs = states.iter().zip(&looser);
        let distances = pairs.flat_map(|(a, b)| pick(a).iter().zip(pick(b)));
        distances.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    let (position_error, velocity_error) = (farthest(|s| &s.x), farthest(|s| &s.v));
    Ok(Reference { states, position_error, velocity_error })
}

#[cfg(test)]
mod tests;
