//! Scratch memory.

use crate::settings::ProvotSettings;
use drape_integrator::{ElongationLimit, ImpulsiveContacts};
use drape_model::{System, Vec3};

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) force: Vec<Vec3>,
    pub(crate) contacts: ImpulsiveContacts,
    pub(crate) limit: ElongationLimit,
}

impl Workspace {
    pub(crate) fn new(system: &System, settings: ProvotSettings) -> Self {
        Self {
            force: vec![Vec3::zeros(); system.len()],
            contacts: ImpulsiveContacts::new(system),
            limit: ElongationLimit::new(system, settings.elongation),
        }
    }
}
