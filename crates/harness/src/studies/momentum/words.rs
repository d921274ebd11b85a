//! The words of the study `momentum`: its question.

use super::facts::*;
use crate::studies::short;
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which methods keep the linear and the angular momentum of a cloth that nothing holds, \
     and how much of its spin is left by the others and by Desbrun's correction?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["order"];

/// Spin left to Desbrun's sheet, `|L|/|L_0|`, in an independent prototype: scene, label, value.
pub(super) const PROTOTYPE: [(&str, &str, f64); 6] = [
    ("spin-1e4", "desbrun, no correction", 0.053),
    ("spin-1e4", "desbrun, literal", 0.15),
    ("spin-1e4", "desbrun, consistent", 0.96),
    ("spin-1e6", "desbrun, no correction", 0.0),
    ("spin-1e6", "desbrun, literal", 0.0),
    ("spin-1e6", "desbrun, consistent", 0.99),
];

/// Greatest difference to the prototype that confirms it.
const CONFIRMED: f64 = 0.005;

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

/// What the numbers say.
pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    let linear: Pick = |row| (row.states_momentum, row.momentum_drift);
    findings.extend(stated(facts, "linear", linear));
    findings.extend(unstated(facts, "linear", linear));
    findings.extend(stated(facts, "angular", |row| {
        (row.states_angular_momentum, row.angular_momentum_drift)
    }));
    for scene in facts.scenes.iter().filter(|scene| scene.id.starts_with("spin")) {
        findings.extend(spins(facts, scene));
    }
    findings.extend(correction(facts));
    findings.extend(gains(facts));
    findings.extend(laws(facts));
    findings.extend(unstable(facts));
    findings
}

/// Whether a row's method states that it keeps something, and how much that drifts.
pub(super) type Pick = fn(&Row) -> (bool, Option<f64>);

/// The labels of the variants whose methods do or do not state that they keep something, each with its greatest
/// drift and the scene where it is.
pub(super) fn drifts(facts: &Facts, pick: Pick, stating: bool) -> Vec<(&str, f64, &str)> {
    let mut worst: Vec<(&str, f64, &str)> = Vec::new();
    for row in &facts.rows {
        let (states, Some(drift)) = pick(row) else { continue };
        if states != stating {
            continue;
        }
        match worst.iter_mut().find(|(label, _, _)| *label == row.label) {
            Some(entry) if entry.1 < drift => (entry.1, entry.2) = (drift, &row.scene),
            Some(_) => {}
            None => worst.push((&row.label, drift, &row.scene)),
        }
    }
    worst
}

fn listed(drifts: &[&(&str, f64, &str)]) -> String {
    let text =
        |(label, drift, scene): &&(&str, f64, &str)| format!("{label} {} ({scene})", short(*drift));
    drifts.iter().map(text).collect::<Vec<_>>().join(", ")
}

/// Who keeps what it states.
pub(super) fn stated(facts: &Facts, what: &str, pick: Pick) -> Option<String> {
    let drifts = drifts(facts, pick, true);
    let broken: Vec<_> = drifts.iter().filter(|(_, drift, _)| *drift > KEPT).collect();
    let all = drifts.len();
    let text = if broken.is_empty() {
        format!(
            "All {all} variants that should keep {what} momentum by the statement of their method do, within a drift \
             of {KEPT:e}, wherever they are stable."
        )
    } else {
        format!(
            "{} of {all} variants that should keep {what} momentum by the statement of their method do, within a drift \
             of {KEPT:e}; not so: {}.",
            all - broken.len(),
            listed(&broken)
        )
    };
    (all > 0).then_some(text)
}

/// What is lost where nothing is stated.
fn unstated(facts: &Facts, what: &str, pick: Pick) -> Option<String> {
    let drifts = drifts(facts, pick, false);
    let moved: Vec<_> = drifts.iter().filter(|(_, drift, _)| *drift > KEPT).collect();
    (!moved.is_empty()).then(|| {
        format!(
            "Drift of {what} momentum of variants that do not claim to keep it: {}.",
            listed(&moved)
        )
    })
}

