//! Experiment `tables`: the paper's tables 2 and 3.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;


use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "tables",
    question: "Do the paper's iteration counts (tables 2 and 3) come out, for which \
     reading of their illegible exponents and at which solver tolerance?",
    builds_on: &["course"],
    run: run::run,
    compare: |fresh, committed| compare("tables.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
