//! The words of the study `post-correction`: its question, and what its numbers say.

use super::facts::{FORWARD, Facts, Mesh, PERTURBED, Row};
use crate::studies::short;
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Is a soft sheet whose springs are shortened after each step a stiff sheet: what becomes of energy, momentum \
     and the differential equation, does the order matter, and do sweeps converge?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// Positions that differ by more than this share of the motion depend on the order.
const DEPENDS: f64 = 0.01;
/// Change of momentum that round-off makes, over mass and speed.
const ROUND_OFF: f64 = 1e-13;
/// A residual that falls with the step falls at least to this share.
const FALLS: f64 = 0.5;

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    findings.extend(facts.meshes.iter().map(reference));
    findings.extend(order(facts));
    findings.extend(approach(facts));
    findings.extend(limits_kept(facts));
    findings.extend(energy(facts));
    findings.extend(residual(facts));
    findings.extend(shorter_steps(facts));
    findings.extend(spins(facts));
    findings.extend(sweeps(facts));
    findings.extend(diverged(facts));
    findings
}

fn a_step(sweeps: u32) -> String {
    if sweeps == 1 { "1 sweep a step".to_owned() } else { format!("{sweeps} sweeps a step") }
}

fn list(values: &[f64]) -> String {
    values.iter().map(|value| short(*value)).collect::<Vec<_>>().join(", ")
}

fn reference(mesh: &Mesh) -> String {
    format!(
        "{}: without correction the longest spring of the soft sheet is stretched by {} % of its length, of the stiff sheet by {} %; \
         at {} s the soft sheet is {} of the motion away from the stiff one, whose own error is {}.",
        mesh.id,
        short(100.0 * mesh.uncorrected_elongation),
        short(100.0 * mesh.reference_elongation),
        list(&mesh.time_s),
        list(&mesh.uncorrected_distance),
        list(&mesh.reference_error)
    )
}

/// Mesh, label, limit and sweeps of the groups of rows that differ in their order.
type Key<'a> = (&'a str, &'a str, f64, u32);

fn key(row: &Row) -> Key<'_> {
    (&row.mesh, &row.label, row.limit, row.sweeps)
}

/// The step size of most rows: the longest.
fn usual_step(facts: &Facts) -> f64 {
    facts.rows.iter().map(|row| row.step_s).fold(0.0, f64::max)
}

/// Groups in the order of the record, each with the rows of its orders, at the usual step.
pub(super) fn groups(facts: &Facts) -> Vec<(Key<'_>, Vec<&Row>)> {
    let step = usual_step(facts);
    let mut groups: Vec<(Key<'_>, Vec<&Row>)> = Vec::new();
    for row in facts.rows.iter().filter(|row| row.step_s == step) {
        match groups.iter_mut().find(|(of, _)| *of == key(row)) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((key(row), vec![row])),
        }
    }
    groups
}

/// Greatest distance to the forward run at each time.
pub(super) fn spread(rows: &[&Row]) -> Vec<f64> {
    let mut spread: Vec<f64> = Vec::new();
    for row in rows.iter().filter(|row| row.order != PERTURBED) {
        for (n, distance) in row.order_distance.iter().enumerate() {
            match spread.get_mut(n) {
                Some(greatest) => *greatest = greatest.max(*distance),
                None => spread.push(*distance),
            }
        }
    }
    spread
}

