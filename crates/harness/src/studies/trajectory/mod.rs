//! Experiment `trajectory`: which methods follow a smooth motion, by stiffness and damping.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use super::Parts;
pub use run::{Agreement, by_other_prices, with_longer_steps};

pub(super) const STUDY: Parts<facts::Facts> = Parts {
    name: "trajectory",
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
