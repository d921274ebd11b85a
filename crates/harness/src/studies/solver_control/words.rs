//! The words of the study `solver-control`: its question, and what its numbers say.

use super::facts::{Facts, PLAIN, Run};
use crate::studies::{gain, short};
use drape_report::Verdict;
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "What do variable forcing terms, saved Jacobians, adaptive steps and preconditioners save, \
     and at what error?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["work-precision"];

/// Runs of a series on a scene.
fn of<'a>(facts: &'a Facts, series: &str, scene: &str) -> Vec<&'a Run> {
    let fits = |run: &&Run| run.series == series && run.scene == scene;
    facts.runs.iter().filter(fits).collect()
}

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    crate::studies::first_leads(findings(facts))
}

pub(super) fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    for scene in &facts.scenes {
        let id = scene.id.as_str();
        findings.extend(forcing(&of(facts, "forcing", id), id));
        findings.extend(updates(&of(facts, "forcing", id), id));
        findings.extend(jacobians(&of(facts, "jacobian", id), id));
        findings.extend(preconditioners(&of(facts, "preconditioner", id), id));
        findings.extend(adaptive(&of(facts, "steps", id), id));
        findings.extend(locking(&of(facts, "steps", id), id));
    }
    let error = facts.scenes.iter().map(|scene| scene.reference_error_m).fold(0.0, f64::max);
    findings.push(format!("The references are off by at most {} m.", short(error)));
    findings
}

/// Eisenstat-Walker beside the constant terms, for Newton's inner CG.
fn forcing(runs: &[&Run], scene: &str) -> Option<String> {
    let mut constant: Vec<_> =
        runs.iter().filter(|run| run.label == "backward-euler" && run.value.is_some()).collect();
    constant.sort_by_key(|run| run.cg_iterations);
    let walker = runs.iter().find(|run| run.label == "backward-euler" && run.value.is_none())?;
    let (best, worst) = (constant.first()?, constant.last()?);
    let term = |run: &Run| short(run.value.unwrap_or_default());
    let mut all = constant.iter().chain([&walker]);
    let same = if all.all(|run| run.verdict == Verdict::Completed && run.unconverged_steps == 0) {
        " All solve to the same residual, so that the error is that of the method at any term."
    } else {
        ""
    };
    Some(format!(
        "{scene}, Newton with inner CG: Eisenstat-Walker takes {} CG iterations in {} Newton iterations; constant terms \
         take {} (ε = {}, {} Newton iterations) to {} (ε = {}, {}).{same}",
        walker.cg_iterations,
        walker.newton_iterations,
        best.cg_iterations,
        term(best),
        best.newton_iterations,
        worst.cg_iterations,
        term(worst),
        worst.newton_iterations
    ))
}

/// The same for updated CG, and how loose a linear solve plain IMEX Euler stands.
fn updates(runs: &[&Run], scene: &str) -> Option<String> {
    let find = |label: &str| runs.iter().find(|run| run.label == label);
    let mut sentences = Vec::new();
    let updated = find("imex-updated, to the end").zip(find("imex-updated, Eisenstat-Walker"));
    if let Some((constant, walker)) = updated {
        sentences.push(format!(
            "Updated CG takes {} CG iterations in {} updates when each is solved to the end, {} in {} by Eisenstat-Walker.",
            constant.cg_iterations, constant.outer_passes, walker.cg_iterations, walker.outer_passes
        ));
    }
    let plain: Vec<_> = runs.iter().filter(|run| run.label == "imex-euler").collect();
    let (loosest, tightest) = (plain.first()?, plain.last()?);
    sentences.push(format!(
        "IMEX Euler at ε = {} takes {} CG iterations, with an error of {} and an energy gain of {}; at ε = {} {}, {} and {}.",
        short(loosest.value?),
        loosest.cg_iterations,
        error(loosest),
        gain(loosest.energy_gain_j),
        short(tightest.value?),
        tightest.cg_iterations,
        error(tightest),
        gain(tightest.energy_gain_j)
    ));
    Some(format!("{scene}: {}", sentences.join(" ")))
}

