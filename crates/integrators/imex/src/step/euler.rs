//! IMEX Euler.

use crate::right_hand_side::{RightHandSide, add_nonlinear_forces};
use crate::settings::{Estimator, IMEX_EULER, ImexEulerSettings};
use crate::splitting::SplittingError;
use crate::workspace::Memory;
use drape_integrator::{
    ContactSet, EnergyLedger, LaplacianSolver, Method, Phase, PhaseClock, Predictor, PrepareError,
    Registration, Rewind, Scheme, SolverKind, StepError, StepReport, StepStart, Stepper, Taken,
};
use drape_model::{State, System, Vec3};
use drape_solvers::StartValue;
use drape_solvers::bands::bands;

/// IMEX Euler, EEH (21).
pub type ImexEuler = Stepper<EulerWorkspace>;

/// Entry of this method in the registry.
pub static EULER: Registration = Registration::controlled::<EulerWorkspace>(&IMEX_EULER);

/// Memory of a step.
#[derive(Debug)]
pub struct EulerWorkspace {
    pub(crate) memory: Memory,
    /// For step size control.
    splitting: Option<SplittingError>,
}

impl Scheme for EulerWorkspace {
    type Settings = ImexEulerSettings;

    fn method(_settings: &ImexEulerSettings) -> &'static Method {
        &IMEX_EULER
    }

    fn new(system: &System, settings: &ImexEulerSettings, h: f64) -> Result<Self, PrepareError> {
        let ImexEulerSettings { implicit, split, tolerance, estimator, .. } = *settings;
        let rhs = RightHandSide::new(system.len(), implicit);
        let is_split = tolerance > 0.0 && estimator == Estimator::Splitting;
        let splitting = is_split.then(|| SplittingError::new(system.len()));
        Ok(Self { memory: Memory::new(system, rhs, settings.linear(), split, h)?, splitting })
    }

    #[doc(alias = "EEH 19")]
    fn step(
        &mut self,
        settings: &ImexEulerSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Memory {
            rhs,
            velocity: v,
            impulse,
            linear,
            predictor,
            contacts,
            constraints,
            reference,
        } = &mut self.memory;
        let bands = bands(system.threads(), system.len());
        clock.switch(Phase::MatrixSetup);
        // A = M + h² L_k + h L_c, EEH (21)
        let mut report = StepReport::after_setup(linear.refresh_at(system, h, &state.x)?);
        clock.switch(Phase::Forces);
        rhs.assemble(system, state, h); // b = M v_n + h [F_explicit(x_n, v_n) − L_k x_n], EEH (21)
        report.force_evaluations = 1 + u32::from(linear.slopes().is_some());
        if let Some(splitting) = &mut self.splitting {
            splitting.expect(system, settings.implicit, linear.slopes(), &state.x);
            report.force_evaluations += 1;
        }
        clock.switch(Phase::Contact);
        let end = state.t + h;
        contacts.detect(system, &state.x, &state.v, (h, end), constraints);
        clock.switch(Phase::Solve);
        // h F, the impulse of the forces of level n
        let forces = |i: usize| rhs.b[i] - state.v[i] * system.mass()[i];
        let begin = StepStart { system, state, tau: h, rounds_positions: false };
        let reference = reference.of(begin, linear, contacts, constraints, forces);
        let mut start = predictor.start(settings.start, &state.v, h); // EEH (22)
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            // A v_{n+1} = b, EEH (21)
            report += linear.solve_from(start, constraints, &rhs.b, v, reference);
            start = StartValue::Given; // solves with other contacts start from the last solution
            wanted.fill(v, |impulse| {
                linear.constraint_impulse(&rhs.b, v, impulse);
                report.matvecs += 1;
            });
            Ok::<(), StepError>(())
        })?;
        clock.switch(Phase::Update);
        self.memory.change_places(&mut state.v, h);
        self.memory.advance(state, h, bands); // x_{n+1} = x_n + h v_{n+1}, EEH (20)
        Ok(report)
    }

    fn restart(&mut self) {
        self.memory.restart();
    }

    fn ledger(&mut self, _settings: &ImexEulerSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(settings: &ImexEulerSettings) -> bool {
        settings.solver == SolverKind::Cg
    }
}

impl Rewind for EulerWorkspace {
    type Past = Predictor;

    fn past(&mut self) -> (&mut Predictor, &mut ContactSet) {
        (&mut self.memory.predictor, &mut self.memory.contacts)
    }

    fn tolerance(settings: &ImexEulerSettings) -> f64 {
        settings.tolerance
    }

    fn add_splitting_error(
        &mut self,
        settings: &ImexEulerSettings,
        system: &System,
        to: &State,
        h: f64,
        error: &mut [Vec3],
        report: &mut StepReport,
    ) {
        let Some(splitting) = &mut self.splitting else { return };
        let Memory { linear, constraints, .. } = &mut self.memory;
        let force = |linear: &LaplacianSolver, out: &mut [Vec3]| {
            add_nonlinear_forces(settings.implicit, linear.slopes(), system, &to.x, out);
        };
        splitting.add(system, force, h, linear, constraints, error, report);
    }
}
