//! EEH Algorithm 1, updated and filtered CG: the loop as printed, and the robust form.

use crate::right_hand_side::RightHandSide;
use crate::settings::ImexUpdatedSettings;
use drape_integrator::{
    Forcing, ForcingRule, Implicit, IncrementalPotential, LaplacianSolver, Newton, NewtonLinear,
    NewtonSettings, PrepareError, SolveStatus, StepError, StepReport,
};
use drape_model::{Revisions, State, System, Vec3};
use drape_solvers::Constraints;

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
    constraints.impose(v);
    let mut forcing = Forcing::new(ForcingRule::EisenstatWalker);
    for _ in 0..settings.max_outer {
        rhs.update(system, state, h, v, linear.slopes()); // b = b(v, x_n + h v)
        report.outer_passes += 1;
        if direct || settings.follows_progress {
            // A direct solve takes no iterations, so that their number says nothing about the update; nor does a loose
            // one.
            let residual = linear.relative_residual(constraints, &rhs.b, v);
            report.matvecs += 2;
            report.relative_residual = residual;
            if residual <= settings.linear.forcing_term {
                report.solve = SolveStatus::Converged;
                return;
            }
        }
        if settings.follows_progress {
            let residual = linear.residual(constraints, &rhs.b, v);
            report.matvecs += 1;
            let goal = residual * (settings.linear.forcing_term / report.relative_residual);
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
        let mut tolerance = (settings.linear.forcing_term * scale).max(floor);
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
            let wanted = settings.linear.forcing_term * scale;
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
        let mut forcing = Forcing::new(ForcingRule::EisenstatWalker);
        while report.outer_passes < settings.max_outer {
            rhs.update(system, state, h, v, linear.slopes());
            report.outer_passes += 1;
            // A direct solve takes no iterations, so that their number says nothing about the update.
            let mut goal = tolerance;
            if direct || settings.follows_progress {
                let residual = linear.residual(constraints, &rhs.b, v) / lightest;
                report.matvecs += 1;
                report.solve = SolveStatus::Converged;
                if residual <= tolerance {
                    report.relative_residual = residual;
                    return true;
                }
                if settings.follows_progress {
                    goal = residual * forcing.next(residual, tolerance);
                }
            }
            let solve = linear.solve_to(constraints, &rhs.b, v, goal * lightest);
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
#[path = "algorithm1_tests.rs"]
mod tests;
