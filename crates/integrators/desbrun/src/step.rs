//! The step.

use crate::settings::{DESBRUN, DesbrunSettings};
use crate::torque::correct;
use crate::workspace::Workspace;
use drape_integrator::{
    Integrator, Method, Phase, PhaseClock, PrepareError, Scratch, StepError, StepReport, TimeStep,
    drift, kick,
};
use drape_model::{State, System, Vec3};

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
        let w = self.scratch.ready(system, state)?;
        let h = h.seconds();
        clock.switch(Phase::MatrixSetup);
        let mut report = StepReport::after_setup(w.linear.refresh(system, h)?); // A⁻¹, if it is not there
        clock.switch(Phase::Forces);
        w.viscous.assemble(&w.linear, system, state, h); // h F̃
        report.force_evaluations = 1;
        clock.switch(Phase::Solve);
        w.linear.apply_preconditioner(w.viscous.impulse(), &mut w.change); // Δv = h M⁻¹ F_filtered
        report.matvecs = 2;
        for i in 0..state.len() {
            let change = if system.pinned()[i] { Vec3::zeros() } else { w.change[i] };
            w.free_velocity[i] = state.v[i] + change;
        }
        correct(self.settings.torque, system, h, &state.x, &w.change, &mut w.free_velocity);
        clock.switch(Phase::Contact);
        kick(system, h, w.viscous.external(), &mut w.free_velocity); // v + h M⁻¹ (F_filtered + f_external)
        w.contacts.detect(system, &state.x, &state.v, h, &mut w.constraints);
        let Workspace { free_velocity, velocity, impulse, contacts, constraints, .. } = w;
        contacts.project(system, constraints, free_velocity, velocity, impulse);
        clock.switch(Phase::Update);
        state.v.copy_from_slice(velocity);
        drift(h, &state.v, &mut state.x); // x_{n+1} = x_n + h v_{n+1}
        contacts.settle(&mut state.v, |_, _| ());
        if let Some(elongation) = &mut w.elongation {
            let State { x, v, .. } = state;
            report.correction = elongation.correct(system, h, x, Some(v)); // v = (x_{n+1} − x_n)/h
        }
        state.t += h;
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.contacts.restart();
        }
    }
}
