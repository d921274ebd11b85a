//! The step of BDF.

use crate::settings::{BDF2, BdfSettings, Steps};
use crate::workspace::{BdfWorkspace, Obstacles};
use drape_integrator::{
    Adaptive, ContactSet, History, Integrator, Method, Order, Phase, PhaseClock, PrepareError,
    Rewind, Scratch, StepError, StepReport, TimeStep,
};
use drape_model::{State, System};

/// Backward differentiation of one to three steps, with Newton's method.
#[derive(Debug, Default)]
pub struct Bdf {
    settings: BdfSettings,
    scratch: Scratch<BdfWorkspace>,
}

impl Bdf {
    /// The method with its settings.
    pub fn new(settings: BdfSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }

    /// The method, under step size control where the settings ask for it.
    pub fn controlled(settings: BdfSettings) -> Box<dyn Integrator> {
        Adaptive::boxed(Self::new(settings), settings.tolerance)
    }
}

impl Integrator for Bdf {
    fn method(&self) -> &'static Method {
        &BDF2
    }

    fn prepare(&mut self, system: &System, _h: TimeStep) -> Result<(), PrepareError> {
        BDF2.check(system)?;
        self.scratch.set(
            system,
            BdfWorkspace::new(system, self.settings.steps, self.settings.stage.linear)?,
        );
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
        let BdfSettings { steps, stage, .. } = self.settings;
        let mut report = StepReport::default();
        clock.switch(Phase::Update);
        w.history.refresh(system, h, self.settings.ratios());
        let tau = if steps == Steps::Three && w.history.is_empty() {
            w.start(system, state, h, stage, clock, &mut report)?
        } else {
            w.differentiate(state, h) // −γ_n/α_k of EEH (4)
        };
        // M (α_k v_{n+k} + γ_n) = h β_k f(x_{n+k}, v_{n+k}), EEH (4), by the iteration (5)
        w.solve(system, state, (h, tau), Obstacles::Met, stage, clock, &mut report)?;
        clock.switch(Phase::Update);
        w.advance(system, state, h, tau);
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

impl Rewind for Bdf {
    type Past = (History<2>, ContactSet);

    fn new_past(&self) -> Option<Self::Past> {
        self.scratch.get().map(|w| (w.history.clone(), w.contacts.clone()))
    }

    fn keep(&self, (history, contacts): &mut Self::Past) {
        if let Some(w) = self.scratch.get() {
            history.copy_from(&w.history);
            contacts.copy_from(&w.contacts);
        }
    }

    fn recall(&mut self, (history, contacts): &Self::Past) {
        if let Some(w) = self.scratch.get_mut() {
            w.history.copy_from(history);
            w.contacts.copy_from(contacts);
        }
    }

    fn contacts(&self) -> Option<&ContactSet> {
        self.scratch.get().map(|w| &w.contacts)
    }

    fn order(&self) -> Order {
        if self.settings.steps == Steps::One { Order::One } else { Order::Two }
    }
}
