//! Records of the experiment `momentum`: drift of linear and angular momentum.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Largest drift that round-off and the tolerance of a tight solve may cause.
pub(super) const KEPT: f64 = 1e-9;

/// A smaller change of the spin counts as none. So does a smaller gain of energy, over the energy
/// of the spin.
pub(super) const LEAST_CHANGE: f64 = 0.01;

/// Labels of Desbrun's method: without correction, as printed, and with consistent lever arms.
pub(super) const CORRECTIONS: [&str; 3] =
    ["desbrun, no correction", "desbrun, literal", "desbrun, consistent"];

/// Spin `|L|/|L_0|` that an independent prototype of Desbrun's method keeps: scene, label, value.
pub(super) const PROTOTYPE: [(&str, &str, f64); 6] = [
    ("spin-1e4", CORRECTIONS[0], 0.053),
    ("spin-1e4", CORRECTIONS[1], 0.15),
    ("spin-1e4", CORRECTIONS[2], 0.96),
    ("spin-1e6", CORRECTIONS[0], 0.0),
    ("spin-1e6", CORRECTIONS[1], 0.0),
    ("spin-1e6", CORRECTIONS[2], 0.99),
];

/// Largest difference from the prototype that confirms it.
const CONFIRMED: f64 = 0.005;

/// All methods on all scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes.
    pub scenes: Vec<Scene>,
    /// One row for each method and scene.
    pub rows: Vec<Row>,
}

/// One scene. No particle is pinned, and no spring is damped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: `spin-1e4`, `spin-1e6`, `fall-1e4`, `fall-1e6`, `pair-1e4` or `pair-1e6`.
    pub id: String,
    /// Number of particles.
    pub particles: usize,
    /// Stiffness over the mean mass of a particle, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Angular velocity of the start, 1/s.
    pub spin_per_s: [f64; 3],
    /// Acceleration of gravity, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Simulated time, s.
    pub duration_s: f64,
    /// Step size of all methods except explicit ones, s.
    pub step_s: f64,
    /// Bound on the largest angular frequency, 1/s. It limits the step of explicit methods.
    pub greatest_frequency_per_s: f64,
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Length to which drifts are compared, m: the diagonal of the box around the start.
    pub size_m: f64,
    /// Speed to which drifts are compared, m/s: the greatest of a particle in the true motion, as
    /// of a rigid body.
    pub speed_m_s: f64,
    /// Times of [`Row::spin`], s.
    pub time_s: Vec<f64>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One method on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Short name for legends: the method's id, and what sets this row apart from the method's
    /// others.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Step size, s: that of the scene, or a part of it for explicit methods.
    pub step_s: f64,
    /// Spin `|L|/|L_0|` at the times of the scene: angular momentum about the centre of mass, over
    /// that at the start. The list ends before the run becomes unstable.
    pub spin: Vec<f64>,
    /// Greatest `|P − P_0 − M g t|` during the run, over mass and reference speed; `None` if the
    /// run was unstable.
    pub momentum_drift: Option<f64>,
    /// Greatest `|L − L_0|` during the run, over mass, size and reference speed. `L` is taken about
    /// the centre of mass, where gravity has no torque. `None` if the run was unstable.
    pub angular_momentum_drift: Option<f64>,
    /// `|L|/|L_0|` at the end; `None` if the run was unstable.
    pub final_spin: Option<f64>,
    /// `|L|/|L_0|` at the end by the exact law of the method; `None` without a law. Laws exist for
    /// two particles only.
    pub law: Option<f64>,
    /// Greatest rise of the total energy above its start, over the kinetic energy of the start;
    /// `None` if the run was unstable.
    pub energy_gain: Option<f64>,
    /// Whether the method states that it keeps linear momentum.
    pub states_momentum: bool,
    /// Whether the method states that it keeps angular momentum.
    pub states_angular_momentum: bool,
    /// `completed` or `unstable`.
    pub verdict: Verdict,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

impl Scene {
    /// Whether gravity acts.
    pub(super) fn has_gravity(&self) -> bool {
        self.gravity_m_s2 != [0.0; 3]
    }

    /// Whether this is a sheet on which only its springs act.
    pub(super) fn is_spinning_sheet(&self) -> bool {
        self.particles > 2 && !self.has_gravity()
    }
}

/// The spin of the prototype for this run, and whether the run confirms it. `None` if the prototype
/// has no value or the run was unstable.
pub(super) fn prototype_of(row: &Row) -> Option<(f64, bool)> {
    let spin = row.final_spin?;
    let is_same =
        |(scene, label, _): &&(&str, &str, f64)| row.scene == *scene && row.label == *label;
    let (_, _, expected) = PROTOTYPE.iter().find(is_same)?;
    Some((*expected, (spin - expected).abs() <= CONFIRMED))
}
