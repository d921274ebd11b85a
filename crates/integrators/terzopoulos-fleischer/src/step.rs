//! The step.

use crate::secant::SecantSystem;
use crate::settings::{TERZOPOULOS_FLEISCHER, TerzopoulosFleischerSettings};
use drape_integrator::{
    EnergyLedger, ImpulsiveContacts, Method, Phase, PhaseClock, PrepareError, Registration, Scheme,
    SetupCause, SolveStatus, StepError, StepReport, Stepper, Taken, drift,
};
use drape_model::{State, System};

/// Terzopoulos and Fleischer's semi-implicit step.
pub type TerzopoulosFleischer = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&TERZOPOULOS_FLEISCHER);

/// Memory of a step.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) secant: SecantSystem,
    /// Why the next step sets the matrix up.
    cause: SetupCause,
    pub(crate) contacts: ImpulsiveContacts,
}

impl Scheme for Workspace {
    type Settings = TerzopoulosFleischerSettings;

    fn method(_settings: &TerzopoulosFleischerSettings) -> &'static Method {
        &TERZOPOULOS_FLEISCHER
    }

    fn new(
        system: &System,
        settings: &TerzopoulosFleischerSettings,
        _h: f64,
    ) -> Result<Self, PrepareError> {
        Ok(Self {
            secant: SecantSystem::new(system, settings.clamp)?,
            cause: SetupCause::First,
            contacts: ImpulsiveContacts::new(system),
        })
    }

    fn step(
        &mut self,
        _settings: &TerzopoulosFleischerSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Self { secant, cause, contacts } = self;
        clock.switch(Phase::MatrixSetup);
        let cause = std::mem::replace(cause, SetupCause::EveryStep);
        let mut report = StepReport::after_setup(Some(cause));
        // A = M + h² K(x_n) + ½ h C, b = (M − ½ h C) v_n + h (f_ext − K(x_n) x_n), (T2)
        secant.assemble(system, state, h);
        secant.factorise()?;
        report.force_evaluations = 1;
        report.factorisations = 1;
        clock.switch(Phase::Solve);
        let v = &mut contacts.free_velocity;
        report.relative_residual = secant.solve(system, &state.v, v); // A v_{n+1} = b, (T2)
        report.matvecs = 1;
        if secant.is_indefinite() {
            report.solve = SolveStatus::Indefinite;
        }
        contacts.constrain(system, h, state, clock);
        drift(system, h, &state.v, &mut state.x); // x_{n+1} = x_n + h v_{n+1}, (T3)
        contacts.settle(h, state);
        Ok(report)
    }

    fn restart(&mut self) {
        self.contacts.restart();
    }

    fn ledger(
        &mut self,
        _settings: &TerzopoulosFleischerSettings,
        taken: &Taken<'_>,
    ) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(_settings: &TerzopoulosFleischerSettings) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::{SpringEffect, Vec3};
    use drape_oracle::Run;
    use drape_oracle::scenes::{anchored, build};

    /// The secant of a spring at half its length is −k.
    #[test]
    fn a_matrix_that_is_not_positive_definite_is_told() {
        for (h, solve) in [(0.01, SolveStatus::Indefinite), (1e-4, SolveStatus::Converged)] {
            let springs = [(SpringEffect::Tension, 2.0, 1e5, 0.0)];
            let spec = anchored(1.0, &springs, Vec3::x(), Vec3::zeros());
            let settings = TerzopoulosFleischerSettings { clamp: false };
            let mut run = Run::new(Box::new(TerzopoulosFleischer::new(settings)), build(&spec), h);
            assert_eq!(run.step().solve, solve, "{h}");
        }
    }
}
