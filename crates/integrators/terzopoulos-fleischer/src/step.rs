//! The step.

use crate::settings::{TERZOPOULOS_FLEISCHER, TerzopoulosFleischerSettings};
use crate::workspace::Workspace;
use drape_integrator::{
    EnergyLedger, Integrator, Method, Phase, PhaseClock, PrepareError, Scratch, SetupCause,
    SolveStatus, StepError, StepReport, TimeStep,
};
use drape_model::{State, System};

/// Terzopoulos and Fleischer's semi-implicit step.
#[derive(Debug)]
pub struct TerzopoulosFleischer {
    settings: TerzopoulosFleischerSettings,
    scratch: Scratch<Workspace>,
}

impl TerzopoulosFleischer {
    /// The method with its settings.
    pub fn new(settings: TerzopoulosFleischerSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }
}

impl Integrator for TerzopoulosFleischer {
    fn method(&self) -> &'static Method {
        &TERZOPOULOS_FLEISCHER
    }

    fn prepare(&mut self, system: &System, _h: TimeStep) -> Result<(), PrepareError> {
        TERZOPOULOS_FLEISCHER.check(system)?;
        self.scratch.set(system, Workspace::new(system, self.settings.clamp)?);
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
        let cause = std::mem::replace(&mut w.cause, SetupCause::EveryStep);
        let mut report = StepReport::after_setup(Some(cause));
        w.secant.assemble(system, state, h); // A = M + h² K(x_n) + ½ h C, and b
        w.secant.factorise()?;
        report.force_evaluations = 1;
        report.factorisations = 1;
        clock.switch(Phase::Solve);
        report.relative_residual = w.secant.solve(system, &state.v, &mut w.contacts.free_velocity); // A v_{n+1} = b
        report.matvecs = 1;
        if w.secant.is_indefinite() {
            report.solve = SolveStatus::Indefinite;
        }
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
