//! The words of the study `energy`: its question, and what its numbers say.

use super::facts::{Facts, Ledger, Row, Scene};
use crate::studies::short;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Where does the energy of a cloth go: how much of it does the damping take that the scene asks for, and how much \
     the method itself, by its steps, its solver, its constraints and its corrections?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["momentum", "stability"];

/// A share of `E_ref` worth a word.
const NOTABLE: f64 = 0.01;
/// A share of `E_ref` that is much for a residual or a correction.
const MUCH: f64 = 0.1;
/// What a ledger may miss.
const CLOSED: f64 = 1e-8;

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    findings.extend(closure(facts));
    for scene in &facts.scenes {
        findings.extend(losses(facts, scene));
    }
    findings.extend(theorem(facts));
    findings.extend(others(facts, "the residual of its solve", |ledger| ledger.residual));
    findings.extend(others(facts, "corrections of positions or velocities", |ledger| {
        ledger.correction
    }));
    findings.extend(excess(facts));
    findings.extend(unstable(facts));
    findings
}

fn rows_of<'a>(facts: &'a Facts, scene: &Scene) -> impl Iterator<Item = &'a Row> + use<'a> {
    let id = scene.id.clone();
    facts.rows.iter().filter(move |row| row.scene == id)
}

fn percent(share: f64) -> String {
    // The sign shows which way the energy went.
    format!("{}{} %", if share > 0.0 { "+" } else { "" }, short(100.0 * share))
}

/// Whether the sums are right.
fn closure(facts: &Facts) -> Option<String> {
    let with = facts.rows.iter().filter_map(|row| Some((row, row.closure_defect?)));
    let worst = with.clone().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let verdict = if worst.1 <= CLOSED { "Every ledger closes" } else { "Not every ledger closes" };
    let without = match &facts.unattributed[..] {
        [] => String::new(),
        labels => format!(
            " Unattributed, since a step of theirs draws on steps before it and has no such identity: {}.",
            labels.join(", ")
        ),
    };
    Some(format!(
        "{verdict}: in {} runs the causes, each computed by itself, add up to the change of energy with an error of at most {} of \
         their magnitudes ({}, {}); {} was demanded.{without}",
        with.count(),
        short(worst.1),
        worst.0.label,
        worst.0.scene,
        short(CLOSED)
    ))
}

/// What the methods themselves take or add on a scene, beside its damping.
fn losses(facts: &Facts, scene: &Scene) -> Option<String> {
    let with = || rows_of(facts, scene).filter_map(|row| Some((row, row.ledger.as_ref()?)));
    let list = |least: bool| -> Vec<String> {
        let mut list: Vec<_> = with()
            .filter(|(_, ledger)| (ledger.numerical().abs() >= NOTABLE) == least)
            .map(|(row, ledger)| (row.label.as_str(), ledger.numerical()))
            .collect();
        list.sort_by(|a, b| a.1.total_cmp(&b.1));
        list.iter().map(|(label, share)| format!("{label} {}", percent(*share))).collect()
    };
    let (much, little) = (list(true), list(false));
    let damping: Vec<f64> = with().map(|(_, ledger)| ledger.damping).collect();
    let physical = match (
        damping.iter().copied().min_by(f64::total_cmp),
        damping.iter().copied().max_by(f64::total_cmp),
    ) {
        (Some(most), Some(least)) if scene.is_damped => format!(
            " The damping that the scene asks for takes {} to {}: the more a method takes by itself, the less is left for it.",
            percent(least),
            percent(most)
        ),
        _ => String::new(),
    };
    let little = match &little[..] {
        [] => String::new(),
        little => format!(" Less than {} %: {}.", 100.0 * NOTABLE, little.join(", ")),
    };
    (!much.is_empty() || !little.is_empty()).then(|| {
        let much = if much.is_empty() { "none".to_owned() } else { much.join(", ") };
        format!(
            "{}: numerical damping (inertia and gaps, of E_ref; a plus is a gain): {much}.{little}{physical}",
            scene.id
        )
    })
}

/// Theorem 1: the gaps of implicit springs in IMEX Euler.
fn theorem(facts: &Facts) -> Option<String> {
    let label = "imex-euler, all springs";
    let gaps: Vec<f64> = facts
        .rows
        .iter()
        .filter(|row| row.label == label)
        .filter_map(|row| row.ledger.as_ref())
        .flat_map(|ledger| ledger.gaps.iter())
        .filter(|(name, _)| *name != "gravity")
        .map(|(_, gap)| *gap)
        .collect();
    let greatest = gaps.iter().copied().max_by(f64::total_cmp)?;
    let verdict =
        if greatest <= 1e-12 { "As its energy theorem says" } else { "Against its energy theorem" };
    Some(format!(
        "{verdict}, the gaps of IMEX Euler with all springs in the matrix are {}: the greatest of {} sums is {} of E_ref.",
        if greatest <= 1e-12 { "never positive" } else { "positive somewhere" },
        gaps.len(),
        short(greatest)
    ))
}

/// Where another cause counts.
fn others(facts: &Facts, cause: &str, pick: fn(&Ledger) -> f64) -> Option<String> {
    let mut list: Vec<_> = facts
        .rows
        .iter()
        .filter_map(|row| Some((row, pick(row.ledger.as_ref()?))))
        .filter(|(_, share)| share.abs() >= MUCH)
        .collect();
    list.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let list: Vec<_> = list
        .iter()
        .map(|(row, share)| format!("{} {} ({})", row.label, percent(*share), row.scene))
        .collect();
    (!list.is_empty()).then(|| {
        format!(
            "More than {} % of E_ref passes through {cause} in: {}.",
            100.0 * MUCH,
            list.join(", ")
        )
    })
}

/// Excess dissipation beside the ledger.
fn excess(facts: &Facts) -> Option<String> {
    // What left by the ledger, but for the damping, is the excess, up to the quadrature of the damping.
    let differences: Vec<_> = facts
        .rows
        .iter()
        .filter_map(|row| {
            let ledger = row.ledger.as_ref()?;
            let by_ledger = -(ledger.sum() - ledger.damping);
            Some((row, (row.excess_dissipation? - by_ledger).abs()))
        })
        .collect();
    let worst = differences.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "Excess dissipation (what is lost beyond ∫vᵀDv dt) and the ledger's sum without damping differ by {} of E_ref at most \
         ({}, {}): the difference between the damping work of the method's steps and the integral along its path.",
        short(worst.1),
        worst.0.label,
        worst.0.scene
    ))
}

/// Who gained more energy than is marginal.
fn unstable(facts: &Facts) -> Option<String> {
    let mut list: Vec<(&str, Vec<String>)> = Vec::new();
    for row in facts.rows.iter().filter(|row| row.drift.is_none()) {
        let entry = format!("{} ({})", row.scene, row.verdict);
        match list.iter_mut().find(|(label, _)| *label == row.label) {
            Some((_, scenes)) => scenes.push(entry),
            None => list.push((&row.label, vec![entry])),
        }
    }
    let list: Vec<_> =
        list.iter().map(|(label, scenes)| format!("{label}: {}", scenes.join(", "))).collect();
    (!list.is_empty()).then(|| {
        format!("No ledger is kept of runs that gained too much energy: {}.", list.join("; "))
    })
}
