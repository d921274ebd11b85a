//! Records of the experiment `hard-cases`.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Why a scene without moving springs is stable.
pub(crate) const NOTHING_MOVES: &str =
    "no spring moves: every method gives the discrete parabola, or stands still";

/// The form of updated CG that the paper prints, as in [`Facts::methods`].
pub(super) const PRINTED: &str = "imex-updated (paper)";
/// The safeguarded form of updated CG, as in [`Facts::methods`].
pub(super) const SAFEGUARDED: &str = "imex-updated";

/// Largest allowance for round-off over `E_ref` at which rises of the energy can be counted.
const VISIBLE: f64 = 1e-3;

/// What theory says of a method on a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Expected {
    /// A theorem: the energy rises in no step.
    #[serde(rename = "stable, no rise in any step")]
    Monotone,
    /// Stable.
    #[serde(rename = "stable")]
    Stable,
    /// Unstable.
    #[serde(rename = "unstable")]
    Unstable,
    /// Nothing is proved.
    #[serde(rename = "no theorem")]
    NoTheorem,
    /// The case has nothing to vary for this method.
    #[serde(rename = "")]
    NotAsked,
}

impl std::fmt::Display for Expected {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl Expected {
    /// The words of records and pages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Monotone => "stable, no rise in any step",
            Self::Stable => "stable",
            Self::Unstable => "unstable",
            Self::NoTheorem => "no theorem",
            Self::NotAsked => "",
        }
    }

    /// Whether a verdict agrees with what theory says; `rises` is the number of steps in which the
    /// energy rose. A run without a verdict agrees with everything.
    pub fn admits(self, verdict: Verdict, rises: u64) -> bool {
        match self {
            Self::Monotone if verdict == Verdict::Stable => rises == 0,
            Self::Monotone | Self::Stable => !verdict.is_judged() || verdict == Verdict::Stable,
            Self::Unstable => !matches!(verdict, Verdict::Stable | Verdict::Marginal),
            Self::NoTheorem | Self::NotAsked => true,
        }
    }
}

/// Cases, methods and the verdict on each of their pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The rows of the table.
    pub cases: Vec<Case>,
    /// The columns: methods, each at its defaults or in a named form.
    pub methods: Vec<String>,
    /// One cell for each case, method and damping.
    pub cells: Vec<Cell>,
    /// Cells whose verdict differs from theory without an explanation.
    pub unexplained: Vec<String>,
}

/// A hard case, or one variant of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Id and title, e.g. `H04 squeezed to half`. Cells refer to the case by it.
    pub name: String,
    /// The scene in one sentence.
    pub scene: String,
    /// How its energy is judged.
    pub judged: String,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Time step, s.
    pub step_s: f64,
    /// Number of steps.
    pub steps: u64,
    /// Simulated time, s.
    pub duration_s: f64,
    /// `E_ref`, the energy that the scene sets free without damping, J.
    pub released_undamped_j: f64,
    /// `E_ref` with damping, J.
    pub released_damped_j: f64,
}

/// One method on one case, undamped or damped: the worst of several perturbed starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Name of the case.
    pub case: String,
    /// Method and form, as in [`Facts::methods`].
    pub method: String,
    /// Whether the springs are damped.
    pub is_damped: bool,
    /// Method id with all settings.
    pub settings: String,
    /// `stable`, `marginal`, `unstable` or `diverged`. A cell without a verdict says why:
    /// `over budget`, `refused` or `not applicable`.
    pub verdict: Verdict,
    /// Why the cell has no verdict, or that a sheet at rest moves; otherwise empty.
    pub note: String,
    /// What theory says.
    pub expected: Expected,
    /// Why theory says so.
    pub reason: String,
    /// Whether the verdict differs from what theory says.
    pub differs: bool,
    /// Why the verdict differs, if that is known.
    pub explanation: Option<String>,
    /// Number of starts that ran. A divergence or the end of the budget ends the series.
    pub runs: u32,
    /// Greatest rise of the total energy above its start, over `E_ref`.
    pub gain: f64,
    /// Secular slope of the total energy times the duration, over `E_ref`. It is taken from the
    /// start whose slope is the steepest.
    pub drift: f64,
    /// Number of steps in all runs in which the energy rose by more than round-off.
    pub rises: u64,
    /// Greatest allowance for round-off in the count of rises, over `E_ref`. It grows with `h²k/m`;
    /// where it is large, the count means nothing.
    pub round_off: f64,
    /// Number of steps in all runs.
    pub steps: u64,
    /// Simulated time that every run reached, s.
    pub reached_s: f64,
    /// Number of CG iterations in all runs.
    pub cg_iterations: u64,
    /// Number of Newton iterations in all runs.
    pub newton_iterations: u64,
    /// Number of steps in all runs whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Greatest distance of the unperturbed start from its equilibrium, m; `None` unless it is one.
    pub strayed_m: Option<f64>,
    /// Greatest speed in the same run, m/s.
    pub strayed_m_per_s: Option<f64>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

impl Cell {
    /// Whether a theorem says that the energy rises in no step.
    pub(super) fn is_monotone(&self) -> bool {
        self.expected == Expected::Monotone
    }

    /// Whether round-off is small enough to count rises.
    pub(super) fn shows_rises(&self) -> bool {
        self.round_off <= VISIBLE
    }
}
