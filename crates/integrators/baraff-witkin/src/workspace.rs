//! Scratch memory.

use crate::linear_system::LinearSystem;
use crate::settings::{BaraffWitkinSettings, Recovery};
use drape_integrator::{ContactSet, PrepareError, SetupCause};
use drape_model::{State, System, Vec3};
use drape_solvers::Constraints;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) linear: LinearSystem,
    /// `Δv`, m/s.
    pub(crate) change: Vec<Vec3>,
    /// `y`, m; 0 throughout where velocities lead particles out of obstacles.
    pub(crate) y: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    /// On `v`.
    pub(crate) constraints: Constraints,
    /// On `Δv`.
    pub(crate) changes: Constraints,
    recovery: Recovery,
    first: bool,
}

impl Workspace {
    pub(crate) fn new(
        system: &System,
        settings: &BaraffWitkinSettings,
    ) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            linear: LinearSystem::new(system, settings)?,
            change: zeros(),
            y: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            changes: Constraints::free(system.len()),
            recovery: settings.contact,
            first: true,
        })
    }

    /// The matrix is of one step only.
    pub(crate) fn setup_cause(&mut self) -> SetupCause {
        if std::mem::take(&mut self.first) { SetupCause::First } else { SetupCause::EveryStep }
    }

    /// Pins, contacts and `y`; returns the largest distance by which `y` moves a particle, m.
    pub(crate) fn detect(&mut self, system: &System, state: &State, h: f64) -> f64 {
        let Self { contacts, constraints, y, .. } = self;
        let span = (h, state.t + h);
        match self.recovery {
            Recovery::Velocity => contacts.detect(system, &state.x, &state.v, span, constraints),
            Recovery::Position => {
                contacts.detect_altering(system, &state.x, &state.v, span, constraints, y);
            }
        }
        y.iter().fold(0.0, |largest, y| largest.max(y.norm()))
    }
}

/// Turns constraints on the new velocity into constraints on its change: Baraff and Witkin's `z`.
pub(crate) fn prescribe_changes(constraints: &Constraints, v: &[Vec3], changes: &mut Constraints) {
    changes.clear();
    for i in constraints.constrained().iter().map(|&i| i as usize) {
        changes.set(i, constraints.filter(i), constraints.prescribed(i) - v[i]);
    }
}
