//! The step.

use crate::settings::{DESBRUN, DesbrunSettings, Inverse, Torque};
use crate::torque::{correct, damping_force};
use crate::workspace::Workspace;
use drape_integrator::{
    EnergyLedger, Integrator, Method, Phase, PhaseClock, PrepareError, Scratch, StepError,
    StepReport, TimeStep, kick,
};
use drape_model::{State, System};

/// Desbrun, Schröder and Barr's precomputed inverse.
#[derive(Debug)]
pub struct Desbrun {
    settings: DesbrunSettings,
    scratch: Scratch<Workspace>,
}

impl Desbrun {
    /// The method with its settings.
    pub fn new(settings: DesbrunSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }
}

impl Integrator for Desbrun {
    fn method(&self) -> &'static Method {
        &DESBRUN
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        DESBRUN.check(system)?;
        self.scratch.set(system, Workspace::new(system, &self.settings, h.seconds())?);
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
        clock.switch(Phase::MatrixSetup);
        let mut report = StepReport::after_setup(w.linear.refresh(system, h)?); // A⁻¹, if it is not there
        clock.switch(Phase::Forces);
        w.viscous.assemble(&mut w.linear, system, state, h); // h F̃
        report.force_evaluations = 1;
        clock.switch(Phase::Solve);
        w.linear.apply_preconditioner(w.viscous.impulse(), &mut w.change); // Δv = h M⁻¹ F_filtered
        report.matvecs = if self.settings.inverse == Inverse::Cholesky { 1 } else { 2 };
        let v = &mut w.contacts.free_velocity;
        v.copy_from_slice(&state.v);
        v.iter_mut().zip(&w.change).for_each(|(v, change)| *v += change);
        if self.settings.torque == Torque::Consistent {
            damping_force(system, state.level(), &mut w.damping);
        }
        correct(self.settings.torque, system, h, &state.x, &w.change, &w.damping, v);
        kick(system, h, w.viscous.external(), v); // v_n + h M⁻¹ (F_filtered + F_corr + f_external)
        w.contacts.advance(system, h, state, clock); // x_{n+1} = x_n + h v_{n+1}
        if let Some(elongation) = &mut w.elongation {
            let State { x, v, .. } = state;
            report.correction = elongation.correct(system, h, x, Some(v)); // v = (x_{n+1} − x_n)/h
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
        Some(self.scratch.get_mut()?.ledger(system, before, after, h, &self.settings))
    }
}
