//! The words of the study `stability`: its question, and the findings from its numbers.

use super::facts::{Cell, EXACT, Facts, Limit, has_gained, labels, over_theory};
use crate::studies::names;
use drape_report::number::{power, setting, significant, trimmed};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which steps, stiffnesses and dampings does a method survive, \
     and does theory predict its longest stable step?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["order"];

/// The bisection of the longest stable step ends at this relative width.
const WIDTH: f64 = 0.05;
/// Share of `E_ref` by which solver and round-off may raise the energy, where a theorem says that
/// it does not rise.
const ROUND_OFF: f64 = 1e-6;
/// Largest number of variants that a sentence names.
const FEW: usize = 5;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion = [clean(facts), standstill(facts), pair(facts)];
    let mut conclusion: Vec<_> = conclusion.into_iter().flatten().collect();
    if conclusion.is_empty() {
        conclusion.push("The record holds no cell and no limit.".to_owned());
    }
    let observations =
        [theorem(facts), sheet(facts), shear(facts), shear_steps(facts), over_budget(facts)];
    Words {
        conclusion: conclusion.join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: [
            "The atlas shows one sheet of 8 × 8 particles, for at least 2 s and 200 steps.",
            "A verdict judges the energy, not the accuracy.",
            "Growth that is too slow to show within a run counts as stable.",
        ]
        .map(str::to_owned)
        .into(),
    }
}

/// Names, or their number if they are too many for a sentence.
fn named(labels: &[&str]) -> String {
    if labels.len() > FEW { format!("{} variants", labels.len()) } else { names::listed(labels) }
}

/// The cells of a label that have a verdict.
fn decided<'a>(facts: &'a Facts, label: &'a str) -> impl Iterator<Item = &'a Cell> + Clone {
    let cells = facts.cells.iter().filter(move |cell| cell.label == label);
    cells.filter(|cell| cell.verdict != Verdict::OverBudget)
}

/// Variants that never gain energy.
fn clean(facts: &Facts) -> Option<String> {
    let labels = labels(facts);
    let all = labels.iter().filter(|label| decided(facts, label).next().is_some());
    let all: Vec<&str> = all.copied().collect();
    let is_clean = |label: &&&str| !decided(facts, label).any(has_gained);
    let clean: Vec<&str> = all.iter().filter(is_clean).copied().collect();
    let count = format!("{} of {} variants", clean.len(), all.len());
    (!all.is_empty()).then(|| match clean.len() {
        0 => format!(
            "None of {} stays free of energy gain in all cells.",
            names::count(all.len(), "variant")
        ),
        1..=FEW => {
            format!("In all cells with a verdict, {count} never gained energy: {}.", named(&clean))
        }
        _ => format!("In all cells with a verdict, {count} never gained energy."),
    })
}

/// Variants that are stable only because they do not move.
fn standstill(facts: &Facts) -> Option<String> {
    let is_still = |label: &&str| {
        let of = |verdict| decided(facts, label).filter(|cell| cell.verdict == verdict).count();
        of(Verdict::Locked) > of(Verdict::Stable)
    };
    let still: Vec<&str> = labels(facts).into_iter().filter(is_still).collect();
    (!still.is_empty()).then(|| {
        format!(
            "Stability does not imply motion: with {}, more than half of the cells without energy \
             gain are locked.",
            named(&still)
        )
    })
}

/// How a measured limit of two particles compares with theory.
#[derive(Clone, Copy, PartialEq)]
enum Agreement {
    Agrees,
    /// The solver stops too early for theory, which has no limit here.
    Loose,
    Differs,
}

fn agreement(limit: &Limit) -> Agreement {
    let agrees = match (limit.theory_s, limit.measured_s) {
        (None, _) => limit.is_unlimited,
        // In theory no step is stable, but growth may be too slow to be visible.
        (Some(0.0), measured) => {
            measured.is_none_or(|h| h <= (1.0 + WIDTH) * limit.visible_s.unwrap_or_default())
        }
        (Some(theory), Some(h)) => !limit.is_unlimited && (h / theory - 1.0).abs() <= WIDTH,
        (Some(_), None) => false,
    };
    if agrees {
        Agreement::Agrees
    } else if limit.is_loose() && limit.theory_s.is_none() {
        Agreement::Loose
    } else {
        Agreement::Differs
    }
}

