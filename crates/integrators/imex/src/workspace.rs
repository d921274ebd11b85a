//! Scratch memory, cached operators and history.

use crate::algorithm1::Descent;
use crate::right_hand_side::RightHandSide;
use crate::splitting::SplittingError;
use drape_integrator::{
    ContactSet, Implicit, LaplacianSolver, LinearSettings, Predictor, PrepareError, Weights,
};
use drape_model::{System, Vec3};
use drape_solvers::Constraints;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) rhs: RightHandSide,
    pub(crate) velocity: Vec<Vec3>,
    pub(crate) extrapolated: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) linear: LaplacianSolver,
    pub(crate) predictor: Predictor,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    pub(crate) splitting: SplittingError,
    /// What only the robust form of Algorithm 1 needs.
    pub(crate) descent: Option<Descent>,
}

impl Workspace {
    pub(crate) fn new(
        system: &System,
        implicit: Implicit,
        linear: LinearSettings,
        robust: bool,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let weights = Weights::StiffnessAndDamping;
        Ok(Self {
            rhs: RightHandSide::new(system.len(), implicit),
            velocity: zeros(),
            extrapolated: zeros(),
            impulse: zeros(),
            linear: LaplacianSolver::new(system, implicit, weights, linear, h)?,
            predictor: Predictor::new(system.len()),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            splitting: SplittingError::new(system.len()),
            descent: robust.then(|| Descent::new(system, implicit)).transpose()?,
        })
    }

    pub(crate) fn restart(&mut self) {
        self.predictor.restart();
        self.contacts.restart();
    }
}
