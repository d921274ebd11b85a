//! Records of the experiment `regret`: the advice of a comparison against the best run of a search.

use crate::compare::Options;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bounds on the regret that the advice should keep: on the median, and on every case.
pub(super) const MEDIAN: f64 = 1.1;
pub(super) const WORST: f64 = 1.5;
/// Largest time that a comparison may take, over its budget.
pub(super) const SPENT: f64 = 1.1;
/// Share of the measured cases in which the target should be met.
pub(super) const MET: f64 = 0.95;

/// All cases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// One case for each scene and target.
    pub cases: Vec<Case>,
}

/// One question: which run of a scene is the cheapest with at most this error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name of the scene.
    pub scene: String,
    /// The scene in one sentence.
    pub description: String,
    /// Number of particles.
    pub particles: usize,
    /// Largest error that was asked for, m.
    pub target_m: f64,
    /// Largest error that meets the target, m: the target itself, or twice the noise if that is
    /// more.
    pub good_m: f64,
    /// Whether the true motion is accurate enough to rank runs.
    pub is_trusted: bool,
    /// The cheapest run that meets the target in the exhaustive search, which runs every form until
    /// it does.
    pub best: Option<Pick>,
    /// The advice of the comparison, which stops forms that seem dominated.
    pub advice: Option<Pick>,
    /// Modelled time of the advice over that of the best; `None` if one of them is missing.
    pub regret: Option<f64>,
    /// Modelled time of all runs of the comparison, over that of the exhaustive search.
    pub effort: f64,
    /// Error of the advised run on the pushed cloth, m; `None` if it was not sound there.
    pub again_m: Option<f64>,
    /// Largest error that meets the target on the pushed cloth, m; `None` if the run was not
    /// measured there.
    pub again_good_m: Option<f64>,
    /// Whether the record has the same bits on every machine.
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
    /// Number of steps a frame.
    pub substeps: u32,
    /// Error, m.
    pub error_m: f64,
    /// Modelled time a frame, s.
    pub frame_s: f64,
}

/// Origin of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// Bundled with the command.
    Bundled,
    /// Of this study, with springs, gravity and pins only. No form was tuned on it.
    Springs,
    /// Of this study, with contact, friction, wind or bending by angles. No form was tuned on it.
    Forces,
}

impl Origin {
    pub(super) const ALL: [Self; 3] = [Self::Bundled, Self::Springs, Self::Forces];

    /// Its name in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bundled => "bundled",
            Self::Springs => "springs, gravity, pins",
            Self::Forces => "contact, friction, wind, angles",
        }
    }
}

/// The advice of a comparison by measured time, against a search on the same machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// Name of the scene.
    pub scene: String,
    /// Origin of the scene.
    pub origin: Origin,
    /// Number of particles.
    pub particles: usize,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Frames a second.
    #[serde(default = "usual_rate")]
    pub frames_per_s: f64,
    /// Largest error that was asked for, m.
    pub target_m: f64,
    /// Time that the comparison was given, s.
    pub budget_s: f64,
    /// Time that the comparison took, s.
    pub seconds: f64,
    /// Whether the comparison had a true motion to rank runs.
    pub is_trusted: bool,
    /// Label of the advised form; `None` if no run met the target in that time.
    pub label: Option<String>,
    /// Number of steps a frame of the advised form.
    pub substeps: u32,
    /// Time that the search took, s.
    pub search_s: f64,
    /// Whether the search had a true motion to rank runs. If not, the case is not judged.
    pub is_judged: bool,
    /// Number of forms that the search had no time to complete.
    pub left: usize,
    /// Label of the fastest run that met the target in the search, timed in turns; `None` if no run
    /// met it.
    pub best: Option<String>,
    /// Number of steps a frame of the fastest run of the search.
    pub best_substeps: u32,
    /// Time a frame of the advice over that of the best, timed in turns; `None` if one of them is
    /// missing. Below 1 the comparison found a faster run than the search.
    pub regret: Option<f64>,
    /// Error of the advised run on the pushed cloth, m; `None` if it was not sound there.
    pub again_m: Option<f64>,
    /// Largest error that meets the target on the pushed cloth, m; `None` if the run was not
    /// measured there.
    pub again_good_m: Option<f64>,
    /// Measured over modelled time a frame of the best form by modelled time. The model's prices
    /// come from another machine.
    pub over_model: Option<f64>,
}

/// Frames a second, where a row of an older file names none.
fn usual_rate() -> f64 {
    Options::default().rate
}

/// The outcome of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The advised run met the target when it was measured on the pushed cloth.
    Met,
    /// The advised run did not meet it there, or only the search found a run that meets the target.
    Missed,
    /// The advised run could not be measured there, or the search had nothing to judge by.
    NotMeasured,
}

impl Outcome {
    /// The outcome from the error of the advised run, m, and the largest error that meets the
    /// target, m. Without the latter the run was not measured.
    fn of(error_m: Option<f64>, good_m: Option<f64>) -> Self {
        match good_m {
            None => Self::NotMeasured,
            Some(good) if error_m.is_some_and(|error| error <= good) => Self::Met,
            Some(_) => Self::Missed,
        }
    }
}

/// Counts of outcomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Number of cases with [`Outcome::Met`].
    pub met: usize,
    /// Number of cases with [`Outcome::Missed`].
    pub missed: usize,
    /// Number of cases with [`Outcome::NotMeasured`].
    pub not_measured: usize,
}

impl Tally {
    /// Counts the outcomes.
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

    /// Number of cases that were measured.
    pub fn measured(self) -> usize {
        self.met + self.missed
    }

    /// Share of the measured cases in which the target was met; `None` without any.
    pub(super) fn share(self) -> Option<f64> {
        (self.measured() > 0).then(|| self.met as f64 / self.measured() as f64)
    }
}

impl TimingRow {
    /// Whether the search found a run that meets the target, but the comparison did not.
    pub(super) fn lacks_advice(&self) -> bool {
        self.label.is_none() && self.best.is_some()
    }

    /// The outcome; `None` if neither the search nor the comparison found a run that meets the
    /// target.
    pub fn outcome(&self) -> Option<Outcome> {
        match &self.label {
            Some(_) => Some(Outcome::of(self.again_m, self.again_good_m)),
            None if self.best.is_some() => Some(Outcome::Missed),
            None => (!self.is_judged).then_some(Outcome::NotMeasured),
        }
    }
}

impl Case {
    /// Whether the search found a run that meets the target, but the comparison did not.
    pub(super) fn lacks_advice(&self) -> bool {
        self.advice.is_none() && self.best.is_some()
    }

    /// The outcome; `None` if neither the search nor the comparison found a run that meets the
    /// target.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        match &self.advice {
            Some(_) => Some(Outcome::of(self.again_m, self.again_good_m)),
            None => self.best.is_some().then_some(Outcome::Missed),
        }
    }
}
