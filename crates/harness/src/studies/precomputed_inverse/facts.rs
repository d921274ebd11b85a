//! Records of the experiment `precomputed-inverse`: what a kept inverse costs, and a change of the
//! system.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// [`Solver::solver`]: the inverse itself, `n²` numbers.
pub const DENSE: &str = "dense inverse";
/// [`Solver::solver`]: a sparse Cholesky factor.
pub const CHOLESKY: &str = "sparse Cholesky";
/// [`Solver::solver`]: conjugate gradients with IC(0).
pub const CG: &str = "CG with IC(0)";

/// Counts, agreement and rebuilds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// One a number of particles and solver: what the linear system costs, counted.
    pub solvers: Vec<Solver>,
    /// One a method: runs in which the system changes on the way.
    pub changes: Vec<Change>,
}

/// One solver of `A v = b`, `A = M + h² L_k + h L_c`, on the hanging sheet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Solver {
    /// Number of particles.
    pub particles: usize,
    /// [`DENSE`], [`CHOLESKY`] or [`CG`].
    pub solver: String,
    /// What stays as the mesh gets finer: `k/m = 1e4`, `k/m = 1e6`, or `one fabric`, where k/m
    /// grows with n; `any` for direct solvers, whose cost does not depend on it.
    pub series: String,
    /// Stiffness over mass, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Entries of `A`, both triangles.
    pub matrix_nonzeros: usize,
    /// Entries of what is kept: of the inverse, of the factor's triangle.
    pub kept_nonzeros: usize,
    /// Memory to make and to keep inverse or factor, bytes: `2 n²` numbers for the inverse, 12
    /// bytes an entry of a factor (value and index).
    pub kept_bytes: u64,
    /// Floating-point operations of the set-up, to leading order.
    pub setup_operations: f64,
    /// Operations of a solve for three coordinates, to leading order: of CG at the tolerance of a
    /// step, mean over the run.
    pub solve_operations: f64,
    /// Mean number of CG iterations a step of the run that gives `solve_operations`; 0 for direct
    /// solvers.
    pub cg_per_step: f64,
    /// Difference of the solution to the sparse factor's, relative, Euclidean; CG solves tightly
    /// for it.
    pub disagreement: f64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One method in a run in which step size, stiffness, masses and pins change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// [`DENSE`], [`CHOLESKY`] or [`CG`].
    pub solver: String,
    /// Method id with all settings.
    pub method: String,
    /// Steps of the run.
    pub steps: u64,
    /// First builds of the operator.
    pub first: u32,
    /// Rebuilds after changes of the step size.
    pub step_size: u32,
    /// Rebuilds after changes of stiffness or masses.
    pub stiffness: u32,
    /// Rebuilds after changes of the pins.
    pub constraints: u32,
    /// What was changed, in order, each followed by steps.
    pub changed: Vec<String>,
    /// After each change: greatest distance, m, of a particle to a run that starts anew from the
    /// state at the change, at the end of the steps that follow.
    pub distance_to_fresh_m: Vec<f64>,
    /// Same bits on every machine.
    pub portable: bool,
}

/// Times of one solver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// Number of particles.
    pub particles: usize,
    /// As in [`Solver::solver`].
    pub solver: String,
    /// As in [`Solver::series`].
    pub series: String,
    /// Method whose steps are timed, with all settings.
    pub method: String,
    /// Nanoseconds of the first set-up, with allocation and the analysis of the pattern; one entry
    /// a repetition.
    pub setup_ns: Vec<u64>,
    /// Nanoseconds of a rebuild after a change of the step size, in the memory that is there.
    pub rebuild_ns: Vec<u64>,
    /// Nanoseconds a step of the hanging sheet, each the mean over the steps of one repetition.
    pub step_ns: Vec<u64>,
    /// Nanoseconds a solve of `A v = b` for the right-hand side of the fall's first step, from 0;
    /// CG to the tolerance 1e-3.
    pub solve_ns: Vec<u64>,
}

/// The rows of a solver.
pub(super) fn of<'a>(facts: &'a Facts, solver: &'a str) -> impl Iterator<Item = &'a Solver> {
    facts.solvers.iter().filter(move |row| row.solver == solver)
}

/// The number of particles from which on `solver` solves with fewer operations than `other`.
pub(super) fn crossover<'a>(
    solver: impl Iterator<Item = &'a Solver>,
    other: &[&Solver],
) -> Option<usize> {
    let mut first = None;
    for row in solver {
        let Some(other) = other.iter().find(|other| other.particles == row.particles) else {
            continue;
        };
        if row.solve_operations >= other.solve_operations {
            first = None;
        } else if first.is_none() {
            first = Some(row.particles);
        }
    }
    first
}
