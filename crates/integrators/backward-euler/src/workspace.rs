//! Scratch memory and history.

use drape_integrator::{ContactSet, ImplicitStage, NewtonLinear, Predictor, PrepareError};
use drape_model::{System, Vec3};
use drape_solvers::Constraints;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) stage: ImplicitStage,
    pub(crate) extrapolated: Vec<Vec3>,
    pub(crate) predictor: Predictor,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
}

impl Workspace {
    pub(crate) fn new(system: &System, linear: NewtonLinear) -> Result<Self, PrepareError> {
        Ok(Self {
            stage: ImplicitStage::with_linear(system, linear)?,
            extrapolated: vec![Vec3::zeros(); system.len()],
            predictor: Predictor::new(system.len()),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
        })
    }
}
