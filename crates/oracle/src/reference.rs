//! The solution of the differential equation itself, with a stated error.
//!
//! An adaptive Runge–Kutta method of order 8 ([`Pair::Dop853`]) integrates `M x'' = f(x, v)` twice.
//! The run with the looser tolerance gives the error of the run with the tighter one. The reference
//! shares only the forces with the integrators.
//!
//! Static pins are supported. Pins on paths are refused, because the motion has no eighth
//! derivative where a path bends, and the stated error would be wrong. Contacts are refused too:
//! their velocity constraints belong to the step of a method and have no differential equation.

use crate::adaptive::{Pair, Stepper};
use drape_model::{State, System, Vec3};

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

/// Refuses what has no reference.
pub(crate) fn check(system: &System, start: &State, tolerance: f64) -> Result<(), ReferenceError> {
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

/// One run through all times.
fn run(
    system: &System,
    start: &State,
    times: &[f64],
    settings: ReferenceSettings,
) -> Result<Vec<State>, ReferenceError> {
    let mut run = Stepper::new(Pair::Dop853, system, start, settings);
    let states = times.iter().map(|&end| run.advance(end).map(|()| run.state()));
    states.collect()
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
    check(system, start, settings.tolerance)?;
    let mut last = start.t;
    for &next in times {
        if next <= last || !next.is_finite() {
            return Err(ReferenceError::Times { last, next });
        }
        last = next;
    }
    let states = run(system, start, times, settings)?;
    let looser = ReferenceSettings { tolerance: 10.0 * settings.tolerance, ..settings };
    let looser = run(system, start, times, looser)?;
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
