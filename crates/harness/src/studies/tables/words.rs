//! The words of the study `tables`: its question.

use super::facts::*;
use crate::studies::{gain, short};
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Do the paper's iteration counts (tables 2 and 3) come out, for which \
     reading of their illegible exponents and at which solver tolerance?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(&facts.rows))
}

/// What fits and what does not, in words, from the rows.
pub(super) fn findings(rows: &[Row]) -> Vec<String> {
    let mut findings = Vec::new();
    for row in rows.iter().filter(|row| row.assumed_reading) {
        let fits: Vec<_> = row
            .best_fit
            .iter()
            .map(|fit| {
                let name = if fit.variant == "plain" { "plain CG" } else { "updated CG" };
                let verdict = row
                    .cells
                    .iter()
                    .find(|c| c.variant == fit.variant && c.forcing_term == fit.forcing_term)
                    .map_or("", |cell| cell.verdict.name());
                format!(
                    "{name} comes to {} at ε = {} (ratio {}, {verdict})",
                    fit.cg_iterations,
                    fit.forcing_term,
                    short(fit.ratio)
                )
            })
            .collect();
        findings.push(format!(
            "Table {}, row {} ({} particles, k/m = {:e}, h = {} s): the paper prints {} iterations; {}.",
            row.table,
            row.row,
            row.particles,
            row.stiffness_over_mass_per_s2,
            row.step_s,
            row.paper.cg_iterations,
            fits.join("; ")
        ));
    }
    findings.extend(common_forcing_term(rows));
    let unstable: Vec<_> = rows
        .iter()
        .filter(|row| row.assumed_reading)
        .flat_map(|row| row.cells.iter().map(move |cell| (row, cell)))
        .filter(|(_, cell)| cell.verdict != Verdict::Stable)
        .map(|(row, cell)| {
            format!(
                "table {} row {} at ε = {} ({}, {}, {})",
                row.table,
                row.row,
                cell.forcing_term,
                cell.variant,
                cell.verdict,
                gain(cell.energy_gain_j)
            )
        })
        .collect();
    findings.extend(capped(rows));
    findings.extend(climbing(rows));
    findings.extend(readings_that_fit(rows));
    findings.push(if unstable.is_empty() {
        "No run of these rows rises above its start by more than the verdict allows.".to_owned()
    } else {
        format!(
            "A count that fits is no proof of a good solution; these runs rise above their start: {}.",
            unstable.join("; ")
        )
    });
    findings
}

/// Runs that the verdict calls stable although their energy climbs after it fell.
fn climbing(rows: &[Row]) -> Option<String> {
    let climbing: Vec<_> = rows
        .iter()
        .filter(|row| row.assumed_reading)
        .flat_map(|row| row.cells.iter().map(move |cell| (row, cell)))
        .filter(|(_, cell)| cell.verdict == Verdict::Stable && cell.energy_climb > 0.02)
        .map(|(row, cell)| {
            format!(
                "table {} row {} at ε = {} ({}, {} % of the released energy)",
                row.table,
                row.row,
                cell.forcing_term,
                cell.variant,
                short(100.0 * cell.energy_climb)
            )
        })
        .collect();
    let list = climbing.join("; ");
    (!climbing.is_empty())
        .then(|| format!("Called stable, but climbing again after they lost energy: {list}."))
}

/// Which reading of the exponent comes nearest to the paper, row by row.
fn readings_that_fit(rows: &[Row]) -> Option<String> {
    let nearest = |assumed: &Row, variant: &str| {
        rows.iter()
            .filter(|row| (row.table, row.row) == (assumed.table, assumed.row))
            .filter_map(|row| {
                let fit = row.best_fit.iter().find(|fit| fit.variant == variant)?;
                Some((row.stiffness_over_mass_per_s2, fit.ratio.max(1.0 / fit.ratio)))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let lines: Vec<_> = rows
        .iter()
        .filter(|row| row.assumed_reading)
        .filter_map(|row| {
            let (plain, updated) = (nearest(row, "plain")?, nearest(row, "updated-paper")?);
            Some(format!(
                "table {} row {}: {:e} for plain, {:e} for updated",
                row.table, row.row, plain.0, updated.0
            ))
        })
        .collect();
    let several = rows.iter().any(|row| !row.assumed_reading);
    several.then(|| {
        format!(
            "The reading of k/m whose best count comes nearest to the paper's: {}. The counts alone do not \
             decide the exponents; 4 and 6 are the readings used.",
            lines.join("; ")
        )
    })
}

/// Counts that the cap on updates cut short.
fn capped(rows: &[Row]) -> Option<String> {
    let cut: Vec<_> = rows
        .iter()
        .filter(|row| row.assumed_reading)
        .flat_map(|row| row.cells.iter().map(move |cell| (row, cell)))
        .filter(|(_, cell)| cell.unconverged_steps > 0)
        .map(|(row, cell)| {
            format!(
                "table {} row {} at ε = {} ({}, steps: {})",
                row.table, row.row, cell.forcing_term, cell.variant, cell.unconverged_steps
            )
        })
        .collect();
    let list = cut.join("; ");
    (!cut.is_empty()).then(|| format!("Solves that ended before their tolerance: {list}."))
}

/// The one ε that fits all rows best, and how badly.
fn common_forcing_term(rows: &[Row]) -> Option<String> {
    let assumed: Vec<_> = rows.iter().filter(|row| row.assumed_reading).collect();
    let worst = |variant: &str, term: f64| -> Option<f64> {
        let mut worst: f64 = 1.0;
        for row in &assumed {
            let cell = row.cells.iter().find(|c| c.variant == variant && c.forcing_term == term)?;
            let ratio = cell.cg_iterations.max(1) as f64 / row.paper.cg_iterations as f64;
            worst = worst.max(ratio).max(1.0 / ratio);
        }
        Some(worst)
    };
    let best = |variant: &str| {
        FORCING_TERMS
            .into_iter()
            .filter_map(|term| worst(variant, term).map(|worst| (term, worst)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let (plain, updated) = (best("plain")?, best("updated-paper")?);
    let verdict = if plain.1.min(updated.1) > COMMON_FIT {
        "No single ε fits all rows"
    } else {
        "A single ε fits all rows that were run"
    };
    Some(format!(
        "{verdict}: the best common choice is ε = {} for plain CG (off by a factor of up to {}) and \
         ε = {} for updated CG (up to {}).",
        plain.0,
        short(plain.1),
        updated.0,
        short(updated.1)
    ))
}
