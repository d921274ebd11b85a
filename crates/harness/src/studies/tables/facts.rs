//! Records of the experiment `tables`: the paper's tables 2 and 3.

use crate::record::Phases;
use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Values of the forcing term in the sweep.
pub(super) const FORCING_TERMS: [f64; 8] = [0.2, 0.1, 0.07, 0.05, 0.03, 0.01, 1e-3, 1e-4];

/// Counts fit the paper's if they are within this factor of them.
pub(super) const COMMON_FIT: f64 = 1.25;

/// [`Cell::variant`] of plain IMEX Euler.
pub const PLAIN: &str = "plain";
/// [`Cell::variant`] of Algorithm 1 as printed.
pub const UPDATED_PAPER: &str = "updated-paper";
/// [`Cell::variant`] of the safeguarded form of Algorithm 1.
pub const UPDATED_ROBUST: &str = "updated-robust";
/// The variants of the method, in the order of all legends and tables.
pub const VARIANTS: [&str; 3] = [PLAIN, UPDATED_PAPER, UPDATED_ROBUST];

/// A stable run is named if its energy climbs by more than this share of the released energy.
const CLIMB: f64 = 0.02;

/// All rows. Those with the assumed exponents come first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// One row for each row of the paper's tables and reading of its exponent.
    pub rows: Vec<Row>,
}

/// One row of a table of the paper, recomputed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Key of the row, e.g. `table2-row1-1e4`.
    pub id: String,
    /// 2 (square table) or 3 (hanging textile), as numbered in the paper's text.
    pub table: u32,
    /// Row within the table, from 1.
    pub row: u32,
    /// Bundled scene that the row runs.
    pub scene: String,
    /// Number of particles.
    pub particles: usize,
    /// Stiffness over mass of the structural springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Whether drape takes this reading of the illegible exponent (4 and 6). The neighbouring
    /// readings are run for comparison.
    pub assumed_reading: bool,
    /// Damping over mass of the structural springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// Time step, s.
    pub step_s: f64,
    /// The printed numbers of the paper.
    pub paper: PaperRow,
    /// One cell for each run: counts over one simulated second.
    pub cells: Vec<Cell>,
    /// The forcing term of each variant whose count is nearest to the paper's, by ratio.
    pub best_fit: Vec<BestFit>,
}

/// The printed columns of a row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperRow {
    /// CG iterations in one second.
    pub cg_iterations: u64,
    /// Seconds in CG on the paper's machine, a MIPS R10000 at 250 MHz.
    pub cg_s: f64,
    /// Seconds in the set-up of the matrix on that machine.
    pub matrix_setup_s: f64,
    /// Seconds of the whole solver on that machine.
    pub solver_s: f64,
}

/// Counts of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// `plain` (EEH 21), `updated-paper` or `updated-robust` (EEH Algorithm 1).
    pub variant: String,
    /// Method id with all settings, as `drape run --method` takes it.
    pub method: String,
    /// Relative tolerance ε of the solver.
    pub forcing_term: f64,
    /// CG iterations in one second.
    pub cg_iterations: u64,
    /// Outer passes of Algorithm 1 in one second (0 for plain).
    pub outer_passes: u64,
    /// Newton iterations in one second (robust form only).
    pub newton_iterations: u64,
    /// Matrix-vector products.
    pub matvecs: u64,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Greatest rise of the total energy above its start, J.
    pub energy_gain_j: f64,
    /// Greatest rise of the total energy above its least value before, over the energy that the
    /// scene sets free.
    pub energy_climb: f64,
    /// `stable`, `marginal`, `unstable` or `diverged`.
    pub verdict: Verdict,
    /// Whether every number of the cell has the same bits on every machine, i.e. no library
    /// factorisation took part.
    pub portable: bool,
}

/// Best-fitting forcing term of one variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BestFit {
    /// As in [`Cell::variant`].
    pub variant: String,
    /// The ε of the sweep with the nearest count.
    pub forcing_term: f64,
    /// CG iterations in one second with that ε.
    pub cg_iterations: u64,
    /// CG iterations with that ε, over the paper's.
    pub ratio: f64,
}

/// Times of one row with one variant and one policy for the matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// Key of the row, as in [`Row::id`].
    pub id: String,
    /// As in [`Cell::variant`].
    pub variant: String,
    /// Method id with all settings.
    pub method: String,
    /// `kept` (built once) or `rebuilt` (each step, as the paper's varying moduli need).
    pub matrix: String,
    /// CG iterations in one second. They connect the time with the count.
    pub cg_iterations: u64,
    /// Number of steps in one simulated second.
    pub steps: u64,
    /// Nanoseconds in all `step` calls together with the phase clock off: one entry for each
    /// repetition.
    pub samples_ns: Vec<u64>,
    /// Median of the samples, s.
    pub solver_s: f64,
    /// Seconds before the first step: allocation, first build of matrix and preconditioner.
    pub prepare_s: f64,
    /// Times of the phases in a separate pass with the phase clock on, s.
    pub phases_s: Phases,
}

/// The rows with the readings that drape takes.
pub(super) fn assumed(rows: &[Row]) -> impl Iterator<Item = &Row> + Clone {
    rows.iter().filter(|row| row.assumed_reading)
}

/// The factor, at least 1, by which a ratio is off.
fn factor(ratio: f64) -> f64 {
    ratio.max(1.0 / ratio)
}

/// Whether a best fit is near the paper's count and its run is stable.
pub(super) fn fits(row: &Row, fit: &BestFit) -> bool {
    let is_stable = |cell: &Cell| {
        cell.variant == fit.variant
            && cell.forcing_term == fit.forcing_term
            && cell.verdict == Verdict::Stable
    };
    factor(fit.ratio) <= COMMON_FIT && row.cells.iter().any(is_stable)
}

/// Whether a run is stable although its energy climbs again after a fall.
pub(super) fn climbs(cell: &Cell) -> bool {
    cell.verdict == Verdict::Stable && cell.energy_climb > CLIMB
}

/// Stiffness over mass of the reading whose best count is nearest to the paper's, 1/s².
pub(super) fn nearest_reading(rows: &[Row], of: &Row, variant: &str) -> Option<f64> {
    let same = rows.iter().filter(|row| (row.table, row.row) == (of.table, of.row));
    let fits = same.filter_map(|row| {
        let fit = row.best_fit.iter().find(|fit| fit.variant == variant)?;
        Some((row.stiffness_over_mass_per_s2, factor(fit.ratio)))
    });
    fits.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
}

/// The factor by which a forcing term misses the paper's count in the worst row; `None` if some row
/// was not run with it.
pub(super) fn worst_factor(rows: &[Row], variant: &str, term: f64) -> Option<f64> {
    assumed(rows).try_fold(1.0_f64, |worst, row| {
        let cell = row.cells.iter().find(|c| c.variant == variant && c.forcing_term == term)?;
        let ratio = cell.cg_iterations.max(1) as f64 / row.paper.cg_iterations as f64;
        Some(worst.max(factor(ratio)))
    })
}

/// The forcing term with the least factor in its worst row, and that factor.
pub(super) fn best_common(rows: &[Row], variant: &str) -> Option<(f64, f64)> {
    let factors = FORCING_TERMS
        .into_iter()
        .filter_map(|term| worst_factor(rows, variant, term).map(|worst| (term, worst)));
    assumed(rows).next().and(factors.min_by(|a, b| a.1.total_cmp(&b.1)))
}
