//! The energy ledger of a step.

use crate::newton::add_mean_force;
use crate::step::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Implicit, Taken};
use drape_model::{Effect, Level, Vec3};
use drape_solvers::Filter;

impl Workspace {
    /// The ledger of the last step, which moved by `h v̄`. The discrete gradients do exactly the
    /// work `−ΔU`: springs leave no gap, and `v₊ − v̄ = v̄ − v_n` leaves no inertia.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let Self { equation, mean, constraints, .. } = self;
        let mut book = Bookkeeping::new(system, before, h, mean, None);
        let (start, end) = (before.x.clone(), book.end().to_vec());
        let velocity = book.velocity().to_vec();
        let is_mean = |effect: &dyn Effect| Implicit::Springs.selects(effect);
        book.forces(|effect, out| {
            if is_mean(effect) {
                add_mean_force(effect, &start, &end, out);
            } else {
                effect.add_force(system.mass(), &start, out);
            }
        });
        book.damping(|effect, out| {
            let v = if is_mean(effect) { &mean[..] } else { &velocity };
            effect.add_damping_force(Level { t: before.t, x: &start, v }, out);
        });
        // M (v₊ − v_n) = h f + p with p = 2 r, and with what contacts took at the end beside it.
        let (mut solved, mut p) = (velocity.clone(), velocity.clone());
        for (i, m) in system.mass().iter().enumerate() {
            let free = mean[i] * 2.0 - velocity[i];
            let filter = constraints.filter(i);
            let is_contact = filter != Filter::Free && !system.pinned()[i];
            let taken = if is_contact { after.v[i] - free } else { Vec3::zeros() };
            solved[i] = free + filter.complement(taken);
            p[i] = equation.residual[i] * 2.0 + filter.complement(taken) * *m;
        }
        book.impulse(constraints, &p);
        book.finish(constraints, &solved, after)
    }
}
