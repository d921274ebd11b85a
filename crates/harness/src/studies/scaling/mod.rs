//! Experiment `scaling`: cost as the work grows.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;


use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "scaling",
    question: "How do the iterations and the time of a step grow with the number of particles, from a hundred to a \
     million?",
    builds_on: &["work-precision"],
    run: run::run,
    compare: |fresh, committed| compare("scaling.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
