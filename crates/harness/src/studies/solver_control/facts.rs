//! Records of the experiment `solver-control`: forcing terms, saved Jacobians, adaptive steps,
//! preconditioners.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Label of IMEX Euler with the estimator that uses positions only.
pub const PLAIN: &str = "imex-euler, plain estimate";

/// All runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes, with the error of their reference solutions.
    pub scenes: Vec<Scene>,
    /// One run for each series, scene, label and value.
    pub runs: Vec<Run>,
    /// Step sizes over time of some adaptive runs.
    pub histories: Vec<History>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: `hanging-1e4`, `hanging-1e6`, `hanging-1e8` or `vibrating-1e4`.
    pub id: String,
    /// Stiffness over mass of the tension springs, 1/s². Shear springs have a tenth.
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// Simulated time, s. Errors are taken at its end.
    pub span_s: f64,
    /// Greatest distance of a particle from a reference solution with a tenfold tolerance, m.
    pub reference_error_m: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// `forcing`, `jacobian`, `steps` or `preconditioner`.
    pub series: String,
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Label of the curve or row within its series.
    pub label: String,
    /// Whether the method chose its own steps.
    pub is_adaptive: bool,
    /// The value that varies. In `forcing` it is the inner tolerance, or `None` for
    /// Eisenstat-Walker. In `steps` it is the step size in s, or the tolerance in mesh widths. It
    /// is `None` elsewhere.
    pub value: Option<f64>,
    /// Method id with all settings.
    pub method: String,
    /// Step size, s. For an adaptive run, the time between two frames.
    pub step_s: f64,
    /// `‖x − x_ref‖_M / ‖x_ref − x_0‖_M` at the end; `None` if the run did not reach it.
    pub error: Option<f64>,
    /// Greatest rise of the total energy above its start at the end of a step, J; 0 if it never
    /// rose.
    pub energy_gain_j: f64,
    /// Number of accepted substeps; without step size control, number of steps.
    pub substeps: u64,
    /// Number of rejected substeps.
    pub rejected: u64,
    /// Number of set-ups of the kept matrix.
    pub setups: u64,
    /// Number of factorisations of Newton's matrix.
    pub factorisations: u64,
    /// Number of Newton iterations.
    pub newton_iterations: u64,
    /// Number of updates of the right-hand side.
    pub outer_passes: u64,
    /// Number of CG iterations.
    pub cg_iterations: u64,
    /// Number of products with the matrix.
    pub matvecs: u64,
    /// Number of sweeps over the springs that evaluated forces or energies.
    pub force_evaluations: u64,
    /// All work, in sweeps over the springs. A product counts 2 with the scalar matrix and 6 with
    /// Newton's 3×3 blocks. A set-up of the scalar matrix counts 30, a factorisation of Newton's
    /// 1000, and a solve with its factor 18.
    pub work_sweeps: u64,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// `completed`, `diverged` or `over budget`.
    pub verdict: Verdict,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// The step sizes of one adaptive run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct History {
    /// Key of the scene.
    pub scene: String,
    /// Label of the run.
    pub label: String,
    /// Tolerance, mesh widths.
    pub tolerance: f64,
    /// Time at the end of each frame, s.
    pub time_s: Vec<f64>,
    /// Mean size of the substeps of each frame, s.
    pub step_s: Vec<f64>,
}

/// Seconds of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// As [`Run::series`].
    pub series: String,
    /// As [`Run::scene`].
    pub scene: String,
    /// As [`Run::label`].
    pub label: String,
    /// As [`Run::is_adaptive`].
    pub is_adaptive: bool,
    /// As [`Run::value`].
    pub value: Option<f64>,
    /// Samples of the time of all steps together, ns.
    pub samples_ns: Vec<u64>,
    /// Median of the samples, s.
    pub median_s: f64,
}

/// An adaptive run, and the run with the longest constant step that is at least as accurate.
pub(super) struct Matched<'a> {
    pub(super) adaptive: &'a Run,
    pub(super) constant: &'a Run,
}

impl Matched<'_> {
    /// Work of the adaptive run, over that of the constant step.
    pub(super) fn ratio(&self) -> f64 {
        self.adaptive.work_sweeps as f64 / self.constant.work_sweeps as f64
    }
}

/// The adaptive runs for which some constant step is at least as accurate, except runs of the
/// [`PLAIN`] estimate.
pub(super) fn matched(facts: &Facts) -> Vec<Matched<'_>> {
    let steps = || facts.runs.iter().filter(|run| run.series == "steps");
    let adaptive = steps().filter(|run| run.is_adaptive && run.label != PLAIN);
    let pairs = adaptive.filter_map(|run| {
        let is_match = |other: &&Run| {
            !other.is_adaptive
                && (&other.scene, &other.label) == (&run.scene, &run.label)
                && other.error.zip(run.error).is_some_and(|(a, b)| a <= b)
        };
        let constant = steps().filter(is_match).min_by_key(|other| other.substeps)?;
        Some(Matched { adaptive: run, constant })
    });
    pairs.collect()
}

/// Labels of the methods that run with constant inner tolerances and with Eisenstat and Walker's.
pub(super) fn inner(facts: &Facts) -> Vec<&str> {
    let forcing = || facts.runs.iter().filter(|run| run.series == "forcing");
    let walker = forcing().filter(|run| run.value.is_none());
    let is_both =
        |run: &&Run| forcing().any(|other| other.label == run.label && other.value.is_some());
    let mut labels: Vec<_> = walker.filter(is_both).map(|run| run.label.as_str()).collect();
    labels.dedup();
    labels
}
