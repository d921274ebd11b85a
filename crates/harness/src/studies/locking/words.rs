//! The words of the study `locking`: its question, and what its numbers say.

use super::facts::{BACKWARD_EULER, BASE_STEP, BASE_STIFFNESS, Facts, IMEX_EULER, Run, Spring};
use crate::studies::short;
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "How much of its motion does a stiff cloth keep when the step is much longer than the periods of its \
     springs, and is what is lost what the law of locking says?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["cg-vs-stiffness", "stability"];

/// Greatest relative difference to the prototype, and half of its last digit, m, that confirm it.
const CONFIRMED: (f64, f64) = (0.01, 0.0006);

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    findings.extend(by_stiffness(facts));
    findings.extend(beside(facts));
    findings.extend(by_step(facts));
    findings.extend(terminal(facts));
    findings.extend(prototype(facts));
    findings.extend(recurrence(facts));
    findings.extend(directions(facts));
    findings.extend(failed(facts));
    let errors = facts.sheets.iter().map(|sheet| sheet.path_error_m / sheet.path_m);
    let error = errors.fold(0.0, f64::max);
    findings.push(format!(
        "The path of the true motion changes by at most {} % when the step of the reference is doubled.",
        short(100.0 * error)
    ));
    findings
}

fn labels(facts: &Facts) -> Vec<&str> {
    let mut labels = Vec::new();
    for run in &facts.runs {
        if !labels.contains(&run.label.as_str()) {
            labels.push(run.label.as_str());
        }
    }
    labels
}

fn of<'a>(facts: &'a Facts, label: &'a str) -> impl Iterator<Item = &'a Run> {
    facts.runs.iter().filter(move |run| run.label == label)
}

/// From which stiffness on a method stands still.
fn by_stiffness(facts: &Facts) -> Option<String> {
    let (mut locking, mut moving) = (Vec::new(), Vec::new());
    for label in labels(facts) {
        let runs: Vec<_> = of(facts, label).filter(|run| run.step_s == BASE_STEP).collect();
        match runs.iter().find(|run| run.verdict == Verdict::Locked) {
            Some(run) => {
                let retained = run.retained.unwrap_or_default();
                let k = run.stiffness_over_mass_per_s2;
                locking.push(format!("{label} {k:e} (R = {})", short(retained)));
            }
            None if runs.iter().any(|run| run.verdict == Verdict::Stable) => {
                moving.push(label.to_owned())
            }
            None => {}
        }
    }
    let also = if moving.is_empty() {
        String::new()
    } else {
        format!("; never, as far as they are stable: {}", moving.join(", "))
    };
    (!locking.is_empty()).then(|| {
        format!("Least k/m at which a method keeps less than half of the motion at h = {BASE_STEP} s: {}{also}.", locking.join(", "))
    })
}

/// Whether backward Euler's own damping explains what is lost.
fn beside(facts: &Facts) -> Option<String> {
    let standard: Vec<_> =
        of(facts, BACKWARD_EULER).filter(|run| run.step_s == BASE_STEP).collect();
    let least = standard.iter().filter_map(|run| run.retained).reduce(f64::min)?;
    let rest: Vec<_> = of(facts, IMEX_EULER)
        .filter(|run| run.step_s == BASE_STEP && run.verdict == Verdict::Locked)
        .filter_map(|run| {
            Some((run.stiffness_over_mass_per_s2, run.retained_beside_backward_euler?))
        })
        .map(|(k, share)| format!("{} at {k:e}", short(share)))
        .collect();
    (!rest.is_empty()).then(|| {
        format!(
            "It is not the damping of implicit steps: backward Euler at h = {BASE_STEP} s keeps at least {} of the true \
             motion; of its motion IMEX Euler keeps {}.",
            short(least),
            rest.join(", ")
        )
    })
}

/// What a smaller step helps.
fn by_step(facts: &Facts) -> Option<String> {
    let mut lines = Vec::new();
    for label in labels(facts) {
        let runs: Vec<_> = of(facts, label)
            .filter(|run| run.stiffness_over_mass_per_s2 == BASE_STIFFNESS)
            .filter(|run| run.verdict == Verdict::Stable || run.verdict == Verdict::Locked)
            .collect();
        let is_locking = runs.iter().any(|run| run.verdict == Verdict::Locked);
        let longest =
            runs.iter().filter(|run| run.verdict == Verdict::Stable).map(|run| run.step_s);
        if is_locking && runs.len() > 1 {
            let longest = longest.reduce(f64::max);
            let text = longest.map_or("none".to_owned(), |h| format!("{h} s"));
            lines.push(format!("{label} {text}"));
        }
    }
    (!lines.is_empty()).then(|| {
        format!("Longest of the tested steps at which half of the motion is kept at k/m = {BASE_STIFFNESS:e}: {}.", lines.join(", "))
    })
}

/// The late speed beside the law where the sheet creeps.
fn terminal(facts: &Facts) -> Option<String> {
    let text = |run: &Run| {
        let place = format!("{:e}", run.stiffness_over_mass_per_s2);
        Some(format!(
            "{} at {place} (R = {})",
            short(run.late_speed_m_s? / run.law_m_s),
            short(run.retained?)
        ))
    };
    let creeping: Vec<_> = of(facts, IMEX_EULER)
        .filter(|run| run.verdict == Verdict::Locked && run.step_s == BASE_STEP)
        .filter_map(text)
        .collect();
    let sheet = facts.sheets.first()?;
    (!creeping.is_empty()).then(|| {
        format!(
            "Late speed of IMEX Euler at h = {BASE_STEP} s over the terminal speed of the law, h L_k v = M g solved for this \
             sheet: {}. The law is that of a flat sheet: it is met the better the less the sheet has moved, since one that \
             sags is held up by its pins too. The lowest swing of a sheet held along a whole edge, which has often been taken, \
             gives u = 1/λ = (2N/π)² = {} for the speed a u/(h k/m); held at two corners the sheet has {}.",
            creeping.join(", "),
            short(sheet.swing_lever),
            short(sheet.lever)
        )
    })
}

