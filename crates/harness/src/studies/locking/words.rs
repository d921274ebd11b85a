//! The words of the study `locking`: its question, and the findings from its numbers.

use super::facts::*;
use crate::studies::names::verb;
use drape_report::number::{percent, power, setting, significant};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "How much motion does a stiff cloth keep at long steps, and does \
     the law of locking predict the loss?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["cg-vs-stiffness", "stability"];

/// Two shares of the motion count as equal below this difference.
const EQUAL: f64 = 0.01;
/// Relative error of a speed below which it follows the law.
const LAWFUL: f64 = 0.01;
/// Relative error below which a recurrence holds to round-off.
const ROUND_OFF: f64 = 1e-12;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion = [plain(facts), updated(facts), terminal(facts)];
    let mut conclusion: Vec<_> = conclusion.into_iter().flatten().collect();
    if conclusion.is_empty() {
        conclusion.push("The record holds no run of IMEX Euler at the base point.".to_owned());
    }
    let observations = [
        by_stiffness(facts),
        implicit(facts),
        by_step(facts),
        recurrence(facts),
        directions(facts),
    ];
    let caveats = [
        terminal(facts).map(|_| {
            "The law assumes a flat sheet; in a sheet that sags, the pins also carry weight."
                .to_owned()
        }),
        prototype(facts),
        failed(facts),
        reference(facts),
    ];
    Words {
        conclusion: conclusion.join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats.into_iter().flatten().collect(),
    }
}

fn of<'a>(facts: &'a Facts, label: &'a str) -> impl Iterator<Item = &'a Run> + Clone {
    facts.runs.iter().filter(move |run| run.label == label)
}

/// The run of a method at the base stiffness and step.
fn base<'a>(facts: &'a Facts, label: &'a str) -> Option<&'a Run> {
    of(facts, label)
        .find(|run| run.stiffness_over_mass_per_s2 == BASE_STIFFNESS && run.step_s == BASE_STEP)
}

/// The motion that IMEX Euler keeps.
fn plain(facts: &Facts) -> Option<String> {
    let run = base(facts, IMEX_EULER)?;
    let only = if run.verdict == Verdict::Locked { "is stable but keeps only" } else { "keeps" };
    Some(format!(
        "At k/m = {} s⁻² and h = {} s, IMEX Euler {only} {} of the motion of the cloth.",
        power(BASE_STIFFNESS),
        setting(BASE_STEP),
        percent(run.retained?, 2)
    ))
}

/// The motion that updated CG keeps.
fn updated(facts: &Facts) -> Option<String> {
    let updated = base(facts, UPDATED)?.retained?;
    let beside = base(facts, BACKWARD_EULER).and_then(|run| run.retained).map(|implicit| {
        if (updated - implicit).abs() < EQUAL {
            ", as much as backward Euler".to_owned()
        } else {
            format!("; backward Euler keeps {}", percent(implicit, 2))
        }
    });
    Some(format!(
        "With updated, safeguarded CG, it keeps {}{}.",
        percent(updated, 2),
        beside.unwrap_or_default()
    ))
}

/// The late speed of the stiffest locked sheet, against the law.
fn terminal(facts: &Facts) -> Option<String> {
    let locked = of(facts, IMEX_EULER).filter(|run| run.verdict == Verdict::Locked);
    let locked = locked.filter(|run| run.step_s == BASE_STEP);
    let stiffest = locked
        .max_by(|a, b| a.stiffness_over_mass_per_s2.total_cmp(&b.stiffness_over_mass_per_s2))?;
    let ratio = stiffest.late_speed_m_s? / stiffest.law_m_s;
    let k = power(stiffest.stiffness_over_mass_per_s2);
    let off = (ratio - 1.0).abs();
    Some(if off < LAWFUL {
        format!(
            "At {k} s⁻², the sheet of IMEX Euler falls at the speed of the law of locking, within \
             {}.",
            percent(off, 2)
        )
    } else {
        format!(
            "At {k} s⁻², the sheet of IMEX Euler falls at {} times the speed of the law of \
             locking.",
            significant(ratio, 3)
        )
    })
}

/// How many variants lock, and from which stiffness on.
fn by_stiffness(facts: &Facts) -> Option<String> {
    let firsts = first_locked(facts);
    let stable = |run: &&Run| matches!(run.verdict, Verdict::Stable | Verdict::Locked);
    let labels: std::collections::BTreeSet<_> =
        facts.runs.iter().filter(stable).map(|run| run.label.as_str()).collect();
    let least = firsts.first().map(|run| power(run.stiffness_over_mass_per_s2));
    let first = least.map_or_else(String::new, |k| format!(", the first at k/m = {k} s⁻²"));
    (!labels.is_empty()).then(|| {
        format!(
            "At h = {} s, {} of {} variants that ran stably {} at some stiffness{first}.",
            setting(BASE_STEP),
            firsts.len(),
            labels.len(),
            verb(firsts.len(), "locks", "lock")
        )
    })
}

