//! The words of the study `cg-vs-stiffness`: its question, and the findings from its numbers.

use super::facts::*;
use crate::studies::names::verb;
use drape_report::number::{power, setting, significant};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "How do CG iterations grow with stiffness, step and tolerance, and does the cloth still move?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["tables"];

/// A sheet hardly moves if it falls less than this share of the true fall.
const HALF: f64 = 0.5;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion = [most(facts), plain_fall(facts), updated_fall(facts)];
    let mut conclusion: Vec<_> = conclusion.into_iter().flatten().collect();
    if conclusion.is_empty() {
        conclusion.push("The record holds no count of plain CG and no motion.".to_owned());
    }
    let observations = [solver(facts), loose(facts), updated(facts), tension(facts), step(facts)];
    Words {
        conclusion: conclusion.join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats(facts),
    }
}

/// The cells of a variant in the sweep over stiffness, with the solver of the base point.
fn base<'a>(facts: &'a Facts, variant: &'a str) -> impl Iterator<Item = &'a Cell> + Clone {
    let cells = facts.cells.iter().filter(|cell| cell.series == STIFFNESS);
    cells.filter(move |c| c.variant == variant && at_fixed_k_over_m(c) && with_base_solver(c))
}

fn k_over_m(value: f64) -> String {
    format!("k/m = {} s⁻²", power(value))
}

/// The greatest iteration count of plain CG.
fn most(facts: &Facts) -> Option<String> {
    let most = base(facts, PLAIN).max_by(|a, b| a.cg_per_step.total_cmp(&b.cg_per_step))?;
    let stiffness = base(facts, PLAIN).map(|cell| cell.stiffness_over_mass_per_s2);
    let (low, high) = stiffness.fold((f64::MAX, 0.0_f64), |(a, b), k| (a.min(k), b.max(k)));
    Some(format!(
        "From k/m = {} to {} s⁻² plain IMEX Euler with IC(0) takes at most {} CG iterations a \
         step.",
        power(low),
        power(high),
        significant(most.cg_per_step, 3)
    ))
}

/// The fall of a method over that of backward Euler, for each k/m (1/s²), ascending.
fn shares(facts: &Facts, label: &str) -> Vec<(f64, f64)> {
    let falls = facts.motion.iter().filter(|motion| motion.label == label);
    let mut shares: Vec<_> = falls
        .filter_map(|fall| {
            let k = fall.stiffness_over_mass_per_s2;
            let same = |m: &&Motion| m.label == IMPLICIT && m.stiffness_over_mass_per_s2 == k;
            Some((k, fall.fall_m / facts.motion.iter().find(same)?.fall_m))
        })
        .collect();
    shares.sort_by(|a, b| a.0.total_cmp(&b.0));
    shares
}

fn plain_fall(facts: &Facts) -> Option<String> {
    let shares = shares(facts, PLAIN_MOTION);
    let least = shares.iter().map(|(_, share)| *share).reduce(f64::min)?;
    Some(match shares.iter().find(|(_, share)| *share < HALF) {
        Some((k, share)) => format!(
            "Few iterations do not mean success: at {} its sheet falls only {} % as far in 0.3 s as \
             with backward Euler.",
            k_over_m(*k),
            significant(100.0 * share, 2)
        ),
        None => format!(
            "Its sheet falls at least {} % as far as with backward Euler.",
            significant(100.0 * least, 2)
        ),
    })
}

fn updated_fall(facts: &Facts) -> Option<String> {
    let shares = shares(facts, UPDATED_MOTION);
    let off = shares.iter().map(|(_, share)| (share - 1.0).abs()).reduce(f64::max)?;
    let far =
        if off < 0.01 { "as far as with backward Euler, within" } else { "differently, by up to" };
    let off = significant(100.0 * off, 1);
    Some(format!("With updated, safeguarded CG it falls {far} {off} %."))
}

/// The iterations that preconditioner and start vector save.
fn solver(facts: &Facts) -> Option<String> {
    let other = |cell: &Cell, preconditioner: &str, start: &str| {
        let cells = facts.cells.iter().filter(|c| c.series == STIFFNESS && c.variant == PLAIN);
        let mut cells = cells.filter(|c| at_fixed_k_over_m(c) && c.particles == cell.particles);
        let same = |c: &&Cell| c.stiffness_over_mass_per_s2 == cell.stiffness_over_mass_per_s2;
        let found =
            cells.find(|c| same(c) && c.preconditioner == preconditioner && c.start == start);
        found.map(|c| c.cg_per_step)
    };
    let without = base(facts, PLAIN).filter(|cell| cell.cg_per_step > 0.0);
    let without = without.filter_map(|c| Some(other(c, "none", &c.start)? / c.cg_per_step));
    let factor = without.reduce(f64::max)?;
    let last = base(facts, PLAIN).filter_map(|c| Some((c, other(c, BASE_PRECONDITIONER, "last")?)));
    let saved = last.clone().filter(|(cell, last)| cell.cg_per_step < *last).count();
    Some(format!(
        "Without a preconditioner, plain CG takes up to {} times as many iterations; the \
         extrapolated start saves iterations in {saved} of {} cases.",
        significant(factor, 2),
        last.count()
    ))
}

