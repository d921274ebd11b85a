//! The step.

use crate::settings::{BARAFF_WITKIN, BaraffWitkinSettings};
use crate::workspace::{Workspace, prescribe_changes};
use drape_integrator::{
    EnergyLedger, Integrator, Method, Phase, PhaseClock, PrepareError, Scratch, StepError,
    StepReport, TimeStep, Wanted,
};
use drape_model::{State, System, Vec3};

/// Baraff and Witkin's implicit step.
#[derive(Debug)]
pub struct BaraffWitkin {
    settings: BaraffWitkinSettings,
    scratch: Scratch<Workspace>,
}

impl BaraffWitkin {
    /// The method with its settings.
    pub fn new(settings: BaraffWitkinSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }
}

impl Integrator for BaraffWitkin {
    fn method(&self) -> &'static Method {
        &BARAFF_WITKIN
    }

    fn prepare(&mut self, system: &System, _h: TimeStep) -> Result<(), PrepareError> {
        BARAFF_WITKIN.check(system)?;
        self.scratch.set(system, Workspace::new(system, &self.settings)?);
        Ok(())
    }

    #[doc(alias = "Baraff-Witkin 6")]
    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let w = self.scratch.ready(system, state, h)?;
        let h = h.seconds();
        let mut report = StepReport::after_setup(Some(w.setup_cause()));
        clock.switch(Phase::Contact);
        report.correction = w.detect(system, state, h); // S, z and y
        clock.switch(Phase::MatrixSetup);
        w.linear.linearise(system, state, &w.y, h); // A = M − h ∂f/∂v − h² ∂f/∂x, Baraff-Witkin (16)
        clock.switch(Phase::Forces);
        w.linear.set_right_hand_side(system, state, h, &mut report); // b, Baraff-Witkin (18)
        clock.switch(Phase::Solve);
        let Workspace { linear, change, y, impulse, contacts, constraints, changes, .. } = w;
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            prescribe_changes(constraints, &state.v, changes);
            linear.solve(changes, change, &mut report)?; // S (b − A Δv) = 0
            match wanted {
                Wanted::Nothing => {}
                Wanted::Impulse(out) => linear.constraint_impulse(change, out, &mut report),
                Wanted::Velocity(out) => {
                    for i in 0..out.len() {
                        out[i] = state.v[i] + change[i];
                    }
                }
            }
            Ok::<(), StepError>(())
        })?;
        clock.switch(Phase::Update);
        for i in 0..state.len() {
            state.v[i] += change[i];
            state.x[i] += y[i];
            state.x[i] += state.v[i] * h; // x_{n+1} = x_n + h (v_n + Δv) + y
        }
        contacts.settle(&mut state.v, |_| ());
        state.t += h;
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.contacts.restart();
            w.change.fill(Vec3::zeros());
        }
    }

    fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> Option<EnergyLedger> {
        Some(self.scratch.get_mut()?.ledger(system, before, after, h, &self.settings))
    }
}

#[cfg(test)]
#[path = "step_tests.rs"]
mod tests;
