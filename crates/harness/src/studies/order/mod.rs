//! Experiment `order`: observed order of accuracy and error constant of every method.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;


use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "order",
    question: "Does the error of every method fall with the order that theory gives, how large \
     is its constant, and what is left of the order where the springs are too stiff for the step?",
    builds_on: &["course"],
    run: run::run,
    compare: |fresh, committed| compare("order.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
