//! A single spring with a load across it. Here the law of locking has a closed form ([`LoadLaw`]).

use crate::HarnessError;
use crate::methods::runs::Variant;
use crate::methods::{self, Choice};
use crate::run::{Runner, Simulation};
use crate::studies::locking::facts::Spring;
use crate::studies::sheet::MASS;
use crate::theory::LoadLaw;
use drape_model::{TimeSpan, Vec3};
use drape_oracle::scenes::{particles, pin, spring};

const STEP: f64 = 0.01;
const STEPS: u64 = 100;
/// Load over mass, m/s². With it the deflection stays below 1e-3 of the length.
const LOAD: f64 = 1e-3;
const THETAS: [f64; 4] = [0.1, 1.0, 10.0, 1000.0];

/// Positions of the spring: name, direction, and direction of the load.
const DIRECTIONS: [(&str, [f64; 3], [f64; 3]); 2] = [
    ("along x", [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
    ("oblique", [1.0, 1.0, 1.0], [1.0, -1.0, 0.0]),
];

/// One method on one spring.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    method: Variant,
    law: LoadLaw,
    theta: f64,
    /// Index into [`DIRECTIONS`].
    direction: usize,
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for &(method, law) in methods::runs().flat_map(|(_, runs)| runs.locked_spring) {
        for theta in THETAS {
            cases.extend([0, 1].map(|direction| Case { method, law, theta, direction }));
        }
    }
    cases
}

pub(super) fn run(case: &Case) -> Result<Spring, HarnessError> {
    let Case { method, law, theta, direction } = *case;
    let (name, along, across) = DIRECTIONS[direction];
    let d = Vec3::from(along).normalize();
    let a = Vec3::from(across).normalize() * LOAD;
    let mut spec = particles(&[MASS; 2], &[Vec3::zeros(), d], &[Vec3::zeros(); 2]);
    let stiffness = theta * MASS / (STEP * STEP);
    spec.springs = vec![spring(drape_model::SpringEffect::Tension, (0, 1), 1.0, stiffness, 0.0)];
    spec.pins = vec![pin(0)];
    spec.effects.gravity = Some(drape_model::GravitySpec { m_s2: a.into() });
    let (system, state) = spec.build()?;
    let choice = Choice::parse(method.method, &[])?;
    let time = TimeSpan { step_s: STEP, duration_s: STEPS as f64 * STEP };
    let axis = d.cross(&a) / LOAD;
    let (mut before, mut spin, mut error) = (d, 0.0, law.follow(theta, 0.0, 0.0));
    let mut simulation = Simulation { system, state };
    let runner = Runner::new(&choice, time).observe(|moment| {
        let state = moment.state;
        let load = STEP * before.cross(&a).dot(&axis);
        let after = state.x[1].cross(&state.v[1]).dot(&axis);
        if let (Some(law), Some(error)) = (law.follow(theta, spin, load), &mut error) {
            let off = (after / law - 1.0).abs();
            *error = if off.is_nan() { f64::INFINITY } else { error.max(off) };
        }
        (before, spin) = (state.x[1], after);
    });
    runner.go(&mut simulation)?;
    Ok(Spring {
        label: method.label.to_owned(),
        method: choice.full_id(),
        direction: name.to_owned(),
        theta,
        step_s: STEP,
        steps: STEPS,
        load_m_s2: LOAD,
        speed_m_s: spin,
        law_m_s: STEP * LOAD * law.speed(theta, STEPS),
        recurrence_error: error,
        free_m_s: STEP * LOAD * STEPS as f64,
        portable: choice.is_portable(),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    /// The closed form solves the recurrence with a constant lever, and tends to `a/(hκ)`.
    #[test]
    fn the_closed_form_solves_the_recurrence_and_tends_to_the_terminal_speed() {
        for law in [LoadLaw::Filtered, LoadLaw::Unfiltered] {
            for theta in THETAS {
                let (mut spin, load) = (0.0, 1.0);
                for n in 1..=200 {
                    spin = law.follow(theta, spin, load).unwrap();
                    assert!(
                        (spin / law.speed(theta, n) - 1.0).abs() < 1e-12,
                        "{law:?} {theta} {n}"
                    );
                }
                let more = if law == LoadLaw::Unfiltered { 1.0 } else { 0.0 };
                assert!((spin - more - 1.0 / theta).abs() < 1e-8 / theta, "{law:?} {theta}");
            }
        }
    }

    #[test]
    fn every_method_falls_as_its_law_says_and_no_direction_matters() {
        let mut slowest: f64 = 1.0;
        for case in cases() {
            let result = run(&case).unwrap();
            let name = format!("{} {} θ = {}", result.label, result.direction, result.theta);
            let ratio = result.speed_m_s / result.law_m_s;
            assert!((ratio - 1.0).abs() < 1e-5, "{name}: {ratio}");
            if let Some(error) = result.recurrence_error {
                assert!(error < 1e-11, "{name}: {error}");
            }
            slowest = slowest.min(result.speed_m_s / result.free_m_s);
        }
        assert!(slowest < 2e-5, "nothing locks: {slowest}");
    }
}
