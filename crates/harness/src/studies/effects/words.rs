//! The words of the study `effects`: its question, and what its numbers say.

use super::facts::{Cell, EVERYTHING, Facts, NOTHING};
use crate::studies::short;
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "What does each effect that a scene names cost with every method, what does it change, and what does a scene \
     pay for those that it does not name?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// Methods whose conjugate gradients tell what a matrix costs.
const ITERATING: [&str; 3] = ["imex-euler", "imex-updated", "baraff-witkin"];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts, &[]))
}

pub(super) fn findings(facts: &Facts, left_out: &[(&str, &str)]) -> Vec<String> {
    let mut findings = vec![matrices(facts), omitted(left_out)];
    findings.extend(ITERATING.iter().filter_map(|method| iterations(facts, method)));
    findings.extend(changes(facts));
    findings.extend(outcomes(facts));
    findings
}

fn cell<'a>(facts: &'a Facts, effect: &str, method: &str) -> Option<&'a Cell> {
    facts.cells.iter().find(|cell| cell.effect == effect && cell.method == method)
}

/// Which effects enter which matrix.
fn matrices(facts: &Facts) -> String {
    let nothing = &facts.effects[0];
    let name = |effect: &&super::facts::Effect| effect.name.clone();
    let own = || facts.effects.iter().filter(|e| ![NOTHING, EVERYTHING].contains(&e.name.as_str()));
    let scalar: Vec<_> = own().filter(|e| e.springs > nothing.springs).map(|e| name(&e)).collect();
    let block: Vec<_> =
        own().filter(|e| e.coupled_pairs > nothing.coupled_pairs).map(|e| name(&e)).collect();
    let neither: Vec<_> = own()
        .filter(|e| e.springs == nothing.springs && e.coupled_pairs == nothing.coupled_pairs)
        .map(|e| name(&e))
        .collect();
    format!(
        "The scalar matrix of IMEX methods grows by {} only, the 3×3 blocks by {}; the pattern is left as it is by {}.",
        list(&scalar),
        list(&block),
        list(&neither)
    )
}

/// What is not among all together, and why.
fn omitted(left_out: &[(&str, &str)]) -> String {
    let said: Vec<_> = left_out.iter().map(|(name, holder)| format!("{name} ({holder})")).collect();
    format!(
        "{EVERYTHING} leaves out {} of the additions, since a scene has one place for each kind and another stands there: {}.",
        left_out.len(),
        said.join(", ")
    )
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
}

/// Iterations of a method with each effect.
fn iterations(facts: &Facts, method: &str) -> Option<String> {
    let nothing = cell(facts, NOTHING, method).filter(|cell| cell.cg_iterations > 0)?;
    let of = |effect: &super::facts::Effect| {
        let cell = cell(facts, &effect.name, method)?;
        (cell.verdict == Verdict::Completed && effect.name != NOTHING)
            .then(|| format!("{} with {}", cell.cg_iterations, effect.name))
    };
    let others: Vec<_> = facts.effects.iter().filter_map(of).collect();
    Some(format!(
        "{method}: {} CG iterations in {} steps of the bare sheet, {}.",
        nothing.cg_iterations,
        nothing.steps,
        others.join(", ")
    ))
}

/// What moves the sheet most and least, by symplectic Euler in short steps.
fn changes(facts: &Facts) -> Option<String> {
    let method = "symplectic-euler";
    let mut changes: Vec<_> = facts
        .cells
        .iter()
        .filter(|cell| {
            cell.method == method && ![NOTHING, EVERYTHING].contains(&cell.effect.as_str())
        })
        .filter_map(|cell| Some((cell.change_m?, cell.effect.as_str())))
        .collect();
    changes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let said: Vec<_> =
        changes.iter().map(|(change, effect)| format!("{effect} {} m", short(*change))).collect();
    (!said.is_empty()).then(|| {
        format!(
            "How far each moves the sheet by the end ({method}, short steps): {}.",
            said.join(", ")
        )
    })
}

/// Runs that were refused or diverged.
fn outcomes(facts: &Facts) -> Vec<String> {
    let of = |verdict: Verdict| -> Vec<String> {
        let cells = facts.cells.iter().filter(|cell| cell.verdict == verdict);
        cells.map(|cell| format!("{} with {}", cell.method, cell.effect)).collect()
    };
    let mut said = Vec::new();
    for (verdict, what) in [(Verdict::Refused, "Refused by name"), (Verdict::Diverged, "Diverged")]
    {
        let cells = of(verdict);
        if !cells.is_empty() {
            said.push(format!("{what}: {}.", cells.join("; ")));
        }
    }
    said
}
