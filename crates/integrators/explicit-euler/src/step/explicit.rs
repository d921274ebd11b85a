//! Explicit (forward) Euler.

use crate::settings::EXPLICIT_EULER;
use crate::workspace::EulerWorkspace;
use drape_integrator::{
    EnergyLedger, Integrator, Method, Phase, PhaseClock, PrepareError, Scratch, StepError,
    StepReport, TimeStep, drift, kick,
};
use drape_model::{State, System};

/// Explicit (forward) Euler.
#[derive(Debug, Default)]
pub struct ExplicitEuler {
    scratch: Scratch<EulerWorkspace>,
}

impl Integrator for ExplicitEuler {
    fn method(&self) -> &'static Method {
        &EXPLICIT_EULER
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        EXPLICIT_EULER.check(system)?;
        self.scratch.set(system, EulerWorkspace::new(system, false, h.seconds())?);
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
        clock.switch(Phase::Contact);
        let end = state.t + h;
        w.contacts.detect(system, &state.x, &state.v, (h, end), &mut w.constraints);
        w.free_velocity.copy_from_slice(&state.v);
        w.project(system);
        clock.switch(Phase::Update);
        drift(h, &w.velocity, &mut state.x); // x_{n+1} = x_n + h v_n
        state.v.copy_from_slice(&w.velocity);
        w.contacts.settle(&mut state.v, |_| ());
        kick(system, h, &w.force, &mut state.v); // v_{n+1} = v_n + h M⁻¹ f_n
        w.contacts.stop(&mut state.v);
        for i in system.pins().iter().map(|&i| i as usize) {
            state.v[i] = w.constraints.prescribed(i);
        }
        state.t += h;
        clock.stop();
        Ok(StepReport { force_evaluations: 1, ..StepReport::default() })
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
        Some(self.scratch.get_mut()?.explicit_ledger(system, before, after, h))
    }
}
