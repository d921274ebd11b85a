//! The energy ledger of a step.

use crate::step::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Implicit, Taken};

impl Workspace {
    /// The ledger of the last step: that of backward Euler with the springs implicit, plus the work
    /// of the residual `∇Φ(v_{n+1})` that the iterations leave.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let Self { minimiser, velocity: v, constraints, .. } = self;
        let p = minimiser.potential.gradient(system, v).to_vec();
        let mut book = Bookkeeping::new(system, before, h, v, None);
        book.implicit(Implicit::Springs);
        book.impulse(constraints, &p);
        book.finish(constraints, v, after)
    }
}
