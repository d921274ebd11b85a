//! Experiment `momentum`: drift of linear and angular momentum of every method.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;


use crate::facts::compare;
use super::Study;

pub(super) const STUDY: Study = Study {
    name: "momentum",
    question: "Which methods keep the linear and the angular momentum of a cloth that nothing holds, \
     and how much of its spin is left by the others and by Desbrun's correction?",
    builds_on: &["order"],
    run: run::run,
    compare: |fresh, committed| compare("momentum.json", fresh, committed, run::comparable),
    figures: plates::figures,
    section: plates::section,
};
