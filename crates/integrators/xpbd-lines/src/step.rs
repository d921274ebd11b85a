//! The step.

use crate::net::Net;
use crate::settings::{Formula, XPBD_LINES, XpbdLinesSettings};
use drape_integrator::{
    Method, Phase, PhaseClock, PositionBased, PrepareError, Registration, Scheme, StepError,
    StepReport, Stepper,
};
use drape_model::{State, System};

/// Extended position-based dynamics, line by line.
#[doc(alias = "line relaxation")]
#[doc(alias = "Bender-Bayer 2008")]
pub type XpbdLines = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&XPBD_LINES);

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    net: Net,
    particles: PositionBased,
}

impl Scheme for Workspace {
    type Settings = XpbdLinesSettings;

    fn method(_settings: &XpbdLinesSettings) -> &'static Method {
        &XPBD_LINES
    }

    fn new(system: &System, settings: &XpbdLinesSettings, _h: f64) -> Result<Self, PrepareError> {
        let is_second = settings.order == Formula::Two;
        Ok(Self { net: Net::new(system), particles: PositionBased::new(system, is_second) })
    }

    fn step(
        &mut self,
        settings: &XpbdLinesSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let (start, count) = (state.t, settings.substeps);
        for k in 1..=count {
            let end = start + h * (f64::from(k) / f64::from(count));
            self.substep(settings, system, state, (h / f64::from(count), end), clock);
        }
        let force_evaluations = count * settings.iterations;
        Ok(StepReport { substeps: count, force_evaluations, ..StepReport::default() })
    }

    fn restart(&mut self) {
        self.net.restart();
        self.particles.restart();
    }

    fn is_portable(_settings: &XpbdLinesSettings) -> bool {
        true
    }

    /// Each line is solved from where the one before left its particles.
    fn follows_springs(_settings: &XpbdLinesSettings) -> bool {
        true
    }
}

impl Workspace {
    /// Advances the state by a substep of `h` seconds that ends at `end`.
    fn substep(
        &mut self,
        settings: &XpbdLinesSettings,
        system: &System,
        state: &mut State,
        (h, end): (f64, f64),
        clock: &mut PhaseClock,
    ) {
        let Self { net, particles } = self;
        clock.switch(Phase::Forces);
        // x*, v*, τ by BDF2; q = τ (v* + τ M⁻¹ f_explicit), λ = 0, (L1), (L2)
        let substep = particles.predict(system, state, h, end);
        let tau = substep.tau;
        let has_past = match settings.order {
            Formula::One => net.bridges(tau),
            Formula::Two => substep.past != 0.0,
        };
        if !has_past {
            net.restart(); // r⁻ = 0, Λ = 0
        }
        net.refresh(system, tau);
        for iteration in 0..settings.iterations {
            clock.switch(Phase::Solve);
            net.sweep(system, tau, particles.places(), iteration == 0); // (L3), (L4), (L5), (L6)
            if !system.obstacles().is_empty() {
                clock.switch(Phase::Contact);
                particles.meet(system, state, substep); // (L7)
            }
        }
        clock.switch(Phase::Update);
        particles.finish(system, state, substep); // v_+ = q/τ, x_+ = x* + q, (L8)
    }
}

#[cfg(test)]
mod tests;
