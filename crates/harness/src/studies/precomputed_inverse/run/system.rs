//! The linear system of a step and its three solvers.

use crate::HarnessError;
use crate::methods::Choice;
use crate::run::Simulation;
use crate::studies::precomputed_inverse::facts::{CG, CHOLESKY, DENSE, Solver};
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::studies::stepper::Stepper;
use drape_integrator::{
    Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, SolverKind, StopNorm, Weights,
    hold_pins,
};
use drape_model::{DampingLaw, SystemSpec, Vec3};
use drape_solvers::{CompleteCholesky, Constraints, DenseInverse, ScalarMatrix};

/// Step size, s.
pub(super) const STEP: f64 = 0.01;
/// Tolerance of CG in the runs: the default of IMEX Euler.
pub(super) const LOOSE: f64 = 1e-3;
/// Tolerance of CG for comparing its solution.
const TIGHT: f64 = 1e-14;
/// Largest memory of an inverse, bytes.
const MEMORY: usize = 1 << 31;
/// Number of coordinates of a particle.
const COORDINATES: f64 = 3.0;
/// Number of steps of the run in which CG iterations are counted.
const COUNTED: u64 = 100;
/// Number of steps before the one whose solutions are compared.
const TAKEN: u64 = 20;

/// A sheet and a solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Case {
    /// Particles along each edge.
    pub(super) side: u32,
    pub(super) solver: &'static str,
    pub(super) series: &'static str,
    pub(super) stiffness: f64,
}

impl Case {
    pub(super) fn name(&self) -> String {
        format!("{} particles, k/m = {:e}", self.side * self.side, self.stiffness)
    }

    pub(super) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        hanging(self.side, self.stiffness)
    }

    /// The method that solves its steps with this solver.
    pub(super) fn method(&self) -> String {
        match self.solver {
            DENSE => "desbrun:inverse=dense,torque=none".to_owned(),
            CHOLESKY => "desbrun:inverse=cholesky,torque=none".to_owned(),
            _ => format!("imex-euler:implicit=springs,forcing_term={LOOSE}"),
        }
    }

    pub(super) fn settings(&self, forcing_term: f64) -> LinearSettings {
        LinearSettings {
            forcing_term,
            preconditioner: PreconditionerKind::Ic0,
            norm: StopNorm::Euclid,
            solver: match self.solver {
                DENSE => SolverKind::DenseInverse { limit_bytes: MEMORY },
                CHOLESKY => SolverKind::Cholesky,
                _ => SolverKind::Cg,
            },
            rebuild_every_step: false,
        }
    }
}

/// The sheet of side `side`, hanging from two corners.
pub(super) fn hanging(side: u32, stiffness: f64) -> Result<SystemSpec, HarnessError> {
    Sheet {
        side,
        tension: stiffness,
        shear: 0.1 * stiffness,
        damping: 40.0,
        law: DampingLaw::Full,
        gravity: GRAVITY,
        is_pinned: true,
    }
    .spec()
}

/// The linear system `A v = b` of a step from a state, under the pins.
pub(super) struct Problem {
    pub(super) simulation: Simulation,
    pub(super) constraints: Constraints,
    pub(super) b: Vec<Vec3>,
}

impl Problem {
    /// The system of the step that follows `steps` steps of the fall.
    pub(super) fn new(spec: &SystemSpec, steps: u64) -> Result<Self, HarnessError> {
        let (system, mut state) = spec.build()?;
        let fall = Choice::parse("imex-euler:implicit=springs,forcing_term=1e-10", &[])?;
        let mut stepper = Stepper::new(&fall, &system, STEP)?;
        for _ in 0..steps {
            stepper.step(&system, &mut state)?;
        }
        let mut b = vec![Vec3::zeros(); system.len()];
        system.forces(state.level(), &mut b);
        for (i, b) in b.iter_mut().enumerate() {
            *b = *b * STEP + state.v[i] * system.mass()[i];
        }
        let mut constraints = Constraints::free(system.len());
        hold_pins(&system, &mut constraints);
        Ok(Self { simulation: Simulation { system, state }, constraints, b })
    }

    pub(super) fn solver(&self, settings: LinearSettings) -> Result<LaplacianSolver, HarnessError> {
        let (system, weights) = (&self.simulation.system, Weights::StiffnessAndDamping);
        Ok(LaplacianSolver::new(system, Implicit::Springs, weights, settings, STEP)?)
    }

    fn solution(&self, settings: LinearSettings) -> Result<Vec<Vec3>, HarnessError> {
        let mut v = vec![Vec3::zeros(); self.b.len()];
        self.solver(settings)?.solve(&self.constraints, &self.b, &mut v);
        Ok(v)
    }
}

