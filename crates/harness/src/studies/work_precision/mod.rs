//! Experiment `work-precision`: what accuracy costs.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "work-precision",
    question: "What does accuracy cost: which method is the cheapest for a given error, and how does that change with \
     stiffness, damping and size?",
    builds_on: &["order", "stability", "locking"],
    run: run::run,
    compare: |fresh, committed| compare("work-precision.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
