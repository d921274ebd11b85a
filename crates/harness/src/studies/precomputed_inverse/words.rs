//! The words of the study `precomputed-inverse`: its question, and the findings from its numbers.

use super::facts::{CG, CHOLESKY, DENSE, Facts, Solver, crossover, of};
use drape_report::Words;
use drape_report::number::{power, significant};

/// The question that the study answers.
pub(super) const QUESTION: &str = "What do a dense inverse, a sparse factor and conjugate \
                                   gradients cost in set-up, memory, solves and changes?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["cg-vs-stiffness"];

/// Largest relative difference at which solutions agree.
const AGREE: f64 = 1e-9;
const MIB: f64 = 1024.0 * 1024.0;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion = [dense(facts), solves(facts), worth(facts)];
    let conclusion: Vec<_> = conclusion.into_iter().flatten().collect();
    let conclusion = match &conclusion[..] {
        [] => "No two solvers were compared.".to_owned(),
        sentences => sentences.join(" "),
    };
    let observations =
        [agreement(facts), memory(facts), iterations(facts), rebuilds(facts), fresh(facts)];
    let observations = observations.into_iter().flatten().collect();
    Words { conclusion, observations, caveats: caveats(facts) }
}

/// Whether the inverse is the most expensive solver at every size.
fn dense(facts: &Facts) -> Option<String> {
    let others = || facts.solvers.iter().filter(|row| row.solver != DENSE);
    let pairs = of(facts, DENSE).flat_map(|dense| {
        others().filter(|row| row.particles == dense.particles).map(move |row| (dense, row))
    });
    let pairs: Vec<_> = pairs.collect();
    let is_dearer = |(dense, other): &(&Solver, &Solver)| {
        dense.setup_operations > other.setup_operations
            && dense.kept_bytes >= other.kept_bytes
            && dense.solve_operations > other.solve_operations
    };
    (!pairs.is_empty()).then(|| {
        if pairs.iter().all(is_dearer) {
            "At every size the dense inverse costs most in set-up, memory and solves.".to_owned()
        } else {
            "The dense inverse does not cost most at every size.".to_owned()
        }
    })
}

/// Which of the other solvers takes fewer operations for a solve.
fn solves(facts: &Facts) -> Option<String> {
    let sparse: Vec<_> = of(facts, CHOLESKY).collect();
    let cg: Vec<_> = of(facts, CG).collect();
    let (_, _) = (sparse.first()?, cg.first()?);
    let mut series: Vec<&str> = cg.iter().map(|row| row.series.as_str()).collect();
    series.dedup();
    let turns = series.into_iter().filter_map(|name| {
        let own = cg.iter().copied().filter(|row| row.series == name);
        Some((crossover(own, &sparse)?, name))
    });
    let first = turns.min_by_key(|(particles, _)| *particles);
    Some(match first {
        None => "A solve takes fewer operations with the sparse factor than with CG at every size."
            .to_owned(),
        Some((particles, name)) => format!(
            "A solve takes the fewest operations with the sparse factor, but from {particles} \
             particles on CG takes fewer ({name})."
        ),
    })
}

/// How many solves a set-up costs at most.
fn worth(facts: &Facts) -> Option<String> {
    let of = |solver| {
        let worths = of(facts, solver).map(|row| row.setup_operations / row.solve_operations);
        worths.reduce(f64::max)
    };
    let said = |solver: &str, worth: f64| {
        format!("up to {} solves with the {solver}", significant(worth, 2))
    };
    let solvers =
        [DENSE, CHOLESKY].into_iter().filter_map(|solver| Some(said(solver, of(solver)?)));
    let solvers: Vec<_> = solvers.collect();
    (!solvers.is_empty())
        .then(|| format!("A change of h or k costs as much as {}.", solvers.join(" and ")))
}

fn agreement(facts: &Facts) -> Option<String> {
    let others = facts.solvers.iter().filter(|row| row.solver != CHOLESKY);
    let worst = others.map(|row| row.disagreement).max_by(f64::total_cmp)?;
    let verdict = if worst <= AGREE { "agree" } else { "do not agree" };
    Some(format!(
        "The three solvers {verdict}: the relative difference of their solutions is at most {}.",
        significant(worst, 2)
    ))
}

fn memory(facts: &Facts) -> Option<String> {
    let largest = |solver| of(facts, solver).max_by_key(|row| row.particles);
    let (dense, sparse, cg) = (largest(DENSE)?, largest(CHOLESKY)?, largest(CG)?);
    let memory = |row: &Solver| significant(row.kept_bytes as f64 / MIB, 2);
    Some(format!(
        "At {} particles, the dense inverse needs {} MiB, the sparse factor {} MiB and IC(0) {} \
         MiB.",
        dense.particles,
        memory(dense),
        memory(sparse),
        memory(cg)
    ))
}

fn iterations(facts: &Facts) -> Option<String> {
    let counts = || of(facts, CG).map(|row| row.cg_per_step);
    let (least, most) = (counts().reduce(f64::min)?, counts().reduce(f64::max)?);
    Some(format!(
        "CG takes {} to {} iterations a step, depending on size and stiffness.",
        significant(least, 2),
        significant(most, 2)
    ))
}

fn rebuilds(facts: &Facts) -> Option<String> {
    let first = facts.changes.first()?;
    let all =
        |run: &super::facts::Change| run.first + run.step_size + run.stiffness + run.constraints;
    let counts = || facts.changes.iter().map(all);
    let (least, most) = (counts().min()?, counts().max()?);
    let times = match most {
        1 => "once".to_owned(),
        _ if least == most => format!("{most} times"),
        _ => format!("{least} to {most} times"),
    };
    Some(format!(
        "In {} steps with changes of h, k, masses and pins, each method sets up its operator \
         {times}.",
        first.steps
    ))
}

fn fresh(facts: &Facts) -> Option<String> {
    let distances = facts.changes.iter().flat_map(|run| &run.distance_to_fresh_m).copied();
    let greatest = distances.reduce(f64::max)?;
    Some(if greatest <= AGREE {
        format!("After every change, each method agrees with a fresh start to {} m.", power(AGREE))
    } else {
        format!(
            "After a change, a method differs from a fresh start by up to {} m.",
            significant(greatest, 2)
        )
    })
}

fn caveats(facts: &Facts) -> Vec<String> {
    let largest = facts.solvers.iter().map(|row| row.particles).max();
    let largest = largest.map(|n| format!("Sheets are square grids of at most {n} particles."));
    let operations =
        "Operations are counted to leading order; measured times stand in tables of their own.";
    let stiffness = of(facts, CG).map(|row| row.stiffness_over_mass_per_s2).reduce(f64::max);
    let stiffness = stiffness.map(|k| {
        format!("CG was run up to k/m = {} s⁻²; stiffer sheets take more iterations.", power(k))
    });
    [Some(operations.to_owned()), largest, stiffness].into_iter().flatten().collect()
}
