//! Records of the experiment `regret`: the advice of a comparison beside the best form there is.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Regrets that the advice should keep: in the median, and always.
pub(super) const MEDIAN: f64 = 1.1;
pub(super) const WORST: f64 = 1.5;
/// Share of the cases in which the target should be met when it is measured again.
pub(super) const MET: f64 = 0.95;

/// All cases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// One a scene and target.
    pub cases: Vec<Case>,
}

/// One question: a scene and a greatest error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name of the scene.
    pub scene: String,
    /// What it is, in a sentence.
    pub description: String,
    /// Number of particles.
    pub particles: usize,
    /// Greatest error that was asked for, m.
    pub target_m: f64,
    /// Error that counts as met, m: the target, or twice the noise.
    pub good_m: f64,
    /// Whether the true motion was found well enough to rank by.
    pub is_trusted: bool,
    /// The cheapest run that meets the target out of all forms, each run until it does.
    pub best: Option<Pick>,
    /// What the comparison advises, which stops what seems dominated.
    pub advice: Option<Pick>,
    /// Modelled time of the advice over that of the best.
    pub regret: Option<f64>,
    /// Modelled time of all runs of the comparison over that of the exhaustive search.
    pub effort: f64,
    /// Error of the advised run where the cloth is pushed, m; `None` where it was not
    /// sound then.
    pub again_m: Option<f64>,
    /// Error that counts as met then, m.
    pub again_good_m: f64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// A run of a form.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pick {
    /// Short name of the form.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Steps a frame.
    pub substeps: u32,
    /// Error, m.
    pub error_m: f64,
    /// Modelled time a frame, s.
    pub frame_s: f64,
}

/// What a comparison by the clock of this machine advised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// Name of the scene.
    pub scene: String,
    /// Greatest error that was asked for, m.
    pub target_m: f64,
    /// Time that it was given, s.
    pub budget_s: f64,
    /// Time that it took, s.
    pub seconds: f64,
    /// Label of the form that it advised; `None` where none met the target in that time.
    pub label: Option<String>,
    /// Steps a frame.
    pub substeps: u32,
    /// Time a frame of the advice over that of the best form of the exhaustive search, both timed
    /// in turns on this machine.
    pub regret: Option<f64>,
    /// Time a frame of that best form over its modelled time, which is that of another machine.
    pub over_model: Option<f64>,
}

impl Case {
    /// Whether the advised run met the target when it was measured again; `None` without advice.
    pub(super) fn is_met(&self) -> Option<bool> {
        self.advice.as_ref()?;
        Some(self.again_m.is_some_and(|error| error <= self.again_good_m))
    }
}
