//! Newton's method for an implicit stage.

use crate::newton_linear::NewtonMatrix;
use crate::{
    Forcing, IncrementalPotential, Jacobian, NewtonLinear, NewtonSolver, PrepareError, Safeguard,
    StepError, each_particle,
};
use drape_model::{System, Vec3};
use drape_solvers::{Constraints, SolveStatus, vector::dot};

/// Settings of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSettings {
    /// Newton's method stops at `‖S∇Φ‖_{M⁻¹} ≤ residual`, √J.
    pub residual: f64,
    /// Largest number of iterations.
    pub max_iterations: u32,
    /// Whether Newton's method continues after `max_iterations`.
    pub safeguard: Safeguard,
}

/// How Newton's method ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonReport {
    /// Number of iterations.
    pub iterations: u32,
    /// Number of factorisations. With a fresh Jacobian there is one per iteration, and two where
    /// the exact Hessian was indefinite.
    pub factorisations: u32,
    /// Number of CG iterations, if CG solves the linear systems.
    pub cg_iterations: u32,
    /// Number of products with the matrix in CG. A multigrid cycle and its set-up count as the
    /// number of products that multiply as many blocks.
    pub matvecs: u32,
    /// `‖S∇Φ‖_{M⁻¹}` at the end, √J.
    pub residual: f64,
    /// How the iteration ended.
    pub status: SolveStatus,
}

/// Armijo's constant.
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Differences of `Φ` below this fraction of it are round-off.
const ENERGY_ROUND_OFF: f64 = 1e-14;
/// A predicted decrease below this fraction of `Φ` cannot be verified: spring energies carry
/// relative round-off of about 1e-16 over their strain. Then Newton takes the full step.
const RESOLUTION: f64 = 1e-10;
/// A step that moves no particle by more than this fraction of the largest coordinate cannot be
/// verified either: it is lost in the round-off of the positions.
const POSITION_ROUND_OFF: f64 = 4.0 * f64::EPSILON;
/// An unverified step must divide the residual by at least this, else round-off has ended all
/// progress.
const LEAST_PROGRESS: f64 = 1.1;
const MAX_HALVINGS: u32 = 30;
/// `δ` of the approximate Wolfe conditions.
const WOLFE_DECREASE: f64 = 0.1;
/// `σ` of the same.
const WOLFE_SLOPE: f64 = 0.9;

/// Minimises an [`IncrementalPotential`] by Newton's method with line search. The minimiser solves
/// the nonlinear system EEH (4) by the iteration (5), reduced to `3n` unknowns as in section 2.3.
///
/// The matrix is the exact Hessian `M + τ_x τ_v ∇²U + τ_v D` while its Cholesky factorisation
/// succeeds. Otherwise the block of each spring is projected to a positive semi-definite one. With
/// a saved Jacobian ([`Jacobian::Saved`]) the factor is kept over iterations and stages. The
/// residual and the line search still use the present potential, so the solution is the same. With
/// conjugate gradients ([`Cg`](crate::NewtonSolver::Cg),
/// [`Multigrid`](crate::NewtonSolver::Multigrid)) the Hessian is taken at the present iterate, and
/// the forcing rule sets the tolerance of the linear system. By the rule of Eisenstat and Walker the
/// last iteration is tight. A [`Safeguard`] continues the iteration if a linearised step would gain
/// energy.
#[derive(Debug)]
pub struct Newton {
    linear: NewtonLinear,
    matrix: NewtonMatrix,
    gradient: Vec<Vec3>,
    direction: Vec<Vec3>,
    trial: Vec<Vec3>,
    previous: Vec<Vec3>,
    topology: u64,
}

impl Default for NewtonReport {
    fn default() -> Self {
        let status = SolveStatus::Converged;
        Self {
            iterations: 0,
            factorisations: 0,
            cg_iterations: 0,
            matvecs: 0,
            residual: 0.0,
            status,
        }
    }
}

impl Newton {
    /// Memory for the implicit effects of `system`, with the sparsity pattern, symbolic
    /// factorisation and multigrid levels that the settings need.
    ///
    /// # Errors
    /// [`PrepareError::Solver`] if the symbolic factorisation fails.
    pub fn new(
        system: &System,
        potential: &IncrementalPotential,
        linear: NewtonLinear,
    ) -> Result<Self, PrepareError> {
        let (n, linear) = (system.len(), linear.resolved());
        let matrix = NewtonMatrix::new(system, potential, linear)?;
        let zeros = || vec![Vec3::zeros(); n];
        Ok(Self {
            linear,
            matrix,
            gradient: zeros(),
            direction: zeros(),
            trial: zeros(),
            previous: zeros(),
            topology: system.revisions().topology,
        })
    }

