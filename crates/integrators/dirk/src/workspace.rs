//! The memory of a step, and what the step does beside its equations.

use crate::settings::DirkSettings;
use crate::tableau::Coefficients;
use drape_integrator::{
    Order, PhaseClock, PrepareError, StageMemory, StepReport, damping_has_directions,
};
use drape_model::{Revisions, State, System, Vec3};

/// What a step leaves to the next one.
#[derive(Clone, Debug)]
pub struct Past {
    /// System of the last step; `None` where there is none.
    pub(crate) known: Option<Revisions>,
    /// `a_s` of its last stage, m/s².
    acceleration: Vec<Vec3>,
    /// `w_s`, the velocity that `a_s` belongs to, m/s.
    velocity: Vec<Vec3>,
}

impl drape_integrator::Past for Past {
    fn copy_from(&mut self, other: &Self) {
        self.known = other.known;
        self.acceleration.copy_from_slice(&other.acceleration);
        self.velocity.copy_from_slice(&other.velocity);
    }
}

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) memory: StageMemory,
    /// `w_i` and `a_i` of each stage, m/s and m/s².
    pub(crate) w: Vec<Vec<Vec3>>,
    pub(crate) a: Vec<Vec<Vec3>>,
    pub(crate) past: Past,
    /// Solves of each stage: a second one where order 3 or 4 needs better directions of damping.
    pub(crate) passes: usize,
}

impl Workspace {
    pub(crate) fn allocate(system: &System, settings: &DirkSettings) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let stages = settings.tableau.coefficients().rows.len();
        let is_low = settings.tableau.order() == Order::Two;
        let passes =
            if is_low || !system.effects().any(|effect| damping_has_directions(system, effect)) {
                1
            } else {
                2
            };
        Ok(Self {
            memory: StageMemory::new(system, settings.linear)?,
            w: (0..stages).map(|_| zeros()).collect(),
            a: (0..stages).map(|_| zeros()).collect(),
            past: Past { known: None, acceleration: zeros(), velocity: zeros() },
            passes,
        })
    }

    /// Finds the contacts of the step.
    pub(crate) fn begin(&mut self, system: &System, state: &State, h: f64, clock: &mut PhaseClock) {
        if self.past.known != Some(system.revisions()) {
            self.past.known = None;
        }
        self.memory.begin(system, state, h, clock);
    }

    /// The explicit stage. `a₁` is `a_s` of the last step, brought to the velocity of this one.
    pub(crate) fn first_stage(&mut self, system: &System, state: &State, report: &mut StepReport) {
        let Self { memory, w, a, past, .. } = self;
        let (Some(w), Some(a)) = (w.first_mut(), a.first_mut()) else { return };
        w.copy_from_slice(&memory.first);
        if past.known.is_none() {
            return memory.accelerate(system, state, a, report);
        }
        a.copy_from_slice(&past.acceleration);
        memory.damp(system, state, &past.velocity, report, |i, change| a[i] += change);
    }

    /// Predicts the end of stage `i` from the acceleration of the stage before it.
    pub(crate) fn predict(&mut self, tableau: &Coefficients, i: usize, state: &State, h: f64) {
        let Self { memory, w, a, past, .. } = self;
        let StageMemory { x_star, ahead: (x_hat, v_hat), first, .. } = memory;
        let since = tableau.time(i) - if i > 0 { tableau.time(i - 1) } else { 0.0 };
        let (v, a, way) = match i.checked_sub(1) {
            Some(before) => (&w[before], &a[before], since * h),
            None => {
                (&*first, &past.acceleration, if past.known.is_some() { since * h } else { 0.0 })
            }
        };
        let tau = tableau.gamma * h;
        for k in 0..state.len() {
            v_hat[k] = v[k] + a[k] * way;
            x_hat[k] = x_star[k] + v_hat[k] * tau;
        }
    }

    /// Prepares a solve after the first of the step: friction holds again where it can. A second
    /// pass of a stage lags its damping at the solution of the first.
    pub(crate) fn again(&mut self, system: &System, i: usize, pass: usize) {
        let StageMemory { stage, ahead, contacts, constraints, .. } = &mut self.memory;
        if i + pass > 0 {
            contacts.write(system, constraints);
        }
        if pass > 0 {
            ahead.0.copy_from_slice(stage.positions());
            ahead.1.copy_from_slice(stage.velocity());
        }
    }

    /// Ends the step, whose last stage was number `last`.
    pub(crate) fn finish(&mut self, system: &System, state: &mut State, last: usize) {
        let Self { memory, w, a, past, .. } = self;
        past.acceleration.copy_from_slice(&a[last]);
        past.velocity.copy_from_slice(&w[last]);
        past.known = Some(system.revisions());
        memory.place(system, &mut state.x);
        memory.contacts.settle(&mut state.v, |_| ());
    }
}
