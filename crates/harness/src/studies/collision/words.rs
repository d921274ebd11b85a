//! The words of the study `collision`: its question, and what its numbers say.

use super::facts::{Bounce, Facts, POSITION, Row, TELEPORT, VELOCITY};
use crate::studies::short;
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "What do contacts by velocity constraints cost and leave, against altering or moving positions: \
     iterations, depth, energy, rebound?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["tables"];

/// EEH's severe increase: so many times the iterations.
const SEVERE: f64 = 2.0;
/// A rebound is met within this share.
const MET: f64 = 0.05;
/// Depth of a display that is none, m.
const SHOWN: f64 = 1e-12;

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    findings.extend(increases(facts));
    findings.extend(onset(facts));
    findings.extend(depths(facts));
    findings.extend(releases(facts));
    findings.extend(unstable(facts));
    findings.extend(restitution(facts));
    findings.extend(heights(facts));
    findings
}

/// A way out against the velocity constraint with the same method.
pub(super) struct Increase<'a> {
    pub(super) label: &'a str,
    pub(super) way_out: &'a str,
    /// Factor of the iterations a step in contact, and the scene, in rising order: where neither run gains energy.
    pub(super) by_scene: Vec<(f64, &'a str)>,
    /// Scenes where one of them does: runs that blow the sheet away cannot be compared by their iterations.
    pub(super) unstable: usize,
}

pub(super) fn factors(facts: &Facts) -> Vec<Increase<'_>> {
    let mut found: Vec<Increase<'_>> = Vec::new();
    for row in facts.rows.iter().filter(|row| row.way_out != VELOCITY) {
        let same = |other: &&Row| {
            other.scene == row.scene && other.label == row.label && other.way_out == VELOCITY
        };
        let Some(velocity) = facts.rows.iter().find(same) else { continue };
        if velocity.iterations_after == 0 {
            continue;
        }
        let (label, way_out) = (row.label.as_str(), row.way_out.as_str());
        let place = found.iter().position(|f| f.label == label && f.way_out == way_out);
        let place = place.unwrap_or_else(|| {
            found.push(Increase { label, way_out, by_scene: Vec::new(), unstable: 0 });
            found.len() - 1
        });
        if row.verdict == Verdict::Stable && velocity.verdict == Verdict::Stable {
            found[place].by_scene.push((row.rate() / velocity.rate(), &row.scene));
        } else {
            found[place].unstable += 1;
        }
    }
    for increase in &mut found {
        increase.by_scene.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    found
}

fn increases(facts: &Facts) -> Vec<String> {
    factors(facts)
        .iter()
        .filter_map(|Increase { label, way_out, by_scene, unstable }| {
            let (least, greatest) = (by_scene.first()?, by_scene.last()?);
            let severe: Vec<_> = by_scene
                .iter()
                .rev()
                .filter(|(factor, _)| *factor >= SEVERE)
                .map(|(factor, scene)| format!("{scene} ({})", short(*factor)))
                .collect();
            let where_severe = if severe.is_empty() {
                "nowhere twice as many".to_owned()
            } else {
                format!("twice as many or more on {}", severe.join(", "))
            };
            Some(format!(
                "{label}, {way_out} against velocity: the iterations a step in contact are {} ({}) to {} ({}) times as many, in \
                 the middle {}; {where_severe} ({} of {} scenes on which neither run gains energy; on {unstable} one does).",
                short(least.0),
                least.1,
                short(greatest.0),
                greatest.1,
                short(by_scene[by_scene.len() / 2].0),
                severe.len(),
                by_scene.len()
            ))
        })
        .collect()
}

/// Iterations in contact against those before.
fn onset(facts: &Facts) -> Option<String> {
    let mut labels: Vec<(&str, f64, f64, f64, f64)> = Vec::new();
    for row in facts.rows.iter().filter(|row| row.way_out == VELOCITY) {
        let (before, steps_before) = (row.iterations_before as f64, row.steps_before as f64);
        let (after, steps_after) = (row.iterations_after as f64, row.steps_after as f64);
        if after == 0.0 {
            continue;
        }
        match labels.iter_mut().find(|entry| entry.0 == row.label) {
            Some(entry) => {
                entry.1 += before;
                entry.2 += steps_before;
                entry.3 += after;
                entry.4 += steps_after;
            }
            None => labels.push((&row.label, before, steps_before, after, steps_after)),
        }
    }
    let text = |&(label, before, steps_before, after, steps_after): &(&str, f64, f64, f64, f64)| {
        format!(
            "{label} {} → {}",
            short(before / steps_before.max(1.0)),
            short(after / steps_after.max(1.0))
        )
    };
    let list: Vec<_> = labels.iter().map(text).collect();
    (!list.is_empty()).then(|| {
        format!(
            "Contact itself: iterations a step before the first contact → after it, with velocity constraints, over all \
             scenes: {}.",
            list.join(", ")
        )
    })
}

fn greatest<'a>(
    rows: impl Iterator<Item = &'a Row>,
    value: impl Fn(&Row) -> f64,
) -> Option<&'a Row> {
    rows.max_by(|a, b| value(a).total_cmp(&value(b)))
}

fn of<'a>(facts: &'a Facts, way_out: &'a str) -> impl Iterator<Item = &'a Row> {
    facts.rows.iter().filter(move |row| row.way_out == way_out)
}

