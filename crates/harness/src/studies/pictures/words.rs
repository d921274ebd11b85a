//! The words of the study `pictures`: its question.

use super::facts::*;
use crate::studies::short;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "What does the cloth look like: on a table and hanging from two corners, and with each method?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

/// How far a sheet has come down on average, m; it starts at height 0.
pub(super) fn fall(shot: &Shot) -> Option<f64> {
    let heights = shot.position_m.iter().skip(2).step_by(3);
    let count = heights.clone().count();
    (count > 0).then(|| -heights.sum::<f64>() / count as f64)
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let methods = || facts.shots.iter().filter(|shot| shot.series == METHODS);
    let Some(reference) = methods().find(|shot| shot.label == REFERENCE) else {
        return vec![
            "The hanging textile was drawn; the quick subset compares no methods.".to_owned(),
        ];
    };
    let others = || {
        let same = |shot: &&Shot| shot.time_s == reference.time_s && shot.label != REFERENCE;
        methods().filter(same)
    };
    let Some(whole) = fall(reference) else { return Vec::new() };
    let list =
        |names: Vec<String>| if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    let diverged = others().filter(|shot| shot.diverged_at_s.is_some());
    let diverged: Vec<_> = diverged.map(|shot| format!("`{}`", shot.label)).collect();
    let fallen = |low: f64, high: f64| -> Vec<String> {
        let parts = others().filter(|shot| shot.diverged_at_s.is_none());
        let parts = parts.filter_map(|shot| Some((shot, fall(shot)? / whole)));
        let parts = parts.filter(|(_, part)| (low..high).contains(part));
        parts.map(|(shot, part)| format!("`{}` ({} %)", shot.label, short(100.0 * part))).collect()
    };
    vec![
        format!(
            "With h = {STEP} s on a sheet of k/m = 1e6/s² {} of {} methods diverge within a second: {}.",
            diverged.len(),
            others().count(),
            list(diverged)
        ),
        format!(
            "After {} s the sheet should have come down by {} m on average. At least nine tenths of it: {}. Less than half: {}.",
            reference.time_s,
            short(whole),
            list(fallen(0.9, f64::INFINITY)),
            list(fallen(f64::NEG_INFINITY, 0.5))
        ),
    ]
}
