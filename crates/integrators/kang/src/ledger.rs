//! What a step did to the energy.

use crate::workspace::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Implicit, TimeStep, momentum_between};
use drape_model::{State, System};

impl Workspace {
    /// The ledger of the last step: that of IMEX Euler with the residual that the sweeps leave.
    pub(crate) fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> EnergyLedger {
        let Self { linear, viscous, change, product: p, contacts } = self;
        let v = contacts.constrained_velocity();
        let mut book = Bookkeeping::new(system, before, h, &v, None);
        let v_n = book.velocity().to_vec();
        let swept: Vec<_> = v_n.iter().zip(&*change).map(|(v, change)| v + change).collect();
        book.split(Implicit::Springs, &swept, (&before.x, &v_n));
        linear.constraint_impulse(viscous.impulse(), change, p);
        book.residual(p);
        book.impulse(
            contacts.constraints(),
            &momentum_between(system, &v, &contacts.free_velocity),
        );
        book.finish(contacts.constraints(), &v, after)
    }
}
