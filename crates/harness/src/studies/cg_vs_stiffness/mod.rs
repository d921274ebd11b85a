//! Experiment `cg-vs-stiffness`: conjugate-gradient iterations against stiffness.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;


use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "cg-vs-stiffness",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("cg-vs-stiffness.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