fn depths(facts: &Facts) -> Option<String> {
    let worst: Vec<_> = [VELOCITY, POSITION, TELEPORT]
        .into_iter()
        .filter_map(|way_out| {
            let row = greatest(of(facts, way_out), |row| row.depth_over_reach)?;
            Some(format!(
                "{way_out} {} ({}, {}: {} m)",
                short(row.depth_over_reach),
                row.label,
                row.scene,
                short(row.depth_m)
            ))
        })
        .collect();
    let deepest = facts.rows.iter().map(|row| row.displayed_depth_m).fold(0.0, f64::max);
    let deeper = facts.rows.iter().filter(|row| row.depth_over_reach > 1.0).count();
    let shown = if deepest <= SHOWN {
        "Displayed by auxiliary particles on the surface, no run shows any depth".to_owned()
    } else {
        format!("Displayed by auxiliary particles, {} m are left", short(deepest))
    };
    (!worst.is_empty()).then(|| {
        format!(
            "Greatest depth over what the fastest particle covers in a step (v h): {}; {} of {} runs go deeper than v h. \
             {shown}.",
            worst.join(", "),
            deeper,
            facts.rows.len()
        )
    })
}

fn releases(facts: &Facts) -> Option<String> {
    let energy = |scene: &str| {
        let scene = facts.scenes.iter().find(|s| s.id == scene);
        scene.map_or(f64::INFINITY, |scene| scene.available_j)
    };
    let share = |row: &Row| row.release_j / energy(&row.scene);
    let worst: Vec<_> = [VELOCITY, POSITION, TELEPORT]
        .into_iter()
        .filter_map(|way_out| {
            let row = greatest(of(facts, way_out), share)?;
            Some(format!(
                "{way_out} {} % ({}, {}: {} J)",
                short(100.0 * share(row)),
                row.label,
                row.scene,
                short(row.release_j)
            ))
        })
        .collect();
    (!worst.is_empty()).then(|| {
        format!(
            "Energy of release, the sum of the rises in steps in which particles leave the obstacle, over the available \
             energy, at worst: {}.",
            worst.join(", ")
        )
    })
}

/// How many runs of each method and way out gain energy.
fn unstable(facts: &Facts) -> Option<String> {
    let mut counts: Vec<(String, usize, usize)> = Vec::new();
    for row in &facts.rows {
        let name = format!("{} {}", row.label, row.way_out);
        let gains = usize::from(row.verdict != Verdict::Stable);
        match counts.iter_mut().find(|(known, _, _)| *known == name) {
            Some((_, gaining, all)) => {
                *gaining += gains;
                *all += 1;
            }
            None => counts.push((name, gains, 1)),
        }
    }
    let list: Vec<_> = counts
        .iter()
        .filter(|(_, gaining, _)| *gaining > 0)
        .map(|(name, gaining, all)| format!("{name} {gaining} of {all}"))
        .collect();
    let none: Vec<_> = counts
        .iter()
        .filter(|(_, gaining, _)| *gaining == 0)
        .map(|(name, _, all)| format!("{name} ({all})"))
        .collect();
    (!counts.is_empty()).then(|| {
        format!(
            "Runs that gain more than 2 % of the available energy: {}; none of: {}.",
            if list.is_empty() { "none".to_owned() } else { list.join(", ") },
            if none.is_empty() { "–".to_owned() } else { none.join(", ") }
        )
    })
}

/// Measured restitution less that of the obstacle.
fn miss(bounce: &Bounce) -> f64 {
    bounce.measured.map_or(f64::INFINITY, |measured| (measured - bounce.restitution).abs())
}

fn restitution(facts: &Facts) -> Option<String> {
    let worst = facts.bounces.iter().max_by(|a, b| miss(a).total_cmp(&miss(b)))?;
    let missed = facts.bounces.iter().filter(|bounce| miss(bounce) > MET).count();
    Some(format!(
        "Restitution, speed after over speed before the contact: {} of {} rebounds miss e by more than {MET}; the worst misses it \
         by {} ({} on {}, {} m/s, e = {}, {} {}).",
        missed,
        facts.bounces.len(),
        short(miss(worst)),
        worst.body,
        worst.obstacle,
        worst.speed_m_s,
        worst.restitution,
        worst.label,
        worst.way_out
    ))
}

/// How far a rebound is from the height of theory, relative to that.
fn height_error(bounce: &Bounce) -> Option<f64> {
    let (height, theory) = (bounce.height_m?, bounce.height_theory_m.filter(|h| *h > 0.0)?);
    Some((height - theory) / theory)
}

fn heights(facts: &Facts) -> Option<String> {
    let mut speeds: Vec<f64> = facts.bounces.iter().map(|bounce| bounce.speed_m_s).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let lines: Vec<_> = speeds
        .iter()
        .flat_map(|&speed| [VELOCITY, POSITION, TELEPORT].map(|way_out| (speed, way_out)))
        .filter_map(|(speed, way_out)| {
            let bounces = facts.bounces.iter();
            let errors: Vec<f64> = bounces
                .filter(|bounce| bounce.speed_m_s == speed && bounce.way_out == way_out)
                .filter_map(height_error)
                .collect();
            let low = errors.iter().copied().reduce(f64::min)?;
            let high = errors.iter().copied().reduce(f64::max)?;
            Some(format!("{speed} m/s, {way_out}: {:+.1} to {:+.1} %", 100.0 * low, 100.0 * high))
        })
        .collect();
    (!lines.is_empty()).then(|| {
        format!(
            "The height of a rebound depends on where within a step the surface is met; against e² of the fall it is off by: \
             {}.",
            lines.join("; ")
        )
    })
}
