//! The words of the study `scaling`: its question.

use super::facts::*;
use crate::studies::short;
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "How do the iterations and the time of a step grow with the number of particles, from a hundred to a \
     million?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["work-precision"];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

/// What the numbers say.
pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    for series in [FIXED_QUOTIENT, FIXED_MATERIAL] {
        for label in ["imex-euler", "imex-updated", "baraff-witkin"] {
            let cells: Vec<_> = facts
                .cells
                .iter()
                .filter(|cell| cell.series == series && cell.label == label)
                .collect();
            let Some((first, last)) = cells.first().zip(cells.last()).filter(|_| cells.len() > 1)
            else {
                continue;
            };
            let growth = if first.cg_per_step > 0.0 && last.cg_per_step > 0.0 {
                let sizes = libm::log(last.particles as f64 / first.particles as f64);
                let power = libm::log(last.cg_per_step / first.cg_per_step) / sizes;
                format!(", on average as n to the power {power:.2}")
            } else {
                String::new()
            };
            let said: Vec<_> = cells
                .iter()
                .map(|cell| format!("{} (n = {})", short(cell.cg_per_step), cell.particles))
                .collect();
            findings.push(format!(
                "{label}, {series}: CG iterations a step {}{growth}.",
                said.join(", ")
            ));
        }
    }
    let failed: Vec<_> = facts
        .cells
        .iter()
        .filter(|cell| cell.verdict != Verdict::Completed || cell.unconverged_steps > 0)
        .map(|cell| {
            let Cell { label, series, particles, verdict, unconverged_steps, .. } = cell;
            format!("{label}, {series}, n = {particles} ({verdict}, {unconverged_steps} steps not converged)")
        })
        .collect();
    findings.push(if failed.is_empty() {
        "Every run is stable and every solve meets its tolerance over the few steps that are run."
            .to_owned()
    } else {
        format!("Not every solve meets its tolerance: {}.", failed.join("; "))
    });
    findings
}
