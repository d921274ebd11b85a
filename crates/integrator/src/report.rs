//! The report of a step.

use crate::NewtonReport;
use drape_solvers::{PcgReport, SolveStatus};
use std::ops::AddAssign;

/// Why an operator was built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetupCause {
    /// The operator did not exist.
    First,
    /// The step size changed.
    StepSize,
    /// Stiffness, damping or masses changed.
    Stiffness,
    /// The set of pinned particles changed.
    Constraints,
    /// The settings request a rebuild in each step.
    EveryStep,
}

/// Numbers of set-ups by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Setups {
    /// First builds.
    pub first: u32,
    /// Rebuilds after a change of the step size.
    pub step_size: u32,
    /// Rebuilds after a change of stiffness, damping or masses.
    pub stiffness: u32,
    /// Rebuilds after a change of the set of pinned particles.
    pub constraints: u32,
    /// Rebuilds in each step at the request of the settings.
    pub every_step: u32,
}

impl Setups {
    /// Number of set-ups of all causes.
    pub fn total(&self) -> u32 {
        self.first + self.step_size + self.stiffness + self.constraints + self.every_step
    }

    /// Counts one more set-up of this cause.
    pub fn count(&mut self, cause: SetupCause) {
        *match cause {
            SetupCause::First => &mut self.first,
            SetupCause::StepSize => &mut self.step_size,
            SetupCause::Stiffness => &mut self.stiffness,
            SetupCause::Constraints => &mut self.constraints,
            SetupCause::EveryStep => &mut self.every_step,
        } += 1;
    }
}

/// Costs of one step, and how its solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport {
    /// CG iterations over all outer passes.
    pub cg_iterations: u32,
    /// Evaluations of the right-hand side inside the solve (EEH Algorithm 1).
    pub outer_passes: u32,
    /// Newton iterations.
    pub newton_iterations: u32,
    /// Factorisations that the step itself made, Newton's among them. Those of kept operators count
    /// as set-ups.
    pub factorisations: u32,
    /// Products of a matrix with a block vector.
    pub matvecs: u32,
    /// Sweeps over the springs inside the step that evaluated forces or energies.
    pub force_evaluations: u32,
    /// Set-ups of cached operators in this step; `prepare` made the first one.
    pub setups: Setups,
    /// Substeps that a method divided the step into; otherwise 1. Rejected substeps do not count.
    pub substeps: u32,
    /// Substeps that step size control rejected; the other counts include their costs.
    pub rejected: u32,
    /// Greatest estimated local error of a substep, divided by the tolerance; 0 without step size
    /// control.
    pub error_estimate: f64,
    /// Size that step size control would give the next substep, s; 0 without control.
    pub next_step: f64,
    /// Largest distance by which the method moved a position other than by integrating, m.
    pub correction: f64,
    /// Residual at the end, relative to the reference of the method's stop test; 0 for methods that
    /// solve nothing or apply a kept inverse. For Kang's method, which has no stop test, it is the
    /// residual before the last sweep.
    pub relative_residual: f64,
    /// How the solve of the step ended.
    pub solve: SolveStatus,
}

impl Default for StepReport {
    fn default() -> Self {
        Self {
            cg_iterations: 0,
            outer_passes: 0,
            newton_iterations: 0,
            factorisations: 0,
            matvecs: 0,
            force_evaluations: 0,
            setups: Setups::default(),
            substeps: 1,
            rejected: 0,
            error_estimate: 0.0,
            next_step: 0.0,
            correction: 0.0,
            relative_residual: 0.0,
            solve: SolveStatus::Converged,
        }
    }
}

impl StepReport {
    /// A report that starts with the set-up of this step, if the step made one.
    pub fn after_setup(cause: Option<SetupCause>) -> Self {
        let mut report = Self::default();
        if let Some(cause) = cause {
            report.setups.count(cause);
        }
        report
    }

    /// Adds one of several solves of a step. If a solve did not converge, its status stays, so that
    /// a later good solve does not hide it.
    pub fn add_stage(&mut self, solve: PcgReport) {
        let before = self.solve;
        *self += solve;
        if before != SolveStatus::Converged {
            self.solve = before;
        }
    }

    /// Adds the costs and the status of a substep, whose error was `error` times the tolerance.
    pub(crate) fn add_substep(&mut self, substep: &Self, error: f64) {
        self.add_costs(substep);
        self.substeps += substep.substeps;
        self.correction = self.correction.max(substep.correction);
        self.error_estimate = self.error_estimate.max(error);
        self.relative_residual = self.relative_residual.max(substep.relative_residual);
        if self.solve == SolveStatus::Converged || substep.solve == SolveStatus::IterationLimit {
            self.solve = substep.solve;
        }
    }

    /// Adds the costs of a rejected substep.
    pub(crate) fn add_rejected(&mut self, substep: &Self) {
        self.add_costs(substep);
        self.rejected += 1;
    }

    fn add_costs(&mut self, substep: &Self) {
        self.cg_iterations += substep.cg_iterations;
        self.outer_passes += substep.outer_passes;
        self.newton_iterations += substep.newton_iterations;
        self.factorisations += substep.factorisations;
        self.matvecs += substep.matvecs;
        self.force_evaluations += substep.force_evaluations;
        self.setups += substep.setups;
    }
}

impl AddAssign for Setups {
    fn add_assign(&mut self, other: Self) {
        self.first += other.first;
        self.step_size += other.step_size;
        self.stiffness += other.stiffness;
        self.constraints += other.constraints;
        self.every_step += other.every_step;
    }
}

impl AddAssign<PcgReport> for StepReport {
    /// Adds the costs of a linear solve and takes over its status.
    fn add_assign(&mut self, solve: PcgReport) {
        self.cg_iterations += solve.iterations as u32;
        self.matvecs += solve.multiplications as u32;
        self.relative_residual = solve.relative_residual;
        self.solve = solve.status;
    }
}

impl AddAssign<NewtonReport> for StepReport {
    /// Adds the costs of a nonlinear solve and takes over its status; the residual stays absolute,
    /// √J.
    fn add_assign(&mut self, solve: NewtonReport) {
        self.newton_iterations += solve.iterations;
        self.factorisations += solve.factorisations;
        self.cg_iterations += solve.cg_iterations;
        self.matvecs += solve.matvecs;
        self.relative_residual = solve.residual;
        self.solve = solve.status;
    }
}
