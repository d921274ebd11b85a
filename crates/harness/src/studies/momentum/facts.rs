//! Records of the experiment `momentum`: drift of linear and angular momentum.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Drift that round-off and the tolerance of a tight solve may make.
pub(super) const KEPT: f64 = 1e-9;

/// A smaller change of the spin, or gain of energy over that of the spin, counts as none.
pub(super) const LEAST_CHANGE: f64 = 0.01;

/// Labels of Desbrun's method without correction, as printed, and with consistent lever arms.
pub(super) const CORRECTIONS: [&str; 3] =
    ["desbrun, no correction", "desbrun, literal", "desbrun, consistent"];

/// Spin left to Desbrun's sheet, `|L|/|L_0|`, in an independent prototype: scene, label, value.
pub(super) const PROTOTYPE: [(&str, &str, f64); 6] = [
    ("spin-1e4", CORRECTIONS[0], 0.053),
    ("spin-1e4", CORRECTIONS[1], 0.15),
    ("spin-1e4", CORRECTIONS[2], 0.96),
    ("spin-1e6", CORRECTIONS[0], 0.0),
    ("spin-1e6", CORRECTIONS[1], 0.0),
    ("spin-1e6", CORRECTIONS[2], 0.99),
];

/// Greatest difference to the prototype that confirms it.
const CONFIRMED: f64 = 0.005;

/// All methods on all scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes.
    pub scenes: Vec<Scene>,
    /// One a method and scene.
    pub rows: Vec<Row>,
}

/// One scene: nothing is pinned, nothing is damped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: `spin-1e4`, `spin-1e6`, `fall-1e4`, `fall-1e6`, `pair-1e4` or `pair-1e6`.
    pub id: String,
    /// Number of particles.
    pub particles: usize,
    /// Stiffness over mean mass of a particle, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Angular velocity of the start, 1/s.
    pub spin_per_s: [f64; 3],
    /// Acceleration of gravity, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Simulated time, s.
    pub duration_s: f64,
    /// Step size of every method but the explicit ones, s.
    pub step_s: f64,
    /// Bound on the largest angular frequency, 1/s, which limits the step of explicit methods.
    pub greatest_frequency_per_s: f64,
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Diagonal of the box around the start, m: the length to which drifts refer.
    pub size_m: f64,
    /// Greatest speed of a particle in the true motion, taken as rigid, m/s: drifts refer to it.
    pub speed_m_s: f64,
    /// Times of [`Row::spin`], s.
    pub time_s: Vec<f64>,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One method on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Short name for legends: the method's id, and what sets it apart from its other rows.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Step size, s: that of the scene, divided for explicit methods.
    pub step_s: f64,
    /// Angular momentum about the centre of mass over that of the start, `|L|/|L_0|`, at the times
    /// of the scene; ends before the run becomes unstable.
    pub spin: Vec<f64>,
    /// Greatest `|P − P_0 − M g t|` on the way over mass and reference speed; `None` if the run was
    /// unstable.
    pub momentum_drift: Option<f64>,
    /// Greatest `|L − L_0|` on the way, about the centre of mass, where gravity has no torque, over
    /// mass, size and reference speed; `None` if the run was unstable.
    pub angular_momentum_drift: Option<f64>,
    /// `|L|/|L_0|` at the end; `None` if the run was unstable.
    pub final_spin: Option<f64>,
    /// `|L|/|L_0|` at the end by the exact law of the method, where there is one (two particles
    /// only).
    pub law: Option<f64>,
    /// Greatest rise of the total energy above its start over the kinetic energy of the start;
    /// `None` if the run was unstable.
    pub energy_gain: Option<f64>,
    /// Whether the method states that it keeps linear momentum.
    pub states_momentum: bool,
    /// Whether the method states that it keeps angular momentum.
    pub states_angular_momentum: bool,
    /// `completed` or `unstable`.
    pub verdict: Verdict,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Same bits on every machine.
    pub portable: bool,
}

impl Scene {
    /// Whether gravity acts.
    pub(super) fn has_gravity(&self) -> bool {
        self.gravity_m_s2 != [0.0; 3]
    }

    /// Whether it is a sheet in space, where nothing but its springs acts.
    pub(super) fn is_spinning_sheet(&self) -> bool {
        self.particles > 2 && !self.has_gravity()
    }
}

/// The spin that the prototype leaves in this run, and whether the run confirms it; `None` where
/// the prototype has no value or the run was unstable.
pub(super) fn prototype_of(row: &Row) -> Option<(f64, bool)> {
    let spin = row.final_spin?;
    let is_same =
        |(scene, label, _): &&(&str, &str, f64)| row.scene == *scene && row.label == *label;
    let (_, _, expected) = PROTOTYPE.iter().find(is_same)?;
    Some((*expected, (spin - expected).abs() <= CONFIRMED))
}