    /// Whether it chooses its solver.
    pub(crate) fn is_auto(&self) -> bool {
        self.linear.solver == NewtonSolver::Auto
    }

    /// Forgets a saved factor.
    pub fn restart(&mut self) {
        self.matrix.restart();
    }

    /// Minimises `potential`, starting from `v`. On return `v` satisfies the constraints.
    ///
    /// # Errors
    /// [`StepError::NeedsPrepare`] after a change of topology, [`StepError::Solver`] if even the
    /// projected Hessian cannot be factorised (overflow).
    #[doc(alias = "EEH 4")]
    #[doc(alias = "EEH 5")]
    pub fn minimise(
        &mut self,
        system: &System,
        potential: &mut IncrementalPotential,
        constraints: &Constraints,
        v: &mut [Vec3],
        settings: &NewtonSettings,
    ) -> Result<NewtonReport, StepError> {
        if system.revisions().topology != self.topology {
            return Err(StepError::NeedsPrepare);
        }
        constraints.impose(v);
        let mut report =
            NewtonReport { status: SolveStatus::IterationLimit, ..NewtonReport::default() };
        let mut blind = false;
        let mut last_residual = f64::INFINITY;
        let NewtonLinear { jacobian, solver } = self.linear;
        let most_iterations = settings.safeguard.most_iterations(settings.max_iterations);
        self.matrix.begin();
        let mut forcing = self.matrix.forcing(solver, potential);
        let mut is_known = false;
        loop {
            if !is_known {
                let gradient = potential.gradient(system, v); // −r of EEH (5)
                each_particle(system, &mut self.gradient, |i| gradient[i]);
            }
            is_known = false;
            report.residual = potential.filtered_norm(constraints, &mut self.gradient);
            if report.residual <= settings.residual {
                report.status = SolveStatus::Converged;
                break;
            }
            let is_limited = report.iterations >= settings.max_iterations;
            let goes_on = || {
                let Self { gradient, .. } = &*self;
                settings.safeguard.objects(system, potential, constraints, gradient, v)
            };
            if report.iterations == most_iterations || is_limited && !goes_on() {
                break;
            }
            if blind && report.residual * LEAST_PROGRESS > last_residual {
                if report.residual > last_residual {
                    v.copy_from_slice(&self.previous); // the blind step made it worse
                    report.residual = last_residual;
                }
                if jacobian == Jacobian::Saved && self.matrix.forget() {
                    (blind, last_residual) = (false, f64::INFINITY); // once more with a new factor
                    continue;
                }
                report.status = SolveStatus::Stagnated;
                break;
            }
            let falls = report.residual * LEAST_PROGRESS <= last_residual;
            last_residual = report.residual;
            each_particle(system, &mut self.previous, |i| v[i]);
            let is_last = report.iterations + 1 >= settings.max_iterations;
            let next = if is_last { Forcing::last } else { Forcing::next };
            let term = next(&mut forcing, report.residual, settings.residual);
            self.matrix.solve(
                system,
                potential,
                constraints,
                (self.linear, term),
                (&self.gradient, &mut self.direction),
                &mut report,
            )?;
            report.iterations += 1;
            if falls && self.is_auto() && self.descends_by_gradients(system, potential, v) {
                (blind, is_known) = (false, true);
                continue;
            }
            match self.descend(system, potential, v) {
                LineSearch::Verified => blind = false,
                LineSearch::Unresolved => blind = true,
                LineSearch::Failed if jacobian == Jacobian::Saved && self.matrix.forget() => (),
                LineSearch::Failed => {
                    report.status = SolveStatus::Stagnated;
                    break;
                }
            }
        }
        Ok(report)
    }

