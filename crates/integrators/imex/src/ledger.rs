//! The energy ledger of the methods of order 1.

use crate::step::{EulerWorkspace, UpdatedWorkspace};
use crate::workspace::Memory;
use drape_integrator::{Bookkeeping, EnergyLedger, Split, Taken, as_stepped};
use drape_model::Vec3;

impl EulerWorkspace {
    /// The ledger of the last step of IMEX Euler, with `−L_k x` at its end and `F2` at its start.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        if self.memory.contacts.is_empty() {
            self.memory.velocity.copy_from_slice(&after.v); // the step swapped it away
        }
        let v_n = as_stepped(system, before, h);
        self.memory.energy_ledger(taken, (&before.x, &v_n))
    }
}

impl UpdatedWorkspace {
    /// The ledger of the last step of updated CG, with `F2` where `b` took it last. Where Newton's
    /// method ended the step, `b` is first updated at its end: the equation is then that of
    /// backward Euler.
    pub(crate) fn energy_ledger(&mut self, taken: &Taken<'_>) -> EnergyLedger {
        let Taken { system, before, h, .. } = *taken;
        let Self { memory, descent } = self;
        if descent.as_ref().is_some_and(|descent| descent.by_newton()) {
            let slopes = memory.linear.slopes();
            memory.rhs.update(system, before, h.seconds(), &memory.velocity, slopes);
        }
        let updated_at = memory.rhs.positions().to_vec();
        let velocity = |(x, x_n): (&Vec3, &Vec3)| (x - x_n) / h.seconds();
        let v: Vec<_> = updated_at.iter().zip(&before.x).map(velocity).collect();
        memory.energy_ledger(taken, (&updated_at, &v))
    }
}

impl Memory {
    /// The ledger with the nonlinear forces at `at = (x̂, v̂)`.
    fn energy_ledger(&mut self, taken: &Taken<'_>, at: (&[Vec3], &[Vec3])) -> EnergyLedger {
        let Taken { system, before, after, h } = *taken;
        let Self { rhs, velocity: v, linear, constraints, .. } = self;
        let mut p = vec![Vec3::zeros(); v.len()];
        linear.constraint_impulse(&rhs.b, v, &mut p);
        let mut book = Bookkeeping::new(system, before, h, v, None);
        let split = linear.slopes().map_or(Split::Majorant, |_| Split::Paper);
        book.split_as(split, rhs.implicit(), v, at);
        book.impulse(constraints, &p);
        book.finish(constraints, v, after)
    }
}
