//! Symplectic Euler.

use crate::settings::{DampingTreatment, SYMPLECTIC_EULER, SymplecticSettings};
use crate::workspace::EulerMemory;
use drape_integrator::{
    EnergyLedger, Implicit, LaplacianSolver, LinearSettings, Method, Phase, PhaseClock,
    PreconditionerKind, PrepareError, Registration, Scheme, SolverKind, StepError, StepReport,
    Stepper, Taken, Weights, drift, kick,
};
use drape_model::{State, System};

/// Symplectic Euler.
pub type SymplecticEuler = Stepper<SymplecticWorkspace>;

/// Entry of this method in the registry.
pub static SYMPLECTIC: Registration = Registration::new::<SymplecticWorkspace>(&SYMPLECTIC_EULER);

/// Memory of a step.
#[derive(Debug)]
pub struct SymplecticWorkspace {
    pub(crate) euler: EulerMemory,
    /// `M + h L_c`, where the damping is implicit.
    pub(crate) damping: Option<LaplacianSolver>,
}

impl Scheme for SymplecticWorkspace {
    type Settings = SymplecticSettings;

    fn method(_settings: &SymplecticSettings) -> &'static Method {
        &SYMPLECTIC_EULER
    }

    fn new(system: &System, settings: &SymplecticSettings, h: f64) -> Result<Self, PrepareError> {
        let direct = LinearSettings::kept(1e-14, PreconditionerKind::Ic0, SolverKind::Cholesky);
        let solver =
            || LaplacianSolver::new(system, Implicit::Springs, Weights::Damping, direct, h);
        let damping = match settings.damping {
            DampingTreatment::Explicit => None,
            DampingTreatment::Implicit => Some(solver()?),
        };
        Ok(Self { euler: EulerMemory::new(system), damping })
    }

    fn step(
        &mut self,
        _settings: &SymplecticSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let EulerMemory { force, free_velocity, velocity, impulse, contacts, constraints } =
            &mut self.euler;
        clock.switch(Phase::MatrixSetup);
        let setup =
            self.damping.as_mut().map(|solver| solver.refresh(system, h)).transpose()?.flatten();
        let mut report = StepReport::after_setup(setup);
        clock.switch(Phase::Contact);
        let end = state.t + h;
        contacts.detect(system, &state.x, &state.v, (h, end), constraints);
        clock.switch(Phase::Forces);
        report.force_evaluations = 1;
        if let Some(solver) = &mut self.damping {
            let b = force;
            // b = M v_n + h (f(x_n, v_n) + L_c v_n), (S3)
            Implicit::Springs.write_impulse(system, state, h, b);
            clock.switch(Phase::Solve);
            velocity.copy_from_slice(&state.v);
            contacts.solve(system, constraints, impulse, |constraints, wanted| {
                report += solver.solve(constraints, b, velocity); // (M + h L_c) v_{n+1} = b, (S3)
                wanted.fill(velocity, |impulse| {
                    solver.constraint_impulse(b, velocity, impulse);
                    report.matvecs += 1;
                });
                Ok::<(), StepError>(())
            })?;
        } else {
            system.forces(state.level(), force); // f(x_n, v_n)
            clock.switch(Phase::Update);
            free_velocity.copy_from_slice(&state.v);
            kick(system, h, force, free_velocity); // v_{n+1} = v_n + h M⁻¹ f(x_n, v_n), (S1)
            contacts.project(system, constraints, free_velocity, velocity, impulse);
        }
        clock.switch(Phase::Update);
        state.v.copy_from_slice(velocity);
        drift(system, h, &state.v, &mut state.x); // x_{n+1} = x_n + h v_{n+1}, (S2)
        contacts.settle(&mut state.v, |_| ());
        state.t += h;
        Ok(report)
    }

    fn restart(&mut self) {
        self.euler.contacts.restart();
    }

    fn ledger(&mut self, _: &SymplecticSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(settings: &SymplecticSettings) -> bool {
        match settings.damping {
            DampingTreatment::Explicit => true,
            DampingTreatment::Implicit => false,
        }
    }
}
