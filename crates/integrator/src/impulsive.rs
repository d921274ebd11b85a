//! The end of a step whose velocity is not the solution of a constrained system.

use crate::{ContactSet, Phase, PhaseClock, drift};
use drape_model::{State, System, Vec3};
use drape_solvers::Constraints;

/// Pins and contacts for methods that first compute the velocity which a step would have without them: each
/// particle by itself then gets the impulse that its constraints need, without the others knowing of it.
#[derive(Debug)]
pub struct ImpulsiveContacts {
    contacts: ContactSet,
    constraints: Constraints,
    impulse: Vec<Vec3>,
    /// Velocity without constraints, m/s; `n` × 3. The method fills it before [`advance`](Self::advance).
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

    /// Imposes pins and contacts on the free velocity and moves the state by `h` seconds:
    /// `x_{n+1} = x_n + h v_{n+1}`.
    pub fn advance(&mut self, system: &System, h: f64, state: &mut State, clock: &mut PhaseClock) {
        let Self { contacts, constraints, impulse, free_velocity } = self;
        clock.switch(Phase::Contact);
        contacts.detect(system, &state.x, &state.v, (h, state.t + h), constraints);
        contacts.project(system, constraints, free_velocity, &mut state.v, impulse);
        clock.switch(Phase::Update);
        drift(h, &state.v, &mut state.x);
        contacts.settle(&mut state.v, |_| ());
        state.t += h;
    }

    /// What the pins and contacts of the last step left of the free velocity, m/s, before what followed its end.
    pub fn constrained_velocity(&self) -> Vec<Vec3> {
        let mut velocity = self.free_velocity.clone();
        self.constraints.impose(&mut velocity);
        velocity
    }

    /// Pins and contacts of the last step.
    pub fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    /// As [`ContactSet::stop`].
    pub fn stop(&self, v: &mut [Vec3]) {
        self.contacts.stop(v);
    }

    /// Forgets which contacts were active.
    pub fn restart(&mut self) {
        self.contacts.restart();
    }
}