/// Agreement with theory on two particles, where it is exact.
fn pair(facts: &Facts) -> Option<String> {
    let all: Vec<_> = facts.limits.iter().filter(|limit| limit.is_pair()).map(agreement).collect();
    let count = |kind: Agreement| all.iter().filter(|found| **found == kind).count();
    let loose = match count(Agreement::Loose) {
        0 => String::new(),
        count => {
            format!("; in {count} the solver tolerance is too large for theory to apply")
        }
    };
    let off = match count(Agreement::Differs) {
        0 => String::new(),
        count => format!("; in {count} it contradicts theory"),
    };
    (!all.is_empty()).then(|| {
        format!(
            "On two particles, the longest stable step agrees with theory in {} of {} \
             cases{loose}{off}.",
            count(Agreement::Agrees),
            all.len()
        )
    })
}

/// Whether the energy theorem of IMEX Euler holds.
fn theorem(facts: &Facts) -> Option<String> {
    let greatest = facts.cells.iter().filter(|cell| cell.label == EXACT).map(|cell| cell.gain);
    let greatest = greatest.reduce(f64::max)?;
    let rise = if greatest > 0.0 {
        format!("rises by at most {} of E_ref", significant(greatest, 3))
    } else {
        "never rises".to_owned()
    };
    let verdict = if greatest <= ROUND_OFF { "holds" } else { "is broken" };
    Some(format!("The energy theorem of IMEX Euler, solved tightly, {verdict}: the energy {rise}."))
}

/// Measured limits on the sheet, where theory is a bound.
fn sheet(facts: &Facts) -> Option<String> {
    let sheets = facts.limits.iter().filter(|limit| !limit.is_pair());
    let ratios: Vec<_> = sheets.filter_map(over_theory).collect();
    let reached = ratios.iter().filter(|ratio| **ratio >= 1.0 - WIDTH).count();
    let least = ratios.iter().copied().reduce(f64::min)?;
    Some(format!(
        "On the sheet, {reached} of {} longest stable steps reach the step that theory guarantees; \
         the shortest is {} times as long.",
        ratios.len(),
        significant(least, 3)
    ))
}

/// Whether explicit shear is stable up to the bound of theory.
fn shear(facts: &Facts) -> Option<String> {
    let above =
        facts.shear.iter().filter(|scan| scan.first_failure.is_none_or(|f| f >= scan.bound));
    (!facts.shear.is_empty()).then(|| {
        format!(
            "With implicit tension, explicit shear is stable up to the bound of theory in {} of {} \
             scans of k_s/k.",
            above.count(),
            facts.shear.len()
        )
    })
}

/// How the least ratio that fails changes with the step.
fn shear_steps(facts: &Facts) -> Option<String> {
    let mut labels: Vec<&str> = facts.shear.iter().map(|scan| scan.label.as_str()).collect();
    labels.sort_unstable();
    labels.dedup();
    let line = |label: &&str| {
        let scans = facts.shear.iter().filter(|scan| scan.label == *label);
        let scans: Vec<_> =
            scans.filter_map(|scan| Some((scan.step_s, scan.first_failure?))).collect();
        let short = scans.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let long = scans.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let at =
            |(h, ratio): &(f64, f64)| format!("{} at h = {} s", trimmed(*ratio, 3), setting(*h));
        Some(format!("{label}, {} and {}", at(short), at(long)))
    };
    let lines: Vec<_> = labels.iter().filter_map(line).collect();
    let stiffness = power(facts.shear.first()?.stiffness_over_mass_per_s2);
    (!lines.is_empty()).then(|| {
        format!(
            "At k/m = {stiffness} s⁻², explicit shear fails from these k_s/k on: {}.",
            lines.join("; ")
        )
    })
}

/// How many cells have no verdict.
fn over_budget(facts: &Facts) -> Option<String> {
    let over = || facts.cells.iter().filter(|cell| cell.verdict == Verdict::OverBudget);
    let (count, skipped) = (over().count(), over().filter(|cell| cell.starts == 0).count());
    let skipped = match skipped {
        0 => String::new(),
        _ => {
            format!("; {skipped} of them did not run, since a longer step was over budget already")
        }
    };
    (count > 0).then(|| {
        format!(
            "{count} of {} cells {} over budget and {} no verdict{skipped}.",
            facts.cells.len(),
            names::verb(count, "is", "are"),
            names::verb(count, "has", "have")
        )
    })
}

#[cfg(test)]
mod tests;
