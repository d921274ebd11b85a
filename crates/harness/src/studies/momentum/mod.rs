//! Experiment `momentum`: drift of linear and angular momentum of every method.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;


use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "momentum",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("momentum.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
