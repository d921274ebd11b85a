//! Records of the experiment `pictures`: positions to draw.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Step of the sheets that are run with all methods, s.
pub(super) const STEP: f64 = 0.01;

/// [`Shot::label`] of the reference.
pub(super) const REFERENCE: &str = "reference";

/// [`Shot::series`] of the pictures that the paper shows.
pub const PAPER: &str = "paper";
/// [`Shot::series`] of the pictures of all methods on the same sheet.
pub const METHODS: &str = "methods";

/// All pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes.
    pub scenes: Vec<Scene>,
    /// The pictures, run by run and in the order of time.
    pub shots: Vec<Shot>,
}

/// A sheet, and the table on which it falls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name of the bundled scene.
    pub id: String,
    /// Number of rows of particles.
    pub rows: u32,
    /// Number of particles in a row.
    pub columns: u32,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// The table, if there is one.
    pub table: Option<Table>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// A box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Centre, m.
    pub center_m: [f64; 3],
    /// Edge lengths, m.
    pub size_m: [f64; 3],
}

/// One moment of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shot {
    /// [`PAPER`] or [`METHODS`].
    pub series: String,
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// The text beside the pictures of the run.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Step size, s.
    pub step_s: f64,
    /// Time, s.
    pub time_s: f64,
    /// Time at which the run diverged, s. There is no picture from then on.
    pub diverged_at_s: Option<f64>,
    /// Positions to draw, outside of obstacles, rounded to 1e-5 m: three coordinates a particle,
    /// row by row. Empty without a picture.
    pub position_m: Vec<f64>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// Mean fall of a sheet, m, from its start at height 0; `None` without a picture.
pub(super) fn fall(shot: &Shot) -> Option<f64> {
    let heights = shot.position_m.iter().skip(2).step_by(3);
    let count = heights.clone().count();
    (count > 0).then(|| -heights.sum::<f64>() / count as f64)
}

/// The picture of the reference at a time (s).
pub(super) fn reference_at(facts: &Facts, time_s: f64) -> Option<&Shot> {
    let mut shots = facts.shots.iter().filter(|shot| shot.series == METHODS);
    shots.find(|shot| shot.label == REFERENCE && shot.time_s == time_s)
}

/// The fall of a sheet over that of the reference at the same time; `None` if the run has diverged.
pub(super) fn fall_share(facts: &Facts, shot: &Shot) -> Option<f64> {
    Some(fall(shot)? / fall(reference_at(facts, shot.time_s)?)?)
}
