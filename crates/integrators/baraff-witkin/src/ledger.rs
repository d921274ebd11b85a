//! The energy ledger of a step.

use crate::settings::BaraffWitkinSettings;
use crate::step::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, StepReport, Taken, as_stepped};

impl Workspace {
    /// The ledger of the last step, with linearised forces and `p = A Δv − b`. The motion by `y` is
    /// a correction; its effect on the forces is not.
    pub(crate) fn energy_ledger(
        &mut self,
        settings: &BaraffWitkinSettings,
        taken: &Taken<'_>,
    ) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let Self { linear, change, y, impulse: p, constraints, .. } = self;
        linear.constraint_impulse(change, p, &mut StepReport::default());
        let mut v = as_stepped(system, before, h);
        v.iter_mut().zip(&*change).for_each(|(v, change)| *v += change);
        let mut book = Bookkeeping::new(system, before, h, &v, Some(y));
        book.linearised(settings.implicit, settings.tangent());
        book.impulse(constraints, p);
        book.finish(constraints, &v, after)
    }
}
