//! Records of the experiment `order`: observed order of accuracy and error constant.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Greatest accepted distance of the observed order from theory.
pub(super) const ACCEPTED: f64 = 0.15;

/// A method that is off by so much of the motion at its finest step does not follow it.
const LOST: f64 = 0.5;

/// All methods on all scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes, with the error of their reference solutions.
    pub scenes: Vec<Scene>,
    /// One a method and scene.
    pub rows: Vec<Row>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: `smooth`, `smooth-projected`, `stiff-1e4` or `stiff-1e6`.
    pub id: String,
    /// Whether the steps resolve every oscillation (`h ω_max < 0.5`), so that theory holds.
    pub resolved: bool,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// `full` or `projected`.
    pub damping: String,
    /// Bound on the largest angular frequency, `√(8 (k + k_s)/m)`, 1/s.
    pub greatest_frequency_per_s: f64,
    /// Simulated time after which the error is taken, s.
    pub span_s: f64,
    /// Largest distance of a particle from its place in a reference with ten times the tolerance,
    /// m.
    pub reference_error_m: f64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One method on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Short name for legends: the method's id, and what sets it apart from its other rows.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Order that theory gives; `None` for a method that claims none.
    pub theory: Option<u32>,
    /// Observed order: slope of `log e` over `log h` by least squares over [`Row::fitted`] runs;
    /// `None` where fewer than three can be used.
    pub order: Option<f64>,
    /// Number of runs in the fit: from the finest step up to the first that diverged.
    pub fitted: usize,
    /// Whether `|order − theory| < 0.15` over all runs; `None` where the scene is not resolved or
    /// the method claims no order.
    pub accepted: Option<bool>,
    /// `C = e/h^p` at the finest step, 1/s^p, for the order `p` of theory; `None` where another
    /// order was observed.
    pub error_constant: Option<f64>,
    /// One a step size, from the coarsest.
    pub runs: Vec<Run>,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Step size, s.
    pub step_s: f64,
    /// `‖x − x_ref‖_M / ‖x_ref − x_0‖_M` at the end; `None` for a run that diverged.
    pub error: Option<f64>,
    /// `completed`, or `diverged`: the state is not finite, has left the scene, or is farther from
    /// the reference than that is from the start (error of 1 or more).
    pub verdict: Verdict,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
}

/// What is left of the order of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Outcome {
    /// The order of theory is observed.
    Kept,
    /// Another order is observed.
    Reduced,
    /// An order is observed where none is claimed.
    Unclaimed,
    /// Off by half the motion or more at the finest step.
    Lost,
    /// Too few runs for an order.
    Few,
    /// Diverged even at the finest step.
    Diverged,
}

impl Outcome {
    /// All outcomes, the best first.
    pub(super) const ALL: [Self; 6] =
        [Self::Kept, Self::Reduced, Self::Unclaimed, Self::Lost, Self::Few, Self::Diverged];

    /// In words.
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

/// What is left of the order of a row.
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
