//! Experiment `locking`: how much of the motion a stiff cloth keeps at a step that does not resolve its springs.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "locking",
    question: "How much of its motion does a stiff cloth keep when the step is much longer than the periods of its \
     springs, and is what is lost what the law of locking says?",
    builds_on: &["cg-vs-stiffness", "stability"],
    run: run::run,
    compare: |fresh, committed| compare("locking.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
