//! The energy ledger of a step.

use crate::step::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Taken};

impl Workspace {
    /// The ledger of the last step, with the forces at its end and `p = ∇Φ(v_{n+1})`.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let p = self.stage.gradient(system).to_vec();
        let v = self.stage.velocity();
        let mut book = Bookkeeping::new(system, before, h, v, None);
        book.implicit(self.stage.implicit());
        book.impulse(&self.constraints, &p);
        book.finish(&self.constraints, v, after)
    }
}
