//! Memory, cached operators and history of the two methods of order 1.

use crate::right_hand_side::RightHandSide;
use drape_integrator::{
    ContactSet, LaplacianSolver, LinearSettings, Predictor, PrepareError, Split, StepReference,
    Weights,
};
use drape_model::{State, System, Vec3};
use drape_solvers::Constraints;
use drape_solvers::bands::in_bands;
use drape_solvers::vector::axpy;

#[derive(Debug)]
pub(crate) struct Memory {
    pub(crate) rhs: RightHandSide,
    pub(crate) velocity: Vec<Vec3>,
    /// Empty without obstacles.
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) linear: LaplacianSolver,
    pub(crate) predictor: Predictor,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    pub(crate) reference: StepReference,
}

impl Memory {
    pub(crate) fn new(
        system: &System,
        rhs: RightHandSide,
        linear: LinearSettings,
        split: Split,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let weights = Weights::StiffnessAndDamping;
        let linear =
            LaplacianSolver::with_split(system, rhs.implicit(), weights, linear, split, h)?;
        Ok(Self {
            reference: StepReference::new(system, &linear),
            linear,
            rhs,
            velocity: vec![Vec3::zeros(); system.len()],
            impulse: ContactSet::impulse(system),
            predictor: Predictor::new(system.len()),
            contacts: ContactSet::new(system),
            constraints: ContactSet::constraints(system),
        })
    }

    pub(crate) fn restart(&mut self) {
        self.predictor.restart();
        self.contacts.restart();
    }

    /// Swaps the new velocity into `v` without a copy; the predictor remembers the old one. The
    /// ledger needs a copy of the solution only where contacts may still change `v`.
    pub(crate) fn change_places(&mut self, v: &mut Vec<Vec3>, h: f64) {
        self.predictor.take(v, h);
        std::mem::swap(v, &mut self.velocity);
        if !self.contacts.is_empty() {
            self.velocity.copy_from_slice(v);
        }
    }

    /// `x_{n+1} = x_n + h v_{n+1}`, EEH (20); then ends the contacts.
    #[doc(alias = "EEH 20")]
    pub(crate) fn advance(&mut self, state: &mut State, h: f64, bands: usize) {
        let Self { contacts, predictor, .. } = self;
        let State { x, v, .. } = state;
        in_bands(bands, v.len(), &mut x[..], &|band, x: &mut [Vec3]| axpy(h, &v[band], x));
        contacts.settle(v, |c| predictor.forget(c.particle, c.velocity));
        state.t += h;
    }
}
