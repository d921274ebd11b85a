//! Experiment `solver-control`: what the paper names as further work, measured.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "solver-control",
    question: "What do variable forcing terms, saved Jacobians, adaptive steps and preconditioners save, \
     and at what error?",
    builds_on: &["work-precision"],
    run: run::run,
    compare: |fresh, committed| compare("solver-control.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
