//! The record of a comparison: what was asked, what was run, what came out.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Times within this factor are a tie.
pub const TIE: f64 = 1.5;

/// How the error of a motion is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Metric {
    /// Mean distance of the surfaces, both ways, mean over the looks.
    #[default]
    Shape,
    /// Root of the mean square distance of the particles, mean over the looks.
    Trajectory,
}

impl Metric {
    /// Its word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shape => "shape",
            Self::Trajectory => "trajectory",
        }
    }
}

/// One scene, its true motion, the methods and their runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scene and the question.
    pub scene: Scene,
    /// What the runs are held against.
    pub truth: Truth,
    /// The forms of methods that were asked for.
    pub forms: Vec<Form>,
    /// One a form and number of steps a frame, in the order in which they were made.
    pub runs: Vec<Run>,
    /// Wall time of all, pages aside, s.
    pub seconds: f64,
}

/// The scene and the question.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// The scene as it was asked for.
    pub name: String,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Number of frames.
    pub frames: u32,
    /// Length of a frame, s.
    pub frame_s: f64,
    /// Longest side of the box around the cloth at the start, m.
    pub size_m: f64,
    /// How errors are measured.
    pub metric: Metric,
    /// Greatest error that was asked for, m.
    pub target_m: f64,
    /// Wall time that may be spent, s.
    pub budget_s: f64,
    /// Steps a frame within the limit of symplectic Euler at the start, by power iteration.
    pub limit_substeps: u32,
    /// Whether pins, obstacles or wind do work on the cloth. Then a gain of energy is a rise beyond
    /// their work.
    #[serde(default)]
    pub is_driven: bool,
}

/// What the runs are held against.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Method with all settings; `None` where no run could be made.
    pub method: Option<String>,
    /// Steps a frame of this method.
    pub substeps: u32,
    /// Error when its step is doubled, m.
    pub error_m: Option<f64>,
    /// Number of true motions: one without noise, the others from perturbed starts.
    pub members: usize,
    /// Noise, m: the mean distance of a true motion from the nearest of the others. So the noise
    /// is measured as the error of a run is. Smaller errors mean nothing.
    pub floor_m: Option<f64>,
    /// The same of true motions of the pushed cloth; `None` where there are none.
    #[serde(default)]
    pub pushed_floor_m: Option<f64>,
    /// Mean path of all free particles, m.
    pub path_m: Option<f64>,
    /// Whether anything moves by more than round-off.
    pub moves: bool,
    /// Energy that the scene sets free, J.
    pub released_j: Option<f64>,
    /// Energy that the true motion gains, for example by pushing particles out of obstacles, J.
    pub gain_j: f64,
    /// Whether its error is small enough to rank by. Otherwise each run is held against that of the
    /// same form with fewer steps (self-convergence), and that distance is also its error bar.
    pub is_trusted: bool,
    /// Why, where it is not.
    pub remark: Option<String>,
}

/// One form of a method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Form {
    /// Short name.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Why no more steps a frame were tried.
    pub end: End,
    /// What the method cannot do, by name.
    pub refusal: Option<String>,
}

/// Why a form was not run with more steps a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// It meets the target; more steps only cost more.
    Good,
    /// It takes more than three times as long as another form that meets the target.
    Dominated,
    /// The most steps a frame were tried.
    Exhausted,
    /// The time was over.
    OutOfTime,
    /// The method refuses the scene.
    Refused,
}

