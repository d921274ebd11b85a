//! The iterations of a step, whatever accelerates them.

mod admm;
mod anderson;
mod chebyshev;
mod fixed_point;
mod lbfgs;

use crate::settings::{Acceleration, ProjectiveSettings};
use admm::Admm;
use anderson::Anderson;
use chebyshev::Chebyshev;
use drape_integrator::{
    ContactSet, Implicit, IncrementalPotential, LaplacianSolver, PrepareError, SetupCause,
    SolveStatus, StepError, StepReport, Weights,
};
use drape_model::{System, Vec3};
use drape_solvers::{Constraints, vector::norm};
use lbfgs::Lbfgs;

/// Differences of `Φ` below this fraction of it are round-off.
const ENERGY_ROUND_OFF: f64 = 1e-14;

/// The metric `A = M + h² L_k + h L_c` of all iterations, and its solver.
#[derive(Debug)]
pub(crate) struct Metric {
    linear: LaplacianSolver,
    /// The constraints of the step, brought to rest: those of a *change* of velocity.
    at_rest: Constraints,
    forcing_term: f64,
}

impl Metric {
    /// `out ← A⁻¹ b` under the constraints at rest; `b` is filtered.
    fn solve(&mut self, b: &[Vec3], out: &mut [Vec3], report: &mut StepReport) {
        out.fill(Vec3::zeros());
        let residual = self.forcing_term * norm(b);
        report.add_stage(self.linear.solve_to(&self.at_rest, b, out, residual));
    }

    /// Takes over the filters of `constraints`, at rest.
    fn hold(&mut self, constraints: &Constraints) {
        self.at_rest.clear();
        for i in constraints.constrained().iter().map(|&i| i as usize) {
            self.at_rest.set(i, constraints.filter(i), Vec3::zeros());
        }
    }
}

/// An iterate, and what the next one is made of.
struct Iterate<'a> {
    system: &'a System,
    potential: &'a mut IncrementalPotential,
    metric: &'a mut Metric,
    report: &'a mut StepReport,
    /// `v^k`, m/s; a rule writes `v^{k+1}`.
    v: &'a mut [Vec3],
    /// `S ∇Φ(v^k)`, kg m/s.
    gradient: &'a mut [Vec3],
    /// `f^k = −A⁻¹ S ∇Φ(v^k)`, m/s, once [asked for](Iterate::fixed_point_residual).
    residual: &'a mut [Vec3],
}

/// How `v^{k+1}` follows from the iterates so far.
#[derive(Debug)]
enum Rule {
    Plain,
    Chebyshev(Chebyshev),
    Anderson(Anderson),
    Lbfgs(Lbfgs),
    Admm(Admm),
}

impl Rule {
    fn new(system: &System, settings: &ProjectiveSettings) -> Self {
        let (n, memory) = (system.len(), settings.memory);
        match settings.acceleration {
            Acceleration::None => Self::Plain,
            Acceleration::Chebyshev => Self::Chebyshev(Chebyshev::new(n, settings.rho)),
            Acceleration::Anderson => Self::Anderson(Anderson::new(n, memory)),
            Acceleration::Lbfgs => Self::Lbfgs(Lbfgs::new(n, memory)),
            Acceleration::Admm => Self::Admm(Admm::new(system)),
        }
    }

    /// Forgets the iterates of another minimisation.
    fn begin(&mut self) {
        match self {
            Self::Plain => {}
            Self::Chebyshev(rule) => rule.begin(),
            Self::Anderson(rule) => rule.begin(),
            Self::Lbfgs(rule) => rule.begin(),
            Self::Admm(rule) => rule.begin(),
        }
    }

    fn advance(&mut self, at: &mut Iterate<'_>) {
        match self {
            Self::Plain => fixed_point::advance(at),
            Self::Chebyshev(rule) => rule.advance(at),
            Self::Anderson(rule) => rule.advance(at),
            Self::Lbfgs(rule) => rule.advance(at),
            Self::Admm(rule) => rule.advance(at),
        }
    }
}

/// Minimises the incremental potential.
#[derive(Debug)]
pub(crate) struct Minimiser {
    pub(crate) potential: IncrementalPotential,
    metric: Metric,
    rule: Rule,
    gradient: Vec<Vec3>,
    residual: Vec<Vec3>,
}

impl Minimiser {
    pub(crate) fn new(
        system: &System,
        settings: &ProjectiveSettings,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let (implicit, weights) = (Implicit::Springs, Weights::StiffnessAndDamping);
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            potential: IncrementalPotential::new(system, implicit),
            metric: Metric {
                linear: LaplacianSolver::new(system, implicit, weights, settings.linear(), h)?,
                at_rest: ContactSet::constraints(system),
                forcing_term: settings.forcing_term,
            },
            rule: Rule::new(system, settings),
            gradient: zeros(),
            residual: zeros(),
        })
    }

    /// Brings the matrix and its factor up to date.
    pub(crate) fn refresh(
        &mut self,
        system: &System,
        h: f64,
    ) -> Result<Option<SetupCause>, StepError> {
        self.metric.linear.refresh(system, h)
    }

    /// Iterates from `v`, which obeys the constraints on return.
    ///
    /// A fixed number of iterations has no tolerance to miss: like Kang's sweeps it ends as
    /// `Converged`, and the relative residual tells how far it came.
    pub(crate) fn minimise(
        &mut self,
        settings: &ProjectiveSettings,
        system: &System,
        constraints: &Constraints,
        v: &mut [Vec3],
        report: &mut StepReport,
    ) {
        let Self { potential, metric, rule, gradient, residual } = self;
        metric.hold(constraints);
        rule.begin();
        constraints.impose(v);
        report.solve = SolveStatus::Converged;
        let wanted = settings.residual * potential.scale();
        let tolerance = wanted.max(potential.round_off());
        let mut iterations = 0;
        let left = loop {
            gradient.copy_from_slice(potential.gradient(system, v));
            let left = potential.filtered_norm(constraints, gradient);
            if left <= tolerance {
                report.solve = potential.status(report.solve, left, wanted);
                break left;
            }
            if iterations == settings.iterations {
                if wanted > 0.0 && report.solve == SolveStatus::Converged {
                    report.solve = SolveStatus::IterationLimit;
                }
                break left;
            }
            rule.advance(&mut Iterate { system, potential, metric, report, v, gradient, residual });
            iterations += 1;
            report.outer_passes += 1;
        };
        report.relative_residual = potential.relative(left);
    }
}
