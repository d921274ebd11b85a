//! What a step did to the energy.

use crate::workspace::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, TimeStep};
use drape_model::{State, System};

impl Workspace {
    /// The ledger of the last step: forces at its end, `p = ∇Φ(v_{n+1})`.
    pub(crate) fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> EnergyLedger {
        let p = self.stage.gradient(system).to_vec();
        let v = self.stage.velocity();
        let mut book = Bookkeeping::new(system, before, h, v, None);
        book.implicit(self.stage.implicit());
        book.impulse(&self.constraints, &p);
        book.finish(&self.constraints, v, after)
    }
}
