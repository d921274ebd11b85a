//! The step.

use crate::settings::{KANG, KangSettings};
use crate::sweep::sweep;
use crate::workspace::Workspace;
use drape_integrator::{
    EnergyLedger, Integrator, Method, Phase, PhaseClock, PrepareError, Scratch, StepError,
    StepReport, TimeStep, kick,
};
use drape_model::{State, System};

/// Kang's neighbour-corrected sweep.
#[derive(Debug)]
pub struct Kang {
    settings: KangSettings,
    scratch: Scratch<Workspace>,
}

impl Kang {
    /// The method with its settings.
    pub fn new(settings: KangSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }
}

impl Integrator for Kang {
    fn method(&self) -> &'static Method {
        &KANG
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        KANG.check(system)?;
        self.scratch.set(system, Workspace::new(system, h.seconds())?);
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
        let (h, sweeps) = (h.seconds(), self.settings.sweeps);
        clock.switch(Phase::MatrixSetup);
        let mut report = StepReport::after_setup(w.linear.refresh(system, h)?); // D and A = M + h² L_k + h L_c
        clock.switch(Phase::Forces);
        w.viscous.assemble(&mut w.linear, system, state, h); // h F̃
        clock.switch(Phase::Solve);
        let b = w.viscous.impulse();
        report.relative_residual =
            sweep(w.linear.product(), b, system.pinned(), sweeps, &mut w.product, &mut w.change);
        report.force_evaluations = 1;
        report.matvecs = 1 + sweeps;
        for (i, free) in w.contacts.free_velocity.iter_mut().enumerate() {
            *free = state.v[i] + w.change[i];
        }
        kick(system, h, w.viscous.external(), &mut w.contacts.free_velocity); // v_n + Δv + h M⁻¹ f_external
        w.contacts.advance(system, h, state, clock); // x_{n+1} = x_n + h v_{n+1}
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
