//! The words of the study `work-precision`: its question, and what its numbers say.

use super::facts::{
    FIXED_MATERIAL, FIXED_QUOTIENT, Facts, Row, STIFFNESS, Scene, Winner, cheapest, rows_of,
};
use crate::studies::short;
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "What does accuracy cost: which method is the cheapest for a given error, and how does that change with \
     stiffness, damping and size?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["order", "stability", "locking"];

/// Levels of error of which the findings speak.
const NAMED: [f64; 3] = [1e-1, 1e-2, 1e-3];

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    findings.extend(headline(facts));
    for (name, series) in series(facts) {
        findings.extend(winners(facts, &name, &series));
        if series.len() > 1 {
            findings.extend(turns(facts, &name, &series));
        }
    }
    findings.extend(absent(facts));
    findings.extend(reference(facts));
    findings
}

/// What the methods of the headline cost beside the cheapest, along the base series.
fn headline(facts: &Facts) -> Option<String> {
    const LEVEL: f64 = 1e-2;
    let said: Vec<_> = base(facts)
        .into_iter()
        .filter_map(|scene| {
            let rows = || rows_of(facts, &scene.id);
            let (best, least) = cheapest(rows(), LEVEL)?;
            let cost = |row: &Row| match cheapest(std::iter::once(row), LEVEL) {
                Some((_, run)) => format!("{} {}", row.label, short(run.effort / least.effort)),
                None => format!("{} not within its budget", row.label),
            };
            let costs: Vec<_> = rows().filter(|row| row.is_headline).map(cost).collect();
            let at = format!("k/m = {:e}", scene.stiffness_over_mass_per_s2);
            Some(format!("{at} (cheapest: {}): {}", best.label, costs.join(", ")))
        })
        .collect();
    (!said.is_empty()).then(|| {
        format!(
            "Counted effort for an error of {} on the lightly damped hanging sheet, over that of the cheapest method of all: {}.",
            percent(LEVEL),
            said.join("; ")
        )
    })
}

/// The series over the stiffness of the lightly damped hanging sheet.
fn base(facts: &Facts) -> Vec<&Scene> {
    let scenes = facts.scenes.iter();
    let is_base = |s: &&Scene| {
        s.scene == "hanging" && s.damping == "light" && s.series.iter().any(|s| s == STIFFNESS)
    };
    scenes.filter(is_base).collect()
}

/// Scenes along which one property varies, with what they have in common.
fn series(facts: &Facts) -> Vec<(String, Vec<&Scene>)> {
    let mut series: Vec<(String, Vec<&Scene>)> = Vec::new();
    for key in [STIFFNESS, FIXED_QUOTIENT, FIXED_MATERIAL] {
        for scene in facts.scenes.iter().filter(|scene| scene.series.iter().any(|s| s == key)) {
            let varied = if key == STIFFNESS { "" } else { &format!(", {key}") };
            let name = format!("{} sheet, {} damping{varied}", scene.scene, scene.damping);
            match series.iter_mut().find(|(known, _)| *known == name) {
                Some((_, scenes)) => scenes.push(scene),
                None => series.push((name, vec![scene])),
            }
        }
    }
    for (_, scenes) in &mut series {
        scenes.sort_by_key(|scene| scene.particles);
        if scenes.iter().any(|scene| scene.series.iter().any(|s| s == STIFFNESS))
            && is_stiffness(scenes)
        {
            let quotient = |scene: &&Scene| scene.stiffness_over_mass_per_s2;
            scenes.sort_by(|a, b| quotient(a).total_cmp(&quotient(b)));
        }
    }
    series
}

/// Whether the stiffness is what varies.
fn is_stiffness(scenes: &[&Scene]) -> bool {
    scenes.iter().all(|scene| scene.series.iter().any(|s| s == STIFFNESS))
}

/// Where a scene stands in its series.
fn place(series: &[&Scene], scene: &Scene) -> String {
    let quotient = format!("k/m = {:e}", scene.stiffness_over_mass_per_s2);
    if is_stiffness(series) { quotient } else { format!("n = {} ({quotient})", scene.particles) }
}

fn winner<'a>(facts: &'a Facts, scene: &Scene, level: f64) -> Option<&'a Winner> {
    facts.winners.iter().find(|winner| winner.scene == scene.id && winner.level == level)
}

fn percent(level: f64) -> String {
    format!("{} %", 100.0 * level)
}

/// Who wins along a series, at each level.
fn winners(facts: &Facts, name: &str, series: &[&Scene]) -> Option<String> {
    let said: Vec<_> = series
        .iter()
        .map(|scene| {
            let label = |level: &f64| {
                let label = winner(facts, scene, *level).and_then(|winner| winner.label.as_deref());
                label.unwrap_or("none").to_owned()
            };
            let labels: Vec<_> = NAMED.iter().map(label).collect();
            format!("{}: {}", place(series, scene), labels.join(" / "))
        })
        .collect();
    let levels = NAMED.map(percent).join(" / ");
    (!said.is_empty()).then(|| {
        format!("{name}, cheapest by counted effort for errors of {levels}: {}.", said.join("; "))
    })
}

/// Where along a series the winner turns from explicit to implicit or back.
fn turns(facts: &Facts, name: &str, series: &[&Scene]) -> Option<String> {
    let kind = |is_explicit: bool| if is_explicit { "explicit" } else { "implicit" };
    let said: Vec<_> = NAMED
        .iter()
        .filter_map(|&level| {
            let known = |scene: &&Scene| {
                let winner = winner(facts, scene, level)?;
                Some((place(series, scene), winner.is_explicit?))
            };
            let kinds: Vec<_> = series.iter().filter_map(known).collect();
            let (_, first) = kinds.first()?;
            let turns: Vec<_> = kinds
                .windows(2)
                .filter(|pair| pair[0].1 != pair[1].1)
                .map(|pair| format!("{} from {} on", kind(pair[1].1), pair[1].0))
                .collect();
            Some(if turns.is_empty() {
                format!("at {} all winners are {}", percent(level), kind(*first))
            } else {
                format!("at {} first {}, {}", percent(level), kind(*first), turns.join(", "))
            })
        })
        .collect();
    (!said.is_empty()).then(|| {
        format!(
            "{name}, where explicit and implicit methods (dop853 is explicit) change places: {}.",
            said.join("; ")
        )
    })
}

/// How many variants reach no useful error within their budget along the base series.
fn absent(facts: &Facts) -> Option<String> {
    let level = 1e-2;
    let misses = |row: &&Row| {
        let is_cut = row.runs.last().is_some_and(|run| run.verdict == Verdict::OverBudget);
        is_cut && cheapest(std::iter::once(*row), level).is_none()
    };
    let count = |scene: &&Scene| {
        let rows = || rows_of(facts, &scene.id);
        let at = format!("k/m = {:e}", scene.stiffness_over_mass_per_s2);
        format!("{at}: {} of {}", rows().filter(misses).count(), rows().count())
    };
    let said: Vec<_> = base(facts).iter().map(count).collect();
    (!said.is_empty()).then(|| {
        format!(
            "Variants that leave the budget before an error of {} on the lightly damped hanging sheet: {}.",
            percent(level),
            said.join("; ")
        )
    })
}

fn reference(facts: &Facts) -> Option<String> {
    let worst =
        facts.scenes.iter().max_by(|a, b| a.reference_error.total_cmp(&b.reference_error))?;
    Some(format!(
        "The references are off by at most {} of the motion ({}).",
        short(worst.reference_error),
        worst.id
    ))
}
