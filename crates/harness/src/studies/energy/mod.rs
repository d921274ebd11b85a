//! Experiment `energy`: where the energy of a cloth goes, method by method and cause by cause.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "energy",
    question: "Where does the energy of a cloth go: how much of it does the damping take that the scene asks for, and how much \
     the method itself, by its steps, its solver, its constraints and its corrections?",
    builds_on: &["momentum", "stability"],
    run: run::run,
    compare: |fresh, committed| compare("energy.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
