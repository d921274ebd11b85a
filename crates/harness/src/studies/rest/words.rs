//! The words of the study `rest`: its question, and the findings from its numbers.

use super::facts::{Facts, RIGHT, Run, Scene, THERE};
use crate::studies::names::{count, labels, range, theirs, told, verb};
use drape_report::number::significant;
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which method brings a cloth to rest on a table first, and in \
                                   the right shape?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["locking", "animation"];

/// The findings that the facts support. Times belong to a machine, so only figures show them.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion: Vec<_> = [longest(facts), any_step(facts)].into_iter().flatten().collect();
    let observations = [shapes(facts), still(facts), failing(facts), shorter(facts), never(facts)];
    Words {
        conclusion: conclusion.join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats(facts),
    }
}

fn runs<'a>(facts: &'a Facts, scene: &'a Scene) -> impl Iterator<Item = &'a Run> + Clone {
    facts.runs.iter().filter(move |run| run.scene == scene.id)
}

/// The labels of some runs, each once.
fn forms<'a>(runs: impl Iterator<Item = &'a Run>) -> Vec<&'a str> {
    labels(runs.map(|run| run.label.as_str()))
}

/// The forms that arrive on every table with the longest step.
fn longest(facts: &Facts) -> Option<String> {
    let arrives = |label: &&str| {
        facts.scenes.iter().all(|scene| {
            runs(facts, scene).any(|run| run.label == **label && run.steps == 1 && run.is_right())
        })
    };
    let all = forms(facts.runs.iter());
    let names: Vec<_> = all.iter().copied().filter(|label| arrives(label)).collect();
    let known = count(all.len(), "form");
    Some(match names.len() {
        0 if all.is_empty() => return None,
        0 => format!(
            "With steps of 0.1 s, none of {known} comes to rest in a right shape on every table."
        ),
        n => format!(
            "With steps of 0.1 s, {n} of {known} {} to rest in a right shape on every table; {}.",
            verb(n, "comes", "come"),
            theirs(&names)
        ),
    })
}

/// How many forms come to rest on every table with some step, and how many on none. No time ranks
/// them here: measured times belong to a machine, and modelled times do not fit these scenes.
fn any_step(facts: &Facts) -> Option<String> {
    let all = forms(facts.runs.iter());
    let arrives = |label: &str, scene: &Scene| {
        runs(facts, scene).any(|run| run.label == label && run.is_right())
    };
    let tables = |label: &&&str| facts.scenes.iter().filter(|s| arrives(label, s)).count();
    let everywhere = all.iter().filter(|label| tables(label) == facts.scenes.len()).count();
    let nowhere = all.iter().filter(|label| tables(label) == 0).count();
    (!all.is_empty()).then(|| {
        format!(
            "With the best of the steps that were tried, {everywhere} {} so, and {nowhere} {} on no \
             table.",
            verb(everywhere, "does", "do"),
            verb(nowhere, "does", "do")
        )
    })
}

/// How many runs end in a wrong shape.
fn shapes(facts: &Facts) -> Option<String> {
    let came: Vec<&Run> = facts.runs.iter().filter(|run| run.arrival_s.is_some()).collect();
    let wrong = came.iter().filter(|run| run.verdict == Verdict::Stable && !run.is_right());
    let wrong = wrong.count();
    (!came.is_empty()).then(|| {
        format!(
            "Of {} runs that come to rest, {wrong} {} in a shape that no true motion reaches and \
             that is not the least known (energies within {} % count as one).",
            came.len(),
            verb(wrong, "ends", "end"),
            100.0 * RIGHT
        )
    })
}

fn with(facts: &Facts, verdict: Verdict) -> Vec<&str> {
    forms(facts.runs.iter().filter(|run| run.verdict == verdict))
}

/// The forms that lock on some scene.
fn still(facts: &Facts) -> Option<String> {
    let rest = "on at least one table, with less than half of the way";
    told(&with(facts, Verdict::Locked), ["locks", "lock"], rest)
}

/// The forms that gain energy although stiffness does not limit them.
fn failing(facts: &Facts) -> Option<String> {
    let gains = |run: &&Run| !run.is_limited && run.verdict.gains_energy();
    let gaining = forms(facts.runs.iter().filter(gains));
    let verbs = ["without a stiffness limit gains energy", "without a stiffness limit gain energy"];
    told(&gaining, verbs, "with at least one step")
}

/// How many steps the forms need that fail with the longest steps.
fn shorter(facts: &Facts) -> Option<String> {
    let least = |label: &str, scene: &Scene| {
        let right = runs(facts, scene).filter(|run| run.label == label && run.is_right());
        right.filter(|run| !run.is_limited).map(|run| run.steps).min()
    };
    let all = forms(facts.runs.iter().filter(|run| !run.is_limited));
    let needs = all.iter().flat_map(|label| facts.scenes.iter().map(|s| least(label, s)));
    let short: Vec<_> = needs.flatten().map(f64::from).filter(|&steps| steps > 3.0).collect();
    let steps = range(&short, |steps| steps.to_string())?;
    Some(format!(
        "In {} a form fails on a table with 1 and 3 steps in 0.1 s, but arrives with {steps}.",
        count(short.len(), "case")
    ))
}

