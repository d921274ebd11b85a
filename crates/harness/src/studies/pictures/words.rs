//! The words of the study `pictures`: its question, and the findings from its numbers.

use super::facts::*;
use crate::studies::names::{count, verb};
use drape_report::Words;
use drape_report::number::{power, significant};

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "What does the cloth look like on a table, hanging from two corners, and with each method?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// Share of the true fall from which on a sheet falls in time.
const ON_TIME: f64 = 0.9;
/// Share of the true fall below which a sheet hangs in the air.
const HANGING: f64 = 0.5;
/// Largest number of methods that a sentence names.
const FEW: usize = 5;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion = [diverged(facts), fallen(facts)];
    let mut conclusion: Vec<_> = conclusion.into_iter().flatten().collect();
    if conclusion.is_empty() {
        conclusion.push("The record compares no methods; it only shows the cloth.".to_owned());
    }
    let observations = [failing(facts), hanging(facts), farthest(facts)];
    let mut caveats =
        vec!["A picture shows no error: a sheet may fall on time and still be wrong.".to_owned()];
    if is_compared(facts) {
        caveats.push("One stiff sheet, with default settings and one step size.".to_owned());
    }
    Words {
        conclusion: conclusion.join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats,
    }
}

/// The pictures of the methods, except the reference.
fn methods(facts: &Facts) -> impl Iterator<Item = &Shot> + Clone {
    facts.shots.iter().filter(|shot| shot.series == METHODS && shot.label != REFERENCE)
}

fn is_compared(facts: &Facts) -> bool {
    reference_at(facts, first_time(facts)).is_some() && methods(facts).next().is_some()
}

fn first_time(facts: &Facts) -> f64 {
    methods(facts).map(|shot| shot.time_s).fold(f64::INFINITY, f64::min)
}

/// The pictures of the methods at the earliest time.
fn first(facts: &Facts) -> impl Iterator<Item = &Shot> + Clone {
    let time = first_time(facts);
    methods(facts).filter(move |shot| shot.time_s == time)
}

/// The names as `: a, b`; empty if there are too many for a sentence.
fn listed<'a>(shots: impl Iterator<Item = &'a Shot>) -> String {
    let names: Vec<_> = shots.map(|shot| format!("`{}`", shot.label)).collect();
    if names.len() > FEW { String::new() } else { format!(": {}", names.join(", ")) }
}

fn has_diverged(shot: &Shot) -> bool {
    shot.diverged_at_s.is_some()
}

fn diverged(facts: &Facts) -> Option<String> {
    let shot = first(facts).next().filter(|_| is_compared(facts))?;
    let scene = facts.scenes.iter().find(|scene| scene.id == shot.scene)?;
    let last = methods(facts).map(|shot| shot.time_s).reduce(f64::max)?;
    let lost = first(facts).filter(|shot| has_diverged(shot)).count();
    Some(format!(
        "With h = {} s, {lost} of {} methods {} within {last} s on a sheet of k/m = {} s⁻².",
        shot.step_s,
        first(facts).count(),
        verb(lost, "diverges", "diverge"),
        power(scene.stiffness_over_mass_per_s2)
    ))
}

/// Pictures at the earliest time whose share of the true fall passes a test.
fn with_share(facts: &Facts, test: impl Fn(f64) -> bool) -> Vec<&Shot> {
    let share = |shot: &&Shot| fall_share(facts, shot).is_some_and(&test);
    first(facts).filter(share).collect()
}

fn fallen(facts: &Facts) -> Option<String> {
    let time = first_time(facts);
    let on_time = with_share(facts, |share| share >= ON_TIME).len();
    is_compared(facts).then(|| {
        format!(
            "After {time} s, {} {} fallen at least {} % as far as the reference, {} less than \
             {} %, and {} in between.",
            count(on_time, "other method"),
            verb(on_time, "has", "have"),
            significant(100.0 * ON_TIME, 2),
            with_share(facts, |share| share < HANGING).len(),
            significant(100.0 * HANGING, 2),
            with_share(facts, |share| (HANGING..ON_TIME).contains(&share)).len()
        )
    })
}

fn failing(facts: &Facts) -> Option<String> {
    let failing = first(facts).filter(|shot| has_diverged(shot));
    let names = listed(failing.clone());
    (failing.count() > 0 && !names.is_empty()).then(|| format!("Methods that diverge{names}."))
}

fn hanging(facts: &Facts) -> Option<String> {
    let hanging = with_share(facts, |share| share < HANGING);
    let names = listed(hanging.iter().copied());
    (!hanging.is_empty() && !names.is_empty()).then(|| {
        format!(
            "Methods that fall less than {} % as far as the reference{names}.",
            significant(100.0 * HANGING, 2)
        )
    })
}

/// The method that falls farthest, if it falls too far.
fn farthest(facts: &Facts) -> Option<String> {
    let shares = methods(facts).filter_map(|shot| Some((shot, fall_share(facts, shot)?)));
    let (shot, share) = shares.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (share > 2.0).then(|| {
        format!(
            "A long fall does not mean success: at {} s, `{}` has fallen {} times as far as the \
             reference.",
            shot.time_s,
            shot.label,
            significant(share, 2)
        )
    })
}

#[cfg(test)]
mod tests;
