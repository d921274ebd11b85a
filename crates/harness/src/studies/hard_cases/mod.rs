//! Experiment `hard-cases`: every method on scenes where methods fail.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use super::Parts;

pub(super) const STUDY: Parts<facts::Facts> = Parts {
    name: "hard-cases",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    method: run::method,
    timing: None,
    starts: run::starts,
    run: run::run,
    comparable: run::comparable,
    words: words::words,
    plates: plates::PLATES,
    tables: plates::tables,
    lessons: None,
};
