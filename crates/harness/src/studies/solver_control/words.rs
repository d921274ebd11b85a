//! The words of the study `solver-control`: its question, and the findings from its numbers.

use super::facts::{Facts, PLAIN, Run, Scene, inner, matched};
use crate::studies::names;
use drape_report::number::{setting, significant};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "What do variable forcing terms, saved Jacobians, adaptive \
                                   steps and preconditioners save, and at what error?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["work-precision"];

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion: Vec<_> = [adaptive(facts), forcing(facts)].into_iter().flatten().collect();
    let conclusion = match &conclusion[..] {
        [] => "No two runs can be compared.".to_owned(),
        sentences => sentences.join(" "),
    };
    let observations =
        [jacobians(facts), preconditioners(facts), updates(facts), loose(facts), splitting(facts)];
    let observations = observations.into_iter().flatten().collect();
    Words { conclusion, observations, caveats: caveats(facts) }
}

/// Runs of a series on a scene.
fn of<'a>(
    facts: &'a Facts,
    series: &'a str,
    scene: &'a Scene,
) -> impl Iterator<Item = &'a Run> + Clone {
    facts.runs.iter().filter(move |run| run.series == series && run.scene == scene.id)
}

/// Least and greatest value over the scenes, as text.
fn range(facts: &Facts, value: impl Fn(&Scene) -> Option<f64>) -> Option<String> {
    let values: Vec<f64> = facts.scenes.iter().filter_map(value).collect();
    names::range(&values, |value| significant(value, 2))
}

fn adaptive(facts: &Facts) -> Option<String> {
    let pairs = matched(facts);
    let cheaper = pairs.iter().filter(|pair| pair.ratio() < 1.0).count();
    let all = pairs.len();
    let best = pairs.iter().map(super::facts::Matched::ratio).reduce(f64::min)?;
    let verdict = if 2 * cheaper > all { "mostly save" } else { "rarely save" };
    let best = match cheaper {
        0 => String::new(),
        _ => format!("; the best saves {} %", significant(100.0 * (1.0 - best), 2)),
    };
    let verdict = if cheaper == 0 { "never save" } else { verdict };
    Some(format!(
        "Adaptive steps {verdict} work: {cheaper} of {all} adaptive runs do less work than a \
         constant step with at most their error{best}."
    ))
}

/// CG iterations within Newton's method: those with Eisenstat and Walker's terms, over those with
/// the best constant term.
fn forcing(facts: &Facts) -> Option<String> {
    let ratio = |scene: &Scene| {
        let runs = of(facts, "forcing", scene);
        let walker =
            runs.clone().find(|run| inner(facts).contains(&&*run.label) && run.value.is_none())?;
        let constant = runs.filter(|run| run.label == walker.label && run.value.is_some());
        let best = constant.map(|run| run.cg_iterations).min()?;
        Some(walker.cg_iterations as f64 / best as f64)
    };
    let ratios = range(facts, ratio)?;
    Some(format!(
        "Eisenstat and Walker's forcing terms take {ratios} times the CG iterations of the best \
         constant one and need no search for it."
    ))
}

fn jacobians(facts: &Facts) -> Option<String> {
    let ratio = |scene: &Scene| {
        let runs = of(facts, "jacobian", scene).filter(|run| !run.label.ends_with("CG"));
        let fresh = runs.clone().find(|run| run.label.contains("fresh"))?;
        let saved = runs.clone().find(|run| run.label == fresh.label.replace("fresh", "saved"))?;
        Some(saved.work_sweeps as f64 / fresh.work_sweeps as f64)
    };
    let ratios = range(facts, ratio)?;
    Some(format!(
        "Runs with saved factors do {ratios} times the work of runs with fresh ones, and the error \
         of the method is the same."
    ))
}

fn preconditioners(facts: &Facts) -> Option<String> {
    let over_none = |label: &'static str| {
        range(facts, |scene| {
            let find =
                |label: &str| of(facts, "preconditioner", scene).find(|run| run.label == *label);
            let (none, own) = (find("none")?, find(label)?);
            Some(own.cg_iterations as f64 / none.cg_iterations as f64)
        })
    };
    let (jacobi, ic0) = (over_none("jacobi")?, over_none("ic0")?);
    Some(format!(
        "IC(0) takes {ic0} times the CG iterations of a run without a preconditioner, and Jacobi \
         takes {jacobi} times."
    ))
}

