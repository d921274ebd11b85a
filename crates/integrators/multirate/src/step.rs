//! The step.

use crate::settings::{MULTIRATE, MultirateSettings};
use drape_integrator::{
    ContactSet, ExplicitKick, KeptForce, Method, MultistepMotion, Phase, PhaseClock, PrepareError,
    Registration, Scheme, StepError, StepReport, Stepper, drift, hold_pins, is_damped, kick,
    lead_pins,
};
use drape_model::{State, System, Vec3};
use drape_solvers::{Constraints, Filter};

/// The impulse method.
#[doc(alias = "r-RESPA")]
pub type Multirate = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&MULTIRATE);

/// Memory of a step.
#[derive(Debug)]
pub struct Workspace {
    slow: KeptForce,
    fast: KeptForce,
    /// The half kicks of a short step; `None` without damping.
    damped: Option<[ExplicitKick; 2]>,
    free_velocity: Vec<Vec3>,
    impulse: Vec<Vec3>,
    contacts: ContactSet,
    constraints: Constraints,
    pins: Constraints,
}

impl Scheme for Workspace {
    type Settings = MultirateSettings;

    fn method(_settings: &MultirateSettings) -> &'static Method {
        &MULTIRATE
    }

    fn new(system: &System, settings: &MultirateSettings, _h: f64) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let [is_slow, is_fast] = settings.slow.selects();
        let damped = || [(); 2].map(|()| ExplicitKick::new(system));
        Ok(Self {
            slow: KeptForce::of(system, is_slow),
            fast: KeptForce::of(system, is_fast),
            damped: is_damped(system).then(damped),
            free_velocity: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            pins: Constraints::free(system.len()),
        })
    }

    fn step(
        &mut self,
        settings: &MultirateSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport { substeps: settings.ratio, ..StepReport::default() };
        let (start, end, short) = (state.t, state.t + h, h / f64::from(settings.ratio));
        let half = 0.5 * short;
        clock.switch(Phase::Forces);
        self.pins.clear();
        hold_pins(system, &mut self.pins);
        self.slow.begin(system, &state.x, &mut report); // F_S(x_n)
        self.fast.begin(system, &state.x, &mut report); // F_F(x_n)
        kick(system, 0.5 * h, self.slow.force(), &mut state.v); // v ← v + H/2 M⁻¹ F_S, (I1)
        for substep in 0..settings.ratio {
            state.t = start + f64::from(substep) * short;
            self.find_contacts(system, state, short, clock);
            self.pins.impose(&mut state.v);
            self.kick(0, system, half, state, &mut report); // h/2 by F_F and the damping, (I2)
            self.constrain(system, &mut state.v, clock);
            drift(system, short, &state.v, &mut state.x); // x ← x + h v, (I2)
            clock.switch(Phase::Forces);
            state.t += short;
            self.fast.evaluate(system, &state.x, &mut report);
            self.kick(1, system, half, state, &mut report); // h/2 by F_F and the damping, (I2)
            self.pins.impose(&mut state.v);
            self.contacts.settle(&mut state.v, |_| ());
            self.contacts.stop(&mut state.v);
        }
        self.slow.evaluate(system, &state.x, &mut report); // F_S(x_{n+1})
        kick(system, 0.5 * h, self.slow.force(), &mut state.v); // v ← v + H/2 M⁻¹ F_S, (I3)
        self.pins.impose(&mut state.v);
        self.contacts.stop(&mut state.v);
        self.slow.keep(system, &state.x);
        self.fast.keep(system, &state.x);
        state.t = end;
        Ok(report)
    }

    fn restart(&mut self) {
        self.slow.forget();
        self.fast.forget();
        self.contacts.restart();
    }

    fn is_portable(_settings: &MultirateSettings) -> bool {
        true
    }
}

/// What a short step does beside its equations, as leapfrog does it.
impl Workspace {
    /// Half a kick of a short step by the fast force and the damping.
    fn kick(
        &mut self,
        half_kick: usize,
        system: &System,
        tau: f64,
        state: &mut State,
        report: &mut StepReport,
    ) {
        match &mut self.damped {
            None => kick(system, tau, self.fast.force(), &mut state.v),
            Some(kicks) => {
                let force = self.fast.force();
                kicks[half_kick].kick(system, tau, force, state, &self.pins, report);
            }
        }
    }

    /// Leads the pins on paths, and finds the contacts of the next `h` seconds.
    fn find_contacts(
        &mut self,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) {
        clock.switch(Phase::Contact);
        let State { t, x, v } = state;
        lead_pins(system, *t, h, x, v);
        for pin in system.moving_pins() {
            self.pins.set(pin.particle, Filter::Fixed, v[pin.particle]);
        }
        let motion = MultistepMotion { from: (x, v), h, end: *t + h, x_star: x, tau: h };
        self.contacts.detect_multistep(system, motion, &mut self.constraints);
        clock.switch(Phase::Forces);
    }

    /// Imposes pins and contacts on the velocity of a drift.
    fn constrain(&mut self, system: &System, v: &mut [Vec3], clock: &mut PhaseClock) {
        clock.switch(Phase::Contact);
        let Self { free_velocity, impulse, contacts, constraints, .. } = self;
        contacts.project_in_place(system, constraints, free_velocity, v, impulse);
        clock.switch(Phase::Update);
    }
}

#[cfg(test)]
mod tests;
