//! Experiment `collision`: ways out of an obstacle, EEH section 6.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "collision",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("collision.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
