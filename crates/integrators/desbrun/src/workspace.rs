//! Scratch memory and the precomputed inverse.

use crate::settings::DesbrunSettings;
use drape_integrator::{
    ElongationLimit, Implicit, ImpulsiveContacts, LaplacianSolver, LinearSettings,
    PreconditionerKind, PrepareError, ViscousImpulse, Weights,
};
use drape_model::{System, Vec3};
use drape_solvers::Norm;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) linear: LaplacianSolver,
    pub(crate) viscous: ViscousImpulse,
    /// `Δv = A⁻¹ h F̃ = h M⁻¹ F_filtered`, m/s.
    pub(crate) change: Vec<Vec3>,
    /// Damping force at level `n`, N: 0 throughout where nothing is damped.
    pub(crate) damping: Vec<Vec3>,
    pub(crate) elongation: Option<ElongationLimit>,
    pub(crate) contacts: ImpulsiveContacts,
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
            damping: zeros(),
            elongation,
            contacts: ImpulsiveContacts::new(system),
        })
    }
}
