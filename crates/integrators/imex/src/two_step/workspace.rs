//! Memory, cached operators and history.

use super::ImexTwoStepSettings;
use super::old_level::OldLevel;
use super::split_forces::SplitForces;
use crate::splitting::SplittingError;
use drape_integrator::{
    ContactSet, ImplicitStage, LaplacianSolver, PrepareError, StepReference, Weights,
};
use drape_model::{System, Vec3};
use drape_solvers::Constraints;

/// Memory of a step.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) linear: LaplacianSolver,
    pub(crate) starter: ImplicitStage,
    pub(crate) past: OldLevel,
    /// Forces of level `n`.
    pub(crate) present: SplitForces,
    /// `X*`, and at the end of the step `x_{n+1}`, m.
    pub(crate) position: Vec<Vec3>,
    pub(crate) velocity: Vec<Vec3>,
    /// Right-hand side, kg m/s.
    pub(crate) b: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    pub(crate) splitting: SplittingError,
    /// Force of the effects without a Jacobian, such as gravity, N.
    pub(crate) external: Vec<Vec3>,
    pub(crate) scratch: Vec<Vec3>,
    pub(crate) reference: StepReference,
}

impl Workspace {
    pub(crate) fn allocate(
        system: &System,
        settings: &ImexTwoStepSettings,
        tau: f64,
    ) -> Result<Self, PrepareError> {
        let (linear, implicit) = (settings.linear(), settings.implicit);
        let zeros = || vec![Vec3::zeros(); system.len()];
        let weights = Weights::StiffnessAndDamping;
        let linear = LaplacianSolver::new(system, implicit, weights, linear, tau)?;
        Ok(Self {
            reference: StepReference::new(system, &linear),
            linear,
            starter: ImplicitStage::new(system)?,
            past: OldLevel::new(system.len()),
            present: SplitForces::new(system.len()),
            position: zeros(),
            velocity: zeros(),
            b: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: ContactSet::constraints(system),
            splitting: SplittingError::new(system.len()),
            external: zeros(),
            scratch: zeros(),
        })
    }
}
