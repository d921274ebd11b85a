//! Experiment `solver-control`: what the paper names as further work, measured.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "solver-control",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("solver-control.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
