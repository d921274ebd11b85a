//! Records of the experiment `momentum`: drift of linear and angular momentum.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Drift that round-off and the tolerance of a tight solve may make.
pub(super) const KEPT: f64 = 1e-9;

/// A change of the spin, and a gain of energy over that of the spin, worth a sentence.
pub(super) const LEAST_CHANGE: f64 = 0.01;

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
    /// Greatest speed of a particle in the true motion, taken as rigid, m/s: the speed to which drifts refer.
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
    /// Angular momentum about the centre of mass over that of the start, `|L|/|L_0|`, at the times of the
    /// scene; ends before the run becomes unstable.
    pub spin: Vec<f64>,
    /// Greatest `|P − P_0 − M g t|` on the way over mass and reference speed; `None` if the run was unstable.
    pub momentum_drift: Option<f64>,
    /// Greatest `|L − L_0|` on the way, about the centre of mass, where gravity has no torque, over mass,
    /// size and reference speed; `None` if the run was unstable.
    pub angular_momentum_drift: Option<f64>,
    /// `|L|/|L_0|` at the end; `None` if the run was unstable.
    pub final_spin: Option<f64>,
    /// What the exact law of the method gives for it, where there is one (two particles only).
    pub law: Option<f64>,
    /// Greatest rise of the total energy above its start over the kinetic energy of the start; `None` if the
    /// run was unstable.
    pub energy_gain: Option<f64>,
    /// Whether the method states that it keeps linear momentum.
    pub states_momentum: bool,
    /// Whether the method states that it keeps angular momentum.
    pub states_angular_momentum: bool,
    /// [`COMPLETED`] or [`UNSTABLE`].
    pub verdict: Verdict,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Same bits on every machine.
    pub portable: bool,
}
