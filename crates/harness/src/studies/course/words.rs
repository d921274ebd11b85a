//! The words of the study `course`: its question, and what its numbers say.

use super::facts::{Facts, Lesson, Run, Scene};
use super::lessons::Plan;
use crate::studies::short;
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "What could each method not do that the next one can, from explicit Euler to two-step IMEX, on one and \
     the same cloth?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &[];

/// Less of the motion than this is lost motion; [`LOCKED`] of it is standstill.
const MOVES: f64 = 0.9;
const LOCKED: f64 = 0.5;
/// A height that is off by more than this is worth a sentence, m.
const OFF: f64 = 0.05;
/// So much more stretch than in the true motion is worth a sentence.
const SLACK: f64 = 0.05;
const STABLE: Verdict = Verdict::Stable;

/// The lesson of the method called `name`: what its runs say, after the lesson before it.
pub(super) fn lesson(
    plan: &Plan,
    name: &str,
    runs: Vec<Run>,
    scenes: &[Scene],
    before: Option<&Lesson>,
) -> Lesson {
    let parts = runs.iter().zip(scenes).map(|(run, scene)| told(run, scene));
    Lesson {
        id: plan.id().to_owned(),
        title: name.to_owned(),
        method: plan.method.to_owned(),
        docs: plan.docs.to_owned(),
        idea: plan.idea.to_owned(),
        before: before.map(|before| lacking(before, scenes)),
        finding: format!("{}.", parts.collect::<Vec<_>>().join(". ")),
        runs,
    }
}

fn at(scene: &Scene) -> String {
    format!("k/m = {:e}/s²", scene.stiffness_over_mass_per_s2)
}

fn per_cent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

/// How a run that is not stable ended.
fn failure(run: &Run) -> String {
    match (run.verdict, run.energy_gain) {
        (Verdict::Diverged, _) => format!("it diverged after {} s", short(run.reached_s)),
        (Verdict::OverBudget, _) => format!("its budget ended after {} s", short(run.reached_s)),
        (verdict, Some(gain)) => format!("it is {verdict} (gains {} of E_ref)", per_cent(gain)),
        (verdict, None) => format!("it is {verdict}"),
    }
}

/// What one run shows.
fn told(run: &Run, scene: &Scene) -> String {
    let (Some(motion), Some(error), Some(stretch)) =
        (run.retained_motion, run.height_error_m, run.greatest_stretch)
    else {
        return format!("At {} {}", at(scene), failure(run));
    };
    let work = [
        (run.force_evaluations, "force evaluations"),
        (run.cg_iterations, "CG iterations"),
        (run.factorisations, "factorisations"),
    ];
    let work = work.into_iter().filter(|(count, _)| *count > 0);
    let work: Vec<_> = work.map(|(count, what)| format!("{count} {what}")).collect();
    format!(
        "At {} it is stable and keeps {} of the motion; the free edge is at most {} m off its true height, springs stretch by \
         up to {} (truly {}); {} steps took {}",
        at(scene),
        per_cent(motion),
        short(error),
        per_cent(stretch),
        per_cent(scene.greatest_stretch),
        run.steps,
        work.join(", ")
    )
}

/// What a method could not do, the gravest first: stay stable, move, keep its springs short, keep to the true motion, do
/// without much work.
fn lacking(lesson: &Lesson, scenes: &[Scene]) -> String {
    let parts: Vec<_> = lesson
        .runs
        .iter()
        .zip(scenes)
        .filter_map(|(run, scene)| Some(format!("{} at {}", shortcoming(run, scene)?, at(scene))))
        .collect();
    if parts.is_empty() {
        return format!("{} lacks nothing that these numbers show.", lesson.id);
    }
    format!("{}: {}.", lesson.id, parts.join("; "))
}

fn shortcoming(run: &Run, scene: &Scene) -> Option<String> {
    let (Some(motion), Some(error), Some(stretch)) =
        (run.retained_motion, run.height_error_m, run.greatest_stretch)
    else {
        return Some(failure(run));
    };
    if motion < LOCKED {
        return Some(format!(
            "it all but stands still (only {} of the motion is left)",
            per_cent(motion)
        ));
    }
    if stretch > scene.greatest_stretch + SLACK {
        let truly = per_cent(scene.greatest_stretch);
        return Some(format!("its springs stretch by {} (truly {truly})", per_cent(stretch)));
    }
    if motion < MOVES {
        return Some(format!("only {} of the motion is left", per_cent(motion)));
    }
    if run.factorisations > run.steps {
        return Some(format!(
            "it needs {} factorisations for {} steps",
            run.factorisations, run.steps
        ));
    }
    if run.force_evaluations > 2 * run.steps {
        return Some(format!(
            "it needs {} evaluations of the forces for {} steps",
            run.force_evaluations, run.steps
        ));
    }
    (error > OFF).then(|| format!("the free edge is up to {} m off its true height", short(error)))
}

/// The whole course in a few sentences.
/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    let Facts { scenes, lessons, .. } = facts;
    let names = |test: &dyn Fn(&Run) -> bool| {
        let chosen = lessons.iter().filter(|lesson| lesson.runs.iter().all(test));
        chosen.map(|lesson| lesson.id.as_str()).collect::<Vec<_>>().join(", ")
    };
    let stiffnesses: Vec<_> = scenes.iter().map(at).collect();
    let stiffnesses = stiffnesses.join(" and at ");
    let or_none = |list: String| if list.is_empty() { "none".to_owned() } else { list };
    findings.push(format!(
        "With steps of 0.01 s, which only leapfrog divides, these of {} methods are stable at {stiffnesses}: {}.",
        lessons.len(),
        or_none(names(&|run| run.verdict == STABLE))
    ));
    findings.push(format!(
        "Of them, these keep at least {} of the motion: {}.",
        per_cent(MOVES),
        or_none(names(&|run| run.retained_motion.is_some_and(|motion| motion >= MOVES)))
    ));
    for (n, scene) in scenes.iter().enumerate() {
        let runs = lessons.iter().filter_map(|lesson| Some((lesson, lesson.runs.get(n)?)));
        let moving = runs.filter(|(_, run)| run.retained_motion.is_some_and(|m| m >= MOVES));
        let mut moving: Vec<_> = moving.collect();
        moving.sort_by(|a, b| a.1.effort.total_cmp(&b.1.effort));
        let list: Vec<_> = moving
            .iter()
            .map(|(lesson, run)| format!("{} {}", lesson.id, short(1e-6 * run.effort)))
            .collect();
        if !list.is_empty() {
            findings.push(format!(
                "Work of those that move at {}, least first, in millions of visits of a spring: {}.",
                at(scene),
                list.join(", ")
            ));
        }
    }
    let errors = scenes.iter().map(|scene| scene.reference_error_m);
    findings.push(format!(
        "The true motion is known to {} m in the first second.",
        short(errors.fold(0.0, f64::max))
    ));
    findings
}
