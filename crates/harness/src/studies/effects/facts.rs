//! Records of the experiment `effects`: the cost of each effect of a scene, and its change of the
//! motion.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// [`Effect::name`] of the bare scene, to which the effects are added.
pub const NOTHING: &str = "nothing more";

/// [`Effect::name`] of the scene with one effect for each place. Effects that would take a filled
/// place are left out.
pub const EVERYTHING: &str = "all together";

/// The scene with each effect by itself and with all places filled, for every method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scene to which the effects are added, as JSON.
    pub scene: String,
    /// Simulated time, s.
    pub duration_s: f64,
    /// The additions. [`NOTHING`] is first, [`EVERYTHING`] last.
    pub effects: Vec<Effect>,
    /// Methods, in the order of the registry.
    pub methods: Vec<String>,
    /// How each method treats each effect that a scene can name.
    pub supports: Vec<Support>,
    /// One cell for each effect and method.
    pub cells: Vec<Cell>,
}

/// An addition to the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Effect {
    /// Name of the addition, to which cells refer.
    pub name: String,
    /// The keys that are added to the scene, as JSON. Lists are appended.
    pub adds: String,
    /// Number of effect objects in the running system.
    pub objects: usize,
    /// Number of springs in the scalar matrix of IMEX methods (EEH 16).
    pub springs: usize,
    /// Number of pairs of particles that the 3×3 blocks of linearised methods couple.
    pub coupled_pairs: usize,
}

/// How a method treats an effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Support {
    /// Name of the effect, `pins` or `contact`.
    pub effect: String,
    /// Method id.
    pub method: String,
    /// `implicit`, `explicit`, `by setting`, `constraint`, or `refused`.
    pub treatment: String,
}

/// A run of one method on the scene with one addition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// As in [`Effect::name`].
    pub effect: String,
    /// Method id.
    pub method: String,
    /// Time step, s.
    pub step_s: f64,
    /// `completed`, `diverged`, or `refused`.
    pub verdict: Verdict,
    /// Number of steps taken.
    pub steps: u64,
    /// Number of CG iterations.
    pub cg_iterations: u64,
    /// Number of Newton iterations.
    pub newton_iterations: u64,
    /// Number of products of the matrix with a block vector.
    pub matvecs: u64,
    /// Number of sweeps that evaluated forces or energies.
    pub force_evaluations: u64,
    /// Number of builds of a matrix, preconditioner or factor.
    pub setups: u64,
    /// Distance of the particles at the end from those of the bare scene: root of the mean square,
    /// m, rounded to 1 µm. Absent if a run did not complete.
    pub change_m: Option<f64>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// Times of the scene with and without an effect, taken in turns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// As in [`Effect::name`].
    pub effect: String,
    /// Method id.
    pub method: String,
    /// Number of steps of each run.
    pub steps: u64,
    /// Nanoseconds in all `step` calls together without the effect: one entry for each repetition.
    pub without_ns: Vec<u64>,
    /// Nanoseconds in all `step` calls together with the effect: one entry for each repetition.
    pub with_ns: Vec<u64>,
    /// Time of the shortest run with the effect, over that of the shortest run without it.
    pub ratio: f64,
    /// Bytes of the system with the effect, less those without it. Absent if the program counts no
    /// allocations.
    pub system_bytes: Option<i64>,
    /// Bytes of the method after `prepare` with the effect, less those without it.
    pub method_bytes: Option<i64>,
}

impl Facts {
    /// Names of the additions that the scene with [`EVERYTHING`] leaves out.
    pub(super) fn left_out(&self) -> Vec<&str> {
        let keys =
            |effect: &Effect| serde_json::from_str::<Value>(&effect.adds).unwrap_or_default();
        let Some(all) = self.effects.iter().find(|effect| effect.name == EVERYTHING).map(keys)
        else {
            return Vec::new();
        };
        let lacks = |effect: &&Effect| !holds(&all, &keys(effect));
        self.effects.iter().filter(lacks).map(|effect| effect.name.as_str()).collect()
    }
}

/// Whether a JSON value contains all that another contains.
pub(super) fn holds(all: &Value, part: &Value) -> bool {
    match (all, part) {
        (Value::Object(all), Value::Object(part)) => {
            part.iter().all(|(key, part)| all.get(key).is_some_and(|all| holds(all, part)))
        }
        (Value::Array(all), Value::Array(part)) => {
            part.iter().all(|part| all.iter().any(|a| a == part))
        }
        (all, part) => all == part,
    }
}
