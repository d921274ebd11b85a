//! Scenes, runs, and backward Euler by Newton's method.

use crate::{Vbd, VbdSettings};
use drape_integrator::{ContactSet, ImplicitStage, PhaseClock, Stage, StageSettings, StepReport};
use drape_model::{State, System, Vec3};
use drape_oracle::Run;
use drape_oracle::scenes::Sheet;
use drape_solvers::Constraints;

/// Settings from `key=value,key=value`.
pub(super) fn settings(text: &str) -> VbdSettings {
    let pairs = text.split(',').filter_map(|pair| pair.split_once('='));
    VbdSettings::from_pairs(pairs).unwrap_or_else(|error| panic!("{error}"))
}

pub(super) fn prepared(text: &str, start: (System, State), h: f64) -> Run {
    Run::new(Box::new(Vbd::new(settings(text))), start, h)
}

/// A step of backward Euler, solved by Newton's method as far as round-off lets it.
pub(super) fn backward_euler(system: &System, state: &mut State, h: f64) -> StepReport {
    let mut stage = ImplicitStage::new(system).unwrap_or_else(|error| panic!("{error}"));
    let (mut contacts, mut report) = (ContactSet::new(system), StepReport::default());
    let mut constraints = Constraints::free(system.len());
    let (contacts, constraints) = (&mut contacts, &mut constraints);
    let input = Stage {
        tau: h.into(),
        end: state.t + h,
        from: (&state.x, &state.v),
        lagged: state.level(),
        velocity: &state.v,
    };
    let tight = StageSettings { residual: 1e-15, ..StageSettings::default() };
    let mut clock = PhaseClock::off();
    stage
        .solve(system, input, &state.v, contacts, constraints, tight, &mut clock, &mut report)
        .unwrap_or_else(|error| panic!("{error}"));
    state.v.copy_from_slice(stage.velocity());
    state.x.copy_from_slice(stage.positions());
    state.t += h;
    report
}

/// The sheet of the measurements: 20 × 20 particles on two pins, shear springs of 0.1 k.
pub(super) fn sheet(stiffness: f64, damping: f64) -> (System, State) {
    Sheet { side: 20, tension: stiffness, shear: 0.1 * stiffness, damping, ..Sheet::default() }
        .build()
}

/// Kick, drift, kick over `duration` seconds with steps of at most `h`, for undamped scenes.
pub(super) fn leapfrog(system: &System, state: &mut State, duration: f64, h: f64) {
    let steps = (duration / h).ceil();
    let h = duration / steps;
    let mut force = vec![Vec3::zeros(); system.len()];
    let mut kick = |state: &mut State, h: f64| {
        system.forces(state.level(), &mut force);
        for (v, (f, m)) in state.v.iter_mut().zip(force.iter().zip(system.mass())) {
            *v += f * (h / m);
        }
        system.clear_pinned(&mut state.v);
    };
    for _ in 0..steps as usize {
        kick(state, 0.5 * h);
        state.x.iter_mut().zip(&state.v).for_each(|(x, v)| *x += v * h);
        kick(state, 0.5 * h);
    }
    state.t += duration;
}

/// `‖a − b‖_M` for equal masses, up to their root.
pub(super) fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>().sqrt()
}
