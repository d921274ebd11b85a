//! Scratch memory.

use crate::settings::ProvotSettings;
use drape_integrator::{ContactSet, ElongationLimit};
use drape_model::{System, Vec3};
use drape_solvers::Constraints;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) force: Vec<Vec3>,
    pub(crate) free_velocity: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    pub(crate) limit: ElongationLimit,
}

impl Workspace {
    pub(crate) fn new(system: &System, settings: ProvotSettings) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Self {
            force: zeros(),
            free_velocity: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            limit: ElongationLimit::new(system, settings.elongation),
        }
    }
}
