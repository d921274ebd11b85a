//! Records of the experiment `course`: methods that build on each other, on one cloth.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A method that keeps less than this share of the motion has lost some.
pub(super) const MOVES: f64 = 0.9;

/// The lessons, with the true motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The cloth at each of its stiffnesses, with its true motion.
    pub scenes: Vec<Scene>,
    /// The lessons, in the order in which they build on each other.
    pub lessons: Vec<Lesson>,
    /// Ids of the five methods that are compared first, in the order of the lessons.
    pub headline: Vec<String>,
    /// How each method treats each effect.
    pub support: Vec<Support>,
}

/// The cloth at one stiffness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name of the bundled scene.
    pub id: String,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Number of particles.
    pub particles: usize,
    /// Step size of the runs, s.
    pub step_s: f64,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Span over which the motion is compared, s.
    pub compared_s: f64,
    /// Energy that the scene sets free, `E_ref`, J.
    pub released_energy_j: f64,
    /// Times of the heights, s.
    pub time_s: Vec<f64>,
    /// Height of the free edge's midpoint in the true motion, m.
    pub height_m: Vec<f64>,
    /// Length of the path of the free edge's midpoint in the true motion within the compared span,
    /// m.
    pub path_m: f64,
    /// Total energy at the end less that at the start, over `E_ref`.
    pub energy_change: f64,
    /// Greatest elongation of a spring, over its rest length.
    pub greatest_stretch: f64,
    /// Step size of the reference, s.
    pub reference_step_s: f64,
    /// Greatest difference between the heights of the reference and of one with twice the step,
    /// within the compared span, m.
    pub reference_error_m: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lesson {
    /// Method id.
    pub id: String,
    /// Name in prose.
    pub title: String,
    /// Method id with the settings that are not at their defaults, as the command line takes it.
    pub method: String,
    /// The crate whose documentation explains the method.
    pub docs: String,
    /// The idea of the method, and what is new in it.
    pub idea: String,
    /// The shortcoming of the method before, with its numbers; `None` for the first.
    pub before: Option<String>,
    /// The result of this method, with its numbers.
    pub finding: String,
    /// Its runs, one for each scene.
    pub runs: Vec<Run>,
}

/// One method on one cloth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Name of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Method id with all settings.
    pub settings: String,
    /// `stable`, `marginal`, `unstable`, `diverged` or `over budget`.
    pub verdict: Verdict,
    /// Simulated time that was reached, s.
    pub reached_s: f64,
    /// Number of completed steps.
    pub steps: u64,
    /// Retained motion `R`: length of the path of the free edge's midpoint, over that in the true
    /// motion. `None` unless stable.
    pub retained_motion: Option<f64>,
    /// Greatest difference of the midpoint's height from the true one within the compared span, m;
    /// `None` unless stable.
    pub height_error_m: Option<f64>,
    /// Greatest rise of the total energy above its start, over `E_ref`; `None` if it diverged.
    pub energy_gain: Option<f64>,
    /// Total energy at the end less that at the start, over `E_ref`; `None` if it diverged.
    pub energy_change: Option<f64>,
    /// Greatest elongation of a spring, over its rest length; `None` unless stable.
    pub greatest_stretch: Option<f64>,
    /// Number of evaluations of the forces.
    pub force_evaluations: u64,
    /// Number of products with a matrix.
    pub matvecs: u64,
    /// Number of CG iterations.
    pub cg_iterations: u64,
    /// Number of Newton iterations.
    pub newton_iterations: u64,
    /// Number of factorisations of a matrix.
    pub factorisations: u64,
    /// Modelled time of the run, s, the measure of work.
    pub modelled_s: f64,
    /// Height of the free edge's midpoint at the times of the scene, m. The list ends with the run.
    pub height_m: Vec<f64>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// How a method treats each effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Support {
    /// Method id.
    pub method: String,
    /// All effects and constraints that some method knows. Each has one of `implicit`, `explicit`,
    /// `by setting`, `constraint` and `refused`.
    pub effects: Vec<(String, String)>,
}

/// Whether a run keeps most of the motion.
pub(super) fn moves(run: &Run) -> bool {
    run.retained_motion.is_some_and(|motion| motion >= MOVES)
}

/// The methods that keep most of the motion on a sheet with their runs, least work first.
pub(super) fn by_work<'a>(facts: &'a Facts, scene: &Scene) -> Vec<(&'a Lesson, &'a Run)> {
    let run = |lesson: &'a Lesson| lesson.runs.iter().find(|run| run.scene == scene.id);
    let runs = facts.lessons.iter().filter_map(|lesson| Some((lesson, run(lesson)?)));
    let mut moving: Vec<_> = runs.filter(|(_, run)| moves(run)).collect();
    moving.sort_by(|a, b| a.1.modelled_s.total_cmp(&b.1.modelled_s));
    moving
}
