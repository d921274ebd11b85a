//! The step of Adams–Bashforth.

use crate::coefficients::LinearMultistep;
use crate::settings::{ADAMS_BASHFORTH2, ADAMS_RATIOS, AdamsBashforthSettings, Steps};
use crate::workspace::{ACCELERATION, AdamsWorkspace, OLD_VELOCITY, step_sizes};
use drape_integrator::{
    Change, Method, Phase, PhaseClock, PrepareError, Registration, Scheme, StepError, StepReport,
    Stepper, drift,
};
use drape_model::{Level, State, System, Vec3};

/// Adams–Bashforth of one to three steps.
pub type AdamsBashforth = Stepper<AdamsWorkspace>;

/// For the registry.
pub static EXPLICIT_ADAMS: Registration = Registration::new::<AdamsWorkspace>(&ADAMS_BASHFORTH2);

/// `a = M⁻¹ f(t, x, v)`, 0 where pinned.
fn accelerations(system: &System, at: Level<'_>, a: &mut [Vec3]) {
    system.forces(at, a);
    for (i, a) in a.iter_mut().enumerate() {
        *a = if system.pinned()[i] { Vec3::zeros() } else { *a / system.mass()[i] };
    }
}

impl Scheme for AdamsWorkspace {
    type Settings = AdamsBashforthSettings;

    fn method(_settings: &AdamsBashforthSettings) -> &'static Method {
        &ADAMS_BASHFORTH2
    }

    fn new(
        system: &System,
        settings: &AdamsBashforthSettings,
        _h: f64,
    ) -> Result<Self, PrepareError> {
        Ok(Self::allocate(system, settings.steps))
    }

    fn step(
        &mut self,
        settings: &AdamsBashforthSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        clock.switch(Phase::Forces);
        self.history.refresh(system, h, ADAMS_RATIOS);
        let mut report = StepReport { force_evaluations: 1, ..StepReport::default() };
        accelerations(system, state.level(), &mut self.acceleration); // a_n = M⁻¹ f(x_n, v_n)
        if settings.steps != Steps::One && self.history.is_empty() {
            self.start(system, state, h);
            report.force_evaluations += 1;
        } else {
            self.extrapolate(state, h);
        }
        clock.switch(Phase::Contact);
        self.meet_obstacles(system, state, h);
        clock.switch(Phase::Update);
        drift(h, &self.velocity, &mut state.x); // x_{n+1} = x_n + h Σ β_j v_{n−j}, EEH (2)
        drift(h, &self.lead, &mut state.x);
        let Self { contacts, velocity, acceleration: a, history, mean_acceleration, .. } = self;
        history.push(h, [velocity, a]);
        // A particle whose contact changed starts anew, with a past of constant acceleration.
        contacts.settle(velocity, |Change { particle: i, velocity: v, .. }| {
            history.rewrite(i, |age| [v - a[i] * (age - h), a[i]]);
        });
        state.v.copy_from_slice(velocity);
        drift(h, mean_acceleration, &mut state.v); // v_{n+1} = v_n + h Σ β_j a_{n−j}, EEH (2)
        contacts.stop(&mut state.v);
        state.t += h;
        Ok(report)
    }

    fn restart(&mut self) {
        self.history.restart();
        self.contacts.restart();
    }

    fn is_portable(_settings: &AdamsBashforthSettings) -> bool {
        true
    }
}

impl AdamsWorkspace {
    /// EEH (2): the means of velocities and accelerations over as many levels as are known.
    fn extrapolate(&mut self, state: &State, h: f64) {
        let (steps, k) = step_sizes(&self.history, h);
        let formula = LinearMultistep::adams_bashforth(&steps[..k]);
        let beta = &formula.beta()[..k];
        self.history.mean(OLD_VELOCITY, &state.v, beta, &mut self.lead); // Σ β_j v_{n−j}
        self.lead.iter_mut().zip(&state.v).for_each(|(lead, v)| *lead -= v);
        self.history.mean(ACCELERATION, &self.acceleration, beta, &mut self.mean_acceleration); // Σ β_j a_{n−j}
    }

    /// The same by Heun's method (the explicit trapezoidal rule), which needs no past.
    fn start(&mut self, system: &System, state: &State, h: f64) {
        let Self { acceleration: a, mean_acceleration: mean, predicted: (x, v), .. } = self;
        x.copy_from_slice(&state.x);
        drift(h, &state.v, x); // x̃ = x_n + h v_n
        v.copy_from_slice(&state.v);
        drift(h, a, v); // ṽ = v_n + h a_n
        accelerations(system, Level { t: state.t + h, x, v }, mean);
        for i in 0..state.len() {
            mean[i] = (mean[i] + a[i]) * 0.5; // ½ (a_n + ã)
            self.lead[i] = a[i] * (0.5 * h); // ½ (v_n + ṽ) − v_n
        }
    }

    /// `velocity` from `v_n`, pins and contacts: an impact is a jump of `v_n`. Contacts that would pull at the
    /// end of the step are released; a particle that stays in contact has no lead along the normals.
    fn meet_obstacles(&mut self, system: &System, state: &State, h: f64) {
        let Self { contacts, constraints, free_velocity, velocity, impulse, .. } = self;
        contacts.detect(system, &state.x, &state.v, (h, state.t + h), constraints);
        free_velocity.copy_from_slice(&state.v);
        drift(h, &self.mean_acceleration, free_velocity);
        contacts.project(system, constraints, free_velocity, velocity, impulse);
        contacts.strike(system, constraints, &state.v, velocity);
        contacts.support(h, &mut self.lead);
        for pin in system.moving_pins() {
            self.lead[pin.particle] = Vec3::zeros();
        }
    }
}