/// Whether the damping of implicit steps explains the loss of motion.
fn implicit(facts: &Facts) -> Option<String> {
    base(facts, IMEX_EULER).filter(|run| run.verdict == Verdict::Locked)?;
    let runs = of(facts, BACKWARD_EULER).filter(|run| run.step_s == BASE_STEP);
    let least = runs.filter_map(|run| run.retained).reduce(f64::min)?;
    let explains = if least > 0.5 { "does not explain" } else { "may explain" };
    Some(format!(
        "The damping of implicit steps {explains} the loss: backward Euler keeps at least {} at \
         every stiffness.",
        percent(least, 2)
    ))
}

/// The longest step at which IMEX Euler keeps half of the motion.
fn by_step(facts: &Facts) -> Option<String> {
    let runs = of(facts, IMEX_EULER).filter(|r| r.stiffness_over_mass_per_s2 == BASE_STIFFNESS);
    let moving = runs.clone().filter(|run| run.verdict == Verdict::Stable).map(|run| run.step_s);
    let at = format!("At k/m = {} s⁻²", power(BASE_STIFFNESS));
    (runs.count() > 1).then(|| match moving.reduce(f64::max) {
        Some(h) => format!(
            "{at} IMEX Euler keeps half of the motion up to h = {} s, of the steps that were run.",
            setting(h)
        ),
        None => format!("{at} IMEX Euler keeps half of the motion at no step that was run."),
    })
}

/// Whether a single spring satisfies its exact law.
fn recurrence(facts: &Facts) -> Option<String> {
    let exact = facts.springs.iter().filter_map(|spring| spring.recurrence_error);
    let worst = exact.reduce(f64::max)?;
    let closed = facts.springs.iter().map(|s| (s.speed_m_s / s.law_m_s - 1.0).abs());
    let met = if worst < ROUND_OFF { "meets" } else { "misses" };
    Some(format!(
        "A single spring {met} its exact recurrence, within {}, and the closed forms of its speed \
         within {}.",
        significant(worst, 2),
        significant(closed.fold(0.0, f64::max), 2)
    ))
}

/// Whether the coupling of coordinates matters.
fn directions(facts: &Facts) -> Option<String> {
    let differences = facts.springs.iter().filter_map(|spring| {
        let other = facts.springs.iter().find(|other| {
            other.label == spring.label
                && other.theta == spring.theta
                && other.direction != spring.direction
        })?;
        Some((spring.speed_m_s / other.speed_m_s - 1.0).abs())
    });
    let greatest = differences.reduce(f64::max)?;
    let within = significant(greatest, 2);
    Some(if greatest < EQUAL {
        format!(
            "A spring along x locks like an oblique one, within {within}: locking needs no \
             coupling of coordinates."
        )
    } else {
        format!("A spring along x and an oblique one lock differently, by up to {within}.")
    })
}

/// Agreement with the independent prototype.
fn prototype(facts: &Facts) -> Option<String> {
    let all: Vec<_> = facts.runs.iter().filter_map(agrees_with_prototype).collect();
    (!all.is_empty()).then(|| {
        format!(
            "An independent prototype agrees in {} of {} paths; its damping of shear springs is \
             unknown.",
            all.iter().filter(|agrees| **agrees).count(),
            all.len()
        )
    })
}

/// Number of runs that show nothing about locking.
fn failed(facts: &Facts) -> Option<String> {
    let said = |run: &&Run| !matches!(run.verdict, Verdict::Stable | Verdict::Locked);
    let failed = facts.runs.iter().filter(said).count();
    (failed > 0).then(|| {
        format!(
            "{failed} of {} runs {} not stable: such motion is neither success nor locking.",
            facts.runs.len(),
            verb(failed, "was", "were")
        )
    })
}

fn reference(facts: &Facts) -> Option<String> {
    let errors = facts.sheets.iter().map(|sheet| sheet.path_error_m / sheet.path_m);
    errors.reduce(f64::max).map(|error| {
        format!(
            "The true path changes by at most {} with twice the step of the reference.",
            percent(error, 2)
        )
    })
}

#[cfg(test)]
mod tests;
