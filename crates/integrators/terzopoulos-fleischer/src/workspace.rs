//! Scratch memory.

use crate::secant::SecantSystem;
use drape_integrator::{ContactSet, PrepareError, SetupCause};
use drape_model::{System, Vec3};
use drape_solvers::Constraints;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) secant: SecantSystem,
    /// Why the next step sets the matrix up.
    pub(crate) cause: SetupCause,
    pub(crate) free_velocity: Vec<Vec3>,
    pub(crate) velocity: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
}

impl Workspace {
    pub(crate) fn new(system: &System, clamp: bool) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            secant: SecantSystem::new(system, clamp)?,
            cause: SetupCause::First,
            free_velocity: zeros(),
            velocity: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
        })
    }
}
