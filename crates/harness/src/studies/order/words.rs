//! The words of the study `order`: its question.

use super::facts::*;
use crate::studies::short;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Does the error of every method fall with the order that theory gives, how large \
     is its constant, and what is left of the order where the springs are too stiff for the step?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

/// What the numbers say.
pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    for scene in &facts.scenes {
        let rows: Vec<_> = facts.rows.iter().filter(|row| row.scene == scene.id).collect();
        if scene.resolved {
            findings.push(acceptance(scene, &rows));
            findings.extend(rows.iter().copied().filter_map(|row| unclaimed(scene, row)));
        } else {
            findings.push(stiffness(scene, &rows));
        }
    }
    let smooth = facts.scenes.iter().find(|scene| scene.resolved);
    findings.extend(smooth.and_then(|scene| constants(scene, &facts.rows)));
    let error = facts.scenes.iter().map(|scene| scene.reference_error_m).fold(0.0, f64::max);
    findings.push(format!("The references are off by at most {} m.", short(error)));
    findings
}

fn title(scene: &Scene) -> &'static str {
    match scene.id.as_str() {
        "smooth" => "the smooth scene with full damping",
        "smooth-projected" => "the smooth scene with projected damping",
        "stiff-1e4" => "k/m = 1e4",
        "stiff-1e6" => "k/m = 1e6",
        _ => "another scene",
    }
}

/// How many methods show their order, and which do not.
fn acceptance(scene: &Scene, rows: &[&Row]) -> String {
    let claiming: Vec<_> = rows.iter().filter(|row| row.accepted.is_some()).collect();
    let failing: Vec<_> = claiming
        .iter()
        .filter(|row| row.accepted == Some(false))
        .map(|row| {
            let theory = row.theory.unwrap_or_default();
            let order = row.order.map_or("none".to_owned(), |order| format!("{order:.2}"));
            format!("{} ({order}, theory {theory})", row.label)
        })
        .collect();
    let all = claiming.len();
    let title = title(scene);
    if failing.is_empty() {
        format!("On {title} all {all} variants that claim an order show it within {ACCEPTED}.")
    } else {
        format!(
            "On {title} {} of {all} variants that claim an order show it within {ACCEPTED}; not so: {}.",
            all - failing.len(),
            failing.join(", ")
        )
    }
}

/// What a method that claims no order does.
fn unclaimed(scene: &Scene, row: &Row) -> Option<String> {
    let order = row.order.filter(|_| row.theory.is_none())?;
    let error = row.runs.last()?.error?;
    Some(format!(
        "{} claims no order: on {} its observed order is {order:.2}, and {} % of the motion is wrong at the finest \
         step.",
        row.label,
        title(scene),
        short(100.0 * error)
    ))
}

/// Where the springs are stiff: who keeps the order, who loses it, who does not move, who diverges.
fn stiffness(scene: &Scene, rows: &[&Row]) -> String {
    let mut kept = Vec::new();
    let mut reduced = Vec::new();
    let mut unclaimed = Vec::new();
    let mut lost = Vec::new();
    let mut few = Vec::new();
    let mut failed = Vec::new();
    for row in rows {
        let finest = row.runs.last().and_then(|run| run.error);
        let error = || finest.map_or(String::new(), |error| format!(" ({})", short(error)));
        let order = |order: f64| format!("{} {order:.2}", row.label);
        match (finest, row.order) {
            (None, _) => failed.push(row.label.clone()),
            (Some(e), _) if e >= LOST => lost.push(format!("{}{}", row.label, error())),
            (_, Some(p)) if row.theory.is_none() => unclaimed.push(order(p)),
            (_, Some(p)) if row.error_constant.is_some() => kept.push(order(p)),
            (_, Some(p)) => reduced.push(order(p)),
            (_, None) => few.push(format!("{} ({})", row.label, row.fitted)),
        }
    }
    let lines: Vec<_> = [
        ("the order of theory is seen with", kept),
        ("another order with", reduced),
        ("an order where none is claimed:", unclaimed),
        ("off by half the motion or more at the finest step (error in brackets):", lost),
        ("too few runs for an order (their number in brackets):", few),
        ("diverged even at the finest step:", failed),
    ]
    .into_iter()
    .filter(|(_, labels)| !labels.is_empty())
    .map(|(what, labels)| format!("{what} {}", labels.join(", ")))
    .collect();
    let steps = |pick: fn(&[Run]) -> Option<&Run>| {
        rows.first().and_then(|row| pick(&row.runs)).map_or(0.0, |run| run.step_s)
    };
    let (first, last) = (steps(<[Run]>::first), steps(<[Run]>::last));
    format!(
        "At {} with h from {first} s to {last} s (h ω_max from {} to {}): {}.",
        title(scene),
        short(first * scene.greatest_frequency_per_s),
        short(last * scene.greatest_frequency_per_s),
        lines.join("; ")
    )
}

/// Least and greatest constants of each order on a scene.
fn constants(scene: &Scene, rows: &[Row]) -> Option<String> {
    let of_order = |theory: u32| {
        let mut found: Vec<_> = rows
            .iter()
            .filter(|row| row.scene == scene.id && row.theory == Some(theory))
            .filter_map(|row| Some((row.error_constant?, row.label.as_str())))
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (least, greatest) = (found.first()?, found.last()?);
        let value = |(constant, label): &(f64, &str)| format!("{} ({label})", short(*constant));
        Some(if found.len() == 1 {
            format!("order {theory}: {}", value(least))
        } else {
            format!("order {theory}: {} to {}", value(least), value(greatest))
        })
    };
    let lines: Vec<_> = (1..=3).filter_map(of_order).collect();
    (!lines.is_empty()).then(|| {
        format!("Error constants C = e/h^p on {}, in 1/s^p: {}.", title(scene), lines.join("; "))
    })
}
