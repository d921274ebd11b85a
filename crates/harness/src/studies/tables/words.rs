//! The words of the study `tables`: its question, and the findings from its numbers.

use super::facts::*;
use crate::studies::names::{count, verb};
use drape_report::number::{percent, significant};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "At which solver tolerance do the paper's iteration counts come \
     out, and for which reading of its illegible exponents?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let rows = &facts.rows;
    let conclusion = [common(rows), row_by_row(rows), undecided(rows)];
    let mut conclusion: Vec<_> = conclusion.into_iter().flatten().collect();
    if conclusion.is_empty() {
        conclusion.push("The record holds no row of the paper's tables.".to_owned());
    }
    let observations =
        [by_variant(rows), readings(rows), gaining(rows), climbing(rows), capped(rows)];
    Words {
        conclusion: conclusion.join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats(rows),
    }
}

/// Whether a single ε fits all rows.
fn common(rows: &[Row]) -> Option<String> {
    let best = |variant| best_common(rows, variant);
    let (plain, updated) = (best(PLAIN)?, best(UPDATED_PAPER)?);
    let (term, factor) = if plain.1 < updated.1 { plain } else { updated };
    Some(if factor > COMMON_FIT {
        format!(
            "No single ε repeats all of the paper's counts: the best common choice, ε = {term}, is \
             off by a factor of up to {}.",
            significant(factor, 3)
        )
    } else {
        format!(
            "A single ε, {term}, repeats all of the paper's counts that were run within a factor \
             of {}.",
            significant(factor, 3)
        )
    })
}

/// In how many rows some ε fits.
fn row_by_row(rows: &[Row]) -> Option<String> {
    let fitting = assumed(rows).filter(|row| row.best_fit.iter().any(|fit| fits(row, fit))).count();
    let all = assumed(rows).count();
    (all > 0).then(|| {
        format!(
            "Row by row, a stable run repeats the count within {} in {fitting} of {all} rows.",
            percent(COMMON_FIT - 1.0, 2)
        )
    })
}

/// Number of cases in which drape's reading is the nearest, and number of all cases.
fn decided(rows: &[Row]) -> (usize, usize) {
    let pairs = assumed(rows).flat_map(|row| [PLAIN, UPDATED_PAPER].map(|variant| (row, variant)));
    let nearest =
        pairs.filter_map(|(row, variant)| Some((row, nearest_reading(rows, row, variant)?)));
    let taken = nearest.clone().filter(|(row, k)| row.stiffness_over_mass_per_s2 == *k).count();
    (taken, nearest.count())
}

fn has_neighbours(rows: &[Row]) -> bool {
    rows.iter().any(|row| !row.assumed_reading)
}

fn undecided(rows: &[Row]) -> Option<String> {
    let (taken, all) = decided(rows);
    has_neighbours(rows).then(|| {
        let exponents = "the illegible exponents are 4 and 6, as drape assumes";
        if taken == all {
            format!("The counts alone suggest that {exponents}.")
        } else {
            format!("The counts alone do not decide whether {exponents}.")
        }
    })
}

fn readings(rows: &[Row]) -> Option<String> {
    let (taken, all) = decided(rows);
    has_neighbours(rows).then(|| {
        format!(
            "The exponents 4 and 6 come nearest to the paper's counts in {taken} of {all} cases."
        )
    })
}

fn by_variant(rows: &[Row]) -> Option<String> {
    let fitting = |variant: &str| {
        let fits = |row: &&Row| row.best_fit.iter().any(|f| f.variant == variant && fits(row, f));
        assumed(rows).filter(fits).count()
    };
    (assumed(rows).count() > 0).then(|| {
        format!(
            "At its best ε, plain CG comes within {} of the paper's count in {}, and updated CG as \
             printed in {}.",
            percent(COMMON_FIT - 1.0, 2),
            count(fitting(PLAIN), "row"),
            fitting(UPDATED_PAPER)
        )
    })
}

fn cells(rows: &[Row]) -> impl Iterator<Item = &Cell> + Clone {
    assumed(rows).flat_map(|row| &row.cells)
}

/// Number of runs that gain energy.
fn gaining(rows: &[Row]) -> Option<String> {
    let all = cells(rows).count();
    let gaining = cells(rows).filter(|cell| cell.verdict != Verdict::Stable);
    let printed = gaining.clone().filter(|cell| cell.variant == UPDATED_PAPER).count();
    let number = gaining.count();
    (all > 0).then(|| match number {
        0 => "No run of these rows gains energy.".to_owned(),
        _ => format!(
            "A fitting count does not prove a good solution: {number} of {all} runs {} energy, {} \
             of them with updated CG as printed.",
            verb(number, "gains", "gain"),
            if printed == number { "all".to_owned() } else { printed.to_string() }
        ),
    })
}

/// Stable runs whose energy climbs again after a fall.
fn climbing(rows: &[Row]) -> Option<String> {
    let climbing = cells(rows).filter(|cell| climbs(cell));
    let most = climbing.clone().map(|cell| cell.energy_climb).reduce(f64::max)?;
    let number = climbing.count();
    Some(format!(
        "{} called stable {} energy and {} it again, by up to {} of the released energy.",
        count(number, "run"),
        verb(number, "loses", "lose"),
        verb(number, "gains", "gain"),
        percent(most, 2)
    ))
}

/// Runs with solves that stopped before their tolerance.
fn capped(rows: &[Row]) -> Option<String> {
    let cut = cells(rows).filter(|cell| cell.unconverged_steps > 0);
    let most = cut.clone().map(|cell| cell.unconverged_steps).max()?;
    let cut = cut.count();
    Some(format!(
        "{} {} solves that stop before their tolerance, in up to {most} steps of a run.",
        count(cut, "run"),
        verb(cut, "has", "have")
    ))
}

fn caveats(rows: &[Row]) -> Vec<String> {
    let mut caveats = vec![
        "The paper states no sizes, masses and contact details; the scenes assume them.".to_owned(),
        "Updates per step are capped here, and not in the paper.".to_owned(),
        "A verdict compares the energy with its start only.".to_owned(),
    ];
    let terms = |variant: &str| {
        let terms = cells(rows).filter(|cell| cell.variant == variant);
        let terms: std::collections::BTreeSet<_> =
            terms.map(|c| c.forcing_term.to_bits()).collect();
        terms.len()
    };
    let (robust, plain) = (terms(UPDATED_ROBUST), terms(PLAIN));
    if robust < plain {
        caveats.push(format!("The safeguarded form ran at {robust} of {plain} tolerances."));
    }
    caveats
}

#[cfg(test)]
mod tests;
