//! The words of the study `fabric`: its question, and the findings from its numbers.

use super::facts::{AT_REST, Cloth, Edgewise, Facts, Model, RIGHT};
use crate::studies::names::verb;
use drape_report::Words;
use drape_report::number::{percent, significant};

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "Does cloth with measured rigidities bend and drape as real cloth does?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["effects"];

/// Greatest `Γ` of a cantilever test; a heavier strip hangs almost upright.
const TESTED: f64 = 16.0;

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion = [bending(facts), wrong(facts), draping(facts)].into_iter().flatten();
    let observations =
        [orders(facts), widths(facts), edgewise(facts), spreads(facts), at_rest(facts)];
    Words {
        conclusion: conclusion.collect::<Vec<_>>().join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats(facts),
    }
}

/// The error of a model that is largest in size, with its sign, on the finest mesh over all tested
/// `Γ`. `None` if a strip there is not at rest.
fn worst(facts: &Facts, model: Model) -> Option<f64> {
    let finest = facts.meshes().into_iter().next_back()?;
    let tested = facts.gammas().into_iter().filter(|gamma| *gamma <= TESTED);
    let errors: Option<Vec<f64>> =
        tested.map(|gamma| facts.bent(model, gamma, finest)?.error()).collect();
    errors?.into_iter().max_by(|a, b| libm::fabs(*a).total_cmp(&libm::fabs(*b)))
}

fn signed(error: f64) -> String {
    let sign = if error < 0.0 { "−" } else { "+" };
    format!("{sign}{}", percent(libm::fabs(error), 2))
}

/// The models that bend like the exact strip.
fn bending(facts: &Facts) -> Option<String> {
    let finest = facts.meshes().into_iter().next_back()?;
    let right = |model: &Model| worst(facts, *model).is_some_and(|e| libm::fabs(e) <= RIGHT);
    let told: Vec<_> = Model::ALL
        .into_iter()
        .filter(right)
        .filter_map(|model| Some(format!("{model} ({})", signed(worst(facts, model)?))))
        .collect();
    Some(format!(
        "On {finest} edges and up to Γ = {TESTED}, these models match the drop over reach of the \
         exact strip within {}: {}.",
        percent(RIGHT, 1),
        if told.is_empty() { "none".to_owned() } else { told.join("; ") }
    ))
}

/// The models that do not.
fn wrong(facts: &Facts) -> Option<String> {
    let wrong = |model: &Model| !worst(facts, *model).is_some_and(|e| libm::fabs(e) <= RIGHT);
    let error = |model| worst(facts, model).map_or_else(|| "not at rest".to_owned(), signed);
    let told: Vec<_> = Model::ALL
        .into_iter()
        .filter(wrong)
        .filter(|model| facts.bent.iter().any(|bent| bent.model == *model))
        .map(|model| format!("{model} ({})", error(model)))
        .collect();
    (!told.is_empty()).then(|| format!("These do not (largest error): {}.", told.join("; ")))
}

/// Whether all coefficients of a material lie in its band; `None` without a band or a coefficient.
fn is_inside(facts: &Facts, cloth: &Cloth) -> Option<bool> {
    let (band, [least, greatest]) = (facts.band(cloth)?, facts.spread(&cloth.name)?);
    Some(band.least <= least && greatest <= band.greatest)
}

fn span([least, greatest]: [f64; 2]) -> String {
    format!("{:.0}–{:.0} %", 100.0 * least, 100.0 * greatest)
}

/// The materials against the bands of their classes.
fn draping(facts: &Facts) -> Option<String> {
    let told = |cloth: &Cloth| {
        let (band, spread) = (facts.band(cloth)?, facts.spread(&cloth.name)?);
        let place = if is_inside(facts, cloth)? { "inside" } else { "not inside" };
        let published = span([band.least, band.greatest]);
        Some(format!("{} {}, {place} {published} of {}", cloth.name, span(spread), band.class))
    };
    let told: Vec<_> = facts.cloths.iter().filter_map(told).collect();
    (!told.is_empty()).then(|| {
        format!("Drape coefficients against the published band of each class: {}.", told.join("; "))
    })
}

/// The observed orders of convergence.
fn orders(facts: &Facts) -> Option<String> {
    let gamma = facts.gammas().into_iter().next()?;
    let told: Vec<_> = Model::ALL
        .into_iter()
        .filter_map(|model| {
            Some(format!("{} ({model})", significant(facts.order(model, gamma)?, 2)))
        })
        .collect();
    (!told.is_empty()).then(|| {
        format!(
            "At Γ = {gamma} the error falls with the edge length with these orders: {}.",
            told.join("; ")
        )
    })
}

