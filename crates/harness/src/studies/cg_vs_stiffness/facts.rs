//! Records of the experiment `cg-vs-stiffness`.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub(super) const FORCING_TERM: f64 = 0.05;

/// Cells of all series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Iteration counts.
    pub cells: Vec<Cell>,
    /// What the cloth did meanwhile.
    pub motion: Vec<Motion>,
}

/// Iterations of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Which sweep the cell belongs to: `stiffness`, `step` or `forcing-term`. A cell that belongs
    /// to several stands in each.
    pub series: String,
    /// Whether k/m is held (`fixed-k-over-m`, the paper's series) or the fabric
    /// (`fixed-material`, k/m grows with the number of particles).
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
    /// CG iterations in all.
    pub cg_iterations: u64,
    /// CG iterations per step.
    pub cg_per_step: f64,
    /// Outer passes in all.
    pub outer_passes: u64,
    /// Newton iterations in all (robust form only).
    pub newton_iterations: u64,
    /// Steps that took no CG iteration at all.
    pub idle_steps: u64,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Greatest rise of the total energy above its start, J.
    pub energy_gain_j: f64,
    /// Greatest rise of the total energy above the least it had before, over the energy that the
    /// scene sets free.
    pub energy_climb: f64,
    /// `stable`, `marginal`, `unstable` or `diverged`.
    pub verdict: Verdict,
    /// Same bits on every machine.
    pub portable: bool,
}

/// How far the sheet fell: the check that the counted iterations solved the problem.
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
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Greatest rise of the total energy above its start within the run, J.
    pub energy_gain_j: f64,
    /// `stable`, `marginal`, `unstable` or `diverged`.
    pub verdict: Verdict,
    /// Same bits on every machine.
    pub portable: bool,
}
