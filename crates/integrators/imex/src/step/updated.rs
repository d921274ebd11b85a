//! IMEX Euler with updated CG, EEH Algorithm 1: the step, the loop as printed, and the robust form.

use crate::right_hand_side::RightHandSide;
use crate::settings::{IMEX_UPDATED, ImexUpdatedSettings, Safeguard};
use crate::workspace::Memory;
use drape_integrator::{
    ContactSet, EnergyLedger, Forcing, ForcingKind, ForcingRule, Implicit, IncrementalPotential,
    LaplacianSolver, Method, Newton, NewtonLinear, NewtonSettings, Phase, PhaseClock, Predictor,
    PrepareError, Registration, Rewind, Scheme, SolveStatus, SolverKind, Start, StepError,
    StepReport, Stepper, Taken,
};
use drape_model::{Revisions, State, System, Vec3};
use drape_solvers::Constraints;
use drape_solvers::bands::bands;

/// IMEX Euler with updated CG, EEH Algorithm 1.
pub type ImexUpdated = Stepper<UpdatedWorkspace>;

/// For the registry.
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
        let Memory { rhs, velocity: v, impulse, linear, predictor, contacts, constraints } = memory;
        let bands = bands(system.threads(), system.len());
        clock.switch(Phase::MatrixSetup);
        let mut report = StepReport::after_setup(linear.refresh_at(system, h, &state.x)?); // A = M + h² L_k + h L_c
        clock.switch(Phase::Forces);
        rhs.freeze(system, state, h, linear.slopes()); // M v_n + h [F_frozen − L_k x_n]
        clock.switch(Phase::Contact);
        let end = state.t + h;
        contacts.detect(system, &state.x, &state.v, (h, end), constraints);
        clock.switch(Phase::Solve);
        match settings.start {
            Start::Last => v.copy_from_slice(&state.v),
            Start::Extrapolated | Start::Best => predictor.extrapolate(&state.v, h, bands, v), // EEH (22)
        }
        if let Some(descent) = descent {
            descent.begin(system, state, h, &rhs.explicit_force);
        }
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            let problem = Problem { system, state, h, constraints, settings };
            if let Some(descent) = descent {
                if settings.start == Start::Best {
                    descent.choose(problem, v, &state.v);
                }
                descent.minimise(problem, rhs, linear, v, &mut report)?; // Algorithm 1, safeguarded
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
        state.v.copy_from_slice(v); // the ledger asks for it
        memory.advance(state, h, bands); // x_{n+1} = x_n + h v_{n+1}, EEH (20)
        Ok(report)
    }

    fn restart(&mut self) {
        self.memory.restart();
    }

    fn ledger(&mut self, _: &ImexUpdatedSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    /// The robust form may turn to Newton, which factorises.
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

/// Everything that a solve looks at but does not change.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a> {
    pub(crate) system: &'a System,
    pub(crate) state: &'a State,
    pub(crate) h: f64,
    pub(crate) constraints: &'a Constraints,
    pub(crate) settings: &'a ImexUpdatedSettings,
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
    let Problem { system, state, h, constraints, settings } = problem;
    let direct = linear.is_direct();
    let follows_progress = settings.forcing == ForcingKind::EisenstatWalker;
    constraints.impose(v);
    let mut forcing = Forcing::new(ForcingRule::EisenstatWalker);
    for _ in 0..settings.max_outer {
        rhs.update(system, state, h, v, linear.slopes()); // b = M v_n + h [F_frozen − L_k x_n + F2(x_n + h v)]
        report.outer_passes += 1;
        if direct || follows_progress {
            // A direct solve takes no iterations, so that their number says nothing about the update; nor does a loose
            // one.
            let residual = linear.relative_residual(constraints, &rhs.b, v);
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
        let solve = linear.solve(constraints, &rhs.b, v); // while |r| > ε |b|
        *report += solve;
        if solve.iterations == 0 && !direct {
            return; // while (k > 0)
        }
    }
    if report.solve == SolveStatus::Converged {
        report.solve = SolveStatus::IterationLimit;
    }
}

/// The robust form: minimises the incremental potential.
#[derive(Debug)]
pub(crate) struct Descent {
    potential: IncrementalPotential,
    newton: Newton,
    by_newton: bool,
    /// `max k (1/m_i + 1/m_j)/2` of the implicit springs, 1/s², and the system that it is of.
    stiffness: Option<(Revisions, f64)>,
}

/// `√m` of the lightest particle that moves: `‖r‖` in the norm of `M⁻¹` is at most `‖r‖` over this.
fn lightest(system: &System) -> f64 {
    let free = system.mass().iter().zip(system.pinned()).filter(|(_, pinned)| !**pinned);
    let mass = free.fold(f64::INFINITY, |least, (&m, _)| least.min(m));
    if mass.is_finite() { mass.sqrt() } else { 1.0 }
}

/// A residual below this fraction of the scale counts as converged, whatever the energy does.
const CONVERGED: f64 = 1e-9;
/// By how much the tolerance is tightened after a step that gained energy.
const TIGHTEN: f64 = 0.1;
const MAX_NEWTON_ITERATIONS: u32 = 100;

impl Descent {
    pub(crate) fn new(system: &System, implicit: Implicit) -> Result<Self, PrepareError> {
        let potential = IncrementalPotential::new(system, implicit);
        let newton = Newton::new(system, &potential, NewtonLinear::default())?;
        Ok(Self { potential, newton, by_newton: false, stiffness: None })
    }

    /// Begins a step.
    pub(crate) fn begin(&mut self, system: &System, state: &State, h: f64, frozen: &[Vec3]) {
        self.potential.begin(system, h, (&state.x, &state.v), state.level(), frozen);
    }

    /// Puts the better of `v` and `other` into `v`.
    pub(crate) fn choose(&mut self, problem: Problem<'_>, v: &mut [Vec3], other: &[Vec3]) {
        self.potential.choose_start(problem.system, problem.constraints, v, &[other], false);
    }

    /// `∇Φ(v)`, unfiltered: the impulse of the constraints, kg m/s.
    pub(crate) fn gradient(&mut self, system: &System, v: &[Vec3]) -> &[Vec3] {
        self.potential.gradient(system, v)
    }

    /// Evaluations of forces and energies since the step began.
    pub(crate) fn evaluations(&self) -> u32 {
        self.potential.evaluations()
    }

    /// Whether the last solve was ended by Newton's method and not by an update of the right-hand side.
    pub(crate) fn by_newton(&self) -> bool {
        self.by_newton
    }

    /// Minimises from `v`. A result that gains energy is accepted only when it has converged; where that
    /// cannot be had, the step is one of plain IMEX Euler, which with full damping never gains any.
    pub(crate) fn minimise(
        &mut self,
        problem: Problem<'_>,
        rhs: &mut RightHandSide,
        linear: &mut LaplacianSolver,
        v: &mut [Vec3],
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let Problem { system, state, h, constraints, settings } = problem;
        let theta = h * h * self.stiffness(settings.implicit, system);
        let updates = theta <= settings.newton_above * (1.0 + 1e-12);
        let (scale, floor) = (self.potential.scale(), self.potential.round_off());
        let kinetic = system.kinetic_energy(&state.v);
        let potential = system.potential_energy(&state.x);
        let allowed =
            kinetic + potential + 1e-9 * scale * scale + 1e-12 * (kinetic + potential.abs());
        let tightest = (CONVERGED * scale).max(floor);
        let mut tolerance = (settings.forcing_term * scale).max(floor);
        report.force_evaluations += 1;
        constraints.impose(v);
        loop {
            let converged =
                updates && self.update_until(problem, rhs, linear, v, tolerance, report);
            self.by_newton = !converged;
            if !converged {
                if linear.slopes().is_some() {
                    // Slopes that are not the steepest ones promise no descent.
                    v.copy_from_slice(&state.v);
                    constraints.impose(v);
                }
                self.finish(problem, v, tolerance, report)?;
            }
            report.force_evaluations += 1;
            let gained = self.energy(system, v) > allowed;
            if gained && report.solve != SolveStatus::Converged {
                let status = report.solve;
                self.by_newton = false;
                v.fill(Vec3::zeros()); // where b(v, x_n + h v) is the b of plain IMEX Euler
                rhs.update(system, state, h, v, linear.slopes()); // EEH (21)
                *report += linear.solve_to(constraints, &rhs.b, v, tightest * lightest(system));
                report.relative_residual *= tightest;
                report.solve = status;
            } else if gained && tolerance > tightest {
                tolerance = (tolerance * TIGHTEN).max(tightest);
                continue;
            }
            let wanted = settings.forcing_term * scale;
            report.solve = self.potential.status(report.solve, report.relative_residual, wanted);
            report.relative_residual = self.potential.relative(report.relative_residual);
            return Ok(());
        }
    }

    /// The greatest stiffness over mass, found once for each state of the system.
    fn stiffness(&mut self, implicit: Implicit, system: &System) -> f64 {
        let now = system.revisions();
        match self.stiffness {
            Some((then, stiffness)) if then == now => stiffness,
            _ => {
                let stiffness = implicit.max_stiffness_over_mass(system);
                self.stiffness = Some((now, stiffness));
                stiffness
            }
        }
    }

    /// Algorithm 1 until an update leaves a residual below `tolerance` (√J); `false` at the outer cap.
    fn update_until(
        &mut self,
        problem: Problem<'_>,
        rhs: &mut RightHandSide,
        linear: &mut LaplacianSolver,
        v: &mut [Vec3],
        tolerance: f64,
        report: &mut StepReport,
    ) -> bool {
        let Problem { system, state, h, constraints, settings } = problem;
        let lightest = lightest(system);
        let direct = linear.is_direct();
        let follows_progress = settings.forcing == ForcingKind::EisenstatWalker;
        let mut forcing = Forcing::new(ForcingRule::EisenstatWalker);
        while report.outer_passes < settings.max_outer {
            rhs.update(system, state, h, v, linear.slopes()); // b = M v_n + h [F_frozen − L_k x_n + F2(x_n + h v)]
            report.outer_passes += 1;
            // A direct solve takes no iterations, so that their number says nothing about the update.
            let mut goal = tolerance;
            if direct || follows_progress {
                let residual = linear.residual(constraints, &rhs.b, v) / lightest;
                report.matvecs += 1;
                report.solve = SolveStatus::Converged;
                if residual <= tolerance {
                    report.relative_residual = residual;
                    return true;
                }
                if follows_progress {
                    goal = residual * forcing.next(residual, tolerance);
                }
            }
            let solve = linear.solve_to(constraints, &rhs.b, v, goal * lightest); // while |r| > goal
            *report += solve;
            report.relative_residual *= goal;
            if !direct && solve.iterations == 0 && solve.status == SolveStatus::Converged {
                return true;
            }
            if solve.status == SolveStatus::Stagnated || solve.status == SolveStatus::Indefinite {
                return false;
            }
        }
        false
    }

    /// Newton's method from where the updates stopped.
    fn finish(
        &mut self,
        problem: Problem<'_>,
        v: &mut [Vec3],
        tolerance: f64,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let settings =
            NewtonSettings { residual: tolerance, max_iterations: MAX_NEWTON_ITERATIONS };
        let Problem { system, constraints, .. } = problem;
        *report += self.newton.minimise(system, &mut self.potential, constraints, v, &settings)?;
        Ok(())
    }

    /// Total energy after the step, J.
    fn energy(&mut self, system: &System, v: &[Vec3]) -> f64 {
        let kinetic = system.kinetic_energy(v);
        kinetic + system.potential_energy(self.potential.positions(v))
    }
}

#[cfg(test)]
mod tests;
