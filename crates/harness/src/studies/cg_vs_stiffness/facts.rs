//! Records of the experiment `cg-vs-stiffness`.

pub(super) use crate::studies::tables::facts::{PLAIN, UPDATED_PAPER, UPDATED_ROBUST};
use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Step of the base point, s. One factor at a time varies from the base point.
pub(super) const BASE_STEP_S: f64 = 0.01;
/// Forcing term of the base point.
pub(super) const FORCING_TERM: f64 = 0.05;
/// Preconditioner of the base point.
pub(super) const BASE_PRECONDITIONER: &str = "ic0";
/// Start vector of the base point.
pub(super) const BASE_START: &str = "extrapolated";

/// [`Cell::series`] of the sweep over the stiffness.
pub(super) const STIFFNESS: &str = "stiffness";
/// [`Cell::series`] of the sweep over the step.
pub(super) const STEP: &str = "step";
/// [`Cell::series`] of the sweep over the forcing term.
pub(super) const FORCING_TERMS: &str = "forcing-term";

/// [`Cell::material`] of the paper's series.
const FIXED_K_OVER_M: &str = "fixed-k-over-m";

/// [`Motion::label`] of plain IMEX Euler.
pub(super) const PLAIN_MOTION: &str = "imex-euler";
/// [`Motion::label`] of updated, safeguarded CG.
pub(super) const UPDATED_MOTION: &str = "imex-updated";
/// [`Motion::label`] of updated CG without shear springs in the matrix.
pub(super) const TENSION_ONLY: &str = "imex-updated, tension only";
/// [`Motion::label`] of backward Euler, with which the others are compared.
pub(super) const IMPLICIT: &str = "backward-euler";

/// Cells of all series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Iteration counts.
    pub cells: Vec<Cell>,
    /// Motion of the cloth in runs with these settings.
    pub motion: Vec<Motion>,
}

/// Iterations of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// The sweep: `stiffness`, `step` or `forcing-term`. A cell that belongs to several sweeps is
    /// listed in each.
    pub series: String,
    /// Whether k/m is fixed (`fixed-k-over-m`, the paper's series) or the fabric is
    /// (`fixed-material`, where k/m grows with the number of particles).
    pub material: String,
    /// Number of particles.
    pub particles: usize,
    /// Stiffness over mass of the structural springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Time step, s.
    pub step_s: f64,
    /// θ = h²k/m, dimensionless.
    pub theta: f64,
    /// `plain` (EEH 21), `updated-paper` or `updated-robust` (EEH Algorithm 1).
    pub variant: String,
    /// `none`, `jacobi` or `ic0`.
    pub preconditioner: String,
    /// `last` (v_n), `extrapolated` (EEH 22) or `best`.
    pub start: String,
    /// Relative tolerance ε.
    pub forcing_term: f64,
    /// Method id with all settings.
    pub method: String,
    /// Number of steps that ran.
    pub steps: u64,
    /// Number of CG iterations in the whole run.
    pub cg_iterations: u64,
    /// Number of CG iterations a step.
    pub cg_per_step: f64,
    /// Number of outer passes in the whole run.
    pub outer_passes: u64,
    /// Number of Newton iterations in the whole run (robust form only).
    pub newton_iterations: u64,
    /// Number of steps without any CG iteration.
    pub idle_steps: u64,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Greatest rise of the total energy above its start, J.
    pub energy_gain_j: f64,
    /// Greatest rise of the total energy above its least value before, over the energy that the
    /// scene sets free.
    pub energy_climb: f64,
    /// `stable`, `marginal`, `unstable` or `diverged`.
    pub verdict: Verdict,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// The fall of the sheet. Few iterations are no success if it hardly moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Stiffness over mass, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Time step, s.
    pub step_s: f64,
    /// Short name for legends: `imex-euler`, `imex-updated`, `imex-updated, tension only` or
    /// `backward-euler`.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Vertical displacement of the free edge's midpoint at t = 0.3 s, m (negative: down).
    pub fall_m: f64,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Greatest rise of the total energy above its start within the run, J.
    pub energy_gain_j: f64,
    /// `stable`, `marginal`, `unstable` or `diverged`.
    pub verdict: Verdict,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// Whether two settings are equal up to round-off, since either may have been computed.
fn same(a: f64, b: f64) -> bool {
    libm::fabs(a - b) <= 1e-9 * libm::fabs(b)
}

/// Whether a cell has the step and the forcing term of the base point.
pub(super) fn at_base_point(cell: &Cell) -> bool {
    at_base_step(cell) && at_base_forcing_term(cell)
}

/// Whether a cell has the step of the base point.
pub(super) fn at_base_step(cell: &Cell) -> bool {
    same(cell.step_s, BASE_STEP_S)
}

/// Whether a cell has the forcing term of the base point.
pub(super) fn at_base_forcing_term(cell: &Cell) -> bool {
    same(cell.forcing_term, FORCING_TERM)
}

/// Whether a cell has the preconditioner and the start vector of the base point.
pub(super) fn with_base_solver(cell: &Cell) -> bool {
    // The robust form takes the better of both start vectors: extrapolation alone is not safe.
    let start = if cell.variant == UPDATED_ROBUST { "best" } else { BASE_START };
    cell.preconditioner == BASE_PRECONDITIONER && cell.start == start
}

/// Whether a cell belongs to the paper's series.
pub(super) fn at_fixed_k_over_m(cell: &Cell) -> bool {
    cell.material == FIXED_K_OVER_M
}
