//! IMEX Euler with updated CG, EEH Algorithm 1: the step, and the loop as printed.

use super::robust::Descent;
use crate::right_hand_side::RightHandSide;
use crate::settings::{IMEX_UPDATED, ImexUpdatedSettings, Safeguard};
use crate::workspace::Memory;
use drape_integrator::{
    ContactSet, EnergyLedger, Forcing, ForcingKind, ForcingRule, LaplacianSolver, Method, Phase,
    PhaseClock, Predictor, PrepareError, Registration, Rewind, Scheme, SolveStatus, SolverKind,
    Start, StepError, StepReport, StepStart, Stepper, Taken,
};
use drape_model::{State, System, Vec3};
use drape_solvers::bands::bands;
use drape_solvers::{Constraints, Reference, StartValue};

/// IMEX Euler with updated CG, EEH Algorithm 1.
pub type ImexUpdated = Stepper<UpdatedWorkspace>;

/// Entry of this method in the registry.
pub static UPDATED: Registration = Registration::controlled::<UpdatedWorkspace>(&IMEX_UPDATED);

/// Memory of a step.
#[derive(Debug)]
pub struct UpdatedWorkspace {
    pub(crate) memory: Memory,
    /// For the robust form.
    pub(crate) descent: Option<Descent>,
}

impl Scheme for UpdatedWorkspace {
    type Settings = ImexUpdatedSettings;

    fn method(_settings: &ImexUpdatedSettings) -> &'static Method {
        &IMEX_UPDATED
    }

    fn new(system: &System, settings: &ImexUpdatedSettings, h: f64) -> Result<Self, PrepareError> {
        let ImexUpdatedSettings { implicit, split, .. } = *settings;
        let rhs = RightHandSide::updated(system.len(), implicit);
        let descent = match settings.safeguard {
            Safeguard::Paper => None,
            Safeguard::Robust => Some(Descent::new(system, implicit)?),
        };
        Ok(Self { memory: Memory::new(system, rhs, settings.linear(), split, h)?, descent })
    }

    fn step(
        &mut self,
        settings: &ImexUpdatedSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Self { memory, descent } = self;
        let Memory {
            rhs,
            velocity: v,
            impulse,
            linear,
            predictor,
            contacts,
            constraints,
            reference,
        } = memory;
        let bands = bands(system.threads(), system.len());
        clock.switch(Phase::MatrixSetup);
        // A = M + h² L_k + h L_c, EEH (21)
        let mut report = StepReport::after_setup(linear.refresh_at(system, h, &state.x)?);
        clock.switch(Phase::Forces);
        rhs.freeze(system, state, h, linear.slopes()); // M v_n + h [F_frozen − L_k x_n]
        clock.switch(Phase::Contact);
        let end = state.t + h;
        contacts.detect(system, &state.x, &state.v, (h, end), constraints);
        clock.switch(Phase::Solve);
        match settings.start {
            Start::Last => v.copy_from_slice(&state.v),
            // EEH (22)
            Start::Extrapolated | Start::Best => predictor.extrapolate(&state.v, h, bands, v),
        }
        let mut relative_to = Reference::FilteredRightHandSide;
        if let Some(descent) = descent {
            descent.begin(system, state, h, &rhs.explicit_force);
        } else {
            let forces = |i: usize| rhs.impulse(system, state, h, i);
            let begin = StepStart { system, state, tau: h, rounds_positions: true };
            relative_to = reference.of(begin, linear, contacts, constraints, forces);
        }
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            let reference = relative_to;
            let problem = Problem { system, state, h, constraints, settings, reference };
            if let Some(descent) = descent {
                if settings.start == Start::Best {
                    descent.choose(problem, v, &state.v);
                }
                descent.minimise(problem, rhs, linear, v, &mut report)?; // (U1) to (U5)
                wanted.fill(v, |impulse| impulse.copy_from_slice(descent.gradient(system, v)));
            } else {
                as_printed(problem, rhs, linear, v, &mut report); // Algorithm 1
                wanted.fill(v, |impulse| {
                    linear.constraint_impulse(&rhs.b, v, impulse);
                    report.matvecs += 1;
                });
            }
            Ok::<(), StepError>(())
        })?;
        clock.switch(Phase::Update);
        let descent = descent.as_ref().map_or(0, |descent| descent.evaluations());
        let slopes = u32::from(linear.slopes().is_some());
        report.force_evaluations += 2 + report.outer_passes + descent + slopes;
        predictor.take(&mut state.v, h);
        state.v.copy_from_slice(v); // the ledger reads `v`, too
        memory.advance(state, h, bands); // x_{n+1} = x_n + h v_{n+1}, EEH (20)
        Ok(report)
    }

    fn restart(&mut self) {
        self.memory.restart();
    }

    fn ledger(&mut self, _: &ImexUpdatedSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    /// The robust form may use Newton's method, which factorises.
    fn is_portable(settings: &ImexUpdatedSettings) -> bool {
        settings.solver == SolverKind::Cg && settings.safeguard == Safeguard::Paper
    }
}

impl Rewind for UpdatedWorkspace {
    type Past = Predictor;

    fn past(&mut self) -> (&mut Predictor, &mut ContactSet) {
        (&mut self.memory.predictor, &mut self.memory.contacts)
    }

    fn tolerance(settings: &ImexUpdatedSettings) -> f64 {
        settings.tolerance
    }
}

/// What a solve reads but does not change.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a> {
    pub(crate) system: &'a System,
    pub(crate) state: &'a State,
    pub(crate) h: f64,
    pub(crate) constraints: &'a Constraints,
    pub(crate) settings: &'a ImexUpdatedSettings,
    /// Of the stop test of the loop as printed.
    pub(crate) reference: Reference,
}

/// Algorithm 1 as printed: updates until an update needs no CG iteration.
#[doc(alias = "EEH Algorithm 1")]
pub(crate) fn as_printed(
    problem: Problem<'_>,
    rhs: &mut RightHandSide,
    linear: &mut LaplacianSolver,
    v: &mut [Vec3],
    report: &mut StepReport,
) {
    let Problem { system, state, h, constraints, settings, reference } = problem;
    let direct = linear.is_direct();
    let follows_progress = settings.forcing == ForcingKind::EisenstatWalker;
    constraints.impose(v);
    let mut forcing = Forcing::new(ForcingRule::EisenstatWalker);
    for _ in 0..settings.max_outer {
        // b = M v_n + h [F_frozen − L_k x_n + F2(x_n + h v)]
        rhs.update(system, state, h, v, linear.slopes());
        report.outer_passes += 1;
        if direct || follows_progress {
            // The iteration count of a direct or a loose solve says nothing about the update.
            let residual = linear.relative_residual(constraints, &rhs.b, v, reference);
            report.matvecs += 2;
            report.relative_residual = residual;
            if residual <= settings.forcing_term {
                report.solve = SolveStatus::Converged;
                return;
            }
        }
        if follows_progress {
            let residual = linear.residual(constraints, &rhs.b, v);
            report.matvecs += 1;
            let goal = residual * (settings.forcing_term / report.relative_residual);
            let term = forcing.next(residual, goal);
            *report += linear.solve_to(constraints, &rhs.b, v, residual * term);
            continue;
        }
        // A v = b by CG while |r| > ε |b|, or ε times another reference
        let solve = linear.solve_from(StartValue::Given, constraints, &rhs.b, v, reference);
        *report += solve;
        if solve.iterations == 0 && !direct {
            return; // the last update needed no iteration: k = 0
        }
    }
    if report.solve == SolveStatus::Converged {
        report.solve = SolveStatus::IterationLimit;
    }
}
