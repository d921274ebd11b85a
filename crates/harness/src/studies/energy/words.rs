//! The words of the study `energy`: its question, and the findings from its numbers.

use super::facts::{ALL_IMPLICIT, Facts, Ledger, Row};
use crate::studies::names::{count, verb};
use drape_report::Words;
use drape_report::number::{percent, setting, significant};
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// The question that the study answers.
pub(super) const QUESTION: &str = "How much of a cloth's energy do the scene's damping, the time \
                                   step, the solver and corrections take?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["momentum", "stability"];

/// Share of `E_ref` from which on a loss is mentioned.
const NOTABLE: f64 = 0.01;
/// Share of `E_ref` that is large for a loss, a residual or a correction.
const MUCH: f64 = 0.1;
/// Closure defect up to which a ledger closes.
const CLOSED: f64 = 1e-8;
/// Gap over `E_ref` up to which it may be round-off.
const ROUND_OFF: f64 = 1e-12;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion: Vec<_> = [loss(facts), instead(facts)].into_iter().flatten().collect();
    let conclusion = match &conclusion[..] {
        [] => "No run kept its energy long enough for a ledger.".to_owned(),
        sentences => sentences.join(" "),
    };
    let observations = [
        closure(facts),
        theorem(facts),
        passes(facts, "the residual of the solve", |ledger| ledger.residual),
        passes(facts, "corrections of positions or velocities", |ledger| ledger.correction),
        excess(facts),
    ];
    let observations = observations.into_iter().flatten().collect();
    Words { conclusion, observations, caveats: caveats(facts) }
}

fn ledgers(facts: &Facts) -> impl Iterator<Item = (&Row, &Ledger)> + Clone {
    facts.rows.iter().filter_map(|row| Some((row, row.ledger.as_ref()?)))
}

/// Rows with a ledger on the damped scenes, or on the undamped ones.
fn on(facts: &Facts, is_damped: bool) -> impl Iterator<Item = (&Row, &Ledger)> + Clone {
    let scenes = facts.scenes.iter().filter(move |scene| scene.is_damped == is_damped);
    scenes.flat_map(move |scene| ledgers(facts).filter(move |(row, _)| row.scene == scene.id))
}

/// A limit in per cent, as text.
fn whole(share: f64) -> String {
    format!("{} %", setting(100.0 * share))
}

fn greatest<T>(items: impl Iterator<Item = T>, value: impl Fn(&T) -> f64) -> Option<T> {
    items.max_by(|a, b| value(a).total_cmp(&value(b)))
}

/// Loss by the time step without damping, where no energy should be lost.
fn loss(facts: &Facts) -> Option<String> {
    let scenes = facts.scenes.iter().filter(|scene| !scene.is_damped).count();
    let labels: BTreeSet<_> = on(facts, false).map(|(row, _)| row.label.as_str()).collect();
    let of = |label: &str| -> Vec<f64> {
        let own = on(facts, false).filter(|(row, _)| row.label == label);
        own.map(|(_, ledger)| ledger.numerical()).collect()
    };
    let takes = |label: &&&str| of(label).iter().any(|share| *share <= -MUCH);
    let takers = labels.iter().filter(takes).count();
    let keeps = |label: &&&str| {
        let shares = of(label);
        shares.len() == scenes && shares.iter().all(|share| share.abs() < NOTABLE)
    };
    let keepers: Vec<_> = labels.iter().filter(keeps).collect();
    let who = match takers {
        0 => "no variant",
        n if n == labels.len() => "every variant",
        n if 2 * n > labels.len() => "most variants",
        _ => "some variants",
    };
    let limit = whole(NOTABLE);
    let keepers = match &keepers[..] {
        [] => format!("No variant stays within {limit} in every scene."),
        [one] => format!("Only `{one}` loses less than {limit} in every scene."),
        several => format!("{} variants lose less than {limit} in every scene.", several.len()),
    };
    (!labels.is_empty()).then(|| {
        format!(
            "Without damping, the time step of {who} takes at least a tenth of the released energy \
             in some scene. {keepers}"
        )
    })
}

