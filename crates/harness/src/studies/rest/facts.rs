//! Records of the experiment `rest`: cloth that comes to rest on a table.

pub use crate::studies::filmed::Counters;
use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A cloth has arrived when its surface stays within this of its rest shape, m.
pub const THERE: f64 = 1e-3;
/// A rest shape is right if its energy is at most this share of the released energy above the
/// least that is known.
pub const RIGHT: f64 = 0.01;
/// Times within this factor are a tie.
pub const TIE: f64 = 1.5;

/// All scenes and methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes, each with its rest shapes.
    pub scenes: Vec<Scene>,
    /// One a scene, form of a method and step.
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
    /// Whether prices hold for it: springs, gravity and pins alone, on a regular grid.
    pub is_priced: bool,
    /// Simulated time after which a run is given up, s.
    pub span_s: f64,
    /// Steps of a look (0.1 s) within the limit of symplectic Euler, by Gershgorin's bound.
    pub limit_steps: u32,
    /// Energy that the cloth sets free, J.
    pub released_j: f64,
    /// Energy of springs and hinges at the start, over that which the cloth sets free.
    pub prestress: f64,
    /// Rest shapes that Newton's method finds from starts in waves, and the best of those to which
    /// a run came, if it is better.
    pub minima: Vec<Minimum>,
    /// Same bits on every machine.
    pub portable: bool,
}

/// A rest shape found without a time step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Minimum {
    /// Where the search began: at a start in so many waves, or where a run ended.
    pub from: String,
    /// Potential energy, J.
    pub energy_j: f64,
    /// Greatest force on a particle over the weight of the heaviest.
    pub residual: f64,
    /// Whether it is a minimum and no saddle.
    pub is_minimum: bool,
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
    /// Calls of the method from one look to the next, 0.1 s.
    pub steps: u32,
    /// Whether stiffness limits its step.
    pub is_limited: bool,
    /// `stable`: it came to its rest shape. `locked`: it came less than half of its
    /// way. `open`: it was still elsewhere at the end. Else what its energy did, or why it ended.
    pub verdict: Verdict,
    /// Simulated time from which the surface stays within 1 mm of the rest shape, s.
    pub arrival_s: Option<f64>,
    /// Distance of the last surface to the rest shape that Newton's method finds from it, m.
    pub shape_error_m: Option<f64>,
    /// Greatest force on a particle at the end over the weight of the heaviest.
    pub residual: Option<f64>,
    /// Root of the mean square speed at the end, m/s.
    pub speed_m_s: Option<f64>,
    /// Potential energy of the rest shape that Newton's method finds from the last surface, J.
    pub rest_energy_j: Option<f64>,
    /// Whether that shape is a minimum and no saddle; asked only if it is better than all that
    /// starts in waves lead to.
    pub is_minimum: Option<bool>,
    /// Energy of that rest shape above the least known, over the released energy.
    pub excess_energy: Option<f64>,
    /// Greatest rise of the energy over the released energy.
    pub gain: f64,
    /// Visits of a spring until it arrived.
    pub effort: Option<f64>,
    /// Modelled time until it arrived, s; where prices hold for scene and form.
    pub modelled_s: Option<f64>,
    /// What its steps counted.
    pub counts: Counters,
    /// Same bits on every machine.
    pub portable: bool,
}

impl Run {
    /// Whether it came to rest, in a shape that is right.
    pub fn is_right(&self) -> bool {
        let is_right = self.excess_energy.is_some_and(|excess| excess <= RIGHT);
        self.verdict == Verdict::Stable && is_right
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
    /// Seconds in all calls of the method until it arrived, one entry a repetition.
    pub samples_s: Vec<f64>,
    /// Median of the samples, s.
    pub seconds: f64,
}
