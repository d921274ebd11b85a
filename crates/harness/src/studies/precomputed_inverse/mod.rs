//! Experiment `precomputed-inverse`: what Desbrun's inverse costs, and what a change of the system costs it.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "precomputed-inverse",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("precomputed-inverse.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
