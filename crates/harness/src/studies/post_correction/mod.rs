//! Experiment `post-correction`: what shortening springs after the step does, EEH section 3.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "post-correction",
    question: "Is a soft sheet whose springs are shortened after each step a stiff sheet: what becomes of energy, momentum \
     and the differential equation, does the order matter, and do sweeps converge?",
    builds_on: &["course"],
    run: run::run,
    compare: |fresh, committed| compare("post-correction.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
