//! The energy ledger of a step.

use crate::step::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Implicit, Taken, momentum_between};

impl Workspace {
    /// The ledger of the last step: as for IMEX Euler, with the residual that the sweeps leave.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
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