/// How the loss changes the work of the damping, on the first damped scene.
fn instead(facts: &Facts) -> Option<String> {
    let (first, _) = on(facts, true).next()?;
    let rows = || on(facts, true).filter(|(row, _)| row.scene == first.scene);
    let (_, most) = greatest(rows(), |(_, ledger)| -ledger.numerical())?;
    let (_, least) = greatest(rows(), |(_, ledger)| -ledger.numerical().abs())?;
    if most.numerical() > -NOTABLE {
        return Some(format!(
            "With damping, no time step takes more than {} ({}).",
            whole(NOTABLE),
            first.scene
        ));
    }
    let verdict = match most.damping.abs().total_cmp(&least.damping.abs()) {
        Ordering::Less => "the numerical loss replaces physical damping",
        _ => "the numerical loss adds to physical damping",
    };
    Some(format!(
        "With damping, {verdict}: dampers take {} with the most dissipative method and {} with the \
         least dissipative one ({}).",
        percent(-most.damping, 2),
        percent(-least.damping, 2),
        first.scene
    ))
}

/// Whether the ledgers close.
fn closure(facts: &Facts) -> Option<String> {
    let defects = facts.rows.iter().filter_map(|row| Some((row, row.closure_defect?)));
    let (worst, defect) = greatest(defects.clone(), |(_, defect)| *defect)?;
    let all = defects.clone().count();
    let open = defects.filter(|(_, defect)| *defect > CLOSED).count();
    Some(if open == 0 {
        format!(
            "Every ledger closes: in {all} runs the causes add up to the change of energy within \
             {} of their size.",
            significant(defect, 1)
        )
    } else {
        format!(
            "In {open} of {all} runs the ledger does not close; the largest defect is {} times the \
             sum of its terms ({}, {}).",
            significant(defect, 1),
            worst.label,
            worst.scene
        )
    })
}

/// Theorem 1: no gap of implicit springs in IMEX Euler adds energy.
fn theorem(facts: &Facts) -> Option<String> {
    let own = ledgers(facts).filter(|(row, _)| row.label == ALL_IMPLICIT);
    let gaps = own.flat_map(|(_, ledger)| &ledger.gaps).filter(|(name, _)| *name != "gravity");
    let gaps: Vec<f64> = gaps.map(|(_, gap)| *gap).collect();
    let greatest = gaps.iter().copied().max_by(f64::total_cmp)?;
    Some(if greatest <= ROUND_OFF {
        format!(
            "IMEX Euler with all springs implicit satisfies its energy theorem: none of the {} \
             energy gaps is positive.",
            gaps.len()
        )
    } else {
        format!(
            "IMEX Euler with all springs implicit violates its energy theorem: the greatest of the \
             {} energy gaps is {} of E_ref.",
            gaps.len(),
            percent(greatest, 2)
        )
    })
}

/// How many runs gain or lose much by another cause.
fn passes(facts: &Facts, cause: &str, share: fn(&Ledger) -> f64) -> Option<String> {
    let much = ledgers(facts).filter(|(_, ledger)| share(ledger).abs() >= MUCH);
    let runs = count(much.clone().count(), "run");
    let (row, ledger) = greatest(much, |(_, ledger)| share(ledger).abs())?;
    Some(format!(
        "In {runs}, at least {} of E_ref passes through {cause}; the most is {} ({}, {}).",
        whole(MUCH),
        percent(share(ledger), 2),
        row.label,
        row.scene
    ))
}

/// Agreement of the excess dissipation with the ledger.
fn excess(facts: &Facts) -> Option<String> {
    // By the ledger, every loss other than damping is the excess. The two differ by the quadrature
    // of the damping.
    let difference = |(row, ledger): (&'_ Row, &Ledger)| {
        let by_ledger = ledger.damping - ledger.sum();
        Some(((row.excess_dissipation? - by_ledger).abs(), row.label.clone(), row.scene.clone()))
    };
    let (most, label, scene) = greatest(ledgers(facts).filter_map(difference), |(most, ..)| *most)?;
    Some(format!(
        "The integral of the damping along the path differs from its work in the steps by at most \
         {} of E_ref ({label}, {scene}).",
        percent(most, 2)
    ))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let gained = facts.rows.iter().filter(|row| row.drift.is_none()).count();
    let gained = (gained > 0).then(|| {
        format!(
            "{gained} of {} runs gained too much energy and {} no ledger.",
            facts.rows.len(),
            verb(gained, "has", "have")
        )
    });
    let unattributed = facts.unattributed.len();
    let unattributed = (unattributed > 0).then(|| {
        format!(
            "{} {} no ledger, because no energy identity holds for a single step.",
            count(unattributed, "variant"),
            verb(unattributed, "has", "have")
        )
    });
    let quiet = "A method that locks also loses little: its sheet hardly falls, as the curves \
                 over time show.";
    gained.into_iter().chain(unattributed).chain([quiet.to_owned()]).collect()
}
