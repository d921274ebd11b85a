//! Records of the experiment `energy`: where the energy goes.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// [`Row::label`] of IMEX Euler with all springs in the matrix, of which the energy theorem speaks.
pub(super) const ALL_IMPLICIT: &str = "imex-euler, all springs";

/// All methods on all scenes, undamped and damped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes.
    pub scenes: Vec<Scene>,
    /// One a scene and method.
    pub rows: Vec<Row>,
    /// Labels of the methods without a ledger: their steps have no energy identity.
    pub unattributed: Vec<String>,
}

/// One scene, undamped or damped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: `hanging-1e4`, `hanging-1e6`, `spinning-1e4` or `sphere-1e4`, and behind a space
    /// `undamped` or `damped`.
    pub id: String,
    /// The key's first part, which both variants share.
    pub scene: String,
    /// Whether the springs are damped.
    pub is_damped: bool,
    /// Number of particles.
    pub particles: usize,
    /// Stiffness of the tension springs over the mass of a particle, 1/s²; shear springs have a
    /// tenth.
    pub stiffness_over_mass_per_s2: f64,
    /// Damping of the tension springs over the mass of a particle, 1/s; shear springs have a tenth.
    pub damping_over_mass_per_s: f64,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Step size of every method but the explicit ones, s.
    pub step_s: f64,
    /// `E_ref`, the energy that the scene sets free, J: the greatest of `H_0 − U` and of the
    /// kinetic energy over the motion that symplectic Euler computes well below its stability
    /// limit.
    pub reference_energy_j: f64,
    /// Total energy at the start, J.
    pub start_energy_j: f64,
    /// Times of [`Row::energy`], s.
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
    /// Steps taken.
    pub steps: u64,
    /// `stable`, `marginal`, `unstable` or `diverged`, by the energy gained.
    pub verdict: Verdict,
    /// `(H − H_0)/E_ref` at the times of the scene, dimensionless; ends where it leaves ±10.
    pub energy: Vec<f64>,
    /// `(H_N − H_0)/E_ref` at the end; `None` if the run was unstable or diverged.
    pub drift: Option<f64>,
    /// Greatest rise of `H` above its start over `E_ref`; `None` if the run was unstable or
    /// diverged.
    pub gain: Option<f64>,
    /// `(H_0 − H_N − ∫ vᵀ D v dt)/E_ref`, the loss beyond the damping, by the trapezoidal rule over
    /// the run's own velocities; `None` if the run was unstable or diverged.
    pub excess_dissipation: Option<f64>,
    /// Changes of the energy, cause by cause; `None` for a method without an identity, and for an
    /// unstable or diverged run.
    pub ledger: Option<Ledger>,
    /// Errors of the ledger's sum, step by step and without their signs, over the magnitudes of all
    /// its terms; `None` without a ledger.
    pub closure_defect: Option<f64>,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// Sums over all steps of a run, each over `E_ref`; what adds energy is positive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ledger {
    /// Work of the damping forces: physical.
    pub damping: f64,
    /// Change of velocity within a step, `∓½‖v_{n+1} − v_n‖²_M` for Euler's methods, in free
    /// directions: numerical.
    pub inertia: f64,
    /// Change of each effect's energy beyond the work of the force that the step used: numerical.
    pub gaps: BTreeMap<String, f64>,
    /// Work of what the solver left over.
    pub residual: f64,
    /// Work of pins and contacts, with the energy of the motion that an impact stops.
    pub constraint: f64,
    /// Work of corrections: positions or velocities moved otherwise.
    pub correction: f64,
}

impl Ledger {
    /// Inertia and all gaps: what the discretisation in time takes or adds, over `E_ref`.
    pub fn numerical(&self) -> f64 {
        self.inertia + self.gaps.values().sum::<f64>()
    }

    /// Sum of all causes over `E_ref`.
    pub fn sum(&self) -> f64 {
        self.damping + self.numerical() + self.residual + self.constraint + self.correction
    }
}
