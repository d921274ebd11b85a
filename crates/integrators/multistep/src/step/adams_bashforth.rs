//! The step of Adams–Bashforth.

use crate::settings::{ADAMS_BASHFORTH2, ADAMS_RATIOS, AdamsBashforthSettings, Steps};
use crate::workspace::AdamsWorkspace;
use drape_integrator::{
    Integrator, Method, Phase, PhaseClock, PrepareError, Scratch, StepError, StepReport, TimeStep,
    drift,
};
use drape_model::{State, System};

/// Adams–Bashforth of one to three steps.
#[derive(Debug, Default)]
pub struct AdamsBashforth {
    settings: AdamsBashforthSettings,
    scratch: Scratch<AdamsWorkspace>,
}

impl AdamsBashforth {
    /// The method with its settings.
    pub fn new(settings: AdamsBashforthSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }
}

impl Integrator for AdamsBashforth {
    fn method(&self) -> &'static Method {
        &ADAMS_BASHFORTH2
    }

    fn prepare(&mut self, system: &System, _h: TimeStep) -> Result<(), PrepareError> {
        ADAMS_BASHFORTH2.check(system)?;
        self.scratch.set(system, AdamsWorkspace::new(system, self.settings.steps));
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
        w.history.refresh(system, h, ADAMS_RATIOS);
        let mut report = StepReport { force_evaluations: 1, ..StepReport::default() };
        w.accelerate(system, state); // a_n = M⁻¹ f(x_n, v_n)
        if self.settings.steps != Steps::One && w.history.is_empty() {
            w.start(system, state, h);
            report.force_evaluations += 1;
        } else {
            w.extrapolate(state, h);
        }
        clock.switch(Phase::Contact);
        w.meet_obstacles(system, state, h);
        clock.switch(Phase::Update);
        drift(h, &w.velocity, &mut state.x); // x_{n+1} = x_n + h Σ β_j v_{n−j}, EEH (2)
        drift(h, &w.lead, &mut state.x);
        w.settle(state, h);
        drift(h, &w.mean_acceleration, &mut state.v); // v_{n+1} = v_n + h Σ β_j a_{n−j}, EEH (2)
        w.contacts.stop(&mut state.v);
        state.t += h;
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.restart();
        }
    }
}
