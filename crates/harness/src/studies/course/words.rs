//! The words of the study `course`: its question, and the findings from its numbers.

use super::facts::*;
pub(super) use super::lessons::lesson;
use crate::studies::names;
use drape_report::number::{power, significant};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "What can each method of the course do that the one before it \
     could not?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &[];

/// Largest number of methods that a sentence names.
const FEW: usize = 5;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion = [stable(facts), moving(facts), cheapest(facts)];
    let mut conclusion: Vec<_> = conclusion.into_iter().flatten().collect();
    if conclusion.is_empty() {
        conclusion.push("The record holds no run.".to_owned());
    }
    let mut observations: Vec<_> = [unstable(facts), locked(facts)].into_iter().flatten().collect();
    observations.extend(facts.scenes.iter().filter_map(|scene| work(facts, scene)));
    Words { conclusion: conclusion.join(" "), observations, caveats: caveats(facts) }
}

/// The methods whose runs all pass a test.
fn methods(facts: &Facts, test: impl Fn(&Run) -> bool) -> Vec<&str> {
    let runs = facts.lessons.iter().filter(|lesson| !lesson.runs.is_empty());
    let chosen = runs.filter(|lesson| lesson.runs.iter().all(&test));
    chosen.map(|lesson| lesson.id.as_str()).collect()
}

/// The names as `: a, b`; empty without names, or with too many for a sentence.
fn listed(names: &[&str]) -> String {
    if names.is_empty() || names.len() > FEW {
        String::new()
    } else {
        format!(": {}", names.join(", "))
    }
}

fn is_stable(run: &Run) -> bool {
    run.verdict == Verdict::Stable
}

fn stable(facts: &Facts) -> Option<String> {
    let step = facts.scenes.first()?.step_s;
    let stable = methods(facts, is_stable).len();
    let k: Vec<_> =
        facts.scenes.iter().map(|scene| power(scene.stiffness_over_mass_per_s2)).collect();
    Some(format!(
        "With steps of {step} s, {stable} of {} methods are stable at k/m = {} s⁻².",
        facts.lessons.len(),
        k.join(" and ")
    ))
}

fn moving(facts: &Facts) -> Option<String> {
    let moving = methods(facts, moves);
    facts.scenes.first()?;
    Some(match moving.len() {
        0 => format!("None keeps at least {} % of the motion.", significant(100.0 * MOVES, 2)),
        count => format!(
            "Of these, {count} {} at least {} % of the motion{}.",
            names::verb(count, "keeps", "keep"),
            significant(100.0 * MOVES, 2),
            listed(&moving)
        ),
    })
}

/// The method with the least work that keeps most of the motion on the stiffest sheet.
fn cheapest(facts: &Facts) -> Option<String> {
    let stiffest = facts
        .scenes
        .iter()
        .max_by(|a, b| a.stiffness_over_mass_per_s2.total_cmp(&b.stiffness_over_mass_per_s2))?;
    let (least, _) = *by_work(facts, stiffest).first()?;
    Some(format!("On the stiffest sheet, {} keeps this much with the least work.", least.id))
}

fn unstable(facts: &Facts) -> Option<String> {
    let failing: Vec<&str> = facts
        .lessons
        .iter()
        .filter(|lesson| !lesson.runs.iter().all(is_stable))
        .map(|lesson| lesson.id.as_str())
        .collect();
    (!failing.is_empty()).then(|| {
        format!(
            "{} {} not stable at every stiffness{}.",
            names::count(failing.len(), "method"),
            names::verb(failing.len(), "is", "are"),
            listed(&failing)
        )
    })
}

/// The stable method that keeps the least motion, if it loses some.
fn locked(facts: &Facts) -> Option<String> {
    let runs = facts.lessons.iter().flat_map(|lesson| lesson.runs.iter().map(move |r| (lesson, r)));
    let lossy = runs.filter_map(|(lesson, run)| Some((lesson, run.retained_motion?)));
    let (worst, motion) = lossy.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (motion < MOVES).then(|| {
        format!(
            "Stability does not imply motion: {} keeps only {} % of the motion in its worst run.",
            worst.id,
            significant(100.0 * motion, 2)
        )
    })
}

/// The least and the greatest work of methods that keep most of the motion on a sheet.
fn work(facts: &Facts, scene: &Scene) -> Option<String> {
    let moving = by_work(facts, scene);
    let ((least, cheap), (most, dear)) = (moving.first()?, moving.last()?);
    Some(format!(
        "At k/m = {} s⁻², methods that move take from {} ms ({}) to {} ms ({}) of modelled time.",
        power(scene.stiffness_over_mass_per_s2),
        significant(1e3 * cheap.modelled_s, 3),
        least.id,
        significant(1e3 * dear.modelled_s, 3),
        most.id
    ))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let divides = |lesson: &&Lesson| lesson.method.contains("step=bound");
    let divided: Vec<_> =
        facts.lessons.iter().filter(divides).map(|lesson| lesson.id.as_str()).collect();
    let divided = (!divided.is_empty()).then(|| {
        format!(
            "Only the steps of {} are divided until they are stable. Stages and substeps of others \
             are part of a step.",
            divided.join(" and ")
        )
    });
    let error = facts.scenes.iter().map(|scene| scene.reference_error_m).reduce(f64::max);
    let error = error.map(|error| {
        format!("The true motion is known to {} m in the first second.", significant(error, 2))
    });
    let fixed = [
        "One sheet runs with one damping; another may rank the methods differently.".to_owned(),
        "Times are counted work at measured prices, not measured times.".to_owned(),
    ];
    fixed.into_iter().chain(divided).chain(error).collect()
}

#[cfg(test)]
mod tests;
