//! Experiment `precomputed-inverse`: what Desbrun's inverse costs, and what a change of the system costs it.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "precomputed-inverse",
    question: "What do a precomputed inverse, a sparse factor and conjugate gradients cost to make, to keep and to use, \
     and what does a change of step size or stiffness cost each?",
    builds_on: &["cg-vs-stiffness"],
    run: run::run,
    compare: |fresh, committed| compare("precomputed-inverse.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
