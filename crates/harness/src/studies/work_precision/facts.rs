//! Records of the experiment `work-precision`: what accuracy costs.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Series of scenes in which the stiffness varies.
pub const STIFFNESS: &str = "stiffness";
/// Series of scenes of more and more particles, stiffness over mass fixed.
pub const FIXED_QUOTIENT: &str = "size, k/m fixed";
/// Series of scenes of more and more particles, material fixed.
pub const FIXED_MATERIAL: &str = "size, material fixed";

/// A lead below this factor is a tie: steps are powers of two, and the modelled time of a form may
/// be off by as much.
pub const LEAD: f64 = 2.0;

/// All scenes and methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Scenes with stiffness, damping and size, and the errors of their reference solutions.
    pub scenes: Vec<Scene>,
    /// One a scene and method.
    pub rows: Vec<Row>,
    /// The cheapest run by modelled time at each scene and level of error.
    pub winners: Vec<Winner>,
}

/// One scene at one stiffness, damping and size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key, e.g. `hanging light 1e6 n=400`.
    pub id: String,
    /// `hanging`, `thrown` or `spread`.
    pub scene: String,
    /// `light` (10/s at 400 particles) or `heavy` (`d/m = √(k/m)`).
    pub damping: String,
    /// Series that the scene belongs to: `stiffness`, `size, k/m fixed`, `size, material fixed`.
    pub series: Vec<String>,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// Bound on the largest angular frequency, `√(8 (k + k_s)/m)`, 1/s.
    pub greatest_frequency_per_s: f64,
    /// Simulated time after which the error is taken, s.
    pub span_s: f64,
    /// Root of the mass-weighted mean square of how far the particles move in that time, m.
    pub motion_m: f64,
    /// Error of the reference, in the norm of all other errors: distance of two solutions whose
    /// tolerances differ tenfold, over the motion.
    pub reference_error: f64,
    /// The tighter of the two tolerances of the reference.
    pub reference_tolerance: f64,
    /// Most effort of a run, in visits of a spring.
    pub budget: f64,
}

/// One method on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Short name for legends: the method's id, and what sets it apart from its other rows.
    pub label: String,
    /// Method id with the settings that are the same in all runs; `dop853` for the adaptive method
    /// of a library.
    pub method: String,
    /// What differs from run to run: `steps`, `tolerance` or another setting of the method.
    pub knob: String,
    /// Whether it stands in the headline figure.
    pub is_headline: bool,
    /// One a value of the knob, from the coarsest run.
    pub runs: Vec<Run>,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Value of the knob: number of steps, tolerance, or another setting.
    pub value: f64,
    /// Length of the steps that the method is asked for, s; `None` for the library, which chooses
    /// its own.
    pub step_s: Option<f64>,
    /// `completed`, `diverged` or `over budget`.
    pub verdict: Verdict,
    /// `‖x − x_ref‖_M / ‖x_ref − x_0‖_M` at the end; `None` unless completed.
    pub error: Option<f64>,
    /// Its other errors, where the study measures them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside: Option<Beside>,
    /// Modelled time of the run, s: its counts times the prices of the form, which were measured
    /// once and are part of the source. Runs are ranked by it.
    pub modelled_s: f64,
    /// Visits of a spring, the unit of the budget. For a run over budget those when it was given
    /// up, 0 where it was not begun.
    pub effort: f64,
    /// Steps that it took.
    pub steps: u64,
    /// Sweeps over all springs that evaluated forces or energies.
    pub force_evaluations: u64,
    /// Products of a matrix with a block vector, triangular solves included.
    pub matvecs: u64,
    /// Factorisations of Newton's matrix.
    pub factorisations: u64,
    /// Set-ups of cached operators.
    pub setups: u64,
    /// Iterations of conjugate gradients.
    pub cg_iterations: u64,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Whether no run of any method on this scene has at most this error for less modelled time.
    pub is_on_front: bool,
    /// Whether the counts have the same bits on every machine. Errors never have: the reference
    /// passes through a library.
    pub portable: bool,
}

/// Errors of a run beside that of the positions at the end, against the nearest true motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Beside {
    /// Mean distance of the surfaces, both ways, mean over time, m.
    pub shape_m: f64,
    /// How much the 99th percentile of the strain exceeds the true one, mean over time.
    pub strain: f64,
    /// Energy at the end beyond the true one, over what the scene sets free: negative where the
    /// method dissipates.
    pub energy: f64,
    /// Path of the midpoint of the free edge over the true one.
    pub retained: f64,
}

/// The cheapest run at one scene and level of error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Winner {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Level of error: that of the winner is at most this.
    pub level: f64,
    /// As in [`Row::label`]; `None` where no run gets there.
    pub label: Option<String>,
    /// Whether stiffness limits its step: an explicit method.
    pub is_explicit: Option<bool>,
    /// Value of the winner's knob, as in [`Run::value`].
    pub value: Option<f64>,
    /// Modelled time of the winner, s.
    pub modelled_s: Option<f64>,
    /// The cheapest row of another method.
    pub runner_up: Option<String>,
    /// Modelled time of the runner-up over that of the winner.
    pub ratio: Option<f64>,
    /// Rows of other methods whose modelled time is so near that the order is not known: a tie.
    pub tied: Vec<Tied>,
}

/// A method that is as cheap as the winner, as far as can be told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tied {
    /// As in [`Row::label`].
    pub label: String,
    /// As in [`Winner::is_explicit`].
    pub is_explicit: bool,
    /// Modelled time of the tied row over that of the winner, below [`LEAD`].
    pub ratio: f64,
}

/// Times of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// As in [`Row::label`].
    pub label: String,
    /// Value of the knob, as in [`Run::value`].
    pub value: f64,
    /// Nanoseconds of the whole run, one entry a repetition: set-up and all steps.
    pub samples_ns: Vec<u64>,
    /// Median of the samples, s.
    pub seconds: f64,
    /// Error of the run that was timed, as in [`Run::error`].
    pub error: f64,
    /// Whether it equals the fact's to the last bit; otherwise the run is not ranked.
    pub is_verified: bool,
}

/// The rows of a scene.
pub(super) fn rows_of<'a>(
    facts: &'a Facts,
    scene: &'a str,
) -> impl Iterator<Item = &'a Row> + Clone {
    facts.rows.iter().filter(move |row| row.scene == scene)
}

impl Row {
    /// Whether it spends its budget without reaching an error of `level`.
    pub(super) fn misses(&self, level: f64) -> bool {
        let is_cut = self.runs.last().is_some_and(|run| run.verdict == Verdict::OverBudget);
        is_cut && cheapest(std::iter::once(self), level).is_none()
    }
}

/// The run with the least modelled time among those with an error of at most `level`; of equally
/// dear ones the more exact.
pub(in crate::studies) fn cheapest<'a>(
    rows: impl Iterator<Item = &'a Row>,
    level: f64,
) -> Option<(&'a Row, &'a Run)> {
    cheapest_of(rows.flat_map(|row| row.runs.iter().map(move |run| (row, run))), level)
}

/// As [`cheapest`], of chosen runs.
pub(super) fn cheapest_of<'a>(
    runs: impl Iterator<Item = (&'a Row, &'a Run)>,
    level: f64,
) -> Option<(&'a Row, &'a Run)> {
    let good = runs.filter(|(_, run)| run.error.is_some_and(|error| error <= level));
    good.min_by(|(_, a), (_, b)| {
        let by_error = || a.error.unwrap_or(f64::NAN).total_cmp(&b.error.unwrap_or(f64::NAN));
        a.modelled_s.total_cmp(&b.modelled_s).then_with(by_error)
    })
}
