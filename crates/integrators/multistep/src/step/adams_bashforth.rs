//! The step of Adams–Bashforth.

use crate::coefficients::LinearMultistep;
use crate::settings::{ADAMS_BASHFORTH2, ADAMS_RATIOS, AdamsBashforthSettings, Steps};
use crate::workspace::{ACCELERATION, AdamsWorkspace, OLD_VELOCITY, step_sizes};
use drape_integrator::{
    Change, Method, Phase, PhaseClock, PrepareError, Registration, Scheme, StepError, StepReport,
    Stepper, drift,
};
use drape_model::{Level, State, System, Vec3};

/// Adams–Bashforth of one to three steps, EEH (2).
pub type AdamsBashforth = Stepper<AdamsWorkspace>;

/// Entry of this method in the registry.
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

    #[doc(alias = "EEH 2")]
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
        let Self { history, acceleration: a, mean_acceleration: mean, lead, predicted, .. } = self;
        accelerations(system, state.level(), a); // a_n = M⁻¹ f(x_n, v_n)
        if settings.steps != Steps::One && history.is_empty() {
            // Heun's method, (H), needs no past.
            let (x, v) = predicted;
            x.copy_from_slice(&state.x);
            drift(system, h, &state.v, x); // x̃ = x_n + h v_n
            v.copy_from_slice(&state.v);
            drift(system, h, a, v); // ṽ = v_n + h a_n
            accelerations(system, Level { t: state.t + h, x, v }, mean); // ã = M⁻¹ f(x̃, ṽ)
            for i in 0..state.len() {
                mean[i] = (mean[i] + a[i]) * 0.5; // ½ (a_n + ã)
                lead[i] = a[i] * (0.5 * h); // ½ (v_n + ṽ) − v_n
            }
            report.force_evaluations += 1;
        } else {
            let (steps, k) = step_sizes(history, h);
            let formula = LinearMultistep::adams_bashforth(&steps[..k]); // β_j of EEH (2)
            let beta = &formula.beta()[..k];
            history.mean(OLD_VELOCITY, &state.v, beta, lead); // Σ β_j v_{n−j} …
            lead.iter_mut().zip(&state.v).for_each(|(lead, v)| *lead -= v); // … − v_n
            history.mean(ACCELERATION, a, beta, mean); // Σ β_j a_{n−j}
        }
        clock.switch(Phase::Contact);
        self.meet_obstacles(system, state, h);
        clock.switch(Phase::Update);
        drift(system, h, &self.velocity, &mut state.x); // x_{n+1} = x_n + h v_n …
        drift(system, h, &self.lead, &mut state.x); // … + h (Σ β_j v_{n−j} − v_n), EEH (2)
        self.remember(h);
        state.v.copy_from_slice(&self.velocity);
        drift(system, h, &self.mean_acceleration, &mut state.v); // v_{n+1} = v_n + h Σ β_j a_{n−j}, EEH (2)
        self.contacts.stop(&mut state.v);
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
    /// Writes `v_n` under pins and contacts to `velocity`: an impact is a jump of `v_n`. Contacts
    /// that would pull at the end of the step are released. A particle that stays in contact has no
    /// lead along the normals.
    fn meet_obstacles(&mut self, system: &System, state: &State, h: f64) {
        let Self { contacts, constraints, free_velocity, velocity, impulse, .. } = self;
        contacts.detect(system, &state.x, &state.v, (h, state.t + h), constraints);
        free_velocity.copy_from_slice(&state.v);
        drift(system, h, &self.mean_acceleration, free_velocity);
        contacts.hold_gaps(system, &state.v, |i| free_velocity[i], constraints);
        contacts.project(system, constraints, free_velocity, velocity, impulse);
        contacts.strike(system, constraints, &state.v, velocity);
        contacts.support(h, &mut self.lead);
        for pin in system.moving_pins() {
            self.lead[pin.particle] = Vec3::zeros();
        }
    }

    /// Pushes level `n` to the history. A particle whose contact changed gets a past of constant
    /// acceleration.
    fn remember(&mut self, h: f64) {
        let Self { contacts, velocity, acceleration: a, history, .. } = self;
        history.push(h, [velocity, a]);
        contacts.settle(velocity, |Change { particle: i, velocity: v, .. }| {
            history.rewrite(i, |age| [v - a[i] * (age - h), a[i]]);
        });
    }
}
