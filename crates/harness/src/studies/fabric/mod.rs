//! Experiment `fabric`: simulated cloth against exact solutions and against measured cloth.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use super::Parts;

pub(super) const STUDY: Parts<facts::Facts> = Parts {
    name: "fabric",
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
