//! What a step of order 1 did to the energy.

use crate::workspace::Workspace;
use drape_integrator::{Bookkeeping, EnergyLedger, Split, TimeStep, as_stepped};
use drape_model::{State, System, Vec3};

impl Workspace {
    /// The ledger of the last step of IMEX Euler: `−L_k` at its end, `F2` at its start.
    pub(crate) fn plain_ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> EnergyLedger {
        if self.contacts.is_empty() {
            self.velocity.copy_from_slice(&after.v); // the step left another vector in its place
        }
        let v_n = as_stepped(system, before, h);
        self.ledger(system, before, after, h, (&before.x, &v_n))
    }

    /// The ledger of the last step of updated CG: `F2` where `b` took it last. Where Newton's method ended the step, `b` was not
    /// what it solved with: the equation is that of an update at its end, backward Euler's.
    pub(crate) fn updated_ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> EnergyLedger {
        if self.descent.as_ref().is_some_and(|descent| descent.by_newton()) {
            let slopes = self.linear.slopes();
            self.rhs.update(system, before, h.seconds(), &self.velocity, slopes);
        }
        let updated_at = self.rhs.positions().to_vec();
        let velocity = |(x, x_n): (&Vec3, &Vec3)| (x - x_n) / h.seconds();
        let v: Vec<_> = updated_at.iter().zip(&before.x).map(velocity).collect();
        self.ledger(system, before, after, h, (&updated_at, &v))
    }

    /// With the nonlinear forces at `(x̂, v̂)`.
    fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
        at: (&[Vec3], &[Vec3]),
    ) -> EnergyLedger {
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
