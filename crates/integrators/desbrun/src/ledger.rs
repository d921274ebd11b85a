//! The energy ledger of a step.

use crate::settings::DesbrunSettings;
use crate::step::Workspace;
use crate::torque::correct;
use drape_integrator::{Bookkeeping, EnergyLedger, Implicit, Taken, momentum_between};
use drape_model::Vec3;

impl Workspace {
    /// The ledger of the last step. The filtered force is that of IMEX Euler. The torque's
    /// correction and every later motion of particles count as corrections.
    pub(crate) fn energy_ledger(
        &mut self,
        settings: &DesbrunSettings,
        taken: &Taken<'_>,
    ) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let Self { linear, viscous, change, damping, contacts, .. } = self;
        let v = contacts.constrained_velocity();
        let mut book = Bookkeeping::new(system, before, h, &v, None);
        let v_n = book.velocity().to_vec();
        let filtered: Vec<_> = v_n.iter().zip(&*change).map(|(v, change)| v + change).collect();
        book.split(Implicit::Springs, &filtered, (&before.x, &v_n));
        let mut p = vec![Vec3::zeros(); system.len()];
        linear.constraint_impulse(viscous.impulse(), change, &mut p);
        book.residual(&p);
        let mut spun = vec![Vec3::zeros(); system.len()];
        correct(settings.torque, system, h.seconds(), &before.x, change, damping, &mut spun);
        let at_rest = vec![Vec3::zeros(); system.len()];
        book.correction(&momentum_between(system, &spun, &at_rest));
        book.impulse(
            contacts.constraints(),
            &momentum_between(system, &v, &contacts.free_velocity),
        );
        book.finish(contacts.constraints(), &v, after)
    }
}
