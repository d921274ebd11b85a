//! The words of the study `cg-vs-stiffness`: its question.

use super::facts::*;
use crate::studies::{gain, short};
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "How do the CG iterations of plain and of updated IMEX Euler grow with the \
     stiffness, the step size and the tolerance, and does the cloth still move?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["tables"];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

/// What the numbers say.
pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    let line = |particles: usize, variant: &str, preconditioner: &str, start: &str| {
        let mut cells: Vec<_> = facts
            .cells
            .iter()
            .filter(|c| {
                c.series == "stiffness"
                    && c.material == "fixed-k-over-m"
                    && c.particles == particles
                    && c.variant == variant
                    && c.preconditioner == preconditioner
                    && c.start == start
            })
            .collect();
        cells.sort_by(|a, b| a.stiffness_over_mass_per_s2.total_cmp(&b.stiffness_over_mass_per_s2));
        cells
    };
    for particles in [400, 2704] {
        let describe = |preconditioner, start| {
            let cells = line(particles, "plain", preconditioner, start);
            let (first, last) = (cells.first()?, cells.last()?);
            let monotone = cells.windows(2).all(|pair| pair[0].cg_per_step <= pair[1].cg_per_step);
            let peak = cells.iter().max_by(|a, b| a.cg_per_step.total_cmp(&b.cg_per_step))?;
            Some(format!(
                "{} to {} a step {}",
                short(first.cg_per_step),
                short(last.cg_per_step),
                if monotone {
                    "(growing throughout)".to_owned()
                } else {
                    format!(
                        "(with a peak of {} at k/m = {:e})",
                        short(peak.cg_per_step),
                        peak.stiffness_over_mass_per_s2
                    )
                }
            ))
        };
        let Some(ic) = describe("ic0", "extrapolated") else { continue };
        let ic_last = describe("ic0", "last").unwrap_or_default();
        let none = describe("none", "extrapolated").unwrap_or_default();
        findings.push(format!(
            "{particles} particles, plain CG, iterations a step for k/m from 1e2 to 1e8: IC(0) with the extrapolated start takes \
             {ic}; started at v_n {ic_last}; without preconditioner {none}."
        ));
    }
    findings.extend(loose_start_finding(facts));
    for (variant, name) in [("updated-paper", "as printed"), ("updated-robust", "robust")] {
        for particles in [400, 2704] {
            let cells = line(
                particles,
                variant,
                "ic0",
                if variant == "updated-robust" { "best" } else { "extrapolated" },
            );
            if cells.is_empty() {
                continue;
            }
            let failed: Vec<_> = cells
                .iter()
                .filter(|cell| cell.verdict != Verdict::Stable)
                .map(|cell| {
                    format!(
                        "{:e} ({}, {})",
                        cell.stiffness_over_mass_per_s2,
                        cell.verdict,
                        gain(cell.energy_gain_j)
                    )
                })
                .collect();
            findings.push(if failed.is_empty() {
                let last = cells.last().map_or(0.0, |cell| cell.stiffness_over_mass_per_s2);
                let newton: u64 = cells.iter().map(|cell| cell.newton_iterations).sum();
                let by = if newton > 0 { format!(", with {newton} Newton iterations in all") } else { String::new() };
                format!(
                    "Updated CG, {name}, {particles} particles: stable over the second at every stiffness \
                     that was run, up to k/m = {last:e}{by}."
                )
            } else {
                format!(
                    "Updated CG, {name}, {particles} particles: gains energy at k/m = {}.",
                    failed.join(", ")
                )
            });
        }
    }
    findings.extend(fall_finding(facts));
    findings.extend(step_finding(facts));
    findings
}

/// Plain CG that gains energy, and how many of its steps passed the test without an iteration.
fn loose_start_finding(facts: &Facts) -> Option<String> {
    let plain = || facts.cells.iter().filter(|c| c.series == "stiffness" && c.variant == "plain");
    let mut gaining: Vec<_> = plain().filter(|c| c.verdict != Verdict::Stable).collect();
    gaining.sort_by(|a, b| b.energy_gain_j.total_cmp(&a.energy_gain_j));
    let extrapolated = gaining.iter().filter(|c| c.start == "extrapolated").count();
    let most = gaining.first()?;
    Some(format!(
        "{} of {} runs of plain CG at ε = {FORCING_TERM} rise above their start, {extrapolated} of them with \
         the extrapolated start; the greatest rise, at n = {}, k/m = {:e}, {}, is {}, where {} of {} steps \
         pass the test without an iteration and are pure extrapolation.",
        gaining.len(),
        plain().count(),
        most.particles,
        most.stiffness_over_mass_per_s2,
        most.preconditioner,
        gain(most.energy_gain_j),
        most.idle_steps,
        most.steps
    ))
}

fn fall_finding(facts: &Facts) -> Option<String> {
    let at = |label: &str| {
        facts.motion.iter().find(|m| m.label == label && m.stiffness_over_mass_per_s2 == 1e6)
    };
    let (plain, updated) = (at("imex-euler")?, at("imex-updated")?);
    let reference = at("backward-euler")?;
    let tension = at("imex-updated, tension only").map_or_else(String::new, |m| {
        format!(
            " With shear left out of the matrix the energy of updated CG rises by {} ({}).",
            gain(m.energy_gain_j),
            m.verdict
        )
    });
    let share = plain.fall_m / reference.fall_m;
    let still = if share < 0.5 { "all but stands still" } else { "moves" };
    Some(format!(
        "Few iterations are not always a good sign: at k/m = 1e6 and h = 0.01 s the sheet of plain IMEX Euler \
         {still} (it falls {} m in 0.3 s, that of backward Euler {} m, that of updated CG {} m).{tension}",
        short(-plain.fall_m),
        short(-reference.fall_m),
        short(-updated.fall_m)
    ))
}

fn step_finding(facts: &Facts) -> Option<String> {
    let totals = |stiffness: f64| {
        let mut cells: Vec<_> = facts
            .cells
            .iter()
            .filter(|c| {
                c.series == "step"
                    && c.variant == "plain"
                    && c.stiffness_over_mass_per_s2 == stiffness
            })
            .collect();
        cells.sort_by(|a, b| a.step_s.total_cmp(&b.step_s));
        let list: Vec<_> =
            cells.iter().map(|c| format!("{} at h = {} s", c.cg_iterations, c.step_s)).collect();
        (!list.is_empty()).then(|| list.join(", "))
    };
    Some(format!(
        "CG iterations in one second against the step size, plain: k/m = 1e4: {}; k/m = 1e6: {}.",
        totals(1e4)?,
        totals(1e6)?
    ))
}
