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

/// Where a scene comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// The command brings it along.
    Bundled,
    /// Springs, gravity and pins; nothing was tuned on it.
    Springs,
    /// Contact, friction, wind, hinges or angles; nothing was tuned on it.
    Forces,
}

impl Origin {
    pub(super) const ALL: [Self; 3] = [Self::Bundled, Self::Springs, Self::Forces];

    /// As tables call it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bundled => "bundled",
            Self::Springs => "springs, gravity, pins",
            Self::Forces => "contact, friction, wind, hinges",
        }
    }
}

/// What a comparison by the clock of this machine advised, beside a search of that machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// Name of the scene.
    pub scene: String,
    /// Where it comes from.
    pub origin: Origin,
    /// Number of particles.
    pub particles: usize,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Greatest error that was asked for, m.
    pub target_m: f64,
    /// Time that the comparison was given, s.
    pub budget_s: f64,
    /// Time that it took, s.
    pub seconds: f64,
    /// Whether the comparison had a true motion to rank by.
    pub is_trusted: bool,
    /// Label of the form that it advised; `None` where none met the target in that time.
    pub label: Option<String>,
    /// Steps a frame.
    pub substeps: u32,
    /// Time that the search took, s.
    pub search_s: f64,
    /// Whether the search had a true motion to rank by. Otherwise the case is not judged.
    pub is_judged: bool,
    /// Forms that the search could not run to their end.
    pub left: usize,
    /// Label of the fastest form that met the target in the search, timed in turns; `None` where
    /// none did.
    pub best: Option<String>,
    /// Its steps a frame.
    pub best_substeps: u32,
    /// Time a frame of the advice over that of the best, timed in turns.
    pub regret: Option<f64>,
    /// Error of the advised run where the cloth is pushed, m; `None` where it was not sound then.
    pub again_m: Option<f64>,
    /// Error that counts as met then, m; `None` where there is no true motion then.
    pub again_good_m: Option<f64>,
    /// Time a frame of the best form by modelled time over its modelled time, which is that of
    /// another machine.
    pub over_model: Option<f64>,
}

impl TimingRow {
    /// Whether the advised run met the target when it was measured again; `None` where nothing was
    /// advised or it could not be measured.
    pub(super) fn is_met(&self) -> Option<bool> {
        self.label.as_ref()?;
        let good = self.again_good_m?;
        Some(self.again_m.is_some_and(|error| error <= good))
    }
}

impl Case {
    /// Whether the advised run met the target when it was measured again; `None` without advice.
    pub(super) fn is_met(&self) -> Option<bool> {
        self.advice.as_ref()?;
        Some(self.again_m.is_some_and(|error| error <= self.again_good_m))
    }
}
