//! Experiment `cg-vs-stiffness`: conjugate-gradient iterations against stiffness.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;


use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "cg-vs-stiffness",
    question: "How do the CG iterations of plain and of updated IMEX Euler grow with the \
     stiffness, the step size and the tolerance, and does the cloth still move?",
    builds_on: &["tables"],
    run: run::run,
    compare: |fresh, committed| compare("cg-vs-stiffness.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
