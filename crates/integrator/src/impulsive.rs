//! Pins and contacts for methods whose velocity does not solve a constrained system.

use crate::{ContactSet, Phase, PhaseClock};
use drape_model::{State, System, Vec3};
use drape_solvers::Constraints;

/// Pins and contacts for methods that compute the new velocity without constraints. Each particle
/// then gets the impulse that its own constraints require; its neighbours do not feel this impulse.
///
/// A step fills [`free_velocity`](Self::free_velocity), calls [`constrain`](Self::constrain), moves
/// the positions by the new velocity, and calls [`settle`](Self::settle).
#[derive(Debug)]
pub struct ImpulsiveContacts {
    contacts: ContactSet,
    constraints: Constraints,
    impulse: Vec<Vec3>,
    /// Velocity without constraints, m/s; `n` × 3.
    pub free_velocity: Vec<Vec3>,
}

impl ImpulsiveContacts {
    /// Memory for a system.
    pub fn new(system: &System) -> Self {
        Self {
            contacts: ContactSet::new(system),
            constraints: ContactSet::constraints(system),
            impulse: ContactSet::impulse(system),
            free_velocity: vec![Vec3::zeros(); system.len()],
        }
    }

    /// Imposes pins and contacts on the free velocity of a step of `h` seconds, and writes the
    /// result to `state.v`.
    pub fn constrain(
        &mut self,
        system: &System,
        h: f64,
        state: &mut State,
        clock: &mut PhaseClock,
    ) {
        let Self { contacts, constraints, impulse, free_velocity } = self;
        clock.switch(Phase::Contact);
        contacts.detect(system, &state.x, &state.v, (h, state.t + h), constraints);
        contacts.project(system, constraints, free_velocity, &mut state.v, impulse);
        clock.switch(Phase::Update);
    }

    /// Ends a step of `h` seconds. Call it after the positions have moved.
    pub fn settle(&mut self, h: f64, state: &mut State) {
        self.contacts.settle(&mut state.v, |_| ());
        state.t += h;
    }

    /// The free velocity of the last step under its pins and contacts, m/s, before corrections.
    pub fn constrained_velocity(&self) -> Vec<Vec3> {
        let mut velocity = self.free_velocity.clone();
        self.constraints.impose(&mut velocity);
        velocity
    }

    /// Pins and contacts of the last step.
    pub fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    /// See [`ContactSet::stop`].
    pub fn stop(&self, v: &mut [Vec3]) {
        self.contacts.stop(v);
    }

    /// Forgets which contacts were active.
    pub fn restart(&mut self) {
        self.contacts.restart();
    }
}