/// The same ratio for updated CG, over full solves.
fn updates(facts: &Facts) -> Option<String> {
    let ratio = |scene: &Scene| {
        let find = |end: &str| of(facts, "forcing", scene).find(|run| run.label.ends_with(end));
        let (constant, walker) = (find(", to the end")?, find(", Eisenstat-Walker")?);
        Some(walker.cg_iterations as f64 / constant.cg_iterations as f64)
    };
    let ratios = range(facts, ratio)?;
    Some(format!(
        "In updated CG Eisenstat and Walker's terms take {ratios} times the CG iterations of full \
         solves."
    ))
}

/// The largest inner tolerance of the method with one system a step, and its gains of energy.
fn loose(facts: &Facts) -> Option<String> {
    let own = |scene| {
        let runs = of(facts, "forcing", scene).filter(|run| run.value.is_some());
        runs.filter(|run| !inner(facts).contains(&&*run.label)).collect::<Vec<_>>()
    };
    let ends = |scene| {
        let runs = own(scene);
        let by_value = |a: &&&Run, b: &&&Run| {
            a.value.unwrap_or_default().total_cmp(&b.value.unwrap_or_default())
        };
        Some((*runs.iter().max_by(by_value)?, *runs.iter().min_by(by_value)?))
    };
    let pairs: Vec<_> = facts.scenes.iter().filter_map(ends).collect();
    let (loosest, tightest) = pairs.first()?;
    let gains = pairs.iter().filter(|(loose, _)| loose.energy_gain_j > 1e-6).count();
    Some(format!(
            "{} at ε = {} gains energy in {gains} of {} scenes; ε = {} takes up to {} times the \
             iterations.",
            loosest.label,
            setting(loosest.value?),
            pairs.len(),
            setting(tightest.value?),
            significant(
                pairs
                    .iter()
                    .map(|(loose, tight)| tight.cg_iterations as f64
                        / loose.cg_iterations.max(1) as f64)
                    .fold(0.0, f64::max),
                2
            )
        ))
}

/// Error and substeps with each of IMEX Euler's estimators, on the scene where they differ most.
fn splitting(facts: &Facts) -> Option<String> {
    let tightest = |scene: &'_ Scene| {
        let plain = of(facts, "steps", scene).filter(|run| run.is_adaptive && run.label == PLAIN);
        let plain = plain
            .min_by(|a, b| a.value.unwrap_or_default().total_cmp(&b.value.unwrap_or_default()))?;
        let label = PLAIN.split(',').next()?;
        let same = |run: &&Run| run.is_adaptive && run.label == label && run.value == plain.value;
        let splitting = of(facts, "steps", scene).find(same)?;
        Some((plain.error?, splitting.error?, plain.substeps, splitting.substeps))
    };
    let pairs = facts.scenes.iter().filter_map(tightest);
    let pairs: Vec<_> = pairs.collect();
    let share = |pair: &&(f64, f64, u64, u64)| pair.3 as f64 / pair.2 as f64;
    let (plain, splitting, few, many) =
        *pairs.iter().max_by(|a, b| share(a).total_cmp(&share(b)))?;
    let verdict = if splitting < plain { "reduces" } else { "does not reduce" };
    let substeps = format!("with {many} instead of {few} substeps");
    Some(format!(
        "The splitting estimate {verdict} the error of IMEX Euler: it changes from {} to {}, \
         {substeps}.",
        significant(plain, 3),
        significant(splitting, 3)
    ))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let error = facts.scenes.iter().map(|scene| scene.reference_error_m).reduce(f64::max);
    let error = error
        .map(|error| format!("The references are off by at most {} m.", significant(error, 2)));
    let newton = inner(facts);
    let is_equal = facts.runs.iter().filter(|run| newton.contains(&&*run.label)).all(|run| {
        run.series != "forcing" || (run.verdict == Verdict::Completed && run.unconverged_steps == 0)
    });
    let residual = (!newton.is_empty()).then(|| {
        if is_equal {
            "Every Newton run reaches the same residual, so its counts compare like with like."
        } else {
            "Not every Newton run reaches its residual: counts of those that stop early are too \
             small."
        }
        .to_owned()
    });
    let span = facts.scenes.first().map(|scene| {
        format!(
            "All runs last {} s; work is counted in sweeps over the springs, not timed.",
            setting(scene.span_s)
        )
    });
    [residual, span, error].into_iter().flatten().collect()
}