/// The independent prototype beside the runs.
fn prototype(facts: &Facts) -> Option<String> {
    let (mut all, mut off, mut worst) = (0, 0, (0.0, String::new()));
    for run in &facts.runs {
        let Some((path, expected)) = run.path_m.zip(run.prototype_path_m) else { continue };
        all += 1;
        let difference = (path - expected).abs();
        if difference > (CONFIRMED.0 * expected).max(CONFIRMED.1) {
            off += 1;
            if difference / expected > worst.0 {
                let k = run.stiffness_over_mass_per_s2;
                let text = format!("{} at {k:e}: {} m ({expected} m)", run.label, short(path));
                worst = (difference / expected, text);
            }
        }
    }
    let but = if off == 0 { String::new() } else { format!("; farthest off is {}", worst.1) };
    (all > 0).then(|| {
        format!(
            "Paths beside those of an independent prototype, written before drape: {} of {all} agree within {} %{but}. How \
             the prototype damps its shear springs is not known.",
            all - off,
            100.0 * CONFIRMED.0
        )
    })
}

/// The exact law of a single spring.
fn recurrence(facts: &Facts) -> Option<String> {
    let exact = facts.springs.iter().filter_map(|spring| spring.recurrence_error);
    let worst = exact.reduce(f64::max)?;
    let closed = facts.springs.iter().map(|s| (s.speed_m_s / s.law_m_s - 1.0).abs());
    let closed = closed.fold(0.0, f64::max);
    let stiff = |label: &str| {
        let greatest = facts.springs.iter().filter(|s| s.label == label);
        greatest.max_by(|a, b| a.theta.total_cmp(&b.theta))
    };
    let text = |s: &Spring| {
        format!("{} {} of free fall at θ = {}", s.label, short(s.speed_m_s / s.free_m_s), s.theta)
    };
    let shares: Vec<_> = [IMEX_EULER, "imex-updated, 8 passes", "baraff-witkin", BACKWARD_EULER]
        .into_iter()
        .filter_map(stiff)
        .map(text)
        .collect();
    Some(format!(
        "A single spring: the recurrence of the angular momentum is met in every step within {}, the closed forms of the \
         speed within {} (deflection over length squared is not in them). After one second: {}.",
        short(worst),
        short(closed),
        shares.join(", ")
    ))
}

/// Whether coupling of the coordinates matters.
fn directions(facts: &Facts) -> Option<String> {
    let mut greatest: Option<f64> = None;
    for spring in &facts.springs {
        let other = facts.springs.iter().find(|other| {
            other.label == spring.label
                && other.theta == spring.theta
                && other.direction != spring.direction
        });
        let Some(other) = other else { continue };
        let difference = (spring.speed_m_s / other.speed_m_s - 1.0).abs();
        greatest = Some(greatest.map_or(difference, |value| value.max(difference)));
    }
    greatest.map(|difference| {
        format!(
            "The coordinates need not be coupled for a spring to lock: along x, where its exact Hessian is diagonal, every \
             method is as fast as on an oblique spring, within {}. What locks is the stiffness k across the spring, \
             which the matrix has and the Hessian has not; methods with the Hessian in the matrix fall freely in \
             both directions.",
            short(difference)
        )
    })
}

/// Runs that say nothing about locking.
fn failed(facts: &Facts) -> Option<String> {
    let mut lines = Vec::new();
    for verdict in [Verdict::Marginal, Verdict::Unstable, Verdict::Diverged, Verdict::OverBudget] {
        let runs: Vec<_> = facts.runs.iter().filter(|run| run.verdict == verdict).collect();
        let mut names: Vec<(&str, Vec<String>)> = Vec::new();
        for run in &runs {
            let place = if run.step_s == BASE_STEP {
                format!("{:e}", run.stiffness_over_mass_per_s2)
            } else {
                format!("h = {}", run.step_s)
            };
            match names.iter_mut().find(|(label, _)| *label == run.label) {
                Some((_, places)) => places.push(place),
                None => names.push((&run.label, vec![place])),
            }
        }
        let names: Vec<_> = names
            .iter()
            .map(|(label, places)| format!("{label} ({})", places.join(", ")))
            .collect();
        if !names.is_empty() {
            lines.push(format!("{verdict}: {}", names.join(", ")));
        }
    }
    (!lines.is_empty()).then(|| {
        format!(
            "Runs whose motion is no success and no locking, with their k/m or h in brackets: {}.",
            lines.join("; ")
        )
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn spring(direction: &str, speed: f64) -> Spring {
        Spring {
            label: IMEX_EULER.to_owned(),
            method: IMEX_EULER.to_owned(),
            direction: direction.to_owned(),
            theta: 10.0,
            step_s: 0.01,
            steps: 100,
            load_m_s2: 1e-3,
            speed_m_s: speed,
            law_m_s: 1e-6,
            recurrence_error: Some(1e-14),
            free_m_s: 1e-3,
            portable: true,
        }
    }

    #[test]
    fn the_finding_on_directions_follows_the_difference() {
        let facts = |speed| Facts {
            sheets: Vec::new(),
            runs: Vec::new(),
            springs: vec![spring("along x", 1e-6), spring("oblique", speed)],
        };
        assert!(directions(&facts(1e-6)).unwrap().contains("within 0."));
        assert!(directions(&facts(2e-6)).unwrap().contains("within 1.00"));
        assert!(directions(&Facts { springs: Vec::new(), ..facts(1.0) }).is_none());
    }
}
