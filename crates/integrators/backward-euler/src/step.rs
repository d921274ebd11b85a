//! The step.

use crate::settings::{BACKWARD_EULER, BackwardEulerSettings};
use crate::workspace::Workspace;
use drape_integrator::{
    Implicit, Integrator, Method, NewtonSettings, Phase, PhaseClock, PrepareError, Scratch,
    StepError, StepReport, TimeStep,
};
use drape_model::{State, System, Vec3};

/// Backward Euler with Newton's method.
#[derive(Debug)]
pub struct BackwardEuler {
    settings: BackwardEulerSettings,
    scratch: Scratch<Workspace>,
}

impl BackwardEuler {
    /// The method with its settings.
    pub fn new(settings: BackwardEulerSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }
}

impl Integrator for BackwardEuler {
    fn method(&self) -> &'static Method {
        &BACKWARD_EULER
    }

    fn prepare(&mut self, system: &System, _h: TimeStep) -> Result<(), PrepareError> {
        BACKWARD_EULER.check(system)?;
        self.scratch.set(system, Workspace::new(system)?);
        Ok(())
    }

    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let w = self.scratch.ready(system, state)?;
        let h = h.seconds();
        let mut report = StepReport::default();
        clock.switch(Phase::Forces);
        w.frozen.fill(Vec3::zeros());
        Implicit::Everything.add_explicit_forces(system, &state.x, &state.v, &mut w.frozen);
        w.potential.begin(system, h, &state.x, &state.v, &w.frozen);
        clock.switch(Phase::Contact);
        w.contacts.detect(system, &state.x, &state.v, h, &mut w.constraints);
        clock.switch(Phase::Solve);
        let settings = NewtonSettings {
            residual: (self.settings.residual * w.potential.scale()).max(w.potential.round_off()),
            max_iterations: self.settings.max_iterations,
        };
        w.predictor.extrapolate(&state.v, h, &mut w.extrapolated);
        let Workspace { velocity: v, extrapolated, impulse, contacts, constraints, .. } = w;
        v.copy_from_slice(&state.v);
        contacts.solve(system, constraints, impulse, |constraints, impulse| {
            w.potential.choose_start(system, constraints, v, &[extrapolated], true);
            report += w.newton.minimise(system, &mut w.potential, constraints, v, &settings)?;
            if let Some(impulse) = impulse {
                impulse.copy_from_slice(w.potential.gradient(system, v)); // ∇Φ, unfiltered
            }
            Ok::<(), StepError>(())
        })?;
        clock.switch(Phase::Update);
        w.predictor.remember(&state.v, h);
        state.v.copy_from_slice(&w.velocity);
        state.x.copy_from_slice(w.potential.positions(&w.velocity)); // x_{n+1} = x_n + h v_{n+1}
        w.contacts.settle(&mut state.v, |i, v| w.predictor.forget(i, v));
        state.t += h;
        clock.stop();
        report.relative_residual = w.potential.relative(report.relative_residual);
        report.force_evaluations = w.potential.evaluations();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.predictor.restart();
            w.contacts.restart();
        }
    }
}
