//! The energy ledger of a step.

use crate::step::{ExplicitWorkspace, SymplecticWorkspace};
use crate::workspace::{Damping, EulerMemory, LeapfrogWorkspace};
use drape_integrator::{
    Bookkeeping, EnergyLedger, Taken, as_stepped, kick, momentum_between, subtract_laplacian,
};
use drape_model::{Level, Vec3};

impl ExplicitWorkspace {
    /// The ledger of the last step of explicit Euler. `v_n` under the contacts moves the positions.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let EulerMemory { force, free_velocity, velocity, constraints, .. } = &self.0;
        let mut book = Bookkeeping::new(system, before, h, velocity, None);
        book.explicit();
        let mut p = momentum_between(system, velocity, free_velocity); // before the motion
        let later = momentum_between(system, &after.v, velocity); // after it, with the forces
        for i in 0..p.len() {
            p[i] += later[i] - force[i] * h.seconds();
        }
        book.impulse(constraints, &p);
        book.finish(constraints, &after.v, after)
    }
}

impl SymplecticWorkspace {
    /// The ledger of the last step of symplectic Euler, with explicit or implicit damping.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let EulerMemory { force: b, free_velocity, velocity: v, impulse: p, constraints, .. } =
            &mut self.euler;
        let mut book = Bookkeeping::new(system, before, h, v, None);
        if let Some(solver) = &self.damping {
            let (x, v_n) = (&before.x, book.velocity().to_vec());
            book.forces(|effect, out| effect.add_force(system.mass(), x, out));
            book.damping(|effect, out| match effect.split() {
                Some(split) => {
                    subtract_laplacian(effect, |_, c| c, v, out);
                    split.add_damping_remainder(x, &v_n, out);
                }
                None => effect.add_damping_force(Level { v: &v_n, ..before.level() }, out),
            });
            solver.constraint_impulse(b, v, p);
        } else {
            book.explicit();
            p.copy_from_slice(&momentum_between(system, v, free_velocity));
        }
        book.impulse(constraints, p);
        book.finish(constraints, v, after)
    }
}

impl LeapfrogWorkspace {
    /// The ledger of the last step, which must be undivided. With forces by the trapezoidal rule
    /// and `w = v½`, inertia is `½‖v_{n+1} − v½‖²_M − ½‖v½ − v_n‖²_M`. Leapfrog's conserved energy
    /// differs from the true one by these terms at either end.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let zeros = || vec![Vec3::zeros(); system.len()];
        let (half, v_n) = (0.5 * h.seconds(), as_stepped(system, before, h));
        let (mut force, mut damping_force) = (zeros(), zeros());
        for effect in system.effects() {
            effect.add_force(system.mass(), &before.x, &mut force);
            effect.add_damping_force(Level { v: &v_n, ..before.level() }, &mut damping_force);
        }
        let mut free = v_n.clone();
        kick(system, half, &force, &mut free);
        if let Some([early, _]) = &self.explicit {
            damping_force.copy_from_slice(&early.damping);
        }
        kick(system, half, &damping_force, &mut free);
        let mut w = free.clone();
        self.constraints.impose(&mut w); // v½
        let ended = if self.contacts.is_empty() { &after.v } else { &self.unsettled };
        let mut book = Bookkeeping::new(system, before, h, &w, None);
        let x = book.end().to_vec();
        book.forces(|effect, out| {
            effect.add_force(system.mass(), &before.x, out);
            effect.add_force(system.mass(), &x, out);
            out.iter_mut().for_each(|f| *f *= 0.5);
        });
        let mut p = zeros();
        if let Some(Damping { solver, force: remainder, right_hand_side: b }) = &self.damping {
            for effect in system.effects() {
                subtract_laplacian(effect, |_, c| c, ended, &mut damping_force);
            }
            for (f, remainder) in damping_force.iter_mut().zip(remainder) {
                *f = (*f + remainder) * 0.5;
            }
            solver.constraint_impulse(b, ended, &mut p); // (M + h/2 L_c) v_{n+1} − b
        } else {
            for (i, m) in system.mass().iter().enumerate() {
                p[i] = (ended[i] - w[i]) * *m - self.kept.force()[i] * half;
            }
        }
        if let Some([_, late]) = &self.explicit {
            for (i, late) in late.damping.iter().enumerate() {
                p[i] -= late * half;
                damping_force[i] = (damping_force[i] + late) * 0.5;
            }
        }
        book.damping_force(&damping_force);
        book.impulse(&self.pins, &p);
        // The impulse of contacts on v½, and their cut at the end.
        let mut contact = momentum_between(system, &w, &free);
        let cut = momentum_between(system, &after.v, ended);
        contact.iter_mut().zip(cut).for_each(|(p, cut)| *p += cut);
        book.impulse(&self.constraints, &contact);
        book.finish(&self.constraints, &after.v, after)
    }
}
