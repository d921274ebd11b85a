//! Scratch memory.

use crate::secant::SecantSystem;
use drape_integrator::{ImpulsiveContacts, PrepareError, SetupCause};
use drape_model::System;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) secant: SecantSystem,
    /// Why the next step sets the matrix up.
    pub(crate) cause: SetupCause,
    pub(crate) contacts: ImpulsiveContacts,
}

impl Workspace {
    pub(crate) fn new(system: &System, clamp: bool) -> Result<Self, PrepareError> {
        Ok(Self {
            secant: SecantSystem::new(system, clamp)?,
            cause: SetupCause::First,
            contacts: ImpulsiveContacts::new(system),
        })
    }
}
