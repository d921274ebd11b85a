//! Scratch memory and history.

use drape_integrator::{
    ContactSet, Implicit, IncrementalPotential, Newton, Predictor, PrepareError,
};
use drape_model::{System, Vec3};
use drape_solvers::Constraints;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) frozen: Vec<Vec3>,
    pub(crate) velocity: Vec<Vec3>,
    pub(crate) extrapolated: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) predictor: Predictor,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    pub(crate) potential: IncrementalPotential,
    pub(crate) newton: Newton,
}

impl Workspace {
    pub(crate) fn new(system: &System) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let potential = IncrementalPotential::new(system, Implicit::Everything);
        let newton = Newton::new(system, &potential)?;
        Ok(Self {
            frozen: zeros(),
            velocity: zeros(),
            extrapolated: zeros(),
            impulse: zeros(),
            predictor: Predictor::new(system.len()),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            potential,
            newton,
        })
    }
}
