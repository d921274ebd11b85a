//! The step.

use crate::settings::{PROVOT, ProvotSettings, VelocityUpdate};
use drape_integrator::{
    ElongationLimit, EnergyLedger, ImpulsiveContacts, Method, Phase, PhaseClock, PrepareError,
    Registration, Scheme, StepError, StepReport, Stepper, Taken, drift, kick,
};
use drape_model::{State, System, Vec3};

/// Symplectic Euler with a limit on the elongation of springs.
pub type Provot = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&PROVOT);

/// Memory of a step.
#[derive(Debug)]
pub struct Workspace {
    force: Vec<Vec3>,
    pub(crate) contacts: ImpulsiveContacts,
    limit: ElongationLimit,
}

impl Scheme for Workspace {
    type Settings = ProvotSettings;

    fn method(_settings: &ProvotSettings) -> &'static Method {
        &PROVOT
    }

    fn new(system: &System, settings: &ProvotSettings, _h: f64) -> Result<Self, PrepareError> {
        Ok(Self {
            force: vec![Vec3::zeros(); system.len()],
            contacts: ImpulsiveContacts::new(system),
            limit: ElongationLimit::new(system, settings.elongation),
        })
    }

    fn step(
        &mut self,
        settings: &ProvotSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Self { force, contacts, limit } = self;
        clock.switch(Phase::Forces);
        system.forces(state.level(), force);
        contacts.free_velocity.copy_from_slice(&state.v);
        kick(system, h, force, &mut contacts.free_velocity); // v = v_n + h M⁻¹ f(x_n, v_n), (P1)
        contacts.constrain(system, h, state, clock);
        drift(system, h, &state.v, &mut state.x); // x = x_n + h v, (P2)
        contacts.settle(h, state);
        clock.switch(Phase::Solve);
        let mut report = StepReport { force_evaluations: 1, ..StepReport::default() };
        let State { x, v, .. } = state;
        let corrected = match settings.velocity {
            VelocityUpdate::Corrected => Some(&mut v[..]), // v_{n+1} = (x_{n+1} − x_n)/h, (P4)
            VelocityUpdate::PositionsOnly => None,
        };
        // A spring with L > (1 + τ_c) ℓ is shortened to (1 + τ_c) ℓ, one after the other, (P3)
        report.correction = limit.correct(system, h, x, corrected);
        if report.correction > 0.0 {
            contacts.stop(v);
        }
        Ok(report)
    }

    fn restart(&mut self) {
        self.contacts.restart();
    }

    fn ledger(&mut self, _settings: &ProvotSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(_settings: &ProvotSettings) -> bool {
        true
    }

    /// Each spring is shortened from where the one before left its ends.
    fn follows_springs(_settings: &ProvotSettings) -> bool {
        true
    }
}

#[cfg(test)]
mod tests;
