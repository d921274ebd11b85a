//! The energy ledger of a step.

use crate::step::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Taken};

impl Workspace {
    /// The ledger of the last step: that of backward Euler, with the residual `S ∇Φ(v_{n+1})` that
    /// the sweeps leave.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let v = self.iterate.v.clone();
        let p = self.potential.gradient(system, &v).to_vec();
        let mut book = Bookkeeping::new(system, before, h, &v, None);
        book.implicit(self.potential.implicit());
        book.impulse(&self.constraints, &p);
        book.finish(&self.constraints, &v, after)
    }
}