fn order(facts: &Facts) -> Vec<String> {
    let Some(mesh) = facts.meshes.first() else { return Vec::new() };
    let widest = facts.rows.iter().map(|row| row.limit).fold(0.0, f64::max);
    let mut sentences = Vec::new();
    for ((mesh_id, label, limit, sweeps), rows) in groups(facts) {
        let spread = spread(&rows);
        if limit != widest || spread.is_empty() {
            continue;
        }
        let last = spread[spread.len() - 1];
        let verdict = if last > DEPENDS { "depends" } else { "does not depend" };
        let disturbed = rows.iter().find(|row| row.order == PERTURBED);
        let disturbed = disturbed.map_or_else(String::new, |row| {
            format!(" (a start disturbed by 1e-4 mesh widths: {})", list(&row.order_distance))
        });
        sentences.push(format!(
            "{mesh_id}, {label}, limit {limit}, {}: where the sheet is at {} s {verdict} on the order of the \
             sweep; the greatest distance to forward sweeps is {} of the motion at {} s{disturbed}.",
            a_step(sweeps),
            mesh.time_s[spread.len() - 1],
            list(&spread),
            list(&mesh.time_s[..spread.len()])
        ));
    }
    sentences
}

fn approach(facts: &Facts) -> Vec<String> {
    let groups = groups(facts);
    let mut series: Vec<(&str, &str, u32)> = Vec::new();
    for ((mesh, label, _, sweeps), _) in &groups {
        if !series.contains(&(mesh, label, *sweeps)) {
            series.push((mesh, label, *sweeps));
        }
    }
    let sentence = |(mesh, label, sweeps): (&str, &str, u32)| {
        let distances: Vec<(f64, &Vec<f64>)> = groups
            .iter()
            .filter(|((m, l, _, s), _)| (*m, *l, *s) == (mesh, label, sweeps))
            .filter_map(|((_, _, limit, _), rows)| {
                let forward = rows.iter().find(|row| row.order == FORWARD)?;
                Some((*limit, &forward.distance))
            })
            .collect();
        let (first, last) = (distances.first()?, distances.last()?);
        let error = &facts.meshes.iter().find(|m| m.id == mesh)?.reference_error;
        let (Some(wide), Some(narrow)) = (first.1.last(), last.1.last()) else { return None };
        if distances.len() < 2 {
            return None;
        }
        let falls = distances.windows(2).all(|pair| pair[1].1.last() <= pair[0].1.last());
        let verdict = if falls { "comes nearer to" } else { "does not come nearer to" };
        let listed: Vec<_> = distances
            .iter()
            .map(|(limit, distance)| format!("limit {limit}: {}", list(distance)))
            .collect();
        Some(format!(
            "{mesh}, {label}, {}: at the end the corrected sheet {verdict} the stiff one with every narrower limit, \
             {} times as near with the narrowest as with the widest, and stays {} of the motion away (distances at all times: {}; the reference is good to {}).",
            a_step(sweeps),
            short(wide / narrow),
            short(*narrow),
            listed.join("; "),
            list(error)
        ))
    };
    series.into_iter().filter_map(sentence).collect()
}

fn forward(facts: &Facts) -> impl Iterator<Item = &Row> {
    let step = usual_step(facts);
    facts.rows.iter().filter(move |row| row.order == FORWARD && row.step_s == step)
}

/// Range of a quantity over meshes and limits, by method and sweeps.
fn ranges(facts: &Facts, value: impl Fn(&Row) -> f64) -> String {
    let mut ranges: Vec<((&str, u32), f64, f64)> = Vec::new();
    for row in forward(facts) {
        let (of, value) = ((row.label.as_str(), row.sweeps), value(row));
        match ranges.iter_mut().find(|(known, _, _)| *known == of) {
            Some((_, low, high)) => (*low, *high) = (low.min(value), high.max(value)),
            None => ranges.push((of, value, value)),
        }
    }
    let text = |((label, sweeps), low, high): &((&str, u32), f64, f64)| {
        format!("{label}, {}: {} to {}", a_step(*sweeps), short(*low), short(*high))
    };
    ranges.iter().map(text).collect::<Vec<_>>().join("; ")
}

fn limits_kept(facts: &Facts) -> Option<String> {
    forward(facts).next()?;
    Some(format!(
        "Is the limit kept? The greatest elongation in the run, in units of the limit, over meshes and limits: {}.",
        ranges(facts, |row| row.elongation / row.limit)
    ))
}

