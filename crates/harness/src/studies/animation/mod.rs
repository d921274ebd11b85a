//! Experiment `animation`: what a good frame costs.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use super::Parts;

/// Larger cloth and longer spans. They take hours, so only `reproduce --long` runs them.
pub(super) const LONG: Parts<facts::Facts, facts::TimingRow> = Parts {
    name: "animation-long",
    question: words::LONG_QUESTION,
    builds_on: words::LONG_BUILDS_ON,
    method: run::long_method,
    timing: Some(run::TIMING),
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
    timing: Some(run::TIMING),
    starts: run::starts,
    run: run::run,
    comparable: run::comparable,
    words: words::words,
    plates: plates::PLATES,
    tables: plates::tables,
    lessons: None,
};