/// One run of a form.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Place of its form in [`Facts::forms`].
    pub form: usize,
    /// Steps a frame.
    pub substeps: u32,
    /// `over budget`: it was stopped because it is dominated or the time was over.
    pub verdict: Verdict,
    /// Distance from the true motion by the metric, m; with self-convergence from the run before.
    pub error_m: Option<f64>,
    /// Mean path of all free particles over that of the true motion. Without a true motion, the
    /// share of the motion that the run kept beside references in a few windows.
    pub retained: Option<f64>,
    /// Greatest rise of the energy over what the scene sets free. Where pins, obstacles or wind do
    /// work: the rise that is surely beyond their work, over the greatest kinetic energy of the run.
    pub gain: Option<f64>,
    /// Force sweeps.
    pub force_evaluations: u64,
    /// Products of a matrix with a block vector.
    pub matvecs: u64,
    /// Factorisations.
    pub factorisations: u64,
    /// Iterations of conjugate gradients.
    pub cg_iterations: u64,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Wall time of the steps a frame, s: the least of the repetitions, on one core.
    pub frame_s: f64,
    /// How often it was timed.
    pub repetitions: u32,
    /// Whether the same steps gain no energy where all free particles are pushed at the start, in
    /// three directions, or in fewer where the time ended. Only the best are tried.
    pub holds_when_pushed: Option<bool>,
    /// Distance from the true motion of the pushed cloth by the metric, m, where there is one.
    #[serde(default)]
    pub pushed_m: Option<f64>,
    /// Share of the motion that the advised run keeps by theory, where that is so little that the cloth
    /// locks. The run may be near the true motion all the same, as far as the metric tells. `None` for
    /// all other runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foreseen: Option<f64>,
}

impl Facts {
    /// The greatest error that meets the target, m: the target, or twice the noise where that is
    /// more. A motion that differs by noise alone is off by the noise. A motion with an error of the
    /// same size is off by about twice that.
    pub fn good_m(&self) -> f64 {
        self.truth.good_m(self.scene.target_m)
    }

    /// Whether a run meets the target.
    pub fn is_met(&self, run: &Run) -> bool {
        self.truth.is_met(self.scene.target_m, run)
    }

    /// Whether a run meets the target, but exceeds it on the pushed cloth, where it gains no
    /// energy.
    pub fn strays(&self, run: &Run) -> bool {
        let target_m = self.scene.target_m;
        self.truth.is_met_here(target_m, run) && !self.truth.is_near_when_pushed(target_m, run)
    }

    /// The form of a run.
    pub fn form_of(&self, run: &Run) -> &Form {
        &self.forms[run.form]
    }
}

impl Truth {
    /// As [`Facts::good_m`], for any target, m.
    pub fn good_m(&self, target_m: f64) -> f64 {
        target_m.max(2.0 * self.floor_m.unwrap_or(0.0))
    }

    /// Whether a run meets a target, m: it is sound and its error is small enough. On the pushed
    /// cloth, as far as that was tried, it gains no energy and its error is small enough, too.
    pub fn is_met(&self, target_m: f64, run: &Run) -> bool {
        self.is_met_here(target_m, run) && self.is_near_when_pushed(target_m, run)
    }

    /// As [`is_met`](Self::is_met), whatever the error on the pushed cloth.
    fn is_met_here(&self, target_m: f64, run: &Run) -> bool {
        let is_near = run.error_m.is_some_and(|error| error <= self.good_m(target_m));
        run.is_sound() && is_near && !run.is_fragile()
    }

    /// Whether the error on the pushed cloth is small enough, or was not measured.
    fn is_near_when_pushed(&self, target_m: f64, run: &Run) -> bool {
        let good = target_m.max(2.0 * self.pushed_floor_m.unwrap_or(0.0));
        run.pushed_m.is_none_or(|error| error <= good)
    }
}

impl Run {
    /// Whether it can be shown: it neither gains energy nor stands still. Where it is not known
    /// whether it gains energy beyond the work of pins, obstacles and wind, the error alone counts.
    pub fn is_sound(&self) -> bool {
        matches!(self.verdict, Verdict::Stable | Verdict::Open)
    }

    /// Whether it gains energy once the cloth is pushed a little: its step is at the edge of
    /// stability.
    pub fn is_fragile(&self) -> bool {
        self.holds_when_pushed == Some(false)
    }

    /// Whether the solver stopped before its tolerance in more than half of the steps of so many
    /// frames.
    pub fn is_rough(&self, frames: u32) -> bool {
        2 * self.unconverged_steps > u64::from(frames) * u64::from(self.substeps)
    }

    /// Whether it gained energy or left the scene.
    pub fn explodes(&self) -> bool {
        self.verdict.gains_energy()
    }
}
