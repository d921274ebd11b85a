//! Scenes, matrices and runs that several claims share.

use crate::HarnessError;
use crate::methods::Choice;
use crate::run::starts::starts_from;
use crate::run::{Counts, Runner, Simulation};
use crate::studies::sheet::{GRAVITY, Sheet};
use drape_integrator::Implicit;
use drape_model::{DampingLaw, State, System, SystemSpec, TimeSpan, Vec3};
use drape_oracle::Random;
use drape_solvers::ScalarMatrix;

/// A sheet that hangs by two corners, at first horizontal: `side × side` particles of 1 g, tension
/// springs of the stiffness over mass `tension` (1/s²), no shear, damping over mass `damping`
/// (1/s).
pub(super) fn hanging(side: u32, tension: f64, damping: f64) -> Sheet {
    Sheet {
        side,
        tension,
        shear: 0.0,
        damping,
        law: DampingLaw::Full,
        gravity: GRAVITY,
        is_pinned: true,
    }
}

/// A free sheet without damping and gravity that turns over and over about the x axis, `rate` in
/// 1/s.
pub(super) fn spinning(side: u32, tension: f64, rate: f64) -> Result<Simulation, HarnessError> {
    let sheet = Sheet { shear: 0.1 * tension, gravity: [0.0; 3], ..hanging(side, tension, 0.0) };
    let mut start = build(&Sheet { is_pinned: false, ..sheet }.spec()?)?;
    for (v, x) in start.state.v.iter_mut().zip(&start.state.x) {
        *v = (Vec3::x() * rate).cross(x);
    }
    Ok(start)
}

/// Builds a system.
pub(super) fn build(spec: &SystemSpec) -> Result<Simulation, HarnessError> {
    let (system, state) = spec.build()?;
    let simulation = Simulation { system, state };
    // Some claims are about the matrix of a system that nobody runs.
    starts_from(&simulation);
    Ok(simulation)
}

/// Moves every particle that is not pinned by up to `distance` m along each axis, at random.
pub(super) fn shake(start: &mut Simulation, distance: f64, seed: u64) {
    let mut random = Random::new(seed);
    for (x, is_pinned) in start.state.x.iter_mut().zip(start.system.pinned()) {
        let way = random.vector() * distance;
        if !is_pinned {
            *x += way;
        }
    }
}

/// Runs a method (id and settings) from a start, watching the energy, until the time is over or the
/// effort (visits of a spring) reaches its limit.
pub(super) fn run(
    start: &Simulation,
    method: &str,
    step_s: f64,
    duration_s: f64,
    effort_limit: Option<f64>,
) -> Result<Counts, HarnessError> {
    let choice = Choice::parse(method, &[])?;
    Runner::new(&choice, TimeSpan { step_s, duration_s }).budget(effort_limit).count(start)
}

/// The matrix of EEH (21) multiplied by the masses, `M + h² L_k + h L_c` over all springs.
pub(super) fn matrix(system: &System, h: f64) -> ScalarMatrix {
    let mut edges = Vec::new();
    Implicit::Springs.visit_weights(system, &mut |i, j, k, c| edges.push((i, j, k, c)));
    let mut matrix =
        ScalarMatrix::with_pattern(system.len(), edges.iter().map(|&(i, j, ..)| (i, j)));
    for (i, &m) in system.mass().iter().enumerate() {
        matrix.add_diagonal(i, m);
    }
    for (i, j, k, c) in edges {
        matrix.add_edge(i, j, h * h * k + h * c);
    }
    matrix
}

/// `‖x − x_ref‖_M / ‖x_ref − x_0‖_M`; infinite for a state that is not finite.
pub(super) fn error(start: &Simulation, reference: &State, state: &State) -> f64 {
    let Simulation { system, state: begin } = start;
    let error = drape_oracle::order::position_error(system, &begin.x, &reference.x, &state.x);
    if error.is_nan() { f64::INFINITY } else { error }
}

/// The greatest of some numbers, infinite if one is none; 0 of none.
pub(super) fn greatest(values: impl IntoIterator<Item = f64>) -> f64 {
    let value = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
    values.into_iter().map(value).fold(0.0, f64::max)
}

/// The least of some numbers, `−∞` if one is none; infinite of none.
pub(super) fn least(values: impl IntoIterator<Item = f64>) -> f64 {
    let value = |value: f64| if value.is_nan() { f64::NEG_INFINITY } else { value };
    values.into_iter().map(value).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_never_overlooked() {
        assert_eq!(greatest([1.0, f64::NAN, 2.0]), f64::INFINITY);
        assert_eq!(least([1.0, f64::NAN, 2.0]), f64::NEG_INFINITY);
        assert_eq!((greatest([1.0, 2.0]), least([1.0, 2.0])), (2.0, 1.0));
    }
}
