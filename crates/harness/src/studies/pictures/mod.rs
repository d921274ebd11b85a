//! Experiment `pictures`: what the cloth looks like, EEH figure 4.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;


use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "pictures",
    question: "What does the cloth look like: on a table and hanging from two corners, and with each method?",
    builds_on: &["course"],
    run: run::run,
    compare: |fresh, committed| compare("pictures.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