fn norm(vectors: impl Iterator<Item = Vec3>) -> f64 {
    vectors.map(|v| v.norm_squared()).sum::<f64>().sqrt()
}

/// Number of entries in each row of the lower triangle, including the diagonal.
fn lower_counts(matrix: &ScalarMatrix) -> impl Iterator<Item = usize> {
    (0..matrix.n()).map(|i| matrix.row(i).0.iter().filter(|&&j| j as usize <= i).count())
}

/// Number of operations of a CG iteration: a product with the matrix, the two triangles, and five
/// operations on vectors.
fn iteration(n: f64, matrix: f64, lower: f64) -> f64 {
    COORDINATES * (2.0 * matrix + 4.0 * lower + 10.0 * n)
}

/// Mean number of CG iterations a step of the fall, at the usual tolerance.
fn cg_per_step(case: &Case, problem: &Problem) -> Result<f64, HarnessError> {
    let Simulation { system, state } = &problem.simulation;
    let mut state = state.clone();
    let mut stepper = Stepper::new(&Choice::parse(&case.method(), &[])?, system, STEP)?;
    let mut iterations = 0;
    for _ in 0..COUNTED {
        let report = stepper.step(system, &mut state)?;
        iterations += report.map_or(0, |report| u64::from(report.cg_iterations));
    }
    Ok(iterations as f64 / COUNTED as f64)
}

/// Counts of one solver, and the difference of its solution from the sparse factor's.
pub(super) fn solver(case: &Case) -> Result<Solver, HarnessError> {
    let spec = case.spec()?;
    let problem = Problem::new(&spec, TAKEN)?;
    let settings = case.settings(TIGHT);
    let built = problem.solver(settings)?;
    let matrix = built.matrix();
    let n = matrix.n();
    let size = n as f64;
    let squares = |counts: &[usize]| counts.iter().map(|count| (count * count) as f64).sum::<f64>();
    let (kept_nonzeros, kept_bytes, setup_operations, solve_operations, cg_per_step);
    match case.solver {
        DENSE => {
            kept_nonzeros = n * n;
            kept_bytes = DenseInverse::bytes_needed(n);
            setup_operations = size * size * size;
            solve_operations = COORDINATES * 2.0 * size * size;
            cg_per_step = 0.0;
        }
        CHOLESKY => {
            let factor =
                CompleteCholesky::new(matrix).map_err(drape_integrator::PrepareError::from)?;
            let counts: Vec<usize> = factor.column_counts().collect();
            kept_nonzeros = counts.iter().sum();
            kept_bytes = 12 * kept_nonzeros as u64;
            setup_operations = squares(&counts);
            solve_operations = COORDINATES * 4.0 * kept_nonzeros as f64;
            cg_per_step = 0.0;
        }
        _ => {
            let counts: Vec<usize> = lower_counts(matrix).collect();
            kept_nonzeros = counts.iter().sum();
            kept_bytes = 12 * kept_nonzeros as u64;
            setup_operations = squares(&counts);
            cg_per_step = self::cg_per_step(case, &Problem::new(&spec, 0)?)?;
            // The first residual and its preconditioning cost about as much as an iteration.
            solve_operations = (cg_per_step + 1.0)
                * iteration(size, matrix.nonzeros() as f64, kept_nonzeros as f64);
        }
    }
    let expected = problem.solution(Case { solver: CHOLESKY, ..*case }.settings(TIGHT))?;
    let found = problem.solution(settings)?;
    let difference = norm(found.iter().zip(&expected).map(|(a, b)| a - b));
    Ok(Solver {
        particles: n,
        series: case.series.to_owned(),
        stiffness_over_mass_per_s2: case.stiffness,
        solver: case.solver.to_owned(),
        matrix_nonzeros: matrix.nonzeros(),
        kept_nonzeros,
        kept_bytes,
        setup_operations,
        solve_operations,
        cg_per_step,
        disagreement: difference / norm(expected.iter().copied()),
        portable: false,
    })
}

/// All solvers on sheets with these sides. The cost of a direct solver does not depend on the
/// stiffness.
pub(super) fn cases(sides: &[u32]) -> Vec<Case> {
    let mut cases = Vec::new();
    for &side in sides {
        let case = |solver, series, stiffness| Case { side, solver, series, stiffness };
        let refinement = f64::from(side) / 20.0;
        cases.extend([
            case(DENSE, "any", 1e6),
            case(CHOLESKY, "any", 1e6),
            case(CG, "k/m = 1e4", 1e4),
            case(CG, "k/m = 1e6", 1e6),
            case(CG, "one fabric", 1e6 * refinement * refinement),
        ]);
    }
    cases
}
