//! Experiment `animation`: what a frame costs that is good enough.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use super::Parts;

/// Larger cloth and longer spans: hours of work, which `reproduce` leaves to `reproduce --long`.
pub(super) const LONG: Parts<facts::Facts, facts::TimingRow> = Parts {
    name: "animation-long",
    question: words::LONG_QUESTION,
    builds_on: words::LONG_BUILDS_ON,
    method: run::long_method,
    timing: Some(run::timing),
    starts: run::long_starts,
    run: run::long,
    comparable: run::comparable,
    words: words::long,
    plates: plates::LONG_PLATES,
    tables: plates::tables,
    lessons: None,
};

pub(super) const STUDY: Parts<facts::Facts, facts::TimingRow> = Parts {
    name: "animation",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    method: run::method,
    timing: Some(run::timing),
    starts: run::starts,
    run: run::run,
    comparable: run::comparable,
    words: words::words,
    plates: plates::PLATES,
    tables: plates::tables,
    lessons: None,
};
