//! Explicit (forward) Euler.

use crate::settings::{EXPLICIT_EULER, ExplicitSettings};
use crate::workspace::EulerMemory;
use drape_integrator::{
    EnergyLedger, Method, Phase, PhaseClock, PrepareError, Registration, Scheme, StepError,
    StepReport, Stepper, Taken, drift, kick,
};
use drape_model::{State, System};

/// Explicit (forward) Euler.
pub type ExplicitEuler = Stepper<ExplicitWorkspace>;

/// Entry of this method in the registry.
pub static EXPLICIT: Registration = Registration::new::<ExplicitWorkspace>(&EXPLICIT_EULER);

/// Memory of a step.
#[derive(Debug)]
pub struct ExplicitWorkspace(pub(crate) EulerMemory);

impl Scheme for ExplicitWorkspace {
    type Settings = ExplicitSettings;

    fn method(_settings: &ExplicitSettings) -> &'static Method {
        &EXPLICIT_EULER
    }

    fn new(system: &System, _settings: &ExplicitSettings, _h: f64) -> Result<Self, PrepareError> {
        Ok(Self(EulerMemory::new(system)))
    }

    fn step(
        &mut self,
        _settings: &ExplicitSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let EulerMemory { force, free_velocity, velocity, impulse, contacts, constraints } =
            &mut self.0;
        clock.switch(Phase::Forces);
        system.forces(state.level(), force); // f(x_n, v_n)
        clock.switch(Phase::Contact);
        let end = state.t + h;
        contacts.detect(system, &state.x, &state.v, (h, end), constraints);
        let ahead = |i: usize| state.v[i] + force[i] * (h / system.mass()[i]);
        contacts.hold_gaps(system, &state.v, ahead, constraints);
        free_velocity.copy_from_slice(&state.v);
        contacts.project(system, constraints, free_velocity, velocity, impulse);
        clock.switch(Phase::Update);
        drift(system, h, velocity, &mut state.x); // x_{n+1} = x_n + h v_n, EEH (2)
        state.v.copy_from_slice(velocity);
        contacts.settle(&mut state.v, |_| ());
        kick(system, h, force, &mut state.v); // v_{n+1} = v_n + h M⁻¹ f(x_n, v_n), EEH (2)
        contacts.stop(&mut state.v);
        for i in system.pins().iter().map(|&i| i as usize) {
            state.v[i] = constraints.prescribed(i);
        }
        state.t += h;
        Ok(StepReport { force_evaluations: 1, ..StepReport::default() })
    }

    fn restart(&mut self) {
        self.0.contacts.restart();
    }

    fn ledger(&mut self, _settings: &ExplicitSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(_settings: &ExplicitSettings) -> bool {
        true
    }
}
