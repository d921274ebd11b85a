//! The energy ledger of a step.

use crate::step::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Taken, momentum_between, subtract_laplacian};
use drape_model::{Level, Vec3};

impl Workspace {
    /// The ledger of the last step. A spring's force is its old secant stiffness times the
    /// positions that the solve leads to, before contacts. Damping is the mean of old and new.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let Self { secant, contacts, .. } = self;
        let free = &contacts.free_velocity;
        let v = contacts.constrained_velocity();
        let mut book = Bookkeeping::new(system, before, h, &v, None);
        let x = &before.x;
        let ahead: Vec<Vec3> = x.iter().zip(free).map(|(x, v)| x + v * h.seconds()).collect();
        book.forces(|effect, out| match effect.split() {
            Some(split) => split.visit_secants(x, &mut |i, j, k| {
                let f = (ahead[i] - ahead[j]) * secant.weight(k);
                out[i] -= f;
                out[j] += f;
            }),
            None => effect.add_force(system.mass(), x, out),
        });
        let v_n = book.velocity().to_vec();
        let half: [Vec<Vec3>; 2] =
            [&v_n, free].map(|v| v.iter().map(|v| v * 0.5).collect::<Vec<_>>());
        book.damping(|effect, out| match effect.split() {
            Some(split) => {
                effect.add_damping_force(Level { v: &half[0], ..before.level() }, out);
                split.add_damping_remainder(x, &half[0], out);
                subtract_laplacian(effect, |_, c| c, &half[1], out);
            }
            None => effect.add_damping_force(Level { v: &v_n, ..before.level() }, out),
        });
        book.residual(secant.left_over(free)); // A v − b of the solve
        book.impulse(contacts.constraints(), &momentum_between(system, &v, free));
        book.finish(contacts.constraints(), &v, after)
    }
}
