//! Experiment `course`: from explicit Euler to two-step IMEX, each method on one and the same cloth.

pub mod facts;
mod lessons;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "course",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("course.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
