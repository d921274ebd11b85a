//! Records of the experiment `animation`: what a frame costs that is good enough.

use crate::methods::runs::Inside;
pub use crate::studies::filmed::Counters;
use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Smallest error that a figure asks for, m. A form whose run is as near tries no dearer ones.
pub const FINE: f64 = 1e-3;
/// Largest error that a film can use, m, where noise does not hide more.
pub const GOOD: f64 = 0.01;
/// Damping of a spring over its stiffness that counts as heavy, or any larger one, s.
pub const HEAVY: f64 = 1e-3;
/// Times within this factor are a tie: of most forms the numbers of calls are powers of two.
pub const TIE: f64 = 2.0;
/// A method also ties that would lead or tie if the accepted error were larger or smaller by this
/// factor.
pub const NEARLY: f64 = 1.1;
/// A good run has the true motion's mean kinetic energy within this factor: noise may allow an error
/// so large that a sluggish run meets it.
pub const LIVELY: f64 = 1.5;
/// If no distance ranks, the strain of a good run exceeds the true one by at most this.
pub const STRETCHED: f64 = 0.01;

/// All scenes and methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes, each with its true motion.
    pub scenes: Vec<Scene>,
    /// One run for each scene, form of a method and number of substeps.
    pub runs: Vec<Run>,
    /// Forms that a long study did not run or time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<Missing>,
}

impl Facts {
    /// Number of forms that a long study did not run on a scene.
    pub fn not_run(&self, scene: &Scene) -> usize {
        let own = self.missing.iter().filter(|missing| missing.scene == scene.id);
        own.map(|missing| missing.not_run.len() + missing.over_budget.len()).sum()
    }
}

/// Forms without a run, or without a timing, on a scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Missing {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Labels of the forms for whose runs there was no time.
    pub not_run: Vec<String>,
    /// Labels of the forms that were run, but for whose timings there was no time.
    pub not_timed: Vec<String>,
    /// Labels of the forms that were left out, since without a sound run they exceed the budget on
    /// the same cloth over a shorter span.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub over_budget: Vec<String>,
}

impl Missing {
    /// Whether any form is named.
    pub fn names_any(&self) -> bool {
        !(self.not_run.is_empty() && self.not_timed.is_empty() && self.over_budget.is_empty())
    }
}

/// The measure that ranks the runs of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Distance of the surfaces over the whole span. It can rank cloth that pins hold without wind,
    /// whose motions stay close to each other.
    Shape,
    /// Distance of the particles at 0.3 s. Cloth that lies free on a ball or flutters forgets its
    /// start, so later all motions are equally far apart.
    Trajectory,
    /// No distance: after seconds in the wind none tells runs apart. In place of the distance
    /// over the span, that at 0.3 s and the strain decide whether a run is good.
    Kept,
}

/// One cloth in one scene, at one rate of frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key, e.g. `hanging, cotton-blend, light, n=400`.
    pub id: String,
    /// The bundled material.
    pub fabric: String,
    /// The measure that ranks its runs.
    pub measure: Measure,
    /// Whether every form of a method is run. If not, only its first form is.
    pub has_all_forms: bool,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Tensile rigidity along the stiffer threads, N/m. On square cells it is the stiffness of a
    /// line of springs.
    pub stiffness_n_per_m: f64,
    /// Stiffness over mass, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Frames a second.
    pub frames_per_s: u32,
    /// `h² k/m` of a frame.
    pub theta: f64,
    /// Damping of a spring over its stiffness, s.
    pub damping_over_stiffness_s: f64,
    /// Simulated time, s.
    pub span_s: f64,
    /// Number of substeps of a frame within symplectic Euler's limit, by Gershgorin's bound.
    pub limit_substeps: u32,
    /// Number of substeps of a frame in the true motion.
    pub reference_substeps: u32,
    /// Number of true motions: one without noise, and others from starts moved by up to 1 µm out of
    /// the plane. A run is compared with the nearest.
    pub members: usize,
    /// Noise of the surfaces, m: the mean distance over the span of a true motion from the nearest
    /// of the others. So the noise is measured as the error of a run is. A smaller error means
    /// nothing.
    pub shape_floor_m: f64,
    /// Noise of the particles at 0.3 s, m: the mean distance of a true motion from the nearest of the
    /// others, each the root of the mean square.
    pub trajectory_floor_m: f64,
    /// Distance of the surfaces if the step of the true motion is doubled, m.
    pub reference_error_m: f64,
    /// 99th percentile of the strain along the threads: a mean over time.
    pub strain: f64,
    /// Energy that the scene sets free, J. If rings or wind supply energy, the greatest kinetic energy
    /// of the true motion at a look.
    pub released_j: f64,
    /// Energy of springs and hinges at the start, over the energy that the scene sets free.
    pub prestress: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
    /// Where the scene and its runs were computed, if not where the record says: a scene was added
    /// to a record that takes hours.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub computed: Option<Origin>,
}

