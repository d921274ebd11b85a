//! The energy ledger of a step.

use crate::step::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Taken, momentum_between};
use drape_model::{Level, Vec3};

impl Workspace {
    /// The ledger of the last step, with the forces in the middle of it. Inertia is 0 in free
    /// directions: `w` is the mean of `v_n` and `v_{n+1}`. What remains of an undamped step is the
    /// gap `U(x_{n+1}) − U(x_n) − h w·∇U(x_n + h/2 w)`.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let half = 0.5 * h.seconds();
        let gradient = self.stage.gradient(system).to_vec();
        let implicit = self.stage.implicit();
        let w = self.stage.velocity();
        let (x_hat, v_hat) = &self.ahead;
        let lagged = Level { t: before.t + half, x: x_hat, v: v_hat };
        let middle: Vec<Vec3> = before.x.iter().zip(w).map(|(x, w)| x + w * half).collect();
        let mut book = Bookkeeping::new(system, before, h, w, None);
        book.forces(|effect, out| {
            let x = if implicit.selects(effect) { &middle } else { x_hat };
            effect.add_force(system.mass(), x, out);
        });
        book.damping(|effect, out| {
            if implicit.selects(effect) {
                effect.add_lagged_damping_force(lagged, w, out);
            } else {
                effect.add_damping_force(lagged, out);
            }
        });
        // M (v_{n+1} − v_n) = h f + 2 S ∇Φ + (I − S) ∇Φ, and what contacts cut at the end: the
        // obstacles act on w alone.
        let mut p = gradient;
        let cut = momentum_between(system, &after.v, &self.unsettled);
        for (i, (p, cut)) in p.iter_mut().zip(cut).enumerate() {
            *p += self.constraints.filter(i).apply(*p) + cut;
        }
        book.impulse(&self.constraints, &p);
        book.finish(&self.constraints, &after.v, after)
    }
}
