//! The words of the study `claims`: its question.

use super::facts::*;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which of the paper's claims hold?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["hard-cases", "work-precision", "solver-control"];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

/// What the verdicts say.
pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let ids = |verdict: Verdict| {
        let rows = facts.claims.iter().filter(|row| row.verdict == verdict);
        rows.map(|row| row.id.as_str()).collect::<Vec<_>>()
    };
    let count = |verdict: Verdict| {
        let ids = ids(verdict);
        let list = if ids.is_empty() { String::new() } else { format!(" ({})", ids.join(", ")) };
        format!("{} {}{list}", ids.len(), verdict.name())
    };
    let verdicts = [Verdict::Confirmed, Verdict::Refuted, Verdict::Undecided].map(count);
    let mut findings = vec![format!("Of {} claims: {}.", facts.claims.len(), verdicts.join("; "))];
    for row in facts.claims.iter().filter(|row| row.verdict != Verdict::Confirmed) {
        let repair =
            row.repair.as_ref().map_or(String::new(), |repair| format!(" Repair: {repair}"));
        let Row { id, says, reason, .. } = row;
        findings.push(format!("{id}, “{says}”, is {}. {reason}{repair}", row.verdict.name()));
    }
    findings
}
