//! Experiment `rest`: which methods bring a cloth to rest, in which shape, and at what cost.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use super::Parts;

pub(super) const STUDY: Parts<facts::Facts, facts::TimingRow> = Parts {
    name: "rest",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    method: run::method,
    timing: Some(run::TIMING),
    starts: run::starts,
    run: run::run,
    comparable: run::comparable,
    words: words::words,
    plates: plates::PLATES,
    tables: plates::tables,
    lessons: None,
};
