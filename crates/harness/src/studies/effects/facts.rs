//! Records of the experiment `effects`: what each effect of a scene costs, and what it changes.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// [`Effect::name`] of the scene to which the effects are added.
pub const NOTHING: &str = "nothing more";

/// [`Effect::name`] of the scene that has all of them, one for each place: what takes the place of
/// another is left out.
pub const EVERYTHING: &str = "all together";

/// Each effect by itself and one for each place together, with every method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scene to which the effects are added, as JSON.
    pub scene: String,
    /// Simulated time, s.
    pub duration_s: f64,
    /// What is added: first [`NOTHING`], last [`EVERYTHING`].
    pub effects: Vec<Effect>,
    /// Methods, in the order of the registry.
    pub methods: Vec<String>,
    /// How each method treats each effect that a scene can name.
    pub supports: Vec<Support>,
    /// One an effect and method.
    pub cells: Vec<Cell>,
}

/// Something that a scene can name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Effect {
    /// Key.
    pub name: String,
    /// The keys that are added to the scene, as JSON; those of a list are appended.
    pub adds: String,
    /// Number of effect objects in the running system.
    pub objects: usize,
    /// Springs in the scalar matrix of IMEX methods, EEH (16).
    pub springs: usize,
    /// Pairs of particles that the 3×3 blocks of linearised methods couple.
    pub coupled_pairs: usize,
}

/// How a method treats an effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Support {
    /// Name of the effect, or `pins`, or `contact`.
    pub effect: String,
    /// Method id.
    pub method: String,
    /// `implicit`, `explicit`, `by setting`, `constraint`, or `refused`.
    pub treatment: String,
}

/// A run of one method on the scene with one effect more.
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
    /// Steps that were taken.
    pub steps: u64,
    /// Iterations of conjugate gradients.
    pub cg_iterations: u64,
    /// Newton iterations.
    pub newton_iterations: u64,
    /// Products of the matrix with a block vector.
    pub matvecs: u64,
    /// Sweeps that evaluated forces or energies.
    pub force_evaluations: u64,
    /// Builds of a matrix, preconditioner or factor.
    pub setups: u64,
    /// Distance of the particles at the end to those of the scene with nothing more, root of the
    /// mean square, m, to the micrometre; absent where a run did not complete.
    pub change_m: Option<f64>,
    /// Same bits on every machine.
    pub portable: bool,
}

/// The same scene with and without an effect, timed in turns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// As in [`Effect::name`].
    pub effect: String,
    /// Method id.
    pub method: String,
    /// Number of steps of each run.
    pub steps: u64,
    /// Nanoseconds in all `step` calls together without the effect, one entry a repetition.
    pub without_ns: Vec<u64>,
    /// Nanoseconds in all `step` calls together with the effect, one entry a repetition.
    pub with_ns: Vec<u64>,
    /// Shortest run with the effect over shortest run without it.
    pub ratio: f64,
    /// Bytes that the system with the effect holds more than without it; absent where no allocator
    /// could be asked.
    pub system_bytes: Option<i64>,
    /// Bytes that the method after `prepare` holds more with the effect than without it.
    pub method_bytes: Option<i64>,
}

impl Facts {
    /// Additions that the scene with [`EVERYTHING`] lacks: another stands in their place.
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

/// Whether a value has all that another one has.
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