/// How many runs of plain CG gain energy, and how many steps of the worst take no iteration.
fn loose(facts: &Facts) -> Option<String> {
    let plain = facts.cells.iter().filter(|c| c.series == STIFFNESS && c.variant == PLAIN);
    let all = plain.clone().count();
    let gaining = plain.filter(|cell| cell.verdict != Verdict::Stable);
    let most = gaining.clone().max_by(|a, b| a.energy_gain_j.total_cmp(&b.energy_gain_j))?;
    let extrapolated = gaining.clone().filter(|cell| cell.start == BASE_START).count();
    let number = gaining.count();
    let theirs = if extrapolated == number { "all".to_owned() } else { extrapolated.to_string() };
    Some(format!(
        "{number} of {all} runs of plain CG {} energy, {theirs} of them with the \
         extrapolated start; in the worst, {} of {} steps take no iteration.",
        verb(number, "gains", "gain"),
        most.idle_steps,
        most.steps
    ))
}

/// How many runs of updated CG gain energy.
fn updated(facts: &Facts) -> Option<String> {
    let count = |variant| {
        let failing = base(facts, variant).filter(|cell| cell.verdict != Verdict::Stable).count();
        (base(facts, variant).count(), failing)
    };
    let ((printed, failing), (robust, failed)) = (count(UPDATED_PAPER), count(UPDATED_ROBUST));
    let newton: u64 = base(facts, UPDATED_ROBUST).map(|cell| cell.newton_iterations).sum();
    let safeguarded =
        format!("; safeguarded, in {failed} of {robust}, with {newton} Newton iterations in all");
    let safeguarded = if robust > 0 { safeguarded } else { String::new() };
    (printed > 0).then(|| {
        format!("Updated CG as printed gains energy in {failing} of {printed} runs{safeguarded}.")
    })
}

/// How often updated CG gains energy if shear is left out of the matrix.
fn tension(facts: &Facts) -> Option<String> {
    let runs = facts.motion.iter().filter(|motion| motion.label == TENSION_ONLY);
    let failing = runs.clone().filter(|motion| motion.verdict != Verdict::Stable);
    let least = failing.clone().map(|m| m.stiffness_over_mass_per_s2).reduce(f64::min);
    let first = least.map_or_else(String::new, |k| format!(", the softest at {}", k_over_m(k)));
    (runs.clone().count() > 0).then(|| {
        format!(
            "With shear left out of the matrix, updated CG gains energy at {} of {} \
             stiffnesses{first}.",
            failing.count(),
            runs.count()
        )
    })
}

/// The steps with the fewest and with the most iterations in one second.
fn step(facts: &Facts) -> Option<String> {
    let cells = facts.cells.iter().filter(|cell| cell.series == STEP && cell.variant == PLAIN);
    let stiffest = cells.clone().map(|c| c.stiffness_over_mass_per_s2).reduce(f64::max)?;
    let cells = cells.filter(|cell| cell.stiffness_over_mass_per_s2 == stiffest);
    let fewest = cells.clone().min_by_key(|cell| cell.cg_iterations)?;
    let most = cells.max_by_key(|cell| cell.cg_iterations)?;
    Some(format!(
        "At {}, one second of plain CG takes the fewest iterations with h = {} s ({}) and the most \
         with h = {} s ({}).",
        k_over_m(stiffest),
        setting(fewest.step_s),
        fewest.cg_iterations,
        setting(most.step_s),
        most.cg_iterations
    ))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let greatest = |particles: usize, variant: &'static str| {
        let cells = base(facts, variant).filter(move |cell| cell.particles == particles);
        cells.map(|cell| cell.stiffness_over_mass_per_s2).reduce(f64::max)
    };
    let sizes: std::collections::BTreeSet<_> = facts.cells.iter().map(|c| c.particles).collect();
    let names: Vec<_> = sizes.iter().map(usize::to_string).collect();
    let mut caveats = vec![
        format!(
            "The scene is one hanging textile, with {} particles, for one second.",
            names.join(" and ")
        ),
        "A run that gained energy follows another motion, so its count is not comparable."
            .to_owned(),
    ];
    caveats.extend(sizes.into_iter().filter_map(|particles| {
        let robust = greatest(particles, UPDATED_ROBUST)?;
        (robust < greatest(particles, PLAIN)?).then(|| {
            format!("Safeguarded, {particles} particles ran up to {} only.", k_over_m(robust))
        })
    }));
    caveats
}

#[cfg(test)]
mod tests;
