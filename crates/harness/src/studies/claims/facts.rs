//! Records of the experiment `claims`: what was measured for each claim of the paper and for each
//! expectation about later methods, and the verdict.

use drape_report::number::median_s;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The ledger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// One a claim: those of the paper, then the expectations, in the order of their ids.
    pub claims: Vec<Row>,
}

/// What the recorded numbers make of a claim.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Ruling {
    /// The criterion is met.
    Holds,
    /// The criterion is not met.
    Fails,
    /// The numbers cannot tell; the reason says why.
    Undecided,
}

impl Ruling {
    /// One word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::Undecided => "undecided",
        }
    }

    /// Holds or fails.
    pub fn of(is_met: bool) -> Self {
        if is_met { Self::Holds } else { Self::Fails }
    }
}

/// What was measured for one claim, and the verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// `C01` to `C29` for claims of the paper, `M01` to `M08` for expectations about later methods.
    pub id: String,
    /// Whether the claim's own criterion is met. The verdict of the report may differ: it also takes
    /// in the other readings of the paper's words.
    pub verdict: Ruling,
    /// The numbers behind it.
    pub numbers: Vec<Number>,
    /// What was run.
    pub scenes: String,
    /// Same bits on every machine.
    pub portable: bool,
}

/// A measured number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Number {
    /// What it is; unique within a claim.
    pub what: String,
    /// Value of a measured number; one that is not finite stands as the largest number.
    pub value: f64,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// What the criterion compares it with.
    pub limit: Option<f64>,
    /// Whether other machines must find the same; counts after a library's factorisation need not.
    pub is_compared: bool,
}

impl Number {
    /// A number without a limit.
    pub fn new(what: impl Into<String>, value: f64, unit: &str) -> Self {
        let value = if value.is_nan() { f64::MAX } else { value.clamp(f64::MIN, f64::MAX) };
        Self { what: what.into(), value, unit: unit.to_owned(), limit: None, is_compared: true }
    }

    /// The same with the limit of the criterion.
    #[must_use]
    pub fn against(self, limit: f64) -> Self {
        Self { limit: Some(limit), ..self }
    }

    /// The same, recorded beside the machine and compared with nothing.
    #[must_use]
    pub fn of_machine(self) -> Self {
        Self { is_compared: false, ..self }
    }
}

/// Seconds beside a claim about time, which counted work decides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// Id of the claim.
    pub id: String,
    /// What was timed.
    pub cases: Vec<TimedCase>,
    /// What the seconds give: the criterion's number.
    pub number: Number,
    /// The verdict by the seconds alone. If it is not that of the facts, the ledger says so.
    pub verdict: Ruling,
}

/// One timed piece of work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimedCase {
    /// What it is.
    pub what: String,
    /// Wall time of each repetition, ns.
    pub samples_ns: Vec<u64>,
}

impl TimedCase {
    /// Median of the samples, s; 0 without samples.
    pub fn median_s(&self) -> f64 {
        median_s(&self.samples_ns)
    }
}
