//! Experiment `course`: from explicit Euler to two-step IMEX, each method on the same cloth.

pub mod facts;
mod lessons;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use super::Parts;

pub(super) const STUDY: Parts<facts::Facts> = Parts {
    name: "course",
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
    lessons: Some(plates::lessons),
};