/// Where a scene was computed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Commit of the source.
    pub commit: String,
    /// The processor.
    pub cpu: String,
}

impl Scene {
    /// `light` or `heavy`.
    pub fn damping(&self) -> &'static str {
        if self.damping_over_stiffness_s >= HEAVY { "heavy" } else { "light" }
    }

    /// Noise in the measure that ranks the runs, m; 0 if no distance ranks.
    pub fn floor_m(&self) -> f64 {
        match self.measure {
            Measure::Kept => 0.0,
            Measure::Shape => self.shape_floor_m,
            Measure::Trajectory => self.trajectory_floor_m,
        }
    }

    /// Largest error of a good run, m. It is at least twice the noise, since noise alone sets two
    /// true motions apart, and a run may err by as much again.
    pub fn good_m(&self) -> f64 {
        GOOD.max(2.0 * self.floor_m())
    }

    /// Largest error at 0.3 s of a good run if no distance ranks, m.
    fn good_at_first_m(&self) -> f64 {
        GOOD.max(2.0 * self.trajectory_floor_m)
    }

    /// The error that ranks a run, m; `None` if no distance ranks or the run was not measured.
    pub fn error(&self, run: &Run) -> Option<f64> {
        match self.measure {
            Measure::Kept => None,
            Measure::Shape => run.shape_error_m,
            Measure::Trajectory => run.trajectory_error_m,
        }
    }
}

/// One form of a method on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Short name for legends.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Number of calls of the method in a frame.
    pub substeps: u32,
    /// Number of substeps, sweeps or iterations in a call, if the study varies it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inside: Option<u32>,
    /// Whether stiffness limits the step. Then calls are added until the run is stable.
    pub is_limited: bool,
    /// `stable`, `locked`, `lost contact`, `marginal`, `unstable`, `diverged`, `over budget` or
    /// `refused`.
    pub verdict: Verdict,
    /// Mean distance of the surface from the nearest true motion's, both ways, m: a mean over time.
    /// `None` if the run was not judged.
    pub shape_error_m: Option<f64>,
    /// Root of the mean square distance of the particles from those of the nearest true motion at
    /// 0.3 s, m.
    pub trajectory_error_m: Option<f64>,
    /// 99th percentile of the strain less that of the true motion: means over time.
    pub excess_strain: Option<f64>,
    /// Length of the path of the free edge's midpoint, over that in the true motion.
    pub retained: Option<f64>,
    /// Mean kinetic energy, over that of the true motion.
    pub kinetic: Option<f64>,
    /// Number of particles that lie on the obstacle at the end, over that in the true motion.
    pub contact: Option<f64>,
    /// Greatest rise of the energy, over the energy set free. If rings or wind supply energy, the
    /// rise beside their work; 0 if a correction hides it.
    pub gain: f64,
    /// Counts of work over all steps.
    pub counts: Counters,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

impl Run {
    /// Whether the run is stable, keeps its motion, and stays on its obstacle.
    pub fn is_sound(&self) -> bool {
        self.verdict == Verdict::Stable
    }

    /// The parts of a call: their number and what they are. `None` if a call is one step.
    pub fn parts(&self, scene: &Scene) -> Option<(u32, &'static str)> {
        if let Some(form) = Inside::of(&self.method, &self.label) {
            let settings = self.method.split([':', ',']);
            let mut values = settings.filter_map(|text| text.split_once('='));
            let value = values.find(|(key, _)| *key == form.setting)?.1;
            return value.parse().ok().map(|number| (number, form.setting));
        }
        // A method that solves nothing and evaluates the forces many times in a call divides it.
        let Counters { force_evaluations, matvecs, factorisations, newton_iterations, .. } =
            self.counts;
        let calls = scene.span_s * f64::from(scene.frames_per_s) * f64::from(self.substeps);
        let evaluations = (force_evaluations as f64 / calls).round() as u32;
        let is_divided = matvecs + factorisations + newton_iterations == 0 && evaluations > 1;
        (is_divided && !self.is_limited).then_some((evaluations, "force evaluations"))
    }

    /// Number of steps, substeps, sweeps or iterations of a frame.
    pub fn parts_of_a_frame(&self) -> u32 {
        self.substeps * self.inside.unwrap_or(1)
    }

