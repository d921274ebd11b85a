//! The step.

use crate::settings::{BACKWARD_EULER, BackwardEulerSettings};
use crate::workspace::Workspace;
use drape_integrator::{
    Adaptive, ContactSet, EnergyLedger, Integrator, Method, Phase, PhaseClock, Predictor,
    PrepareError, Rewind, Scratch, Stage, StepError, StepReport, TimeStep,
};
use drape_model::{State, System};
use drape_solvers::bands::bands;

/// Backward Euler with Newton's method.
#[derive(Debug)]
pub struct BackwardEuler {
    settings: BackwardEulerSettings,
    scratch: Scratch<Workspace>,
}

impl BackwardEuler {
    /// The method with its settings.
    pub fn new(settings: BackwardEulerSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }

    /// The method, under step size control where the settings ask for it.
    pub fn controlled(settings: BackwardEulerSettings) -> Box<dyn Integrator> {
        Adaptive::boxed(Self::new(settings), settings.tolerance)
    }
}

impl Integrator for BackwardEuler {
    fn method(&self) -> &'static Method {
        &BACKWARD_EULER
    }

    fn prepare(&mut self, system: &System, _h: TimeStep) -> Result<(), PrepareError> {
        BACKWARD_EULER.check(system)?;
        self.scratch.set(system, Workspace::new(system, self.settings.stage.linear)?);
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
        let mut report = StepReport::default();
        let bands = bands(system.threads(), system.len());
        w.predictor.extrapolate(&state.v, h, bands, &mut w.extrapolated);
        let Workspace { stage, extrapolated, predictor, contacts, constraints } = w;
        let from = (&state.x[..], &state.v[..]);
        let (end, lagged) = (state.t + h, state.level());
        let input = Stage { tau: h, end, from, lagged, velocity: &state.v };
        let settings = self.settings.stage;
        // M (v_{n+1} − v_n) = h f(x_n + h v_{n+1}, v_{n+1})
        stage.solve(
            system,
            input,
            extrapolated,
            contacts,
            constraints,
            settings,
            clock,
            &mut report,
        )?;
        clock.switch(Phase::Update);
        predictor.remember(&state.v, h);
        state.v.copy_from_slice(stage.velocity());
        state.x.copy_from_slice(stage.positions()); // x_{n+1} = x_n + h v_{n+1}
        contacts.settle(&mut state.v, |c| predictor.forget(c.particle, c.velocity));
        state.t += h;
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.predictor.restart();
            w.contacts.restart();
            w.stage.restart();
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

impl Rewind for BackwardEuler {
    type Past = (Predictor, ContactSet);

    fn new_past(&self) -> Option<Self::Past> {
        self.scratch.get().map(|w| (w.predictor.clone(), w.contacts.clone()))
    }

    fn keep(&self, (predictor, contacts): &mut Self::Past) {
        if let Some(w) = self.scratch.get() {
            predictor.copy_from(&w.predictor);
            contacts.copy_from(&w.contacts);
        }
    }

    fn recall(&mut self, (predictor, contacts): &Self::Past) {
        if let Some(w) = self.scratch.get_mut() {
            w.predictor.copy_from(predictor);
            w.contacts.copy_from(contacts);
        }
    }

    fn contacts(&self) -> Option<&ContactSet> {
        self.scratch.get().map(|w| &w.contacts)
    }
}
