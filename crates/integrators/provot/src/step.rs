//! The step.

use crate::settings::{PROVOT, ProvotSettings, VelocityUpdate};
use crate::workspace::Workspace;
use drape_integrator::{
    EnergyLedger, Integrator, Method, Phase, PhaseClock, PrepareError, Scratch, StepError,
    StepReport, TimeStep, kick,
};
use drape_model::{State, System};

/// Symplectic Euler, then a limit on the elongation of springs.
#[derive(Debug, Default)]
pub struct Provot {
    settings: ProvotSettings,
    scratch: Scratch<Workspace>,
}

impl Provot {
    /// The method with its settings.
    pub fn new(settings: ProvotSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }
}

impl Integrator for Provot {
    fn method(&self) -> &'static Method {
        &PROVOT
    }

    fn prepare(&mut self, system: &System, _h: TimeStep) -> Result<(), PrepareError> {
        PROVOT.check(system)?;
        self.scratch.set(system, Workspace::new(system, self.settings));
        Ok(())
    }

    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let w = self.scratch.ready(system, state, h)?;
        let h = h.seconds();
        clock.switch(Phase::Forces);
        system.forces(state.level(), &mut w.force);
        w.contacts.free_velocity.copy_from_slice(&state.v);
        kick(system, h, &w.force, &mut w.contacts.free_velocity); // v = v_n + h M⁻¹ f(x_n, v_n)
        w.contacts.advance(system, h, state, clock); // x = x_n + h v
        clock.switch(Phase::Solve);
        let mut report = StepReport { force_evaluations: 1, ..StepReport::default() };
        let State { x, v, .. } = state;
        let along = (self.settings.velocity == VelocityUpdate::Corrected).then_some(&mut v[..]);
        report.correction = w.limit.correct(system, h, x, along); // v_{n+1} = (x_{n+1} − x_n)/h
        if report.correction > 0.0 {
            w.contacts.stop(v);
        }
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.contacts.restart();
        }
    }

    fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> Option<EnergyLedger> {
        Some(self.scratch.get_mut()?.ledger(system, before, after, h))
    }
}

#[cfg(test)]
#[path = "step_tests.rs"]
mod tests;
