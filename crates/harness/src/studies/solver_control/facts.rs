//! Records of the experiment `solver-control`: forcing terms, saved Jacobians, adaptive steps,
//! preconditioners.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// IMEX Euler with the estimator that looks at positions alone.
pub const PLAIN: &str = "imex-euler, plain estimate";

/// All runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes, with the error of their reference solutions.
    pub scenes: Vec<Scene>,
    /// One a series, scene, label and value.
    pub runs: Vec<Run>,
    /// Step sizes of some of the adaptive runs.
    pub histories: Vec<History>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: `hanging-1e4`, `hanging-1e6`, `hanging-1e8` or `vibrating-1e4`.
    pub id: String,
    /// Stiffness over mass of the tension springs, 1/s²; shear springs have a tenth.
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// Simulated time after which the error is taken, s.
    pub span_s: f64,
    /// Largest distance of a particle to the reference solution with a tenfold tolerance, m.
    pub reference_error_m: f64,
    /// Same bits on every machine.
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
    /// What sets the curve or row apart from the others of its series.
    pub label: String,
    /// Whether the method chose its steps.
    pub is_adaptive: bool,
    /// What varies: the inner tolerance (`forcing`; `None` for Eisenstat-Walker), the step size in
    /// s or the tolerance in mesh widths (`steps`); `None` elsewhere.
    pub value: Option<f64>,
    /// Method id with all settings.
    pub method: String,
    /// Step size, or the time between two frames for an adaptive run, s.
    pub step_s: f64,
    /// `‖x − x_ref‖_M / ‖x_ref − x_0‖_M` at the end; `None` for a run that did not get there.
    pub error: Option<f64>,
    /// Greatest total energy at the end of a step above that at the start, J; 0 if it never rose.
    pub energy_gain_j: f64,
    /// Substeps that stand; without control, steps.
    pub substeps: u64,
    /// Substeps that were taken back.
    pub rejected: u64,
    /// Set-ups of the kept matrix.
    pub setups: u64,
    /// Factorisations of Newton's matrix.
    pub factorisations: u64,
    /// Newton iterations.
    pub newton_iterations: u64,
    /// Updates of the right-hand side.
    pub outer_passes: u64,
    /// CG iterations.
    pub cg_iterations: u64,
    /// Products with the matrix.
    pub matvecs: u64,
    /// Sweeps over the springs that evaluated forces or energies.
    pub force_evaluations: u64,
    /// All work, weighed in sweeps over the springs. A product with the scalar matrix counts 2,
    /// with Newton's 3×3 blocks 6, a set-up of the scalar matrix 30, a factorisation of Newton's
    /// 1000, a solve with its factor 18.
    pub work_sweeps: u64,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// `completed`, `diverged` or `over budget`.
    pub verdict: Verdict,
    /// Same bits on every machine.
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
    /// End of each frame, s.
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
    /// Raw samples of all steps together, ns.
    pub samples_ns: Vec<u64>,
    /// Median of the samples, s.
    pub median_s: f64,
}

/// An adaptive run, and the cheapest constant step that is at least as exact.
pub(super) struct Matched<'a> {
    pub(super) adaptive: &'a Run,
    pub(super) constant: &'a Run,
}

impl Matched<'_> {
    /// Work of the adaptive run over the constant step's.
    pub(super) fn ratio(&self) -> f64 {
        self.adaptive.work_sweeps as f64 / self.constant.work_sweeps as f64
    }
}

/// Adaptive runs that a constant step matches in error, without those of the [`PLAIN`] estimate.
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

/// Labels of the methods whose inner tolerance is run as a constant and by Eisenstat and Walker.
pub(super) fn inner(facts: &Facts) -> Vec<&str> {
    let forcing = || facts.runs.iter().filter(|run| run.series == "forcing");
    let walker = forcing().filter(|run| run.value.is_none());
    let is_both =
        |run: &&Run| forcing().any(|other| other.label == run.label && other.value.is_some());
    let mut labels: Vec<_> = walker.filter(is_both).map(|run| run.label.as_str()).collect();
    labels.dedup();
    labels
}
