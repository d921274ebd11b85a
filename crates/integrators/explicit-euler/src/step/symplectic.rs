//! Symplectic Euler.

use crate::settings::{DampingTreatment, SYMPLECTIC_EULER, SymplecticSettings};
use crate::workspace::EulerWorkspace;
use drape_integrator::{
    EnergyLedger, Implicit, Integrator, Method, Phase, PhaseClock, PrepareError, Scratch,
    StepError, StepReport, TimeStep, drift, kick,
};
use drape_model::{State, System};

/// Symplectic Euler.
#[derive(Debug, Default)]
pub struct SymplecticEuler {
    settings: SymplecticSettings,
    scratch: Scratch<EulerWorkspace>,
}

impl SymplecticEuler {
    /// The method with its settings.
    pub fn new(settings: SymplecticSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }
}

impl Integrator for SymplecticEuler {
    fn method(&self) -> &'static Method {
        &SYMPLECTIC_EULER
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        SYMPLECTIC_EULER.check(system)?;
        let implicit_damping = self.settings.damping == DampingTreatment::Implicit;
        self.scratch.set(system, EulerWorkspace::new(system, implicit_damping, h.seconds())?);
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
        let h = h.seconds();
        clock.switch(Phase::MatrixSetup);
        let setup =
            w.damping.as_mut().map(|solver| solver.refresh(system, h)).transpose()?.flatten();
        let mut report = StepReport::after_setup(setup);
        clock.switch(Phase::Contact);
        let end = state.t + h;
        w.contacts.detect(system, &state.x, &state.v, (h, end), &mut w.constraints);
        clock.switch(Phase::Forces);
        report.force_evaluations = 1;
        if let Some(solver) = &mut w.damping {
            Implicit::Springs.write_impulse(system, state, h, &mut w.force); // M v_n + h f
            clock.switch(Phase::Solve);
            w.velocity.copy_from_slice(&state.v);
            let EulerWorkspace { force: b, velocity, impulse, contacts, constraints, .. } = w;
            contacts.solve(system, constraints, impulse, |constraints, wanted| {
                report += solver.solve(constraints, b, velocity); // (M + h L_c) v_{n+1} = b
                wanted.fill(velocity, |impulse| {
                    solver.constraint_impulse(b, velocity, impulse);
                    report.matvecs += 1;
                });
                Ok::<(), StepError>(())
            })?;
        } else {
            system.forces(state.level(), &mut w.force);
            clock.switch(Phase::Update);
            w.free_velocity.copy_from_slice(&state.v);
            kick(system, h, &w.force, &mut w.free_velocity); // v_{n+1} = v_n + h M⁻¹ f_n
            w.project(system);
        }
        clock.switch(Phase::Update);
        state.v.copy_from_slice(&w.velocity);
        drift(h, &state.v, &mut state.x); // x_{n+1} = x_n + h v_{n+1}
        w.contacts.settle(&mut state.v, |_| ());
        state.t += h;
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.contacts.restart();
        }
    }

    fn ledger(
        &mut self,
        system: &System,
        before: &State,
        after: &State,
        h: TimeStep,
    ) -> Option<EnergyLedger> {
        Some(self.scratch.get_mut()?.symplectic_ledger(system, before, after, h))
    }
}
