//! The words of the study `rest`: its question, and the findings from its numbers.

use super::facts::{Facts, RIGHT, Run, Scene, THERE, TIE};
use crate::studies::names::{count, labels, methods, range, theirs, told, verb};
use drape_report::number::significant;
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which method brings a cloth to rest on a table first, and in \
                                   the right shape?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["locking", "animation"];

/// The findings that the facts support. Times belong to a machine, so only figures show them.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion: Vec<_> = [longest(facts), priced(facts)].into_iter().flatten().collect();
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

/// The cheapest form on the scene for which prices hold.
fn priced(facts: &Facts) -> Option<String> {
    let scene = facts.scenes.iter().find(|scene| scene.is_priced)?;
    let right = || runs(facts, scene).filter(|run| run.is_right());
    let mut all: Vec<(&Run, f64)> =
        right().filter_map(|run| Some((run, run.modelled_s?))).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (first, least) = *all.first()?;
    let ties = all.iter().filter(|(run, time)| *time <= TIE * least && run.label != first.label);
    let ties = forms(ties.map(|(run, _)| *run));
    let tied = match ties.as_slice() {
        [] => "no other form ties".to_owned(),
        [_] => "1 other form ties".to_owned(),
        ties => format!("{} other forms tie", ties.len()),
    };
    let what = methods(&[&first.label]);
    Some(format!(
        "On the square table, {what} is first with {} ms of modelled time; {tied}.",
        significant(1e3 * least, 2)
    ))
}

/// How many runs end in a wrong shape.
fn shapes(facts: &Facts) -> Option<String> {
    let came: Vec<&Run> = facts.runs.iter().filter(|run| run.arrival_s.is_some()).collect();
    let wrong = came.iter().filter(|run| run.verdict == Verdict::Stable && !run.is_right());
    let wrong = wrong.count();
    (!came.is_empty()).then(|| {
        format!(
            "Of {} runs that come to rest, {wrong} {} in a shape whose energy is more than {} % \
             above the least known.",
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
    let gains = |run: &&Run| {
        let verdict = run.verdict;
        !run.is_limited
            && matches!(verdict, Verdict::Marginal | Verdict::Unstable | Verdict::Diverged)
    };
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
    vec![
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
    ]
}

#[cfg(test)]
mod tests {
    use super::super::facts::{Counters, Minimum};
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
            gain: 0.0,
            effort: Some(1.0),
            modelled_s: arrival_s.map(|_| modelled_s),
            counts: Counters::default(),
            portable: true,
        }
    }

    #[test]
    fn words_name_who_arrives_first_who_ties_and_who_stands_still() {
        let wrong = Run { excess_energy: Some(0.5), ..run("wrong", 1, Verdict::Stable, 0.5) };
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
        assert!(said.contains("`cheap` is first with 1000 ms"), "{said}");
        assert!(said.contains("1 other form ties."), "{said}");
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
