//! Records of the experiment `regret`: the advice of a comparison beside the best form there is.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Regrets that the advice should keep: in the median, and always.
pub(super) const MEDIAN: f64 = 1.1;
pub(super) const WORST: f64 = 1.5;
/// Share of its budget that a comparison may spend.
pub(super) const SPENT: f64 = 1.1;
/// Share of the measured cases in which the target should be met.
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
    /// Modelled time of the advice over that of the best; `None` where one of them is missing.
    pub regret: Option<f64>,
    /// Modelled time of all runs of the comparison over that of the exhaustive search.
    pub effort: f64,
    /// Error of the advised run where the cloth is pushed, m; `None` where it was not
    /// sound then.
    pub again_m: Option<f64>,
    /// Error that counts as met where the cloth is pushed, m; `None` where the run was not measured
    /// then.
    pub again_good_m: Option<f64>,
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
    /// Contact, friction, wind or bending by angles; nothing was tuned on it.
    Forces,
}

impl Origin {
    pub(super) const ALL: [Self; 3] = [Self::Bundled, Self::Springs, Self::Forces];

    /// As tables call it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bundled => "bundled",
            Self::Springs => "springs, gravity, pins",
            Self::Forces => "contact, friction, wind, angles",
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
    /// Time that the comparison took, s.
    pub seconds: f64,
    /// Whether the comparison had a true motion to rank by.
    pub is_trusted: bool,
    /// Label of the form that it advised; `None` where none met the target in that time.
    pub label: Option<String>,
    /// Steps a frame of the advised form.
    pub substeps: u32,
    /// Time that the search took, s.
    pub search_s: f64,
    /// Whether the search had a true motion to rank by. Otherwise the case is not judged.
    pub is_judged: bool,
    /// Forms that the search could not run to their end.
    pub left: usize,
    /// Label of the fastest run that met the target in the search, timed in turns; `None` where
    /// none did.
    pub best: Option<String>,
    /// Steps a frame of the fastest run of the search.
    pub best_substeps: u32,
    /// Time a frame of the advice over that of the best, timed in turns; `None` where one of them
    /// is missing. Below 1 the comparison found a faster run than the search.
    pub regret: Option<f64>,
    /// Error of the advised run where the cloth is pushed, m; `None` where it was not sound then.
    pub again_m: Option<f64>,
    /// Error that counts as met where the cloth is pushed, m; `None` where the run was not measured
    /// then.
    pub again_good_m: Option<f64>,
    /// Time a frame of the best form by modelled time over its modelled time, which is that of
    /// another machine.
    pub over_model: Option<f64>,
}

/// What came of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The advised run met the target when it was measured again.
    Met,
    /// It did not, or the search found a run that meets the target and the comparison none.
    Missed,
    /// The advised run could not be measured again, or the search has nothing to judge by.
    NotMeasured,
}

impl Outcome {
    /// From the error of the advised run, m, and that which counts as met, when it was measured.
    fn of(error_m: Option<f64>, good_m: Option<f64>) -> Self {
        match good_m {
            None => Self::NotMeasured,
            Some(good) if error_m.is_some_and(|error| error <= good) => Self::Met,
            Some(_) => Self::Missed,
        }
    }
}

/// How often the target was met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Cases of [`Outcome::Met`].
    pub met: usize,
    /// Of [`Outcome::Missed`].
    pub missed: usize,
    /// Of [`Outcome::NotMeasured`].
    pub not_measured: usize,
}

impl Tally {
    /// Counts them.
    pub fn of(outcomes: impl Iterator<Item = Outcome>) -> Self {
        outcomes.fold(Self::default(), |mut tally, outcome| {
            *match outcome {
                Outcome::Met => &mut tally.met,
                Outcome::Missed => &mut tally.missed,
                Outcome::NotMeasured => &mut tally.not_measured,
            } += 1;
            tally
        })
    }

    /// Cases that were measured.
    pub fn measured(self) -> usize {
        self.met + self.missed
    }

    /// Share of the measured cases in which the target was met.
    pub(super) fn share(self) -> Option<f64> {
        (self.measured() > 0).then(|| self.met as f64 / self.measured() as f64)
    }
}

impl TimingRow {
    /// Whether the search found a run that meets the target, and the comparison none.
    pub(super) fn lacks_advice(&self) -> bool {
        self.label.is_none() && self.best.is_some()
    }

    /// What came of it; `None` where no form meets the target.
    pub fn outcome(&self) -> Option<Outcome> {
        match &self.label {
            Some(_) => Some(Outcome::of(self.again_m, self.again_good_m)),
            None if self.best.is_some() => Some(Outcome::Missed),
            None => (!self.is_judged).then_some(Outcome::NotMeasured),
        }
    }
}

impl Case {
    /// Whether the search found a run that meets the target, and the comparison none.
    pub(super) fn lacks_advice(&self) -> bool {
        self.advice.is_none() && self.best.is_some()
    }

    /// What came of it; `None` where no form meets the target.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        match &self.advice {
            Some(_) => Some(Outcome::of(self.again_m, self.again_good_m)),
            None => self.best.is_some().then_some(Outcome::Missed),
        }
    }
}
