//! Experiment `energy`: where the energy of a cloth goes, method by method and cause by cause.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "energy",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("energy.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
