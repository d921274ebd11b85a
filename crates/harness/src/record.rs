//! What `drape run --out` writes: "drape-run/2".

use crate::methods::Choice;
use crate::{Outcome, system_hash};
use drape_model::{State, SystemSpec, TimeSpan};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The value of `format`.
pub const RUN_FORMAT: &str = "drape-run/2";

/// One run of one scene with one method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Always [`RUN_FORMAT`].
    pub format: String,
    /// Name of the scene.
    pub scene: String,
    /// SHA-256 of the discretised system ("drape-system/1", as `drape system` prints it).
    pub scene_hash: String,
    /// Method id.
    pub method: String,
    /// Every setting of the method with the value that was used.
    pub settings: BTreeMap<String, String>,
    /// Time step, s.
    pub dt_s: f64,
    /// Number of steps that were completed.
    pub steps: u64,
    /// How the run ended.
    pub ending: Ending,
    /// What the result is worth.
    pub verdict: Judgement,
    /// Sums over the run.
    pub totals: Totals,
    /// Seconds by phase; `null` unless asked for.
    pub phases_seconds: Option<Phases>,
    /// Diagnostics over time, the start first.
    pub series: Vec<Sample>,
    /// The last state.
    #[serde(rename = "final")]
    pub final_state: FinalState,
}

impl Run {
    /// The record of a run of `spec` that ended in `state`.
    pub fn of(
        spec: &SystemSpec,
        choice: &Choice,
        time: TimeSpan,
        (outcome, verdict): (&Outcome, Judgement),
        state: &State,
    ) -> Self {
        let settings = choice.settings().iter();
        let settings = settings.map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
        Self {
            format: RUN_FORMAT.to_owned(),
            scene: spec.name.clone(),
            scene_hash: system_hash(spec),
            method: choice.method().id.to_owned(),
            settings,
            dt_s: time.step_s,
            steps: outcome.steps,
            ending: Ending::of(outcome, state.t),
            verdict,
            totals: outcome.totals,
            phases_seconds: outcome.phases,
            series: outcome.series.clone(),
            final_state: FinalState {
                time_s: state.t,
                position_m: state.x.iter().map(|&x| x.into()).collect(),
                velocity_m_s: state.v.iter().map(|&v| v.into()).collect(),
            },
        }
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Ending {
    /// All steps were taken and the state stayed finite and near.
    Completed {
        /// Steps whose solver stopped before its tolerance.
        unconverged_steps: u64,
    },
    /// The user interrupted the run.
    Interrupted {
        /// The last step that was taken, from 1.
        step: u64,
        /// Simulated time after that step, s.
        time_s: f64,
        /// Steps whose solver stopped before its tolerance.
        unconverged_steps: u64,
    },
    /// The state became non-finite or left the scene.
    Diverged {
        /// Step at which it was seen, from 1.
        step: u64,
        /// Simulated time after that step, s.
        time_s: f64,
        /// Which criterion was met.
        criterion: String,
    },
}

impl Ending {
    fn of(outcome: &Outcome, time_s: f64) -> Self {
        let unconverged_steps = outcome.unconverged;
        match &outcome.divergence {
            None if outcome.is_over_budget => {
                Self::Interrupted { step: outcome.steps, time_s, unconverged_steps }
            }
            None => Self::Completed { unconverged_steps },
            Some(divergence) => Self::Diverged {
                step: divergence.step,
                time_s: divergence.time,
                criterion: divergence.criterion.clone(),
            },
        }
    }
}

/// What the result of a run is worth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Judgement {
    /// The verdict.
    pub kind: Judged,
    /// Share of the motion that the run kept, measured beside a reference in a few windows; 1 is
    /// all. `null` where nothing was measured.
    pub share: Option<f64>,
    /// Share that theory expected before the run; `null` where it expects nothing.
    pub expected_share: Option<f64>,
    /// Share of its angular momentum about the centre of mass that a free, spinning cloth has at
    /// the end. `null` where the cloth does not spin, or where a torque may act on it.
    pub spin_share: Option<f64>,
    /// Why, in a sentence.
    pub reason: String,
}

/// A verdict on a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Judged {
    /// The energy did not rise, and the cloth moves as it should.
    Stable,
    /// The energy did not rise, but the cloth keeps less than half of its motion.
    Locked,
    /// The energy rose above what came in.
    GainedEnergy,
    /// The run diverged.
    Diverged,
    /// Nothing shows whether the cloth moves as it should, or whether it gained energy.
    Unknown,
}

impl std::fmt::Display for Judged {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Stable => "stable",
            Self::Locked => "locked",
            Self::GainedEnergy => "gained energy",
            Self::Diverged => "diverged",
            Self::Unknown => "could not tell",
        })
    }
}

/// Sums over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Totals {
    /// CG iterations.
    pub cg_iterations: u64,
    /// Outer passes (re-evaluations of the right-hand side, EEH Algorithm 1).
    pub outer_passes: u64,
    /// Newton iterations.
    pub newton_iterations: u64,
    /// Factorisations of Newton's matrix.
    pub factorisations: u64,
    /// Set-ups of cached operators, the first one in `prepare` included.
    pub setups: u64,
    /// Products of the matrix with a block vector.
    pub matvecs: u64,
    /// Sweeps over the springs that evaluated forces or energies inside the steps.
    pub force_evaluations: u64,
    /// Wall time of all `step` calls together, s; diagnostics excluded.
    pub seconds: f64,
    /// Wall time of `prepare`, s.
    pub prepare_seconds: f64,
}

/// Diagnostics at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// Time, s.
    pub time_s: f64,
    /// Energies by effect, with `kinetic` and `total`, J.
    pub energy_j: BTreeMap<String, f64>,
    /// Linear momentum, kg m/s.
    pub momentum: [f64; 3],
    /// Angular momentum about the origin, kg m²/s.
    pub angular_momentum: [f64; 3],
}

/// The state at the end of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FinalState {
    /// Time, s.
    pub time_s: f64,
    /// Positions, m.
    pub position_m: Vec<[f64; 3]>,
    /// Velocities, m/s.
    pub velocity_m_s: Vec<[f64; 3]>,
}

/// Seconds by phase, summed over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Phases {
    /// Evaluation of forces.
    pub forces: f64,
    /// Assembly of the matrix and factorisation of the preconditioner.
    pub matrix_setup: f64,
    /// The linear or nonlinear solve, with every evaluation of forces inside it.
    pub solve: f64,
    /// Detection and release of contacts.
    pub contact: f64,
    /// Update of positions and velocities.
    pub update: f64,
}
