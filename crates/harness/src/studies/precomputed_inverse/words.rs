//! The words of the study `precomputed-inverse`: its question, and what its numbers say.

use super::facts::{CG, CHOLESKY, DENSE, Facts, Solver};
use crate::studies::short;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "What do a precomputed inverse, a sparse factor and conjugate gradients cost to make, to keep and to use, \
     and what does a change of step size or stiffness cost each?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["cg-vs-stiffness"];

/// Solutions agree within this.
const AGREE: f64 = 1e-9;
/// A rebuild of fewer steps' worth forbids nothing.
const CHEAP: f64 = 20.0;
const MIB: f64 = 1024.0 * 1024.0;

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    findings.extend(agreement(facts));
    findings.extend(growth(facts));
    findings.extend(crossovers(facts));
    findings.extend(worth(facts));
    findings.extend(rebuilds(facts));
    findings.extend(fresh(facts));
    findings
}

fn of<'a>(facts: &'a Facts, solver: &'a str) -> impl Iterator<Item = &'a Solver> {
    facts.solvers.iter().filter(move |row| row.solver == solver)
}

fn agreement(facts: &Facts) -> Option<String> {
    let others = facts.solvers.iter().filter(|row| row.solver != CHOLESKY);
    let worst = others.max_by(|a, b| a.disagreement.total_cmp(&b.disagreement))?;
    let verdict = if worst.disagreement <= AGREE { "agree" } else { "do not agree" };
    Some(format!(
        "The three solvers {verdict} within {AGREE:e}: the greatest relative difference to the sparse factor is {} ({}, {} particles, \
         {}).",
        short(worst.disagreement),
        worst.solver,
        worst.particles,
        worst.series
    ))
}

fn growth(facts: &Facts) -> Option<String> {
    let largest = |solver| of(facts, solver).max_by_key(|row| row.particles);
    let (dense, sparse, cg) = (largest(DENSE)?, largest(CHOLESKY)?, largest(CG)?);
    let memory = |row: &Solver| row.kept_bytes as f64 / MIB;
    Some(format!(
        "At {} particles the inverse keeps and needs {} MiB, the sparse factor {} MiB ({} times the entries of the lower triangle of A), \
         IC(0) {} MiB; to make them takes {}, {} and {} operations.",
        dense.particles,
        short(memory(dense)),
        short(memory(sparse)),
        short(sparse.kept_nonzeros as f64 / cg.kept_nonzeros as f64),
        short(memory(cg)),
        short(dense.setup_operations),
        short(sparse.setup_operations),
        short(cg.setup_operations)
    ))
}

/// The first number of particles at which `solver` solves with fewer operations than `other`, from which on it stays so.
pub(super) fn crossover<'a>(
    solver: impl Iterator<Item = &'a Solver>,
    other: &[&Solver],
) -> Option<usize> {
    let mut first = None;
    for row in solver {
        let Some(other) = other.iter().find(|other| other.particles == row.particles) else {
            continue;
        };
        if row.solve_operations >= other.solve_operations {
            first = None;
        } else if first.is_none() {
            first = Some(row.particles);
        }
    }
    first
}

fn crossovers(facts: &Facts) -> Vec<String> {
    let mut series: Vec<&str> = of(facts, CG).map(|row| row.series.as_str()).collect();
    series.sort_unstable();
    series.dedup();
    let mut sentences = Vec::new();
    for name in series {
        let cg = || of(facts, CG).filter(|row| row.series == name);
        let text = |solver| {
            let others: Vec<_> = of(facts, solver).collect();
            match crossover(cg(), &others) {
                Some(n) => format!("than the {solver} from {n} particles on"),
                None => format!("than the {solver} at none of the sizes"),
            }
        };
        let counts: Vec<_> =
            cg().map(|row| format!("{}: {}", row.particles, short(row.cg_per_step))).collect();
        sentences.push(format!(
            "CG, {name}: a solve takes fewer operations {} and {} (iterations a step by particles: {}). \
             Operations are no time, which stands in a table of its own.",
            text(DENSE),
            text(CHOLESKY),
            counts.join(", ")
        ));
    }
    sentences
}

fn worth(facts: &Facts) -> Vec<String> {
    [DENSE, CHOLESKY]
        .into_iter()
        .filter_map(|solver| {
            let worths: Vec<_> = of(facts, solver)
                .map(|row| (row.particles, row.setup_operations / row.solve_operations))
                .collect();
            let greatest = worths.iter().map(|(_, worth)| *worth).reduce(f64::max)?;
            let verdict = if greatest < CHEAP {
                "forbids no change of h or k"
            } else {
                "makes changes of h and k dear"
            };
            let listed: Vec<_> =
                worths.iter().map(|(n, worth)| format!("{n}: {}", short(*worth))).collect();
            Some(format!(
                "To make the {solver} anew is worth so many solves with it, by particles, in operations: {}. It {verdict}.",
                listed.join(", ")
            ))
        })
        .collect()
}

fn rebuilds(facts: &Facts) -> Option<String> {
    let listed: Vec<_> = facts
        .changes
        .iter()
        .map(|run| {
            format!(
                "{}: {} at first, {} by the step size, {} by stiffness and masses, {} by pins",
                run.solver, run.first, run.step_size, run.stiffness, run.constraints
            )
        })
        .collect();
    let steps = facts.changes.first()?.steps;
    Some(format!(
        "Set-ups in {steps} steps with {} changes: {}.",
        facts.changes.first()?.changed.len(),
        listed.join("; ")
    ))
}

fn fresh(facts: &Facts) -> Option<String> {
    let apart = |distances: &[f64]| distances.iter().copied().fold(0.0, f64::max);
    let worst = facts
        .changes
        .iter()
        .max_by(|a, b| apart(&a.distance_to_fresh_m).total_cmp(&apart(&b.distance_to_fresh_m)))?;
    let greatest = apart(&worst.distance_to_fresh_m);
    let verdict = if greatest <= AGREE { "None differs" } else { "They differ" };
    Some(format!(
        "After a change each method goes on as one that starts anew from there. {verdict} by more than {AGREE:e} m: the greatest distance \
         is {} m ({}).",
        short(greatest),
        worst.solver
    ))
}
