//! Scratch memory of explicit and symplectic Euler.

use drape_integrator::{
    ContactSet, Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, PrepareError,
    SolverKind, Weights,
};
use drape_model::{System, Vec3};
use drape_solvers::{Constraints, Norm};

#[derive(Debug)]
pub(crate) struct EulerWorkspace {
    pub(crate) force: Vec<Vec3>,
    pub(crate) free_velocity: Vec<Vec3>,
    pub(crate) velocity: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    /// `M + h L_c`, where the damping is implicit.
    pub(crate) damping: Option<LaplacianSolver>,
}

impl EulerWorkspace {
    pub(crate) fn new(
        system: &System,
        implicit_damping: bool,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let direct = LinearSettings {
            forcing_term: 1e-14,
            preconditioner: PreconditionerKind::Ic0,
            norm: Norm::Euclid,
            solver: SolverKind::Cholesky,
            rebuild_every_step: false,
        };
        let solver =
            || LaplacianSolver::new(system, Implicit::Springs, Weights::Damping, direct, h);
        Ok(Self {
            force: zeros(),
            free_velocity: zeros(),
            velocity: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            damping: implicit_damping.then(solver).transpose()?,
        })
    }

    /// `velocity` from `free_velocity`, pins and contacts.
    pub(crate) fn project(&mut self, system: &System) {
        let Self { free_velocity, velocity, impulse, contacts, constraints, .. } = self;
        contacts.project(system, constraints, free_velocity, velocity, impulse);
    }
}
