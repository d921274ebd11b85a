//! Leapfrog.

use crate::settings::{LEAPFROG, LeapfrogSettings};
use crate::workspace::LeapfrogWorkspace;
use drape_integrator::{
    EnergyLedger, Integrator, Method, MultistepMotion, Phase, PhaseClock, PrepareError, Scratch,
    StepError, StepReport, TimeStep, drift, kick,
};
use drape_model::{State, System};

/// Leapfrog (velocity Verlet) with Crank–Nicolson damping.
#[derive(Debug, Default)]
pub struct Leapfrog {
    settings: LeapfrogSettings,
    scratch: Scratch<LeapfrogWorkspace>,
}

impl Leapfrog {
    /// The method with its settings.
    pub fn new(settings: LeapfrogSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }
}

impl Integrator for Leapfrog {
    fn method(&self) -> &'static Method {
        &LEAPFROG
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        LEAPFROG.check(system)?;
        self.scratch.set(system, LeapfrogWorkspace::new(system, self.settings, h.seconds())?);
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
        let mut report = StepReport::default();
        clock.switch(Phase::MatrixSetup);
        report.substeps = w.substeps(system, &state.x, h.seconds(), &mut report);
        let substep = h.seconds() / f64::from(report.substeps);
        w.refresh(system, substep, &mut report)?;
        clock.switch(Phase::Forces);
        w.ensure_force(system, &state.x, &mut report);
        let start = state.t;
        for part in 0..report.substeps {
            state.t = start + f64::from(part) * substep;
            w.advance(system, state, substep, clock, &mut report);
        }
        w.remember_force(system, &state.x);
        w.last_substeps = report.substeps;
        state.t = start + h.seconds();
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.restart();
        }
    }

    fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> Option<EnergyLedger> {
        // Of a divided step the parts are not kept.
        let w = self.scratch.get_mut().filter(|w| w.last_substeps == 1)?;
        Some(w.ledger(system, before, after, h))
    }
}

impl LeapfrogWorkspace {
    /// One kick–drift–kick of `h` seconds.
    fn advance(
        &mut self,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) {
        let State { t, x, v } = state;
        let t = *t;
        clock.switch(Phase::Contact);
        self.lead_pins(system, t, h, x, v);
        // A rebound moves by the mean of the velocities before and after it, as befits order 2.
        let motion = MultistepMotion { from: (x, v), h, end: t + h, x_star: x, tau: h };
        self.contacts.detect_multistep(system, motion, &mut self.constraints);
        clock.switch(Phase::Forces);
        self.old_velocity.copy_from_slice(v);
        kick(system, 0.5 * h, &self.force, v);
        self.kick_by_damping(system, (t, x), 0.5 * h, v); // v½ = v_n + h/2 M⁻¹ (F_n − D_n v_n)
        clock.switch(Phase::Contact);
        self.project(system, v);
        clock.switch(Phase::Update);
        drift(h, v, x); // x_{n+1} = x_n + h v½
        clock.switch(Phase::Forces);
        self.evaluate_force(system, x, report);
        if self.damping.is_some() {
            clock.switch(Phase::Solve);
            self.solve_half_kick(system, (t + h, x), 0.5 * h, v, report); // (M + h/2 L_c) v_{n+1} = …
        } else {
            clock.switch(Phase::Update);
            kick(system, 0.5 * h, &self.force, v); // v_{n+1} = v½ + h/2 M⁻¹ F_{n+1}
            self.pins.impose(v);
        }
        if !self.contacts.is_empty() {
            self.unsettled.copy_from_slice(v);
        }
        self.contacts.settle(v, |_| ());
        self.contacts.stop(v);
    }
}

#[cfg(test)]
#[path = "leapfrog_tests.rs"]
mod tests;
