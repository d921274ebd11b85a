//! The words of the study `order`: its question, and the findings from its numbers.

use super::facts::*;
use crate::studies::names::{count, listed, verb};
use drape_report::Words;
use drape_report::number::{power, significant};

/// The question that the study answers.
pub(super) const QUESTION: &str = "Does the error of every method fall with its theoretical order, \
     and does that order remain on stiff springs?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// Largest number of variants that a sentence names.
const FEW: usize = 3;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let mut conclusion: Vec<_> = [acceptance(facts), stiff(facts)].into_iter().flatten().collect();
    if conclusion.is_empty() {
        conclusion.push("The record holds no row with a claimed order.".to_owned());
    }
    let mut observations: Vec<_> = unresolved(facts).filter_map(|s| outcomes(facts, s)).collect();
    observations.extend([unclaimed(facts), constants(facts)].into_iter().flatten());
    Words { conclusion: conclusion.join(" "), observations, caveats: caveats(facts) }
}

fn rows<'a>(facts: &'a Facts, scene: &'a Scene) -> impl Iterator<Item = &'a Row> + Clone {
    facts.rows.iter().filter(move |row| row.scene == scene.id)
}

fn unresolved(facts: &Facts) -> impl Iterator<Item = &Scene> {
    facts.scenes.iter().filter(|scene| !scene.resolved)
}

/// How many variants show the order that they claim where theory holds.
fn acceptance(facts: &Facts) -> Option<String> {
    let claiming: Vec<_> = facts.rows.iter().filter(|row| row.accepted.is_some()).collect();
    let failing = claiming.iter().filter(|row| row.accepted == Some(false));
    let mut names: Vec<&str> = failing.clone().map(|row| row.label.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let but = match names.len() {
        0 => String::new(),
        1 => format!(" The exception is {}.", listed(&names)),
        2..=FEW => format!(" The exceptions are {}.", listed(&names)),
        others => format!(" The exceptions are {others} variants."),
    };
    let all = claiming.len();
    let shown = all - failing.count();
    (all > 0).then(|| {
        format!(
            "Where steps resolve every oscillation, variants show their claimed order within \
             {ACCEPTED} in {shown} of {}.{but}",
            count(all, "case")
        )
    })
}

/// Number of variants on a scene that show the order that they claim, and number that claim one.
fn kept(facts: &Facts, scene: &Scene) -> (usize, usize) {
    let claiming = rows(facts, scene).filter(|row| row.theory.is_some());
    (claiming.clone().filter(|row| outcome(row) == Outcome::Kept).count(), claiming.count())
}

/// The variants that keep their order on stiff springs.
fn stiff(facts: &Facts) -> Option<String> {
    let line = |scene: &Scene| {
        let (kept, all) = kept(facts, scene);
        let k = power(scene.stiffness_over_mass_per_s2);
        (all > 0).then(|| format!("{kept} of {all} at k/m = {k} s⁻²"))
    };
    let lines: Vec<_> = unresolved(facts).filter_map(line).collect();
    (!lines.is_empty()).then(|| {
        format!("On stiff springs, the claimed order remains with {}.", lines.join(" and "))
    })
}

/// Numbers of the outcomes of all variants on a stiff scene.
fn outcomes(facts: &Facts, scene: &Scene) -> Option<String> {
    let parts: Vec<_> = Outcome::ALL
        .into_iter()
        .filter_map(|kind| {
            let count = rows(facts, scene).filter(|row| outcome(row) == kind).count();
            (count > 0).then(|| format!("{count} {}", kind.name()))
        })
        .collect();
    let runs = &rows(facts, scene).next()?.runs;
    let finest = runs.last()?.step_s * scene.greatest_frequency_per_s;
    Some(format!(
        "At k/m = {} s⁻² (h ω_max down to {}): {}.",
        power(scene.stiffness_over_mass_per_s2),
        significant(finest, 2),
        parts.join(", ")
    ))
}

/// The error of variants that claim no order.
fn unclaimed(facts: &Facts) -> Option<String> {
    let resolved = facts.scenes.iter().filter(|scene| scene.resolved);
    let rows = resolved.flat_map(|scene| rows(facts, scene)).filter(|row| row.theory.is_none());
    let labels: std::collections::BTreeSet<_> = rows.clone().map(|row| &row.label).collect();
    let claiming = labels.len();
    let error = rows.filter_map(finest_error).reduce(f64::max)?;
    Some(format!(
        "{} that {} no order {} another equation; {} error at the finest step reaches {} % of the \
         motion.",
        count(claiming, "variant"),
        verb(claiming, "claims", "claim"),
        verb(claiming, "solves", "solve"),
        verb(claiming, "its", "their"),
        significant(100.0 * error, 2)
    ))
}

/// The range of the error constants of one order.
fn constants(facts: &Facts) -> Option<String> {
    let scene = facts.scenes.iter().find(|scene| scene.resolved)?;
    let spread = |theory: u32| {
        let of = rows(facts, scene).filter(|row| row.theory == Some(theory));
        let found: Vec<f64> = of.filter_map(|row| row.error_constant).collect();
        let least = found.iter().copied().reduce(f64::min).filter(|_| found.len() > 1)?;
        Some((found.iter().copied().reduce(f64::max)? / least, theory))
    };
    let (factor, theory) = (1..=3).filter_map(spread).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(format!(
        "Error constants of methods of one order differ by a factor of up to {} (order {theory}).",
        significant(factor, 2)
    ))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let error = facts.scenes.iter().map(|scene| scene.reference_error_m).reduce(f64::max);
    let span = facts.scenes.iter().map(|scene| scene.span_s).reduce(f64::max);
    let mut caveats: Vec<String> = Vec::new();
    caveats.extend(span.map(|span| format!("The sheet is small and falls for {span} s only.")));
    caveats.push("Solver tolerances are so tight that residuals do not show.".to_owned());
    caveats.extend(
        error.map(|e| format!("The references are off by at most {} m.", significant(e, 2))),
    );
    caveats
}

#[cfg(test)]
mod tests;
