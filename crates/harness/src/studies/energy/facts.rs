//! Records of the experiment `energy`: gains and losses of energy by cause.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// [`Row::label`] of IMEX Euler with all springs in the matrix, for which the energy theorem holds.
pub(super) const ALL_IMPLICIT: &str = "imex-euler, all springs";

/// All methods on all scenes, undamped and damped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes.
    pub scenes: Vec<Scene>,
    /// One row for each scene and method.
    pub rows: Vec<Row>,
    /// Labels of the methods without a ledger, since their steps have no energy identity.
    pub unattributed: Vec<String>,
}

/// One scene, undamped or damped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: `hanging-1e4`, `hanging-1e6`, `spinning-1e4` or `sphere-1e4`, then a space and
    /// `undamped` or `damped`.
    pub id: String,
    /// The first part of the key, which the undamped and the damped scene share.
    pub scene: String,
    /// Whether the springs are damped.
    pub is_damped: bool,
    /// Number of particles.
    pub particles: usize,
    /// Stiffness of the tension springs over the mass of a particle, 1/s². Shear springs have a
    /// tenth.
    pub stiffness_over_mass_per_s2: f64,
    /// Damping of the tension springs over the mass of a particle, 1/s. Shear springs have a tenth.
    pub damping_over_mass_per_s: f64,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Step size of all methods except explicit ones, s.
    pub step_s: f64,
    /// `E_ref`, the energy that the scene sets free, J. It is the greatest value of `H_0 − U` and
    /// of the kinetic energy over the motion. Symplectic Euler computes this motion well below its
    /// stability limit.
    pub reference_energy_j: f64,
    /// Total energy at the start, J.
    pub start_energy_j: f64,
    /// Times of [`Row::energy`], s.
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
    /// Number of steps taken.
    pub steps: u64,
    /// `stable`, `marginal`, `unstable` or `diverged`, judged by the energy gained.
    pub verdict: Verdict,
    /// `(H − H_0)/E_ref` at the times of the scene. The list ends where the value leaves ±10.
    pub energy: Vec<f64>,
    /// Drift: `(H_N − H_0)/E_ref` at the end; `None` if the run was unstable or diverged.
    pub drift: Option<f64>,
    /// Greatest rise of `H` above its start, over `E_ref`; `None` if the run was unstable or
    /// diverged.
    pub gain: Option<f64>,
    /// The loss beyond the damping, `(H_0 − H_N − ∫ vᵀ D v dt)/E_ref`. The trapezoidal rule
    /// integrates over the run's own velocities. `None` if the run was unstable or diverged.
    pub excess_dissipation: Option<f64>,
    /// Changes of the energy by cause; `None` for a method without an identity, and for an unstable
    /// or diverged run.
    pub ledger: Option<Ledger>,
    /// Sum of the absolute errors of each step's ledger, over the sum of the magnitudes of all its
    /// terms; `None` without a ledger.
    pub closure_defect: Option<f64>,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// Sums over all steps of a run, each over `E_ref`. A positive sum adds energy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ledger {
    /// Work of the damping forces, a physical loss.
    pub damping: f64,
    /// Numerical term from the change of velocity in a step: `∓½‖v_{n+1} − v_n‖²_M` for Euler's
    /// methods, in free directions.
    pub inertia: f64,
    /// Numerical term of each effect: the change of its energy beyond the work of the force in the
    /// step.
    pub gaps: BTreeMap<String, f64>,
    /// Work of the solver's residual.
    pub residual: f64,
    /// Work of pins and contacts, including the energy of the motion that an impact stops.
    pub constraint: f64,
    /// Work of corrections, i.e. other changes of positions or velocities.
    pub correction: f64,
}

impl Ledger {
    /// Gain by the discretisation in time over `E_ref`: inertia and all gaps.
    pub fn numerical(&self) -> f64 {
        self.inertia + self.gaps.values().sum::<f64>()
    }

    /// Sum of all causes, over `E_ref`.
    pub fn sum(&self) -> f64 {
        self.damping + self.numerical() + self.residual + self.constraint + self.correction
    }
}
