//! Scratch memory and the precomputed inverse.

use crate::settings::DesbrunSettings;
use drape_integrator::{
    ContactSet, ElongationLimit, Implicit, LaplacianSolver, LinearSettings, PreconditionerKind,
    PrepareError, ViscousImpulse, Weights,
};
use drape_model::{System, Vec3};
use drape_solvers::{Constraints, Norm};

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) linear: LaplacianSolver,
    pub(crate) viscous: ViscousImpulse,
    /// `Δv = A⁻¹ h F̃ = h M⁻¹ F_filtered`, m/s.
    pub(crate) change: Vec<Vec3>,
    pub(crate) free_velocity: Vec<Vec3>,
    pub(crate) velocity: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) elongation: Option<ElongationLimit>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
}

impl Workspace {
    pub(crate) fn new(
        system: &System,
        settings: &DesbrunSettings,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let linear = LinearSettings {
            forcing_term: 1e-14,
            preconditioner: PreconditionerKind::None,
            norm: Norm::Euclid,
            solver: settings.inverse.solver(),
            rebuild_every_step: false,
        };
        let weights = Weights::StiffnessAndDamping;
        let zeros = || vec![Vec3::zeros(); system.len()];
        let elongation = settings.inverse_dynamics.map(|limit| ElongationLimit::new(system, limit));
        Ok(Self {
            linear: LaplacianSolver::new(system, Implicit::Springs, weights, linear, h)?,
            viscous: ViscousImpulse::new(system.len()),
            change: zeros(),
            free_velocity: zeros(),
            velocity: zeros(),
            impulse: zeros(),
            elongation,
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
        })
    }
}
