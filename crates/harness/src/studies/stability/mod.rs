//! Experiment `stability`: which step, stiffness and damping a method survives.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "stability",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("stability.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
