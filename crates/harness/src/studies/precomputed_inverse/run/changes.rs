//! Runs in which the system changes. They show which change makes a solver rebuild, and whether the
//! result equals that of a run that starts after the change.

use super::system::{STEP, hanging};
use crate::HarnessError;
use crate::methods::Choice;
use crate::studies::precomputed_inverse::facts::{CG, CHOLESKY, Change, DENSE};
use crate::studies::stepper::Stepper;
use drape_integrator::Setups;
use drape_model::{EffectKind, State, System};

/// Particles along each edge, and stiffness over mass, 1/s².
const SIDE: u32 = 20;
const STIFFNESS: f64 = 1e4;
/// Number of steps after each change.
const STEPS: u64 = 10;
/// A particle near the middle that is pinned during the run.
const HELD: usize = (SIDE * SIDE / 2 + SIDE / 2) as usize;

/// Solver and method. The method has a tight tolerance if any, and does not remember earlier steps.
pub(super) const METHODS: [(&str, &str); 3] = [
    (DENSE, "desbrun:inverse=dense,torque=none"),
    (CHOLESKY, "desbrun:inverse=cholesky,torque=none"),
    (CG, "imex-euler:implicit=springs,forcing_term=1e-14,start=last"),
];

/// A change of the system.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Event {
    /// No change, for comparison.
    Nothing,
    /// The step size is multiplied by this factor.
    Step(f64),
    /// All stiffnesses are multiplied by this factor.
    Stiffness(f64),
    /// All masses are multiplied by this factor.
    Mass(f64),
    /// The particle near the middle is pinned, or released.
    Pin(bool),
    /// The step size changes in every step.
    EveryStep,
}

const EVENTS: [(&str, Event); 9] = [
    ("nothing", Event::Nothing),
    ("h halved", Event::Step(0.5)),
    ("h doubled", Event::Step(2.0)),
    ("k × 100", Event::Stiffness(100.0)),
    ("k ÷ 100", Event::Stiffness(0.01)),
    ("m × 2", Event::Mass(2.0)),
    ("a particle pinned", Event::Pin(true)),
    ("it is freed", Event::Pin(false)),
    ("h halved or doubled in each step", Event::EveryStep),
];

fn apply(event: Event, system: &mut System, state: &mut State, step_s: &mut f64) {
    let _is_there = match event {
        Event::Nothing | Event::EveryStep => true,
        Event::Step(factor) => {
            *step_s *= factor;
            true
        }
        Event::Stiffness(factor) => [EffectKind::Tension, EffectKind::Shear]
            .into_iter()
            .all(|kind| system.scale_stiffness(kind, factor)),
        Event::Mass(factor) => {
            let mass: Vec<f64> = system.mass().iter().map(|mass| mass * factor).collect();
            system.set_mass(&mass)
        }
        Event::Pin(is_held) => {
            state.v[HELD] *= 0.0;
            system.set_pinned(HELD, is_held)
        }
    };
}

fn add(sum: &mut Setups, setups: Setups) {
    sum.first += setups.first;
    sum.step_size += setups.step_size;
    sum.stiffness += setups.stiffness;
    sum.constraints += setups.constraints;
}

/// Takes the steps after a change. Returns the number of set-ups by cause.
fn go_on(
    stepper: &mut Stepper,
    event: Event,
    system: &System,
    state: &mut State,
) -> Result<Setups, HarnessError> {
    let mut setups = Setups::default();
    let usual = stepper.step_s();
    for step in 0..STEPS {
        if event == Event::EveryStep {
            stepper.set_step_s(usual * if step % 2 == 0 { 0.5 } else { 1.0 })?;
        }
        if let Some(report) = stepper.step(system, state)? {
            add(&mut setups, report.setups);
        }
    }
    stepper.set_step_s(usual)?;
    Ok(setups)
}

/// Runs one method through all changes.
pub(super) fn change(solver: &str, method: &str) -> Result<Change, HarnessError> {
    let choice = Choice::parse(method, &[])?;
    let (mut system, mut state) = hanging(SIDE, STIFFNESS)?.build()?;
    let mut step_s = STEP;
    let mut stepper = Stepper::new(&choice, &system, step_s)?;
    let mut setups = go_on(&mut stepper, Event::Nothing, &system, &mut state)?;
    let mut distances = Vec::new();
    for (_, event) in EVENTS {
        apply(event, &mut system, &mut state, &mut step_s);
        let mut anew = state.clone();
        stepper.set_step_s(step_s)?;
        add(&mut setups, go_on(&mut stepper, event, &system, &mut state)?);
        let mut fresh = Stepper::new(&choice, &system, step_s)?;
        go_on(&mut fresh, event, &system, &mut anew)?;
        let apart = state.x.iter().zip(&anew.x).map(|(x, anew)| (x - anew).norm());
        distances.push(apart.fold(0.0, f64::max));
    }
    Ok(Change {
        solver: solver.to_owned(),
        method: choice.full_id(),
        steps: (1 + EVENTS.len() as u64) * STEPS,
        first: setups.first,
        step_size: setups.step_size,
        stiffness: setups.stiffness,
        constraints: setups.constraints,
        changed: EVENTS.iter().map(|(name, _)| (*name).to_owned()).collect(),
        distance_to_fresh_m: distances,
        portable: choice.is_portable(),
    })
}
