//! Experiment `trajectory`: which methods follow a smooth motion, by stiffness and damping.

mod cases;
#[cfg(test)]
mod tests;

use super::facts::{Facts, LEAD, LEVELS, Row};
use crate::HarnessError;
use crate::cost::Prices;
use crate::facts::{Fact, fact};
use crate::methods::runs::work::{Knob, Variant};
use crate::stability::STABLE;
use crate::studies::work_precision::run::front;
use crate::studies::work_precision::run::truth::{PERTURBED, SEED};
use crate::studies::work_precision::run::variants::VARIANTS;
use crate::studies::work_precision::run::{FOLLOWING, counts, reprice};
use crate::studies::{Context, Measured, Start, prepared, taken};
use cases::{BUDGET_S, Stage, cases};
use serde_json::json;

/// Largest effort of a run in the quick subset, in visits of a spring.
const QUICK: f64 = 4e6;

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "The hanging sheet of `work-precision`, a part of a cylinder, 1 m × 1 m, with every \
         spring at its rest length, swings down for T = 0.25 s. Its damping is d/m = 0, 10 or 40 \
         s⁻¹, or such that the stiffest mode has a damping ratio ζ of 0.01, 0.1 or 1. DOP853 \
         computes the true motion: once without noise at tolerance 10⁻¹⁰, and {PERTURBED} times \
         from perturbed starts at 10⁻⁹. A perturbed start moves each free particle along the \
         normal of the sheet by a distance of its own of at most 1 µm (uniform, seeded). Noise is \
         the mean distance of the perturbed motions from the unperturbed one. A run is compared \
         with the nearest of all these motions. It has four errors. Trajectory: the mass-weighted \
         distance of the particles at the end, over the motion. Shape: the mean distance of the \
         surfaces at four times; between the ends of long steps the motion is the cubic through \
         positions and velocities. Stretch: the 99th percentile of the strain beyond the true \
         one, as a mean over these times. Energy: the energy at the end beyond the true one, over \
         the energy that the scene sets free. Motion kept is the path of the middle of the free \
         edge over the true path. Every method runs in all forms of `work-precision`, except that \
         `rkc` refuses sheets without damping. They take steps T/2ʲ, from one step of T or the \
         limit of stability on, until the trajectory errs by less than {} or by less than the \
         noise, or until the visits of a run of eight steps or more, all at the least price of \
         its form, take more than {BUDGET_S} s of modelled time. Modelled time ranks the runs, as \
         in `work-precision`; a method that takes less than {LEAD} times as long as the winner \
         ties with it. An error ranks only if it is at least twice the noise. A run may win only \
         if it has a state for each picture of a film (steps of at most 1/24 s, so T/8 here), \
         keeps at least half of the motion, and its energy at the end exceeds the true one by at \
         most {} % of the energy that the scene sets free, or by twice the noise of the energy.",
        LEVELS[2],
        100.0 * STABLE
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    cases().into_iter().map(|case| Start::new(case.id(), move || case.spec())).collect()
}

/// The forms that are run: those of all methods of the registry.
fn forms() -> impl Iterator<Item = &'static Variant> {
    VARIANTS.iter().filter(|variant| !matches!(variant.knob, Knob::Tolerance(_)))
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let mut chosen = cases();
    chosen.retain(|case| !context.quick || case.is_quick());
    let stages = prepared(context, "true motions", &chosen, Stage::new)?;
    let pairs: Vec<_> =
        stages.iter().flat_map(|stage| forms().map(move |form| (stage, form))).collect();
    let limit = context.quick.then_some(QUICK);
    let mut rows =
        taken(context, "methods", &pairs, |(stage, form)| stage.setting.row(form, limit))?.all()?;
    let mut winners = Vec::new();
    for Stage { scene, .. } in &stages {
        let own = rows.iter_mut().filter(|row| row.scene == scene.id);
        front::mark(own, scene.floor);
        let ranked = LEVELS.into_iter().filter(|level| scene.ranks(*level));
        winners.extend(ranked.map(|level| front::winner(&scene.id, &rows, level)));
    }
    let hashes = stages.iter().map(|s| (s.scene.id.clone(), s.setting.hash.clone())).collect();
    let scenes = stages.into_iter().map(|stage| stage.scene).collect();
    let facts = Facts { scenes, rows, winners };
    Ok(Measured { facts, timings: None, scenes: hashes, seed: Some(SEED) })
}

/// How far the winners agree with those of a ranking by other rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Agreement {
    /// Number of winners.
    pub winners: usize,
    /// How many are the same method by the other rules.
    pub same: usize,
    /// How many of the other rules' winners, where they differ, tie with the winner.
    pub tied: usize,
}

/// Compares the winners with those of the same runs by other prices.
#[must_use]
pub fn by_other_prices(facts: &Facts, prices: &Prices) -> Agreement {
    let mut rows = facts.rows.clone();
    for row in &mut rows {
        if let Some(scene) = facts.scenes.iter().find(|scene| scene.id == row.scene) {
            reprice(row, (scene.particles, scene.springs), prices);
        }
    }
    agreement(facts, &rows)
}

/// Compares the winners with those where steps longer than a picture of a film may win.
#[must_use]
pub fn with_longer_steps(facts: &Facts) -> Agreement {
    let mut rows = facts.rows.clone();
    let runs = rows.iter_mut().flat_map(|row| &mut row.runs);
    runs.filter(|run| run.skips_pictures()).for_each(|run| run.flaw = None);
    agreement(facts, &rows)
}

fn agreement(facts: &Facts, rows: &[Row]) -> Agreement {
    let id = |label: &str| {
        let row = facts.rows.iter().find(|row| row.label == label)?;
        row.method.split(':').next()
    };
    let mut agreement = Agreement { winners: 0, same: 0, tied: 0 };
    for winner in &facts.winners {
        let other = front::winner(&winner.scene, rows, winner.level);
        let (Some(label), Some(other)) = (&winner.label, &other.label) else { continue };
        agreement.winners += 1;
        if id(label) == id(other) {
            agreement.same += 1;
        } else if winner.tied.iter().any(|tied| id(&tied.label) == id(other)) {
            agreement.tied += 1;
        }
    }
    agreement
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let scenes = facts.scenes.iter().map(|scene| fact(scene.id.clone(), false, scene));
    let rows = facts.rows.iter().flat_map(|row| {
        row.runs.iter().flat_map(move |run| {
            let key = format!("{}, {}, {}={}", row.scene, row.label, row.knob, run.value);
            let is_near = run.error.is_some_and(|error| error < FOLLOWING);
            let errors = is_near.then(|| json!({ "error": run.error, "beside": run.beside }));
            let outcome = json!({ "verdict": run.verdict, "step_s": run.step_s, "errors": errors });
            [fact(format!("{key} outcome"), false, &outcome), counts(format!("{key} counts"), run)]
        })
    });
    scenes.chain(rows).collect()
}
