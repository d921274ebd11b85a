//! Records of the experiment `pictures`: positions to be drawn.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Step of the sheets that all methods move, s.
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
    /// The pictures: of a run one after the other, run by run.
    pub shots: Vec<Shot>,
}

/// A sheet, and the table on which it falls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Its name, that of a bundled scene.
    pub id: String,
    /// Rows of particles.
    pub rows: u32,
    /// Particles a row.
    pub columns: u32,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// The table, where there is one.
    pub table: Option<Table>,
    /// Same bits on every machine.
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

/// A moment of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shot {
    /// [`PAPER`] or [`METHODS`].
    pub series: String,
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// The text beside the pictures of this run.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Step size, s.
    pub step_s: f64,
    /// Time, s.
    pub time_s: f64,
    /// When the run diverged, s; there is no picture from then on.
    pub diverged_at_s: Option<f64>,
    /// Positions to be drawn, outside of obstacles, rounded to 1e-5 m: three a particle, row by
    /// row. Empty where there is no picture.
    pub position_m: Vec<f64>,
    /// Same bits on every machine.
    pub portable: bool,
}

/// How far a sheet has come down on average, m; it starts at height 0.
pub(super) fn fall(shot: &Shot) -> Option<f64> {
    let heights = shot.position_m.iter().skip(2).step_by(3);
    let count = heights.clone().count();
    (count > 0).then(|| -heights.sum::<f64>() / count as f64)
}

/// The picture of the reference at a time.
pub(super) fn reference_at(facts: &Facts, time_s: f64) -> Option<&Shot> {
    let mut shots = facts.shots.iter().filter(|shot| shot.series == METHODS);
    shots.find(|shot| shot.label == REFERENCE && shot.time_s == time_s)
}

/// The fall of a sheet over that of the reference; `None` for a run that has diverged.
pub(super) fn fall_share(facts: &Facts, shot: &Shot) -> Option<f64> {
    Some(fall(shot)? / fall(reference_at(facts, shot.time_s)?)?)
}
