//! The words of the study `momentum`: its question, and the findings from its numbers.

use super::facts::*;
use crate::studies::names::{count, verb};
use drape_report::number::{percent, power, significant, trimmed};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "Which methods keep the momentum and spin of a free cloth, and how much do the others lose?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["order"];

/// A run has lost its spin if it keeps less than this share.
const LOST: f64 = 0.01;
/// Largest difference from an exact law that round-off and a tight solve may cause.
const LAWFUL: f64 = 1e-8;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let mut conclusion: Vec<_> = [stated(facts), spin(facts)].into_iter().flatten().collect();
    if conclusion.is_empty() {
        conclusion.push("The record holds no method that states what it keeps.".to_owned());
    }
    let observations =
        [unstated(facts), correction(facts), gains(facts), laws(facts), unstable(facts)];
    let caveats = [prototype(facts), shorter(facts)];
    Words {
        conclusion: conclusion.join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: std::iter::once(
            "Runs last one second, without pins and without damping.".to_owned(),
        )
        .chain(caveats.into_iter().flatten())
        .collect(),
    }
}

/// Whether a row's method states that it keeps a quantity, and the drift of that quantity.
type Pick = fn(&Row) -> (bool, Option<f64>);

const LINEAR: Pick = |row| (row.states_momentum, row.momentum_drift);
const ANGULAR: Pick = |row| (row.states_angular_momentum, row.angular_momentum_drift);

/// The labels of the variants that state that they keep a quantity, or do not (`stating`). Each has
/// its greatest drift and the scene of that drift.
fn drifts(facts: &Facts, pick: Pick, stating: bool) -> Vec<(&str, f64, &str)> {
    let mut worst: Vec<(&str, f64, &str)> = Vec::new();
    for row in &facts.rows {
        let (states, Some(drift)) = pick(row) else { continue };
        if states != stating {
            continue;
        }
        match worst.iter_mut().find(|(label, _, _)| *label == row.label) {
            Some(entry) if entry.1 < drift => (entry.1, entry.2) = (drift, &row.scene),
            Some(_) => {}
            None => worst.push((&row.label, drift, &row.scene)),
        }
    }
    worst.sort_by(|a, b| b.1.total_cmp(&a.1));
    worst
}

/// Whether methods keep the quantities that they state.
fn stated(facts: &Facts) -> Option<String> {
    let mut stated = drifts(facts, LINEAR, true);
    stated.extend(drifts(facts, ANGULAR, true));
    let all = stated.len();
    let broken: Vec<_> = stated.iter().filter(|(_, drift, _)| *drift > KEPT).collect();
    let kept = power(KEPT);
    let worst = broken.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    Some(match worst {
        None if all == 0 => return None,
        None => format!(
            "All {all} claims that a variant keeps linear or angular momentum hold within {kept} \
             in stable runs."
        ),
        Some((label, drift, scene)) => format!(
            "{} of {all} claims that a variant keeps linear or angular momentum {} broken; {label} \
             drifts by {} ({scene}).",
            broken.len(),
            verb(broken.len(), "is", "are"),
            significant(*drift, 3)
        ),
    })
}

/// How many methods keep the spin of the stiffest spinning sheet, and how many lose it.
fn spin(facts: &Facts) -> Option<String> {
    let scenes = facts.scenes.iter().filter(|scene| scene.is_spinning_sheet());
    let scene = scenes
        .max_by(|a, b| a.stiffness_over_mass_per_s2.total_cmp(&b.stiffness_over_mass_per_s2))?;
    let rows = facts.rows.iter().filter(|row| row.scene == scene.id);
    let spins: Vec<f64> = rows.filter_map(|row| row.final_spin).collect();
    let number = |test: fn(f64) -> bool| spins.iter().filter(|spin| test(**spin)).count();
    let lost = number(|spin| spin < LOST);
    (!spins.is_empty()).then(|| {
        format!(
            "At k/m = {} s⁻², {} of {} stable variants keep the spin of a sheet within {} % for \
             one second, and {lost} {} less than {} % of it.",
            power(scene.stiffness_over_mass_per_s2),
            number(|spin| (spin - 1.0).abs() <= LEAST_CHANGE),
            spins.len(),
            trimmed(100.0 * LEAST_CHANGE, 2),
            verb(lost, "keeps", "keep"),
            trimmed(100.0 * LOST, 2)
        )
    })
}

