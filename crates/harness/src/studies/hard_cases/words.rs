//! The words of the study `hard-cases`: its question.

use super::facts::*;
use crate::studies::short;
use drape_report::Verdict;
use drape_report::Words;
use std::collections::BTreeSet;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which method stays stable where methods fail, and does it do so where its theory \
     says that it should?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["momentum", "stability"];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

/// What the numbers say.
pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    let decided = |cell: &&Cell| cell.verdict.is_judged();
    let of = |method: &str| facts.cells.iter().filter(|c| c.method == method).collect::<Vec<_>>();
    let (mut everywhere, mut others) = (Vec::new(), Vec::new());
    for method in &facts.methods {
        let cells = of(method);
        let count = |verdict: Verdict| cells.iter().filter(|c| c.verdict == verdict).count();
        let (all, stable) =
            (cells.iter().copied().filter(|c| decided(c)).count(), count(Verdict::Stable));
        if all == stable {
            everywhere.push(format!("{method} ({stable})"));
        } else {
            others.push(format!("{method} {stable} of {all}"));
        }
    }
    if !everywhere.is_empty() {
        findings.push(format!("Stable in every run that came to a verdict: {}.", list(everywhere)));
    }
    if !others.is_empty() {
        findings.push(format!("Stable runs of those that came to a verdict: {}.", list(others)));
    }
    findings.extend(theorem_finding(facts));
    findings.extend(explicit_shear_finding(facts));
    findings.extend(safeguard_finding(facts));
    findings.extend(rest_finding(facts));
    findings.extend(budget_finding(facts));
    let differing: Vec<_> = facts.cells.iter().filter(|cell| cell.differs).collect();
    let explained = differing.len() - facts.unexplained.len();
    let predicted =
        facts.cells.iter().filter(decided).filter(|c| c.expected != Expected::NoTheorem).count();
    let trivial = facts.cells.iter().filter(decided).filter(|c| c.reason == NOTHING_MOVES).count();
    findings.push(format!(
        "Theory says something about {predicted} of the cells with a verdict ({trivial} of them without a moving \
         spring); {} differ from it, {explained} with an explanation below.",
        differing.len()
    ));
    if !facts.unexplained.is_empty() {
        findings.push(format!("Unexplained: {}.", facts.unexplained.join("; ")));
    }
    findings
}

/// Allowance for round-off over `E_ref` beyond which a count of rises says nothing.
const VISIBLE: f64 = 1e-3;

/// The energy theorem, counted.
fn theorem_finding(facts: &Facts) -> Option<String> {
    let count = |is_counted: &dyn Fn(&Cell) -> bool| {
        let cells = facts.cells.iter().filter(|cell| is_counted(cell));
        cells.fold((0, 0), |(steps, rises), c| (steps + c.steps, rises + c.rises))
    };
    let is_seen = |cell: &Cell| cell.round_off <= VISIBLE;
    let is_monotone = |cell: &Cell| cell.expected == Expected::Monotone;
    let (steps, rises) = count(&|cell| is_monotone(cell) && is_seen(cell));
    let (newton, newton_rises) = count(&|cell| cell.method == "backward-euler" && is_seen(cell));
    let blind = facts.cells.iter().filter(|cell| is_monotone(cell) && !is_seen(cell));
    let blind: BTreeSet<_> = blind.map(|cell| cell.case.clone()).collect();
    let blind = if blind.is_empty() {
        String::new()
    } else {
        format!(
            " Not counted, because the allowance for round-off exceeds {} E_ref there: {}.",
            short(VISIBLE),
            list(blind)
        )
    };
    (steps > 0).then(|| {
        format!(
            "Where the energy theorem of IMEX Euler holds, the energy rose in {rises} of {steps} steps; that of \
             backward Euler, which has no such theorem, in {newton_rises} of {newton}.{blind}"
        )
    })
}

/// H16: which springs may stay out of the matrix.
fn explicit_shear_finding(facts: &Facts) -> Option<String> {
    let cells = facts.cells.iter().filter(|cell| cell.case.starts_with("H16"));
    let outside = cells.filter(|cell| cell.settings.contains("implicit=tension"));
    let (failing, holding): (Vec<_>, Vec<_>) =
        outside.partition(|cell| cell.verdict != Verdict::Stable);
    let names = |cells: &[&Cell]| {
        let names: BTreeSet<_> = cells.iter().map(|cell| cell.method.as_str()).collect();
        list(names.into_iter().map(str::to_owned))
    };
    (!failing.is_empty()).then(|| {
        let but = match holding.as_slice() {
            [] => String::new(),
            holding => format!("; not with {}", names(holding)),
        };
        format!(
            "Shear springs as stiff as the tension springs must stand in the matrix: left out of it, they make the \
             sheet unstable with {}{but}.",
            names(&failing)
        )
    })
}

/// H20: what the paper's algorithm gains and its safeguards keep.
fn safeguard_finding(facts: &Facts) -> Option<String> {
    let at = |method: &str| {
        let cells = facts.cells.iter().filter(|c| c.case.starts_with("H20") && c.method == method);
        cells.max_by(|a, b| a.gain.total_cmp(&b.gain))
    };
    let (paper, robust) = (at("imex-updated (paper)")?, at("imex-updated")?);
    Some(format!(
        "At k/m = 1e6 and ε = 0.1 updated CG as printed is {} (its energy rises by up to {} times what the scene sets free), \
         its safeguarded form {}.",
        paper.verdict,
        short(paper.gain),
        robust.verdict
    ))
}

/// What was not found out.
fn budget_finding(facts: &Facts) -> Option<String> {
    let count = |method: &String| {
        let is_over = |c: &&Cell| c.method == *method && c.verdict == Verdict::OverBudget;
        let count = facts.cells.iter().filter(is_over).count();
        (count > 0).then(|| format!("{method} {count}"))
    };
    let counts: Vec<_> = facts.methods.iter().filter_map(count).collect();
    (!counts.is_empty()).then(|| format!("Cells that ended over budget: {}.", list(counts)))
}

/// Who does not keep still.
fn rest_finding(facts: &Facts) -> Option<String> {
    let restless = |cell: &&Cell| cell.strayed_m.is_some() && !cell.note.is_empty();
    let name = |cell: &Cell| {
        let damping = if cell.is_damped { "damped" } else { "undamped" };
        let way = cell.strayed_m.filter(|way| *way < f64::MAX);
        let way = way.map_or("without end".to_owned(), |way| format!("{} m", short(way)));
        format!("{} {damping} ({way})", cell.method)
    };
    let moving: Vec<_> = facts.cells.iter().filter(restless).map(name).collect();
    let looked = facts.cells.iter().any(|cell| cell.strayed_m.is_some());
    looked.then(|| {
        if moving.is_empty() {
            "The sheet at rest keeps still with every method.".to_owned()
        } else {
            format!("The sheet at rest does not keep still with {}.", list(moving))
        }
    })
}

fn list(texts: impl IntoIterator<Item = String>) -> String {
    texts.into_iter().collect::<Vec<_>>().join(", ")
}
