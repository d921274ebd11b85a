//! Experiment `post-correction`: what shortening springs after the step does, EEH section 3.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "post-correction",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    run: run::run,
    compare: |fresh, committed| compare("post-correction.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