/// The drift of methods that do not state to keep linear momentum.
fn unstated(facts: &Facts) -> Option<String> {
    let drifts = drifts(facts, LINEAR, false);
    let moved = drifts.iter().filter(|(_, drift, _)| *drift > KEPT).count();
    let (label, drift, scene) = drifts.first().filter(|(_, drift, _)| *drift > KEPT)?;
    Some(format!(
        "Of {} that {} not claim to keep linear momentum, {moved} {} it drift, most {label} by {} \
         ({scene}).",
        count(drifts.len(), "variant"),
        verb(drifts.len(), "does", "do"),
        verb(moved, "lets", "let"),
        significant(*drift, 3)
    ))
}

/// The spin that Desbrun's correction of torques keeps.
fn correction(facts: &Facts) -> Option<String> {
    let spin = |label: &str| {
        let sheets = facts.scenes.iter().filter(|scene| scene.is_spinning_sheet());
        let softest = sheets
            .min_by(|a, b| a.stiffness_over_mass_per_s2.total_cmp(&b.stiffness_over_mass_per_s2))?;
        facts.rows.iter().find(|row| row.scene == softest.id && row.label == label)?.final_spin
    };
    let [none, literal, consistent] = CORRECTIONS.map(spin);
    Some(format!(
        "On the softer spinning sheet, Desbrun's method keeps {} of the spin without correction, \
         {} with the printed one and {} with a consistent one.",
        percent(none?, 2),
        percent(literal?, 2),
        percent(consistent?, 2)
    ))
}

/// How many stable runs gain energy, and the largest gain.
fn gains(facts: &Facts) -> Option<String> {
    let stable = facts.rows.iter().filter_map(|row| row.energy_gain);
    let all = stable.clone().count();
    let gaining = stable.filter(|gain| *gain > LEAST_CHANGE);
    let most = gaining.clone().reduce(f64::max)?;
    let gains = gaining.count();
    Some(format!(
        "Keeping the spin does not keep the energy: {gains} of {all} stable runs {} more than {} % \
         of the energy of the spin, at most {} %.",
        verb(gains, "gains", "gain"),
        trimmed(100.0 * LEAST_CHANGE, 2),
        significant(100.0 * most, 2)
    ))
}

/// Agreement of the pair with the exact laws.
fn laws(facts: &Facts) -> Option<String> {
    let rows = facts.rows.iter();
    let differences: Vec<f64> =
        rows.filter_map(|row| Some((row.final_spin? - row.law?).abs())).collect();
    let worst = differences.iter().copied().reduce(f64::max)?;
    Some(format!(
        "Two particles meet the exact law of their method in {} of {} runs; the greatest \
         difference is {}.",
        differences.iter().filter(|difference| **difference < LAWFUL).count(),
        differences.len(),
        significant(worst, 2)
    ))
}

fn unstable(facts: &Facts) -> Option<String> {
    let failed = facts.rows.iter().filter(|row| row.verdict == Verdict::Unstable).count();
    (failed > 0).then(|| {
        format!(
            "{failed} of {} runs diverged or gained more energy than there was in the spin.",
            facts.rows.len()
        )
    })
}

/// Agreement of Desbrun's correction with an independent prototype.
fn prototype(facts: &Facts) -> Option<String> {
    let compared: Vec<_> = facts.rows.iter().filter_map(prototype_of).collect();
    let confirmed = compared.iter().filter(|(_, is_confirmed)| *is_confirmed).count();
    (!compared.is_empty()).then(|| {
        format!(
            "An independent prototype confirms {confirmed} of {} values of Desbrun's method; its \
             choice of lever arms is unknown.",
            compared.len()
        )
    })
}

/// Number of variants with a shorter step than the others.
fn shorter(facts: &Facts) -> Option<String> {
    let is_shorter = |row: &&Row| {
        facts.scenes.iter().any(|scene| scene.id == row.scene && row.step_s < scene.step_s)
    };
    let labels = facts.rows.iter().filter(is_shorter).map(|row| &row.label);
    let shorter = labels.collect::<std::collections::BTreeSet<_>>().len();
    (shorter > 0).then(|| {
        format!(
            "{} {} shorter steps than the others.",
            count(shorter, "explicit variant"),
            verb(shorter, "takes", "take")
        )
    })
}

#[cfg(test)]
mod tests;
