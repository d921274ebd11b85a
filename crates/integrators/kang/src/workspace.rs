//! Scratch memory and the cached matrix.

use drape_integrator::{
    Implicit, ImpulsiveContacts, LaplacianSolver, LinearSettings, PreconditionerKind, PrepareError,
    SolverKind, ViscousImpulse, Weights,
};
use drape_model::{System, Vec3};
use drape_solvers::Norm;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) linear: LaplacianSolver,
    /// Right-hand side `h F̃`, and the external force.
    pub(crate) viscous: ViscousImpulse,
    pub(crate) change: Vec<Vec3>,
    pub(crate) product: Vec<Vec3>,
    pub(crate) contacts: ImpulsiveContacts,
}

impl Workspace {
    pub(crate) fn new(system: &System, h: f64) -> Result<Self, PrepareError> {
        // Of the solver only the matrix is used: its diagonal is all that is ever inverted.
        let settings = LinearSettings {
            forcing_term: 0.5,
            preconditioner: PreconditionerKind::None,
            norm: Norm::Euclid,
            solver: SolverKind::Cg,
            rebuild_every_step: false,
        };
        let weights = Weights::StiffnessAndDamping;
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            linear: LaplacianSolver::new(system, Implicit::Springs, weights, settings, h)?,
            viscous: ViscousImpulse::new(system.len()),
            change: zeros(),
            product: zeros(),
            contacts: ImpulsiveContacts::new(system),
        })
    }
}
