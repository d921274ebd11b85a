//! Records of the experiment `rest`: cloth that comes to rest on a table.

pub use crate::studies::filmed::Counters;
use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A cloth has arrived when its surface stays within this distance of its rest shape, m.
pub const THERE: f64 = 1e-3;
/// A rest shape counts as one of the accepted minima if their energies differ by at most this share
/// of the released energy.
pub const RIGHT: f64 = 0.01;
/// Times within this factor are a tie: numbers of steps differ by factors of about 3.
pub const TIE: f64 = 3.0;

/// All scenes and methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes, each with its rest shapes.
    pub scenes: Vec<Scene>,
    /// One run for each scene, form of a method and step.
    pub runs: Vec<Run>,
}

/// One cloth on a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key, e.g. `round table, denim, n=208`.
    pub id: String,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Whether prices hold for the scene: it has only springs, gravity and pins, on a regular grid.
    pub is_priced: bool,
    /// Longest simulated time of a run, s.
    pub span_s: f64,
    /// Number of steps between looks (0.1 s) within symplectic Euler's limit, by Gershgorin's
    /// bound.
    pub limit_steps: u32,
    /// Energy that the cloth sets free, J.
    pub released_j: f64,
    /// Energy of springs and hinges at the start, over the energy that the cloth sets free.
    pub prestress: f64,
    /// Rest shapes that Newton's method finds from starts in waves. If a run came to a better
    /// shape, the best of those is added.
    pub minima: Vec<Minimum>,
    /// The true motions, from the start and from starts with noise.
    #[serde(default)]
    pub motions: Vec<Motion>,
    /// The minima that count as right: first the least known, then those in which true motions end.
    /// A cloth may buckle into several folds, and no motion owes the least energy.
    #[serde(default)]
    pub accepted: Vec<Accepted>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// A rest shape found without a time step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Minimum {
    /// Start of the search: a number of waves, or the run at whose end it began.
    pub from: String,
    /// Potential energy, J.
    pub energy_j: f64,
    /// Greatest force on a particle, over the weight of the heaviest.
    pub residual: f64,
    /// Whether the shape is a minimum of the energy, not a saddle.
    pub is_minimum: bool,
}

/// A true motion: an explicit method with steps far below its limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Its start: that of the runs, or the seed of the noise.
    pub from: String,
    /// Its end for each number of steps.
    pub ends: Vec<End>,
    /// Whether it is converged: all steps lead to one energy, within the tolerance for a right
    /// shape.
    pub is_converged: bool,
}

/// The end of a true motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct End {
    /// Number of steps of the true motion in 0.1 s.
    pub steps: u32,
    /// Potential energy of the minimum in which the true motion ends, J. `None` if it does not come
    /// to rest in a minimum in time.
    pub energy_j: Option<f64>,
}

/// A minimum that counts as right.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Accepted {
    /// Potential energy, J.
    pub energy_j: f64,
    /// Energy above the least known, over the released energy.
    pub excess_energy: f64,
    /// The searches or the run that found the least known energy, and the true motions that end in
    /// the minimum.
    pub from: Vec<String>,
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
    /// Number of calls of the method between looks (0.1 s).
    pub steps: u32,
    /// Whether stiffness limits the step.
    pub is_limited: bool,
    /// `stable` if the run came to its rest shape, `locked` if it came less than half of its way,
    /// and `open` if it was still on its way. Otherwise the verdict on its energy, or why it ended.
    pub verdict: Verdict,
    /// Simulated time from which on the surface stays within 1 mm of the rest shape, s.
    pub arrival_s: Option<f64>,
    /// Distance of the last surface from the rest shape that Newton's method finds from it, m.
    pub shape_error_m: Option<f64>,
    /// Greatest force on a particle at the end, over the weight of the heaviest.
    pub residual: Option<f64>,
    /// Root of the mean square speed at the end, m/s.
    pub speed_m_s: Option<f64>,
    /// Potential energy of the rest shape that Newton's method finds from the last surface, J.
    pub rest_energy_j: Option<f64>,
    /// Whether that shape is a minimum of the energy, not a saddle. `None` unless it is better than
    /// all shapes from starts in waves.
    pub is_minimum: Option<bool>,
    /// Energy of that rest shape above the least known, over the released energy.
    pub excess_energy: Option<f64>,
    /// Energy of the accepted minimum that the run reached, as in [`Accepted::energy_j`], J. `None`
    /// if its rest shape is none of them.
    #[serde(default)]
    pub reached_j: Option<f64>,
    /// Greatest rise of the energy, over the released energy.
    pub gain: f64,
    /// Visits of a spring until the cloth arrived.
    pub effort: Option<f64>,
    /// Modelled time until the cloth arrived, s, if prices hold for the scene and the form.
    pub modelled_s: Option<f64>,
    /// Counts of work over all steps.
    pub counts: Counters,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

impl Run {
    /// Whether the cloth came to rest in a right shape: one of the accepted minima.
    pub fn is_right(&self) -> bool {
        self.verdict == Verdict::Stable && self.reached_j.is_some()
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
    /// As in [`Run::steps`].
    pub steps: u32,
    /// Seconds in all calls of the method until the cloth arrived, one entry for each repetition.
    pub samples_s: Vec<f64>,
    /// Median of the samples, s.
    pub seconds: f64,
    /// Seconds of a fixed loop before or after the samples, whichever is longer; more than
    /// elsewhere in the file if another program disturbed the machine. `None` in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe_s: Option<f64>,
}

impl TimingRow {
    /// Whether these are the times of this run.
    pub fn is_of(&self, run: &Run) -> bool {
        (&self.scene, &self.label, self.steps) == (&run.scene, &run.label, run.steps)
    }
}
