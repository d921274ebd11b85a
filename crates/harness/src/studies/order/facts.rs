//! Records of the experiment `order`: observed order of accuracy and error constant.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Largest accepted difference of the observed order from theory.
pub(super) const ACCEPTED: f64 = 0.15;

/// A method has lost the motion if its error at the finest step is at least this.
const LOST: f64 = 0.5;

/// All methods on all scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes, with the error of their reference solutions.
    pub scenes: Vec<Scene>,
    /// One row for each method and scene.
    pub rows: Vec<Row>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: `smooth`, `smooth-projected`, `stiff-1e4` or `stiff-1e6`.
    pub id: String,
    /// Whether the steps resolve every oscillation (`h ω_max < 0.5`). Theory holds only then.
    pub resolved: bool,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// `full` or `projected`.
    pub damping: String,
    /// Bound on the largest angular frequency, `√(8 (k + k_s)/m)`, 1/s.
    pub greatest_frequency_per_s: f64,
    /// Simulated time, s. Errors are taken at its end.
    pub span_s: f64,
    /// Greatest distance of a particle from its position in a reference with ten times the
    /// tolerance, m.
    pub reference_error_m: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One method on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Short name for legends: the method's id, and what sets this row apart from the method's
    /// others.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Order of convergence in theory; `None` for a method that claims none.
    pub theory: Option<u32>,
    /// Observed order: the slope of `log e` over `log h` by least squares over [`Row::fitted`]
    /// runs. `None` if fewer than three runs can be used.
    pub order: Option<f64>,
    /// Number of runs in the fit: from the finest step up to the first run that diverged.
    pub fitted: usize,
    /// Whether `|order − theory| < 0.15` over all runs. `None` if the scene is not resolved or the
    /// method claims no order.
    pub accepted: Option<bool>,
    /// `C = e/h^p` at the finest step, 1/s^p, for the order `p` of theory. `None` if another order
    /// was observed.
    pub error_constant: Option<f64>,
    /// One run for each step size, coarsest first.
    pub runs: Vec<Run>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Step size, s.
    pub step_s: f64,
    /// `‖x − x_ref‖_M / ‖x_ref − x_0‖_M` at the end; `None` if the run diverged.
    pub error: Option<f64>,
    /// `completed` or `diverged`. A run has diverged if its state is not finite, has left the
    /// scene, or has an error of 1 or more.
    pub verdict: Verdict,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
}

/// How a row's observed order compares with theory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Outcome {
    /// The observed order is that of theory.
    Kept,
    /// Another order is observed.
    Reduced,
    /// An order is observed, but the method claims none.
    Unclaimed,
    /// The error at the finest step is half of the motion or more.
    Lost,
    /// Too few runs for an order.
    Few,
    /// Diverged even at the finest step.
    Diverged,
}

impl Outcome {
    /// All outcomes, best first.
    pub(super) const ALL: [Self; 6] =
        [Self::Kept, Self::Reduced, Self::Unclaimed, Self::Lost, Self::Few, Self::Diverged];

    /// The outcome in words.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Kept => "with the order of theory",
            Self::Reduced => "with another order",
            Self::Unclaimed => "without a claim",
            Self::Lost => "off by half the motion",
            Self::Few => "with too few runs",
            Self::Diverged => "diverged",
        }
    }
}

/// The error of a row at its finest step; `None` if that run diverged.
pub(super) fn finest_error(row: &Row) -> Option<f64> {
    row.runs.last().and_then(|run| run.error)
}

/// The outcome of a row.
pub(super) fn outcome(row: &Row) -> Outcome {
    match (finest_error(row), row.order) {
        (None, _) => Outcome::Diverged,
        (Some(error), _) if error >= LOST => Outcome::Lost,
        (_, None) => Outcome::Few,
        (_, Some(_)) if row.theory.is_none() => Outcome::Unclaimed,
        (_, Some(_)) if row.error_constant.is_some() => Outcome::Kept,
        (_, Some(_)) => Outcome::Reduced,
    }
}
