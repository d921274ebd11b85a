//! Experiment `hard-cases`: every method where methods fail.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;


use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "hard-cases",
    question: "Which method stays stable where methods fail, and does it do so where its theory \
     says that it should?",
    builds_on: &["momentum", "stability"],
    run: run::run,
    compare: |fresh, committed| compare("hard-cases.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