    /// Takes the full step if the gradients at its ends tell that the potential falls: the
    /// approximate Wolfe conditions of W. W. Hager and H. Zhang, *A new conjugate gradient method
    /// with guaranteed descent and an efficient line search* (2005), (4.3). With the slopes
    /// `s₀ = ∇Φ(v)·d` and `s₁ = ∇Φ(v − d)·d`
    ///
    /// ```text
    /// −(1 − 2δ) s₀ ≤ s₁ ≤ σ s₀          δ = 0.1, σ = 0.9
    /// ```
    ///
    /// On a parabola the left one is Armijo's condition. The gradient then is that of the new `v`.
    fn descends_by_gradients(
        &mut self,
        system: &System,
        potential: &mut IncrementalPotential,
        v: &mut [Vec3],
    ) -> bool {
        let start = dot(&self.gradient, &self.direction);
        let Self { trial, direction, .. } = self;
        each_particle(system, trial, |i| v[i] - direction[i]);
        let gradient = potential.gradient(system, &self.trial);
        let end = dot(gradient, &self.direction);
        let descends = end >= -(1.0 - 2.0 * WOLFE_DECREASE) * start && end <= WOLFE_SLOPE * start;
        if descends {
            each_particle(system, &mut self.gradient, |i| gradient[i]);
            each_particle(system, v, |i| self.trial[i]);
        }
        descends
    }

    /// Armijo line search along `−direction`.
    fn descend(
        &mut self,
        system: &System,
        potential: &mut IncrementalPotential,
        v: &mut [Vec3],
    ) -> LineSearch {
        let start = potential.value(system, v);
        let slope = dot(&self.gradient, &self.direction);
        let largest = |vectors: &[Vec3]| vectors.iter().fold(0.0, |a: f64, v| a.max(v.amax()));
        let reach = potential.tau().x * largest(&self.direction);
        let drowned = reach <= POSITION_ROUND_OFF * largest(potential.last_positions());
        if drowned || slope.abs() <= RESOLUTION * start.abs() {
            v.iter_mut().zip(&self.direction).for_each(|(v, direction)| *v -= direction);
            return LineSearch::Unresolved;
        }
        let slack = ENERGY_ROUND_OFF * start.abs();
        let mut length = 1.0;
        for _ in 0..=MAX_HALVINGS {
            let Self { trial, direction, .. } = self;
            each_particle(system, trial, |i| v[i] - direction[i] * length);
            let value = potential.value(system, &self.trial);
            if value <= start - SUFFICIENT_DECREASE * length * slope + slack {
                v.copy_from_slice(&self.trial);
                let fell = value < start - slack;
                return if fell { LineSearch::Verified } else { LineSearch::Unresolved };
            }
            length *= 0.5;
        }
        LineSearch::Failed
    }
}

/// How a line search ended.
enum LineSearch {
    /// The potential fell.
    Verified,
    /// Newton took a step with a decrease too small to verify.
    Unresolved,
    /// No step length lowers the potential.
    Failed,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Implicit;
    use crate::random::Lcg;
    use crate::test_support::net;

    /// Without a tolerance round-off ends the iteration. Then the better of the last two iterates
    /// is the solution.
    #[test]
    fn an_iteration_that_stagnates_keeps_the_better_of_its_last_two_iterates() {
        let mut random = Lcg::new();
        let mut taken_back = 0;
        for _ in 0..20 {
            let x: Vec<_> = (0..6)
                .map(|i| Vec3::x() * f64::from(i) + Vec3::from_fn(|_, _| 0.3 * random.signed()))
                .collect();
            let springs: Vec<_> = (1..6).map(|i| (i - 1, i, 1e5, 0.9)).collect();
            let (system, state) = net("tension", &[1.0; 6], &x, &springs, &[]);
            let (free, none) = (Constraints::free(6), [Vec3::zeros(); 6]);
            let solve = |max_iterations: u32| {
                let mut potential = IncrementalPotential::new(&system, Implicit::Springs);
                potential.begin(&system, 0.01, (&state.x, &state.v), state.level(), &none);
                let linear =
                    NewtonLinear { jacobian: Jacobian::Fresh, solver: NewtonSolver::Cholesky };
                let mut newton = Newton::new(&system, &potential, linear).expect("a pattern");
                let settings =
                    NewtonSettings { residual: 0.0, max_iterations, safeguard: Safeguard::None };
                let mut v = state.v.clone();
                let report = newton.minimise(&system, &mut potential, &free, &mut v, &settings);
                let mut left = potential.gradient(&system, &v).to_vec();
                (report.expect("solved"), potential.filtered_norm(&free, &mut left))
            };
            let (end, left) = solve(100);
            assert_eq!(end.status, SolveStatus::Stagnated);
            assert_eq!(left, end.residual);
            let [before, last] = [end.iterations - 1, end.iterations].map(|most| solve(most).1);
            assert_eq!(left, last.min(before));
            taken_back += u32::from(last > before);
        }
        assert!(taken_back > 0, "no iterate was worse than the one before");
    }
}
