//! Records of the experiment `precomputed-inverse`: the cost of a kept inverse, and of a change of
//! the system.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// [`Solver::solver`]: the inverse itself, with `n²` numbers.
pub const DENSE: &str = "dense inverse";
/// [`Solver::solver`]: a sparse Cholesky factor.
pub const CHOLESKY: &str = "sparse Cholesky";
/// [`Solver::solver`]: conjugate gradients with IC(0).
pub const CG: &str = "CG with IC(0)";

/// Counts, agreement and rebuilds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Counted costs of the linear system: one for each number of particles and solver.
    pub solvers: Vec<Solver>,
    /// Runs in which the system changes: one for each method.
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
    /// What is kept as the mesh becomes finer: `k/m = 1e4`, `k/m = 1e6`, or `one fabric`, where k/m
    /// grows with n. It is `any` for direct solvers, whose cost does not depend on it.
    pub series: String,
    /// Stiffness over mass, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Number of entries of `A`, both triangles.
    pub matrix_nonzeros: usize,
    /// Number of entries that are kept: of the inverse, or of the factor's triangle.
    pub kept_nonzeros: usize,
    /// Memory to make and to keep the inverse or the factor, bytes: `2 n²` numbers for the inverse,
    /// and 12 bytes for each entry of a factor (value and index).
    pub kept_bytes: u64,
    /// Number of floating-point operations of the set-up, to leading order.
    pub setup_operations: f64,
    /// Number of operations of a solve for three coordinates, to leading order. CG solves to the
    /// tolerance of a step, and its number is a mean over the run.
    pub solve_operations: f64,
    /// Mean number of CG iterations a step in the run for `solve_operations`; 0 for direct solvers.
    pub cg_per_step: f64,
    /// Relative difference of the solution from the sparse factor's, in the Euclidean norm. CG
    /// solves tightly here.
    pub disagreement: f64,
    /// Whether the record has the same bits on every machine.
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
    /// Number of steps of the run.
    pub steps: u64,
    /// Number of first builds of the operator.
    pub first: u32,
    /// Number of rebuilds after changes of the step size.
    pub step_size: u32,
    /// Number of rebuilds after changes of stiffness or masses.
    pub stiffness: u32,
    /// Number of rebuilds after changes of the pins.
    pub constraints: u32,
    /// The changes, in order. Steps follow each of them.
    pub changed: Vec<String>,
    /// Comparison with a run that starts anew after each change: the greatest distance of a
    /// particle, m, at the end of the steps that follow.
    pub distance_to_fresh_m: Vec<f64>,
    /// Whether the record has the same bits on every machine.
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
    /// Nanoseconds of the first set-up, with allocation and the analysis of the pattern: one entry
    /// for each repetition.
    pub setup_ns: Vec<u64>,
    /// Nanoseconds of a rebuild after a change of the step size, in memory that is already
    /// allocated.
    pub rebuild_ns: Vec<u64>,
    /// Nanoseconds a step of the hanging sheet. Each entry is the mean over the steps of a
    /// repetition.
    pub step_ns: Vec<u64>,
    /// Nanoseconds a solve of `A v = b` from 0, for the right-hand side of the fall's first step.
    /// CG solves to the tolerance 1e-3.
    pub solve_ns: Vec<u64>,
}

/// The rows of a solver.
pub(super) fn of<'a>(facts: &'a Facts, solver: &'a str) -> impl Iterator<Item = &'a Solver> {
    facts.solvers.iter().filter(move |row| row.solver == solver)
}

/// The number of particles from which on `solver` takes fewer operations for a solve than `other`;
/// `None` if there is none.
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
