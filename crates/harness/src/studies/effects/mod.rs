//! Experiment `effects`: the cost of each effect.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use super::{Parts, Timing};

pub(super) const STUDY: Parts<facts::Facts, facts::TimingRow> = Parts {
    name: "effects",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    method: run::method,
    timing: Some(Timing::of(run::timing)),
    starts: run::starts,
    run: run::run,
    comparable: run::comparable,
    words: words::words,
    plates: plates::PLATES,
    tables: plates::tables,
    lessons: None,
};