fn energy(facts: &Facts) -> Option<String> {
    forward(facts).next()?;
    Some(format!(
        "Share of the weight that the corrections hold instead of the springs: {}. Energy that corrections give, in units of what the \
         fall sets free: {}; that they take: {}.",
        ranges(facts, |row| row.weight_held),
        ranges(facts, |row| row.energy_given),
        ranges(facts, |row| row.energy_taken)
    ))
}

fn residual(facts: &Facts) -> Option<String> {
    forward(facts).next()?;
    Some(format!(
        "Residual of the differential equation, ‖M a − f‖/‖f‖: {}. Without its correction the same step leaves {}.",
        ranges(facts, |row| row.residual),
        ranges(facts, |row| row.uncorrected_residual)
    ))
}

fn shorter_steps(facts: &Facts) -> Vec<String> {
    let step = usual_step(facts);
    let sentence = |mesh: &Mesh| {
        let shorter: Vec<&Row> =
            facts.rows.iter().filter(|row| row.mesh == mesh.id && row.step_s < step).collect();
        let first = shorter.first()?;
        let usual = forward(facts).find(|row| key(row) == key(first))?;
        let all = || [usual].into_iter().chain(shorter.iter().copied());
        let least = all().map(|row| row.residual).fold(f64::INFINITY, f64::min);
        let verdict = if least < FALLS * usual.residual { "falls" } else { "does not vanish" };
        let listed: Vec<_> =
            all().map(|row| format!("h = {} s: {}", row.step_s, short(row.residual))).collect();
        Some(format!(
            "{}, {}, limit {}: the residual {verdict} with the step ({}).",
            mesh.id,
            first.label,
            first.limit,
            listed.join(", ")
        ))
    };
    facts.meshes.iter().filter_map(sentence).collect()
}

fn spins(facts: &Facts) -> Option<String> {
    let greatest = facts.spins.iter().map(|spin| spin.momentum_change).reduce(f64::max)?;
    let corrected = || facts.spins.iter().filter(|spin| spin.limit.is_some());
    let least = corrected().map(|spin| spin.angular_momentum_left).reduce(f64::min)?;
    let most = corrected().map(|spin| spin.angular_momentum_left).reduce(f64::max)?;
    let energy = corrected().map(|spin| spin.energy_left).reduce(f64::min)?;
    let is_kept = if greatest < ROUND_OFF { ", which is round-off" } else { "" };
    Some(format!(
        "Free sheets that spin: a correction changes the momentum by {} of mass times edge speed at most{is_kept}. Of the angular momentum, \
         which is theirs to keep, corrected sheets have {} to {} left after a second, of the energy {} at least.",
        short(greatest),
        short(least),
        short(most),
        short(energy)
    ))
}

fn sweeps(facts: &Facts) -> Option<String> {
    let listed: Vec<_> = facts
        .sweeps
        .iter()
        .filter_map(|run| {
            let met = run.elongation.iter().position(|left| *left <= run.limit * (1.0 + DEPENDS));
            let met = match met {
                Some(n) => format!("the limit is met within 1 % by {} sweeps", run.sweeps[n]),
                None => {
                    format!(
                        "{} are left after {}",
                        short(*run.elongation.last()?),
                        run.sweeps.last()?
                    )
                }
            };
            Some(format!(
                "{}, limit {}, {}: from {}, one sweep leaves {}, {met}",
                run.mesh,
                run.limit,
                run.order,
                short(run.before),
                short(*run.elongation.first()?)
            ))
        })
        .collect();
    (!listed.is_empty())
        .then(|| format!("Convergence of sweeps, greatest elongation left: {}.", listed.join("; ")))
}

fn diverged(facts: &Facts) -> Option<String> {
    let list: Vec<_> = facts
        .rows
        .iter()
        .filter(|row| row.verdict != Verdict::Completed)
        .map(|row| format!("{} {} {} {}", row.mesh, row.label, row.limit, row.order))
        .collect();
    (!list.is_empty()).then(|| format!("Diverged: {}.", list.join("; ")))
}
