//! What a step did to the energy.

use crate::workspace::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, TimeStep, momentum_between};
use drape_model::{State, System};

impl Workspace {
    /// The ledger of the last step: that of symplectic Euler, and the energy before and after the springs were shortened.
    pub(crate) fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> EnergyLedger {
        let contacts = &self.contacts;
        let v = contacts.constrained_velocity();
        let mut book = Bookkeeping::new(system, before, h, &v, None);
        book.explicit();
        let p = momentum_between(system, &v, &contacts.free_velocity);
        book.impulse(contacts.constraints(), &p);
        book.finish(contacts.constraints(), &v, after)
    }
}
