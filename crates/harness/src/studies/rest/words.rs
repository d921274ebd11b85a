//! The words of the study `rest`: its question, and what its numbers say.

use super::facts::{Facts, Run, Scene, THERE, TIE};
use drape_report::number::significant;
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "Who brings a cloth to rest on a table first, and to the right \
                                   shape?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["locking", "animation"];

/// Most names in a sentence.
const MOST: usize = 8;

/// What the facts say. Times belong to a machine and stand in the figures.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion: Vec<_> = [longest(facts), priced(facts)].into_iter().flatten().collect();
    let observations = [shapes(facts), still(facts), open(facts), failing(facts), never(facts)];
    Words {
        conclusion: conclusion.join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats(facts),
    }
}

fn runs<'a>(facts: &'a Facts, scene: &'a Scene) -> impl Iterator<Item = &'a Run> + Clone {
    facts.runs.iter().filter(move |run| run.scene == scene.id)
}

/// Labels of runs, each once, in the record's order.
fn labels<'a>(runs: impl Iterator<Item = &'a Run>) -> Vec<&'a str> {
    let mut labels: Vec<&str> = Vec::new();
    for run in runs {
        if !labels.contains(&run.label.as_str()) {
            labels.push(&run.label);
        }
    }
    labels
}

/// Names in a row, the first few by name.
fn listed(names: &[&str]) -> String {
    match names {
        [] => "none".to_owned(),
        names if names.len() > MOST => {
            format!("{} and {} more", names[..MOST].join("; "), names.len() - MOST)
        }
        names => names.join("; "),
    }
}

/// Who arrives everywhere with the longest step.
fn longest(facts: &Facts) -> Option<String> {
    let arrives = |label: &&str| {
        facts.scenes.iter().all(|scene| {
            runs(facts, scene).any(|run| run.label == **label && run.steps == 1 && run.is_right())
        })
    };
    let all = labels(facts.runs.iter());
    let names: Vec<_> = all.iter().copied().filter(|label| arrives(label)).collect();
    let count = all.len();
    Some(match names.len() {
        0 if count == 0 => return None,
        0 => format!("With steps of 0.1 s none of {count} forms comes to rest on every table."),
        n => format!(
            "With steps of 0.1 s {n} of {count} forms come to rest in a right shape on every \
             table: {}.",
            listed(&names)
        ),
    })
}

/// Who is first where prices hold.
fn priced(facts: &Facts) -> Option<String> {
    let scene = facts.scenes.iter().find(|scene| scene.is_priced)?;
    let right = || runs(facts, scene).filter(|run| run.is_right());
    let mut all: Vec<(&Run, f64)> =
        right().filter_map(|run| Some((run, run.modelled_s?))).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (first, least) = *all.first()?;
    let ties = all.iter().filter(|(run, time)| *time <= TIE * least && run.label != first.label);
    let ties = labels(ties.map(|(run, _)| *run));
    let tied = if ties.is_empty() {
        "nobody ties".to_owned()
    } else {
        format!("with a tie of {}", listed(&ties))
    };
    Some(format!(
        "On the {} the least modelled time is that of {} with {} steps in 0.1 s, {} ms: {tied}.",
        scene.id,
        first.label,
        first.steps,
        significant(1e3 * least, 2)
    ))
}

/// How many shapes there are, and who finds a wrong one.
fn shapes(facts: &Facts) -> Option<String> {
    let came: Vec<&Run> = facts.runs.iter().filter(|run| run.arrival_s.is_some()).collect();
    let wrong = came.iter().filter(|run| run.verdict == Verdict::Stable && !run.is_right());
    let (wrong, count) = (wrong.count(), came.len());
    (count > 0).then(|| {
        format!(
            "Of {count} runs that come to rest {wrong} do so without a gain of energy in a shape \
             that another surpasses by more than a hundredth of the energy set free."
        )
    })
}

