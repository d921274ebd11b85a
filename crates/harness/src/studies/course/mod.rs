//! Experiment `course`: from explicit Euler to two-step IMEX, each method on one and the same cloth.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "course",
    question: "What could each method not do that the next one can, from explicit Euler to two-step IMEX, on one and \
     the same cloth?",
    builds_on: &[],
    run: run::run,
    compare: |fresh, committed| compare("course.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
