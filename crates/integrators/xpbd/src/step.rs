//! The step.

use crate::net::Net;
use crate::settings::{Formula, XPBD, XpbdSettings};
use crate::springs::Pass;
use drape_integrator::{
    Method, Phase, PhaseClock, PositionBased, PrepareError, Registration, Scheme, StepError,
    StepReport, Stepper,
};
use drape_model::{State, System};

/// Extended position-based dynamics.
#[doc(alias = "XPBD")]
#[doc(alias = "Macklin-Müller-Chentanez 2016")]
pub type Xpbd = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&XPBD);

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    net: Net,
    particles: PositionBased,
}

impl Scheme for Workspace {
    type Settings = XpbdSettings;

    fn method(_settings: &XpbdSettings) -> &'static Method {
        &XPBD
    }

    fn new(system: &System, settings: &XpbdSettings, _h: f64) -> Result<Self, PrepareError> {
        Ok(Self {
            net: Net::new(system, settings.sweep),
            particles: PositionBased::new(system, settings.order == Formula::Two),
        })
    }

    fn step(
        &mut self,
        settings: &XpbdSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let (start, count) = (state.t, settings.substeps);
        let substep = h / f64::from(count);
        for k in 1..=count {
            let end = start + h * (f64::from(k) / f64::from(count));
            self.substep(settings, system, state, (substep, end), clock);
        }
        let force_evaluations = count * settings.iterations;
        Ok(StepReport { substeps: count, force_evaluations, ..StepReport::default() })
    }

    fn restart(&mut self) {
        self.particles.restart();
    }

    fn is_portable(_settings: &XpbdSettings) -> bool {
        true
    }

    /// Each constraint is projected from where the one before left its particles.
    fn follows_springs(_settings: &XpbdSettings) -> bool {
        true
    }
}

impl Workspace {
    /// Advances the state by a substep of `h` seconds that ends at `end`.
    fn substep(
        &mut self,
        settings: &XpbdSettings,
        system: &System,
        state: &mut State,
        (h, end): (f64, f64),
        clock: &mut PhaseClock,
    ) {
        let Self { net, particles } = self;
        clock.switch(Phase::Forces);
        let substep = particles.predict(system, state, h, end); // (X1) or (X2), (X3)
        let tau = substep.tau;
        net.refresh(system, tau);
        for iteration in 0..settings.iterations {
            clock.switch(Phase::Solve);
            let pass =
                Pass { is_first: iteration == 0, is_last: iteration + 1 == settings.iterations };
            net.sweep(system, tau, particles.places(), pass); // (X4), (X5), (X6)
            if !system.obstacles().is_empty() {
                clock.switch(Phase::Contact);
                particles.meet(system, state, substep); // (X7)
            }
        }
        clock.switch(Phase::Update);
        particles.finish(system, state, substep); // v_+ = q/τ, x_+ = x* + q, (X8)
    }
}

#[cfg(test)]
mod tests;