fn with(facts: &Facts, verdict: Verdict) -> Vec<&str> {
    labels(facts.runs.iter().filter(|run| run.verdict == verdict))
}

/// Forms that stand still elsewhere.
fn still(facts: &Facts) -> Option<String> {
    let names = with(facts, Verdict::Locked);
    (!names.is_empty()).then(|| {
        format!(
            "Forms that come less than half of their way on some table with some step: {} ({}).",
            names.len(),
            listed(&names)
        )
    })
}

/// Forms that still move at the end.
fn open(facts: &Facts) -> Option<String> {
    let names = with(facts, Verdict::Open);
    (!names.is_empty()).then(|| {
        format!(
            "Forms that are on their way when their time is over: {} ({}).",
            names.len(),
            listed(&names)
        )
    })
}

/// Forms that gain energy although stiffness does not limit them.
fn failing(facts: &Facts) -> Option<String> {
    let gains = |run: &&Run| {
        let verdict = run.verdict;
        !run.is_limited
            && matches!(verdict, Verdict::Marginal | Verdict::Unstable | Verdict::Diverged)
    };
    let names = labels(facts.runs.iter().filter(gains));
    (!names.is_empty()).then(|| {
        format!("Forms that gain energy on the way: {} ({}).", names.len(), listed(&names))
    })
}

/// Forms that arrive nowhere.
fn never(facts: &Facts) -> Option<String> {
    let arrives = |label: &str| facts.runs.iter().any(|run| run.label == label && run.is_right());
    let all = labels(facts.runs.iter());
    let never: Vec<_> = all.into_iter().filter(|label| !arrives(label)).collect();
    (!never.is_empty()).then(|| format!("No step that was tried suits {}.", listed(&never)))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let spans = facts.scenes.iter().map(|scene| scene.span_s).fold(0.0, f64::max);
    vec![
        format!(
            "A run has at most {} simulated seconds, and an arrival is known to 0.1 s and {} mm.",
            spans,
            significant(1e3 * THERE, 2)
        ),
        "Air or full damping brings the cloth to rest; with other damping other methods are first."
            .to_owned(),
        "The table is a held part of the cloth, so that the static search sees all forces."
            .to_owned(),
        "Methods that stiffness does not limit have two steps, 0.1 s and a third of it: one that \
         fails with both may do with shorter ones."
            .to_owned(),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::facts::Minimum;
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
            minima: vec![Minimum { waves: 2, energy_j: -1.0, residual: 0.0, is_minimum: true }],
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
            excess_energy: Some(0.0),
            gain: 0.0,
            effort: Some(1.0),
            modelled_s: arrival_s.map(|_| modelled_s),
            force_evaluations: 1,
            matvecs: 1,
            factorisations: 0,
            unconverged_steps: 0,
            portable: true,
        }
    }

    #[test]
    fn words_name_who_arrives_first_who_ties_and_who_stands_still() {
        let wrong = Run { excess_energy: Some(0.5), ..run("wrong", 1, Verdict::Stable, 0.5) };
        let runs = vec![
            run("dear", 1, Verdict::Stable, 9.0),
            run("cheap", 2, Verdict::Stable, 1.0),
            run("near", 6, Verdict::Stable, 1.4),
            run("slow", 1, Verdict::Locked, 0.1),
            wrong,
        ];
        let words = words(&Facts { scenes: vec![scene()], runs });
        let said = &words.conclusion;
        assert!(said.contains("1 of 5 forms come to rest"), "{said}");
        assert!(said.contains("is that of cheap with 2 steps"), "{said}");
        assert!(said.contains("a tie of near."), "{said}");
        let said = words.observations.join("\n");
        assert!(said.contains("Of 4 runs that come to rest 1 do so"), "{said}");
        assert!(
            said.contains(
                "come less than half of their way on some table with some step: 1 (slow)"
            )
        );
        assert!(said.contains("No step that was tried suits slow; wrong."), "{said}");
    }
}
