//! Experiment `effects`: the bill of each effect.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "effects",
    question: "What does each effect that a scene names cost with every method, what does it change, and what does a scene \
     pay for those that it does not name?",
    builds_on: &["course"],
    run: run::run,
    compare: |fresh, committed| compare("effects.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
