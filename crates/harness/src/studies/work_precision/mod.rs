//! Experiment `work-precision`: what accuracy costs.

pub mod facts;
pub(crate) mod plates;
pub(crate) mod run;
mod words;

use super::Parts;

pub(super) const STUDY: Parts<facts::Facts, facts::TimingRow> = Parts {
    name: "work-precision",
    question: words::QUESTION,
    builds_on: words::BUILDS_ON,
    method: run::method,
    timing: Some(run::TIMING),
    starts: run::starts,
    run: run::run,
    comparable: run::comparable,
    words: words::words,
    plates: plates::PLATES,
    tables: plates::tables,
    lessons: None,
};

/// The facts of the same runs by other prices: modelled times, fronts and winners.
pub fn repriced(facts: facts::Facts, prices: &crate::cost::Prices) -> facts::Facts {
    run::repriced(facts, prices)
}