    /// The calls of a frame, as `32 steps` or `1 call of 6 substeps`.
    pub fn calls(&self, scene: &Scene) -> String {
        let plural = if self.substeps == 1 { "" } else { "s" };
        match self.parts(scene) {
            Some((number, what)) => format!("{} call{plural} of {number} {what}", self.substeps),
            None => format!("{} step{plural}", self.substeps),
        }
    }

    /// Whether the run keeps its mean kinetic energy within `share` times a factor of [`LIVELY`].
    pub fn is_lively(&self, share: f64) -> bool {
        let most = share * LIVELY;
        self.kinetic.is_some_and(|kept| (1.0 / most..=most).contains(&kept))
    }

    /// Whether the run is sound, lively and near enough to the true motion. If no distance ranks, it
    /// must be near at 0.3 s and keep its strain until the end.
    pub fn is_good(&self, scene: &Scene) -> bool {
        self.is_good_within(scene, 1.0)
    }

    /// Whether the run is [good](Self::is_good) if the accepted error and the accepted factor of the
    /// kinetic energy are `share` times as large.
    pub fn is_good_within(&self, scene: &Scene, share: f64) -> bool {
        self.is_sound() && self.is_lively(share) && self.is_near(scene, share)
    }

    /// Whether the run is near enough to the true motion if the accepted error is `share` times as
    /// large.
    pub fn is_near(&self, scene: &Scene, share: f64) -> bool {
        match scene.measure {
            Measure::Kept => {
                let begins_near = |error: f64| error <= share * scene.good_at_first_m();
                self.trajectory_error_m.is_some_and(begins_near)
                    && self.excess_strain.is_some_and(|strain| strain <= STRETCHED)
            }
            _ => scene.error(self).is_some_and(|error| error <= share * scene.good_m()),
        }
    }

    /// The id of the method.
    pub fn id(&self) -> &str {
        self.method.split(':').next().unwrap_or(&self.method)
    }
}

/// The fastest run of each method, fastest first, of runs with their times, s.
pub fn fastest_of_each<'a>(runs: impl Iterator<Item = (&'a Run, f64)>) -> Vec<(&'a Run, f64)> {
    let mut fastest: Vec<(&Run, f64)> = Vec::new();
    for (run, time) in runs {
        match fastest.iter_mut().find(|(other, _)| other.id() == run.id()) {
            Some(known) if known.1 <= time => {}
            Some(known) => *known = (run, time),
            None => fastest.push((run, time)),
        }
    }
    fastest.sort_by(|a, b| a.1.total_cmp(&b.1));
    fastest
}

/// The fastest run of all and those that tie with it, one for each method: those within [`TIE`], and
/// those that would lead or tie, whatever they take, if what is accepted were [`NEARLY`] times as
/// much or as little. `within` gives the [fastest run of each method](fastest_of_each) where `share`
/// times as much as is meant is accepted.
pub fn leaders<'a>(within: impl Fn(f64) -> Vec<(&'a Run, f64)>) -> Vec<(&'a Run, f64)> {
    let first = |share: f64| {
        let mut runs = within(share);
        let least = runs.first().map_or(0.0, |(_, time)| *time);
        runs.truncate(runs.partition_point(|(_, time)| *time <= TIE * least));
        runs
    };
    let mut leaders = first(1.0);
    if !leaders.is_empty() {
        for (run, time) in [1.0 / NEARLY, NEARLY].into_iter().flat_map(first) {
            if leaders.iter().all(|(known, _)| known.id() != run.id()) {
                leaders.push((run, time));
            }
        }
    }
    leaders
}

/// Times of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// As in [`Run::scene`].
    pub scene: String,
    /// As in [`Run::label`].
    pub label: String,
    /// As in [`Run::substeps`].
    pub substeps: u32,
    /// As in [`Run::inside`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inside: Option<u32>,
    /// Number of frames that were timed, from the start.
    pub frames: u64,
    /// Seconds in all calls of the method, one entry for each repetition.
    pub samples_s: Vec<f64>,
    /// Median of the samples over the number of frames, s.
    pub frame_s: f64,
    /// Seconds of a fixed loop before or after the samples, whichever is longer; more than
    /// elsewhere in the file if another program disturbed the machine. `None` in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe_s: Option<f64>,
}

impl TimingRow {
    /// Whether these are the times of this run.
    pub fn is_of(&self, run: &Run) -> bool {
        (&self.scene, &self.label, self.substeps, self.inside)
            == (&run.scene, &run.label, run.substeps, run.inside)
    }
}
