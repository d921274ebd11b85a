//! The energy ledger of a step.

use crate::step::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Taken, momentum_between};

impl Workspace {
    /// The ledger of the last step: as for symplectic Euler, with the shortening of springs as a
    /// correction.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let contacts = &self.contacts;
        let v = contacts.constrained_velocity();
        let mut book = Bookkeeping::new(system, before, h, &v, None);
        book.explicit();
        let p = momentum_between(system, &v, &contacts.free_velocity);
        book.impulse(contacts.constraints(), &p);
        book.finish(contacts.constraints(), &v, after)
    }
}