fn error(run: &Run) -> String {
    run.error.map_or_else(|| run.verdict.to_string(), short)
}

fn jacobians(runs: &[&Run], scene: &str) -> Option<String> {
    let lines: Vec<_> = runs
        .iter()
        .map(|run| {
            format!(
                "{}: {} factorisations, {} Newton and {} CG iterations",
                run.label, run.factorisations, run.newton_iterations, run.cg_iterations
            )
        })
        .collect();
    let errors = runs.iter().filter(|run| run.label.starts_with("backward-euler"));
    let errors: Vec<f64> = errors.filter_map(|run| run.error).collect();
    let (least, greatest) =
        errors.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), e| (a.min(*e), b.max(*e)));
    (!lines.is_empty()).then(|| {
        format!(
            "{scene}, {}. The errors of the four forms of backward Euler differ by {} of themselves.",
            lines.join("; "),
            short((greatest - least) / greatest)
        )
    })
}

fn preconditioners(runs: &[&Run], scene: &str) -> Option<String> {
    let lines: Vec<_> =
        runs.iter().map(|run| format!("{} {}", run.label, run.cg_iterations)).collect();
    (!lines.is_empty()).then(|| {
        format!("{scene}, CG iterations of IMEX Euler by preconditioner: {}.", lines.join(", "))
    })
}

/// For each adaptive run that got there: the constant run with the nearest error that is not larger.
fn adaptive(runs: &[&Run], scene: &str) -> Option<String> {
    let mut lines = Vec::new();
    for run in runs.iter().filter(|run| run.is_adaptive && run.label != PLAIN) {
        let constant = runs.iter().filter(|other| {
            !other.is_adaptive
                && other.label == run.label
                && other.error.zip(run.error).is_some_and(|(a, b)| a <= b)
        });
        let cheapest = constant.min_by_key(|other| other.substeps);
        if let (Some(cheapest), Some(tolerance)) = (cheapest, run.value) {
            lines.push((
                run.work_sweeps as f64 / cheapest.work_sweeps as f64,
                format!(
                    "{} at tolerance {} ({} substeps, {} rejected, {} set-ups, error {}) does {} times the work of the \
                     constant step with an error of {} ({} steps)",
                    run.label,
                    short(tolerance),
                    run.substeps,
                    run.rejected,
                    run.setups + run.factorisations,
                    error(run),
                    short(run.work_sweeps as f64 / cheapest.work_sweeps as f64),
                    error(cheapest),
                    cheapest.substeps
                ),
            ));
        }
    }
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (best, worst) = (lines.first()?, lines.last()?);
    let cheaper = lines.iter().filter(|(ratio, _)| *ratio < 1.0).count();
    Some(format!(
        "{scene}: of {} adaptive runs that a constant step matches in error, {cheaper} do less work (weighed in \
         sweeps over the springs). Best: {}. Worst: {}.",
        lines.len(),
        best.1,
        worst.1
    ))
}

/// What the estimator of IMEX Euler sees.
fn locking(runs: &[&Run], scene: &str) -> Option<String> {
    let find = |label: &str, tolerance: f64| {
        let fits =
            |run: &&&Run| run.is_adaptive && run.label == label && run.value == Some(tolerance);
        runs.iter().find(fits).copied()
    };
    let plain = runs.iter().filter(|run| run.is_adaptive && run.label == PLAIN);
    let tolerance = plain.filter_map(|run| run.value).reduce(f64::min)?;
    let (plain, splitting) = (find(PLAIN, tolerance)?, find("imex-euler", tolerance)?);
    Some(format!(
        "{scene}: at tolerance {} IMEX Euler with the plain estimate takes {} substeps and is off by {} of the motion; with \
         the splitting error in the estimate it takes {} and is off by {}.",
        short(tolerance),
        plain.substeps,
        error(plain),
        splitting.substeps,
        error(splitting)
    ))
}
