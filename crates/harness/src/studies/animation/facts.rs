//! Records of the experiment `animation`: what a frame costs that is good enough.

pub use crate::studies::filmed::Counters;
use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a film can use is off by at most this, m.
pub const GOOD: f64 = 0.01;
/// Damping of a spring over its stiffness from which on it is heavy, s.
pub const HEAVY: f64 = 1e-3;
/// Times within this factor are a tie.
pub const TIE: f64 = 1.5;
/// Where no distance ranks, a good run has the kinetic energy of the true motion within this factor.
pub const LIVELY: f64 = 1.5;
/// There its strain exceeds the true one by at most this.
pub const STRETCHED: f64 = 0.01;

/// All scenes and methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes, each with its true motion.
    pub scenes: Vec<Scene>,
    /// One a scene, form of a method and number of substeps.
    pub runs: Vec<Run>,
    /// What a long study had no time for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<Missing>,
}

/// Forms that were not run, or not timed, on a scene for want of time.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Missing {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Labels of the forms that were not run.
    pub not_run: Vec<String>,
    /// Labels of the forms that were run and not timed.
    pub not_timed: Vec<String>,
}

/// What the runs of a scene are ranked by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The distance of the surfaces over the whole span: two motions of cloth that hangs stay
    /// together.
    Shape,
    /// The distance of the particles at 0.3 s: cloth that touches or flutters forgets its start, so
    /// that later all motions are equally far apart.
    Trajectory,
    /// By nothing: after seconds of contact or wind no distance tells runs apart. A run is good if
    /// it keeps its kinetic energy and its strain.
    Kept,
}

/// One cloth in one scene, at 60 frames a second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key, e.g. `hanging, cotton-blend, light, n=400`.
    pub id: String,
    /// The bundled material.
    pub fabric: String,
    /// What its runs are ranked by.
    pub measure: Measure,
    /// Whether every form of a method is run; else only its first.
    pub has_all_forms: bool,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Tensile rigidity along the stiffer threads, N/m: on square cells the stiffness of a line of
    /// springs.
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
    /// Substeps of a frame within the limit of symplectic Euler, by Gershgorin's bound.
    pub limit_substeps: u32,
    /// Substeps of a frame in the true motion.
    pub reference_substeps: u32,
    /// Number of true motions: one without noise, the others from starts moved by up to 1 µm out of
    /// the plane. A run is held against the nearest.
    pub members: usize,
    /// Mean distance over the span of the surfaces of two starts that differ by noise, m: a smaller
    /// error means nothing.
    pub shape_floor_m: f64,
    /// Root of the mean square distance of the particles of two such starts at 0.3 s, m.
    pub trajectory_floor_m: f64,
    /// Distance of the surfaces when the step of the true motion is doubled, m.
    pub reference_error_m: f64,
    /// 99th percentile of the strain along the threads, mean over time.
    pub strain: f64,
    /// Energy that the scene sets free, J.
    pub released_j: f64,
    /// Energy of springs and hinges at the start, over that which the scene sets free.
    pub prestress: f64,
    /// Same bits on every machine.
    pub portable: bool,
}

impl Scene {
    /// The noise of what its runs are ranked by, m; 0 where nothing ranks them.
    pub fn floor_m(&self) -> f64 {
        match self.measure {
            Measure::Kept => 0.0,
            Measure::Shape => self.shape_floor_m,
            Measure::Trajectory => self.trajectory_floor_m,
        }
    }

    /// An error of at most this is good, m. Two motions that differ by noise alone are apart by the
    /// noise, and one that errs as much besides by about twice that.
    pub fn good_m(&self) -> f64 {
        GOOD.max(2.0 * self.floor_m())
    }

    /// The error by which a run is ranked, m.
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
    /// Calls of the method in a frame.
    pub substeps: u32,
    /// Whether stiffness limits its step, so that calls were added until it held.
    pub is_limited: bool,
    /// `stable`, `locked`, `lost contact`, `marginal`, `unstable`, `diverged`, `over budget` or
    /// `refused`.
    pub verdict: Verdict,
    /// Mean distance of the surface to that of the nearest true motion, both ways, mean over time,
    /// m.
    pub shape_error_m: Option<f64>,
    /// Root of the mean square distance of the particles to those of the nearest true motion at
    /// 0.3 s, m.
    pub trajectory_error_m: Option<f64>,
    /// How much the 99th percentile of the strain exceeds that of the true motion.
    pub excess_strain: Option<f64>,
    /// Path of the midpoint of the free edge over that of the true motion.
    pub retained: Option<f64>,
    /// Mean kinetic energy over that of the true motion.
    pub kinetic: Option<f64>,
    /// Particles that lie on the obstacle at the end, over those of the true motion.
    pub contact: Option<f64>,
    /// Greatest rise of the energy over what the scene sets free; 0 where rings or wind supply some.
    pub gain: f64,
    /// What its steps counted.
    pub counts: Counters,
    /// Same bits on every machine.
    pub portable: bool,
}

impl Run {
    /// Whether it can be shown: it neither gains energy nor stands still.
    pub fn is_sound(&self) -> bool {
        self.verdict == Verdict::Stable
    }

    /// Whether it is near enough to the true motion, too. Below the noise of the scene nothing is
    /// told apart. Where no distance ranks, it keeps its kinetic energy and its strain.
    pub fn is_good(&self, scene: &Scene) -> bool {
        let is_near = match scene.measure {
            Measure::Kept => {
                let is_lively = |kept: f64| (1.0 / LIVELY..=LIVELY).contains(&kept);
                self.kinetic.is_some_and(is_lively)
                    && self.excess_strain.is_some_and(|strain| strain <= STRETCHED)
            }
            _ => scene.error(self).is_some_and(|error| error <= scene.good_m()),
        };
        self.is_sound() && is_near
    }
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
    /// Frames that were timed, from the start.
    pub frames: u64,
    /// Seconds in all calls of the method, one entry a repetition.
    pub samples_s: Vec<f64>,
    /// Median of the samples over the number of frames, s.
    pub frame_s: f64,
}
