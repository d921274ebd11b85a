//! The frame of every record under `results/`: question, method, results and origin.
//!
//! A *record* is one JSON file: the facts of a study ([`Record`]) or its timings ([`Timings`]).
//! Facts are counts, errors and verdicts. They are the same on every machine and are compared bit
//! for bit. Timings belong to the machine that took them and live in files of their own, so that a
//! new machine does not touch the facts. Each file carries its [`Provenance`].

use crate::Provenance;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The value of `format` in every record of facts.
pub const RECORD_FORMAT: &str = "drape-record/2";
/// The value of `format` in every record of timings.
pub const TIMINGS_FORMAT: &str = "drape-timings/1";

/// The facts of one experiment, with what a reader needs to judge and to repeat them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Record<F> {
    /// Always [`RECORD_FORMAT`].
    pub format: String,
    /// Name of the experiment, as `drape experiment` takes it.
    pub experiment: String,
    /// The question that the experiment answers.
    pub question: String,
    /// How it was measured, in a few sentences.
    pub method: String,
    /// Conclusion, observations and caveats.
    pub words: Words,
    /// The one command that writes this record again.
    pub command: String,
    /// Whether only the quick subset of the cells was computed.
    pub quick: bool,
    /// Title and caption of each figure that is drawn from this record.
    pub figures: Vec<Figure>,
    /// The facts themselves.
    pub facts: F,
    /// The origin of the facts.
    pub provenance: Provenance,
}

impl<F> Record<F> {
    /// Splits the record into itself without facts, and the facts.
    pub fn split(self) -> (Record<()>, F) {
        let frame = Record {
            facts: (),
            format: self.format,
            experiment: self.experiment,
            question: self.question,
            method: self.method,
            words: self.words,
            command: self.command,
            quick: self.quick,
            figures: self.figures,
            provenance: self.provenance,
        };
        (frame, self.facts)
    }
}

/// The statements of a record. Code computes every word from the facts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Words {
    /// The answer to the question, at most three sentences.
    pub conclusion: String,
    /// At most five observations, of one sentence each.
    pub observations: Vec<String>,
    /// Limits of the conclusion, one sentence each.
    pub caveats: Vec<String>,
}

/// A figure drawn from a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// File name below `figures/`, e.g. `cg-vs-stiffness.svg`.
    pub file: String,
    /// Title, one line.
    pub title: String,
    /// What is drawn, under which conditions, and what to see in it.
    pub caption: String,
}

/// Wall-clock timings of one experiment on one machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Timings<R> {
    /// Always [`TIMINGS_FORMAT`].
    pub format: String,
    /// Name of the experiment.
    pub experiment: String,
    /// How the times were taken.
    pub method: String,
    /// One row per timed case.
    pub rows: Vec<R>,
    /// The machine and the build that took the times.
    pub provenance: Provenance,
}
