//! Experiment `locking`: how much of the motion a stiff cloth keeps at a step that does not resolve its springs.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "locking",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("locking.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