/// The forms that never arrive in a right shape.
fn never(facts: &Facts) -> Option<String> {
    let arrives = |label: &str| facts.runs.iter().any(|run| run.label == label && run.is_right());
    let all = forms(facts.runs.iter());
    let never: Vec<_> = all.into_iter().filter(|label| !arrives(label)).collect();
    told(&never, ["reaches", "reach"], "a right shape with no step that was tried")
}

fn caveats(facts: &Facts) -> Vec<String> {
    let spans = facts.scenes.iter().map(|scene| scene.span_s).fold(0.0, f64::max);
    [doubtful(facts), several(facts)].into_iter().flatten().chain([
        format!(
            "A run lasts at most {} simulated seconds; a surface within {} mm of its rest shape \
             has arrived, and the time of arrival is known to 0.1 s.",
            spans,
            significant(1e3 * THERE, 2)
        ),
        "Air or full damping brings the cloth to rest; with other damping, other methods may be \
         first."
            .to_owned(),
        "The table is a held part of the cloth, so that the static search sees all forces."
            .to_owned(),
        "The least energy that is known may not be the least.".to_owned(),
    ])
    .collect()
}

/// How many true motions do not tell where the cloth comes to rest.
fn doubtful(facts: &Facts) -> Option<String> {
    let motions = facts.scenes.iter().flat_map(|scene| &scene.motions);
    let all = motions.clone().count();
    let open = motions.filter(|motion| !motion.is_converged).count();
    (open > 0).then(|| {
        format!(
            "{open} of {all} true motions {} not count, because their steps lead to different \
             minima or to none in time.",
            verb(open, "does", "do")
        )
    })
}

/// The tables on which true motions end in other minima than the least known.
fn several(facts: &Facts) -> Option<String> {
    let has_other =
        |scene: &&Scene| scene.accepted.iter().any(|accepted| accepted.excess_energy > RIGHT);
    let count = facts.scenes.iter().filter(has_other).count();
    (count > 0).then(|| {
        format!(
            "On {count} of {} tables true motions end in minima whose energy is more than {} % \
             above the least known; these count as right, too.",
            facts.scenes.len(),
            100.0 * RIGHT
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::facts::{Accepted, Counters, End, Minimum, Motion};
    use super::*;

    fn scene() -> Scene {
        Scene {
            id: "s".to_owned(),
            particles: 4,
            springs: 4,
            is_priced: true,
            span_s: 2.0,
            limit_steps: 40,
            released_j: 1.0,
            prestress: 0.0,
            minima: vec![Minimum {
                from: "2 waves".to_owned(),
                energy_j: -1.0,
                residual: 0.0,
                is_minimum: true,
            }],
            motions: vec![Motion {
                from: "true motion".to_owned(),
                ends: [(80, Some(-0.9)), (160, None)]
                    .map(|(steps, energy_j)| End { steps, energy_j })
                    .into(),
                is_converged: false,
            }],
            accepted: vec![Accepted {
                energy_j: -1.0,
                excess_energy: 0.0,
                from: vec!["2 waves".to_owned()],
            }],
            portable: true,
        }
    }

    fn run(label: &str, steps: u32, verdict: Verdict, modelled_s: f64) -> Run {
        let arrival_s = (verdict == Verdict::Stable).then_some(1.0);
        Run {
            scene: "s".to_owned(),
            label: label.to_owned(),
            method: label.to_owned(),
            steps,
            is_limited: false,
            verdict,
            arrival_s,
            shape_error_m: Some(1e-4),
            residual: Some(0.001),
            speed_m_s: Some(0.001),
            rest_energy_j: Some(-1.0),
            is_minimum: None,
            excess_energy: Some(0.0),
            reached_j: Some(-1.0),
            gain: 0.0,
            effort: Some(1.0),
            modelled_s: arrival_s.map(|_| modelled_s),
            counts: Counters::default(),
            portable: true,
        }
    }

    #[test]
    fn words_count_who_arrives_and_who_stands_still_and_rank_by_no_time() {
        let wrong = Run { reached_j: None, ..run("wrong", 1, Verdict::Stable, 0.5) };
        let runs = vec![
            run("dear", 1, Verdict::Stable, 9.0),
            run("cheap", 2, Verdict::Stable, 1.0),
            run("near", 3, Verdict::Stable, 1.4),
            run("slow", 1, Verdict::Locked, 0.1),
            run("short", 30, Verdict::Stable, 5.0),
            wrong,
        ];
        let words = words(&Facts { scenes: vec![scene()], runs });
        let said = &words.conclusion;
        assert!(said.contains("1 of 6 forms comes to rest"), "{said}");
        assert!(said.contains("4 do so, and 2 do on no table."), "{said}");
        assert!(!said.contains("time") && !said.contains("first"), "{said}");
        let caveats = words.caveats.join("\n");
        assert!(caveats.contains("1 of 1 true motions does not count"), "{caveats}");
        assert!(!caveats.contains("count as right, too"), "{caveats}");
        let said = words.observations.join("\n");
        assert!(said.contains("Of 5 runs that come to rest, 1 ends"), "{said}");
        assert!(said.contains("1 form locks on at least one table"), "{said}");
        assert!(said.contains("half of the way; its method is `slow`."), "{said}");
        assert!(said.contains("In 1 case a form fails on a table with 1 and 3 steps"), "{said}");
        let never = "2 forms reach a right shape with no step that was tried; their methods are \
                     `slow` and `wrong`.";
        assert!(said.contains(never), "{said}");
    }
}
