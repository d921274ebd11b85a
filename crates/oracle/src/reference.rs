//! The solution of the differential equation itself, with a stated error.
//!
//! An adaptive Runge–Kutta method of order 8 ([`Pair::Dop853`]) integrates `M x'' = f(x, v)` twice.
//! The run with the looser tolerance gives the error of the run with the tighter one. The reference
//! shares only the forces with the integrators.
//!
//! Static pins are supported. Pins on paths are refused, because the motion has no eighth
//! derivative where a path bends, and the stated error would be wrong. Contacts are refused too:
//! their velocity constraints belong to the step of a method and have no differential equation.

use crate::adaptive::{AdaptiveError, AdaptiveSettings, Pair, Stepper, check};
use drape_model::{State, System, Vec3};

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

/// One run through all times.
fn run(
    system: &System,
    start: &State,
    times: &[f64],
    settings: AdaptiveSettings,
) -> Result<Vec<State>, AdaptiveError> {
    let mut run = Stepper::new(Pair::Dop853, system, start, settings);
    let states = times.iter().map(|&end| run.advance(end).map(|()| run.state()));
    states.collect()
}

/// The exact motion of `system` from `start`, at increasing `times`, s.
///
/// # Errors
/// [`AdaptiveError`] if the scene has contacts, if the start or the times do not fit, if there are
/// too many steps, or if the motion blows up.
pub fn reference(
    system: &System,
    start: &State,
    times: &[f64],
    settings: AdaptiveSettings,
) -> Result<Reference, AdaptiveError> {
    check(system, start, settings.tolerance)?;
    let mut last = start.t;
    for &next in times {
        if next <= last || !next.is_finite() {
            return Err(AdaptiveError::Times { last, next });
        }
        last = next;
    }
    let states = run(system, start, times, settings)?;
    let looser = AdaptiveSettings { tolerance: 10.0 * settings.tolerance, ..settings };
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