/// Spin that is left to the sheet: who keeps it, who loses or gains how much.
fn spins(facts: &Facts, case: &Scene) -> Option<String> {
    let mut kept = Vec::new();
    let mut changed: Vec<(f64, &str)> = Vec::new();
    for row in facts.rows.iter().filter(|row| row.scene == case.id) {
        match row.final_spin {
            Some(spin) if (spin - 1.0).abs() <= LEAST_CHANGE => kept.push(row.label.as_str()),
            Some(spin) => changed.push((spin, &row.label)),
            None => {}
        }
    }
    changed.sort_by(|a, b| b.0.total_cmp(&a.0));
    let changed: Vec<_> =
        changed.iter().map(|(spin, label)| format!("{label} {spin:.3}")).collect();
    let parts: Vec<_> = [
        (format!("kept within {} % by", 100.0 * LEAST_CHANGE), kept.join(", ")),
        ("else |L|/|L₀| is".to_owned(), changed.join(", ")),
    ]
    .into_iter()
    .filter(|(_, list)| !list.is_empty())
    .map(|(what, list)| format!("{what} {list}"))
    .collect();
    (!parts.is_empty()).then(|| {
        format!(
            "Spin of the sheet at k/m = {:e} after one second: {}.",
            case.stiffness_over_mass_per_s2,
            parts.join("; ")
        )
    })
}

/// Desbrun's correction beside an independent prototype.
fn correction(facts: &Facts) -> Option<String> {
    let lines: Vec<_> = PROTOTYPE
        .iter()
        .filter_map(|(scene, label, expected)| {
            let row = facts.rows.iter().find(|row| row.scene == *scene && row.label == *label)?;
            let found = row.final_spin?;
            let holds = (found - expected).abs() <= CONFIRMED;
            let verdict = if holds { "confirmed" } else { "not confirmed" };
            Some(format!("{label}, {scene}: {found:.3} (prototype {expected}, {verdict})"))
        })
        .collect();
    (!lines.is_empty()).then(|| {
        format!(
            "Spin left by Desbrun's correction of torques, beside an independent prototype that was written before drape: {}. \
             Here the consistent correction takes its lever arms at the old positions, which keeps the angular momentum to \
             round-off; where the prototype took them is not known.",
            lines.join("; ")
        )
    })
}

/// Who gains energy while it spins.
fn gains(facts: &Facts) -> Option<String> {
    let list: Vec<_> = facts
        .rows
        .iter()
        .filter_map(|row| Some((row, row.energy_gain.filter(|gain| *gain > LEAST_CHANGE)?)))
        .map(|(row, gain)| format!("{} {} % ({})", row.label, short(100.0 * gain), row.scene))
        .collect();
    (!list.is_empty()).then(|| {
        format!(
            "Kept spin is not kept energy: these gain more than {} % of the energy of the spin: {}.",
            100.0 * LEAST_CHANGE,
            list.join(", ")
        )
    })
}

/// The pair beside the exact laws.
fn laws(facts: &Facts) -> Option<String> {
    let compared: Vec<_> = facts
        .rows
        .iter()
        .filter_map(|row| Some((row, (row.final_spin? - row.law?).abs())))
        .collect();
    let worst = compared.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "Two particles: in all {} runs of methods with an exact law for |L|/|L₀| it is met within {} (the greatest \
         difference is that of {}, {}).",
        compared.len(),
        short(worst.1),
        worst.0.label,
        worst.0.scene
    ))
}

fn unstable(facts: &Facts) -> Option<String> {
    let mut list: Vec<(&str, Vec<&str>)> = Vec::new();
    for row in facts.rows.iter().filter(|row| row.verdict == Verdict::Unstable) {
        match list.iter_mut().find(|(label, _)| *label == row.label) {
            Some((_, scenes)) => scenes.push(&row.scene),
            None => list.push((&row.label, vec![&row.scene])),
        }
    }
    let list: Vec<_> =
        list.iter().map(|(label, scenes)| format!("{label} ({})", scenes.join(", "))).collect();
    (!list.is_empty()).then(|| {
        format!("Diverged, or gained more energy than there was in the spin: {}.", list.join("; "))
    })
}
