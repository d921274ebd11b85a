//! Scratch memory and history.

use drape_integrator::{
    ContactSet, Implicit, IncrementalPotential, Newton, Predictor, PrepareError, StepError,
};
use drape_model::{State, System, Vec3};
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
    topology: u64,
}

impl Workspace {
    pub(crate) fn new(system: &System) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let potential = IncrementalPotential::new(system, Implicit::Springs);
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
            topology: system.revisions().topology,
        })
    }

    /// The workspace, if it was prepared for this system.
    pub(crate) fn ready<'a>(
        workspace: &'a mut Option<Self>,
        system: &System,
        state: &State,
    ) -> Result<&'a mut Self, StepError> {
        if state.len() != system.len() || state.v.len() != system.len() {
            return Err(StepError::SizeMismatch { expected: system.len(), found: state.len() });
        }
        let topology = system.revisions().topology;
        workspace.as_mut().filter(|w| w.topology == topology).ok_or(StepError::NeedsPrepare)
    }
}
