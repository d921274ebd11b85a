//! Records of the experiment `stability`: which steps, stiffness and damping a method survives.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The form for which the energy theorem holds.
pub const EXACT: &str = "imex-euler, all springs";

/// All maps and limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The atlas: each method at each step, stiffness and damping.
    pub cells: Vec<Cell>,
    /// The longest stable steps.
    pub limits: Vec<Limit>,
    /// How much explicit shear stiffness a method survives beside implicit tension.
    pub shear: Vec<Shear>,
}

/// One method on the hanging sheet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Short name for legends.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Stiffness over mass of the tension springs, 1/s²; shear springs have a tenth.
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s; shear springs have a tenth.
    pub damping_over_mass_per_s: f64,
    /// Step size, s.
    pub step_s: f64,
    /// `stable`, `locked`, `marginal`, `unstable`, `diverged` or `over budget`: the worst verdict
    /// of all starts. `over budget` without a start follows from a longer step.
    pub verdict: Verdict,
    /// Number of perturbed starts that were run. Without any, gain, drift and simulated time are 0.
    pub starts: u32,
    /// Greatest rise of the energy above its start, over `E_ref`, the energy that the scene sets
    /// free.
    pub gain: f64,
    /// Drift of the energy over the run, by a fitted straight line, over `E_ref`. It is the
    /// greatest in size of all starts.
    pub drift: f64,
    /// Greatest distance of the free edge's midpoint from its start within 2 s, over the true one:
    /// the least of all starts. `None` if a run ended before 2 s.
    pub reach: Option<f64>,
    /// Simulated time, s: the least of all starts.
    pub reached_s: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// The longest stable step of one method on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// `pair` or `sheet`. The pair is two free particles on a spring of rest length 0, for which
    /// theory is exact. The sheet is the hanging sheet, for which theory is a bound.
    pub scene: String,
    /// Short name for legends.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// Largest eigenvalue of `M⁻¹ L_k`, 1/s².
    pub largest_eigenvalue_per_s2: f64,
    /// The rule from which [`Limit::theory_s`] follows, in words.
    pub rule: String,
    /// Longest step for which no mode grows, s, from the closed form. It is 0 if a mode grows at
    /// every step, and `None` if there is no theory or no limit within the range.
    pub theory_s: Option<f64>,
    /// Longest step for which no mode's energy grows by more than 2 % within the run, s. Failure of
    /// a longer step is visible.
    pub visible_s: Option<f64>,
    /// Longest step that was found stable, s; an unstable step is at most 5 % longer. `None` if no
    /// step was stable.
    pub measured_s: Option<f64>,
    /// Whether no unstable step was found. Then `measured_s` is the longest step of the range.
    pub is_unlimited: bool,
    /// Shortest and longest step of the range, s.
    pub range_s: [f64; 2],
    /// Number of runs.
    pub runs: u32,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// A scan over the ratio of explicit shear to implicit tension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shear {
    /// Short name for legends.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Step size, s.
    pub step_s: f64,
    /// Ratio up to which no mode has `θ_E > 4 + θ_I`, whatever the positions of the sheet.
    pub bound: f64,
    /// Ratio from which on some mode has `θ_E > 4 + θ_I` at the start. `None` if no ratio that was
    /// run has one.
    pub start_bound: Option<f64>,
    /// Least ratio at which the run is not stable.
    pub first_failure: Option<f64>,
    /// The ratios with their verdicts and gains of energy over `E_ref`.
    pub ratios: Vec<Ratio>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One run of a scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ratio {
    /// Stiffness of the shear springs over that of the tension springs.
    pub ratio: f64,
    /// `stable`, `marginal`, `unstable`, `diverged` or `over budget`.
    pub verdict: Verdict,
    /// Greatest rise of the energy above its start over `E_ref`.
    pub gain: f64,
}

impl Limit {
    /// Whether the limit belongs to the pair.
    pub(super) fn is_pair(&self) -> bool {
        self.scene == "pair"
    }

    /// Whether the method's solver stops as early as the paper's.
    pub(super) fn is_loose(&self) -> bool {
        self.method.contains("forcing_term=0.05")
    }
}

/// Measured over theoretical limit; `None` if theory has no finite limit.
pub(super) fn over_theory(limit: &Limit) -> Option<f64> {
    let theory = limit.theory_s.filter(|theory| *theory > 0.0)?;
    Some(limit.measured_s.unwrap_or(0.0) / theory)
}

/// The labels of the atlas in the record's order.
pub(super) fn labels(facts: &Facts) -> Vec<&str> {
    let mut labels: Vec<&str> = Vec::new();
    for cell in &facts.cells {
        if !labels.contains(&cell.label.as_str()) {
            labels.push(&cell.label);
        }
    }
    labels
}

/// Whether the run of a cell gained energy.
pub(super) fn has_gained(cell: &Cell) -> bool {
    cell.verdict.gains_energy()
}
