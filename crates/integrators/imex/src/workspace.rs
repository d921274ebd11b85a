//! Scratch memory, cached operators and history.

use crate::algorithm1::Descent;
use crate::right_hand_side::RightHandSide;
use crate::settings::{ImexEulerSettings, ImexUpdatedSettings, Safeguard};
use crate::splitting::SplittingError;
use drape_integrator::{
    ContactSet, LaplacianSolver, LinearSettings, Predictor, PrepareError, Split, Weights,
};
use drape_model::{System, Vec3};
use drape_solvers::Constraints;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) rhs: RightHandSide,
    pub(crate) velocity: Vec<Vec3>,
    /// Empty without obstacles.
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) linear: LaplacianSolver,
    pub(crate) predictor: Predictor,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    /// What only step size control of plain IMEX Euler needs.
    pub(crate) splitting: Option<SplittingError>,
    /// What only the robust form of Algorithm 1 needs.
    pub(crate) descent: Option<Descent>,
}

impl Workspace {
    /// For plain IMEX Euler.
    pub(crate) fn plain(
        system: &System,
        settings: &ImexEulerSettings,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let ImexEulerSettings { implicit, linear, split, tolerance, sees_splitting, .. } =
            *settings;
        let rhs = RightHandSide::new(system.len(), implicit);
        let is_split = tolerance > 0.0 && sees_splitting;
        let splitting = is_split.then(|| SplittingError::new(system.len()));
        Ok(Self { splitting, ..Self::new(system, rhs, linear, split, h)? })
    }

    /// For Algorithm 1.
    pub(crate) fn updated(
        system: &System,
        settings: &ImexUpdatedSettings,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let ImexUpdatedSettings { implicit, linear, split, safeguard, .. } = *settings;
        let rhs = RightHandSide::updated(system.len(), implicit);
        let robust = safeguard == Safeguard::Robust;
        let descent = robust.then(|| Descent::new(system, implicit)).transpose()?;
        Ok(Self { descent, ..Self::new(system, rhs, linear, split, h)? })
    }

    /// What both methods need.
    fn new(
        system: &System,
        rhs: RightHandSide,
        linear: LinearSettings,
        split: Split,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let weights = Weights::StiffnessAndDamping;
        Ok(Self {
            linear: LaplacianSolver::with_split(system, rhs.implicit(), weights, linear, split, h)?,
            rhs,
            velocity: vec![Vec3::zeros(); system.len()],
            impulse: ContactSet::impulse(system),
            predictor: Predictor::new(system.len()),
            contacts: ContactSet::new(system),
            constraints: ContactSet::constraints(system),
            splitting: None,
            descent: None,
        })
    }

    pub(crate) fn restart(&mut self) {
        self.predictor.restart();
        self.contacts.restart();
    }
}