/// How the width of a strip changes the rigidity of a hinge.
fn widths(facts: &Facts) -> Option<String> {
    let told = |model: Model| {
        let own = facts.widths.iter().filter(|width| width.model == model);
        let gamma = own.clone().map(|width| width.gamma).fold(f64::INFINITY, f64::min);
        let own: Vec<_> = own.filter(|width| width.gamma == gamma).collect();
        let (first, last) = (own.first()?, own.last()?);
        let is_hinge = first.narrow != first.wide;
        is_hinge.then(|| {
            let [narrow, wide] =
                [first, last].map(|width| significant(width.rigidity_over_stiffness, 3));
            format!(
                "{} to {} rows give {narrow} to {wide} on {} (derived {} to {})",
                first.rows,
                last.rows,
                if model == Model::Triangles { "triangles" } else { "squares" },
                significant(first.narrow, 3),
                significant(first.wide, 3)
            )
        })
    };
    let told: Vec<_> = Model::ALL.into_iter().filter_map(told).collect();
    (!told.is_empty()).then(|| {
        format!("The rigidity over the stiffness k depends on the width: {}.", told.join("; "))
    })
}

/// The weight at which strips on edge buckle, beside the law of a slender beam. The table holds the
/// models without such a law.
fn edgewise(facts: &Facts) -> Option<String> {
    // The most slender strip, on both sides.
    let lawful = || facts.edgewise.iter().filter(|edge| edge.law.is_some());
    let slender = lawful().min_by(|a, b| a.width_over_length.total_cmp(&b.width_over_length))?;
    let is_its = |edge: &&Edgewise| {
        (edge.model, edge.width_over_length) == (slender.model, slender.width_over_length)
    };
    let both = lawful().filter(is_its);
    let mut found: Vec<_> =
        both.filter_map(|edge| Some(significant(edge.critical_gamma?, 3))).collect();
    found.dedup();
    let law = significant(slender.law?, 3);
    (!found.is_empty()).then(|| {
        format!(
            "The most slender strip on edge ({}) buckles at Γ = {}; the law of a slender beam \
             gives {law}.",
            slender.model,
            found.join(" or ")
        )
    })
}

/// How far drape coefficients spread.
fn spreads(facts: &Facts) -> Option<String> {
    let width = |[least, greatest]: [f64; 2]| greatest - least;
    let spread = |cloth: &Cloth| Some((width(facts.spread(&cloth.name)?), cloth.name.clone()));
    let (widest, name) =
        facts.cloths.iter().filter_map(spread).max_by(|a, b| a.0.total_cmp(&b.0))?;
    // Differences between two starts on one mesh.
    let resting = || facts.drapes.iter().filter(|drape| drape.is_at_rest());
    let pairs = resting().flat_map(|a| {
        let same = resting().filter(|b| (&b.cloth, b.cells) == (&a.cloth, a.cells));
        same.map(|b| b.coefficient - a.coefficient)
    });
    let of_starts = pairs.fold(0.0, f64::max);
    // A single test has no spread.
    (widest > 0.0).then(|| {
        format!(
            "The drape coefficient of one material differs by up to {} points between meshes and \
             starts ({name}), and by up to {} between starts on one mesh.",
            significant(100.0 * widest, 2),
            significant(100.0 * of_starts, 2)
        )
    })
}

/// How many specimens are at rest.
fn at_rest(facts: &Facts) -> Option<String> {
    let rests = |residual: f64| (residual, residual <= AT_REST);
    let bent = facts.bent.iter().map(|bent| rests(bent.residual));
    let widths = facts.widths.iter().map(|width| rests(width.residual));
    let edges = facts.edgewise.iter().map(|edge| rests(edge.residual));
    let drapes = facts.drapes.iter().map(|drape| (drape.residual, drape.is_at_rest()));
    let all: Vec<(f64, bool)> = bent.chain(widths).chain(edges).chain(drapes).collect();
    let resting: Vec<f64> = all.iter().filter(|(_, rests)| *rests).map(|(r, _)| *r).collect();
    let greatest = resting.iter().copied().reduce(f64::max)?;
    Some(format!(
        "Of {} specimens, {} {} at rest, with a residual of at most {greatest:.1e} of the heaviest \
         particle's weight; others are left out.",
        all.len(),
        resting.len(),
        verb(resting.len(), "is", "are")
    ))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let mut caveats = vec![
        "A band holds for a class of cloths, not for the specimen that the material was measured \
         on."
            .to_owned(),
        "The materials are linear: a cloth that is stretched or folded sharply has other constants."
            .to_owned(),
        "The strips hardly stretch; springs that buckle are limp below a curvature that grows with \
         the mesh and falls with the tensile rigidity."
            .to_owned(),
    ];
    if facts.drapes.iter().any(|drape| !drape.is_at_rest()) {
        let count = facts.drapes.iter().filter(|drape| !drape.is_at_rest()).count();
        caveats.push(format!("{count} of the drape tests did not come to rest."));
    }
    caveats
}

#[cfg(test)]
#[path = "words/tests.rs"]
mod tests;
