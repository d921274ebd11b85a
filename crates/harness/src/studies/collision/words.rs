//! The words of the study `collision`: its question, and the findings from its numbers.

use super::facts::{Bounce, Facts, Increase, POSITION, SEVERE, TELEPORT, VELOCITY, factors};
use crate::studies::names::{count, verb};
use drape_report::number::{setting, significant};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "Does the velocity constraint resolve contacts with fewer \
                                   iterations and less energy gain than altering positions?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["tables"];

/// Largest difference from the obstacle's restitution at which a rebound meets it.
const MET: f64 = 0.05;
/// Largest displayed depth that counts as none, m.
const SHOWN: f64 = 1e-12;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let factors = factors(facts);
    let conclusion: Vec<_> = [iterations(&factors), energy(facts)].into_iter().flatten().collect();
    let conclusion = match &conclusion[..] {
        [] => "No run met an obstacle.".to_owned(),
        sentences => sentences.join(" "),
    };
    let observations = [
        range(&factors, POSITION, "Altering positions within the step"),
        range(&factors, TELEPORT, "Moving particles by hand"),
        onset(facts),
        depth(facts),
        rebounds(facts),
    ];
    let observations = observations.into_iter().flatten().collect();
    Words { conclusion, observations, caveats: caveats(facts, &factors) }
}

fn percent(part: usize, all: usize) -> String {
    format!("{} %", significant(100.0 * part as f64 / all.max(1) as f64, 2))
}

/// How often the iterations increase severely, as the paper says.
fn iterations(factors: &[Increase<'_>]) -> Option<String> {
    let all: Vec<f64> =
        factors.iter().flat_map(|f| &f.by_scene).map(|(factor, _)| *factor).collect();
    let severe = all.iter().filter(|factor| **factor >= SEVERE).count();
    let what = "Altering or moving positions";
    let than = "the iterations of the velocity constraint";
    (!all.is_empty()).then(|| match severe {
        0 => format!("{what} nowhere doubles {than}."),
        n => {
            let only = if 2 * n < all.len() { "only " } else { "" };
            let share = percent(n, all.len());
            format!(
                "{what} at least doubles {than} in {only}{share} of the runs that can be compared."
            )
        }
    })
}

/// Number of runs of a way out that gain energy, and number of all its runs.
fn gaining(facts: &Facts, way_out: &str) -> (usize, usize) {
    let own = || facts.rows.iter().filter(|row| row.way_out == way_out);
    (own().filter(|row| row.verdict != Verdict::Stable).count(), own().count())
}

fn energy(facts: &Facts) -> Option<String> {
    let ((moved, all_moved), (constrained, all)) =
        (gaining(facts, TELEPORT), gaining(facts, VELOCITY));
    let is_harm = moved * all > constrained * all_moved;
    let harm = if is_harm {
        "Moving particles by hand adds energy"
    } else {
        "Moving particles by hand adds energy no more often than the constraint"
    };
    (all_moved > 0 && all > 0).then(|| {
        format!(
            "{harm}: {} of those runs gain some, against {} with the constraint.",
            percent(moved, all_moved),
            percent(constrained, all)
        )
    })
}

/// Range of the factors of a way out, over all methods.
fn range(factors: &[Increase<'_>], way_out: &str, what: &str) -> Option<String> {
    let own = factors.iter().filter(|factor| factor.way_out == way_out);
    let all: Vec<f64> = own.flat_map(|f| &f.by_scene).map(|(factor, _)| *factor).collect();
    let least = all.iter().copied().reduce(f64::min)?;
    let most = all.iter().copied().reduce(f64::max)?;
    Some(format!(
        "{what} takes {} to {} times the iterations of the constraint ({}).",
        significant(least, 2),
        significant(most, 3),
        count(all.len(), "run")
    ))
}

/// Iterations in contact over those before, for the methods with the least and the greatest factor.
fn onset(facts: &Facts) -> Option<String> {
    let rises = facts.onsets();
    let least = rises.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let most = rises.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "With the constraint, a step in contact takes {} ({}) to {} times ({}) the iterations of a \
         step before.",
        significant(least.1, 2),
        least.0,
        significant(most.1, 2),
        most.0
    ))
}

fn depth(facts: &Facts) -> Option<String> {
    let deeper = facts.rows.iter().filter(|row| row.depth_over_reach > 1.0).count();
    let shown = facts.rows.iter().map(|row| row.displayed_depth_m).reduce(f64::max)?;
    let shown = if shown <= SHOWN {
        "no depth is visible".to_owned()
    } else {
        format!("a depth of up to {} m is visible", significant(shown, 2))
    };
    let deeper = match deeper {
        0 => "No particle penetrates".to_owned(),
        n => format!("In {n} of {}, a particle penetrates", count(facts.rows.len(), "run")),
    };
    Some(format!(
        "{deeper} deeper than the fastest one moves in a step; with auxiliary particles, {shown}."
    ))
}

fn rebounds(facts: &Facts) -> Option<String> {
    let missed = facts.bounces.iter().filter(|bounce| bounce.miss() > MET).count();
    let errors = facts.bounces.iter().filter_map(Bounce::height_error).map(f64::abs);
    let height = errors.reduce(f64::max)?;
    let speeds = match missed {
        0 => {
            let all = facts.bounces.len();
            format!("{all} of {all} rebounds meet the restitution within {MET}")
        }
        n => format!(
            "{n} of {} rebounds {} the restitution by more than {MET}",
            facts.bounces.len(),
            verb(n, "misses", "miss")
        ),
    };
    Some(format!(
        "{speeds}; heights are off by up to {} %, because particles meet the surface within a \
         step.",
        significant(100.0 * height, 2)
    ))
}

fn caveats(facts: &Facts, factors: &[Increase<'_>]) -> Vec<String> {
    let left_out: usize = factors.iter().map(|factor| factor.unstable).sum();
    let left_out = (left_out > 0).then(|| {
        format!(
            "{} {} not compared by iterations: the run or its partner gains energy.",
            count(left_out, "run"),
            verb(left_out, "is", "are")
        )
    });
    let particles = facts.scenes.first().map(|scene| {
        format!(
            "All sheets have {} particles and steps of at most {} s; finer ones were not run.",
            scene.particles,
            setting(facts.scenes.iter().map(|scene| scene.step_s).fold(0.0, f64::max))
        )
    });
    left_out.into_iter().chain(particles).collect()
}
