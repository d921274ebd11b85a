//! Experiment `work-precision`: what accuracy costs.

pub(in crate::studies) mod front;
mod runs;
pub(in crate::studies) mod scenes;
#[cfg(test)]
mod tests;
mod timing;
pub(in crate::studies) mod truth;
pub(in crate::studies) mod variants;

use crate::cost::{Counted, Prices};
use crate::facts::{Fact, fact};
use crate::stability::STABLE;
use crate::studies::clocked::disturbance;
use crate::studies::work_precision::facts::{Facts, Row, Run, Scene, TimingRow};
use crate::studies::{Context, Measured, Recorded, Start, Timing, prepared, taken, timed};
use crate::{HarnessError, system_hash};
use drape_report::Verdict;
use front::LEVELS;
use scenes::{Case, Setting, cases};
use serde_json::json;
use variants::VARIANTS;

/// Largest effort of a run in the quick subset, in visits of a spring.
const QUICK: f64 = 8e6;
/// A run with a larger error does not follow the motion: its error is recorded, but not compared.
pub(in crate::studies) const FOLLOWING: f64 = 0.5;

/// The timings.
pub(super) const TIMING: Timing<Facts, TimingRow> = Timing {
    method: timing::method,
    about: |rows| disturbance(rows.iter().map(|row| row.probe_s)),
    again: Some(again),
};

/// Takes the timings of a record anew.
fn again(
    context: &Context<'_>,
    facts: Facts,
    recorded: &Recorded<'_>,
) -> Result<(Facts, Vec<TimingRow>), HarnessError> {
    let mut of_record = Vec::new();
    for scene in &facts.scenes {
        let own = cases().into_iter().find(|case| case.id() == scene.id);
        let hashed = own.map(|case| Ok::<_, HarnessError>((system_hash(&case.spec()?), case)));
        let (_, case) = recorded.same(&scene.id, hashed.transpose()?, |(hash, _)| hash)?;
        of_record.extend(Some(case).filter(Case::is_timed));
    }
    if let Some(row) = facts.rows.iter().find(|row| timing::form(&row.label).is_none()) {
        let (record, label) = (recorded.path.to_owned(), row.label.clone());
        return Err(HarnessError::OtherForm { record, label });
    }
    let settings = prepared(context, "references", &of_record, Setting::new)?;
    let chosen = timing::chosen(&settings, &facts);
    let rows = recorded.timed(context, &facts.rows, &chosen, (timing::time, |row| row.seconds))?;
    Ok((facts, rows))
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!("{METHOD} {}", noise())
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    cases().into_iter().map(|case| Start::new(case.id(), move || case.spec())).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let mut chosen = cases();
    chosen.retain(|case| !context.quick || case.is_quick());
    let settings = prepared(context, "references", &chosen, Setting::beside_noise)?;
    let pairs: Vec<_> = settings
        .iter()
        .flat_map(|setting| {
            let is_base = setting.case.is_base();
            let variants = VARIANTS.iter().filter(move |v| is_base || v.is_run_everywhere());
            variants.map(move |variant| (setting, variant))
        })
        .collect();
    let limit = context.quick.then_some(QUICK);
    let rows = taken(context, "methods", &pairs, |(setting, variant)| setting.row(variant, limit))?
        .all()?;
    let scenes: Vec<_> = settings.iter().map(|setting| setting.scene.clone()).collect();
    let facts = ranked(scenes, rows);
    let hashes: std::collections::BTreeMap<_, _> =
        settings.iter().map(|s| (s.scene.id.clone(), s.hash.clone())).collect();
    let timings = if context.long && !context.quick {
        let chosen = timing::chosen(&settings, &facts);
        Some(timed(context, "timings", &chosen, timing::time)?.all()?)
    } else {
        None
    };
    Ok(Measured { facts, timings, scenes: hashes, seed: Some(truth::SEED) })
}

/// The facts of runs whose modelled times are known.
fn ranked(scenes: Vec<Scene>, mut rows: Vec<Row>) -> Facts {
    let mut winners = Vec::new();
    for scene in &scenes {
        front::mark(rows.iter_mut().filter(|row| row.scene == scene.id), scene.floor);
        let ranked = LEVELS.into_iter().filter(|level| scene.ranks(*level));
        winners.extend(ranked.map(|level| front::winner(&scene.id, &rows, level)));
    }
    Facts { scenes, rows, winners }
}

/// The facts of the same runs by other prices.
pub(super) fn repriced(facts: Facts, prices: &Prices) -> Facts {
    let Facts { scenes, mut rows, .. } = facts;
    for row in &mut rows {
        let Some(scene) = scenes.iter().find(|scene| scene.id == row.scene) else { continue };
        reprice(row, (scene.particles, scene.springs), prices);
    }
    ranked(scenes, rows)
}

/// Gives the runs of a row, on a scene of so many particles and springs, other prices.
pub(in crate::studies) fn reprice(
    row: &mut Row,
    (particles, springs): (usize, usize),
    prices: &Prices,
) {
    // A run that its budget forbade to begin took no time.
    let begun = |run: &&mut Run| run.steps > 0 || run.verdict != Verdict::OverBudget;
    for run in row.runs.iter_mut().filter(begun) {
        let counted = Counted {
            steps: run.steps,
            force_evaluations: run.force_evaluations,
            matvecs: run.matvecs,
            factorisations: run.factorisations,
            setups: run.setups,
            particles,
            springs,
        };
        run.modelled_s = counted.seconds(prices.of(&row.method));
    }
}

const METHOD: &str = "\
    A bent, unstretched sheet of 1 m × 1 m (a part of a cylinder of radius 1.5 m) moves for T = \
    0.25 s under gravity. It hangs by two corners of one edge, is thrown free while it turns at \
    5.4 rad/s, or is spread between four pinned corners. Shear springs have a quarter of the \
    stiffness and a tenth of the damping of tension springs; damping is full. Light damping is d/m \
    = 10 s⁻¹, heavy damping d/m = √(k/m): both are the same at k/m = 100 s⁻². The sheet has 20 × \
    20 particles, 10 × 10 at k/m = 10¹⁰ s⁻²; two series vary the size at fixed k/m and at fixed \
    material. The error is ‖x − \
    x_ref‖/‖x_ref − x₀‖ at the end, mass-weighted. The reference is DOP853 (adaptive, order 8) at \
    tolerance 10⁻¹⁰; its own error is the distance from a run at 10⁻⁹. Methods take T/2ʲ as their \
    step until the error is below 10⁻⁵ or the run exceeds the budget of its scene. Implicit \
    methods begin at T/8, explicit ones beyond their limit. `leapfrog` divides frames of T/16 into \
    steps below its stability limit, of which it uses the share `safety`. For comparison, `dop853` \
    is that adaptive method at tolerances from 10⁻² to 10⁻¹⁰. Modelled \
    time ranks the runs: the visits of a spring in forces, products, factorisations and set-ups, \
    each times its price in this form. The prices were fitted once to measured times and are part \
    of the source (`drape_harness::cost`). A method ties with the winner if it takes less than \
    twice the winner's time. The budget is counted in visits: sweeps of forces and matrix products \
    by their length, and 80 n^1.5 for a factorisation of Newton's matrix.";

/// How noise and energy decide which runs and which errors rank.
fn noise() -> String {
    let perturbed = truth::PERTURBED;
    format!(
        "Noise is the mean error of {perturbed} true motions from perturbed starts: each free \
         particle starts up to 1 µm away along the normal of the sheet (uniform, seeded). DOP853 \
         computes them at tolerance 10⁻⁹. An error ranks only if it is at least twice the noise. A \
         run may win only if its energy at the end exceeds the true one by at most {} % of the \
         energy that the scene sets free, or by twice the noise of the energy. It must also keep \
         at least half of the motion: the path of the middle of the free edge, over the true path. \
         On the spread sheet it is the path of the sheet's middle.",
        100.0 * STABLE
    )
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let scenes = facts.scenes.iter();
    let scenes = scenes.map(|scene| fact(format!("scene {}", scene.id), false, scene));
    let rows = facts.rows.iter().flat_map(|row| {
        row.runs.iter().flat_map(move |run| {
            let key = format!("{} {} {}={}", row.scene, row.label, row.knob, run.value);
            let error = run.error.filter(|error| *error < FOLLOWING);
            let outcome = json!({ "verdict": run.verdict, "step_s": run.step_s, "error": error });
            [fact(format!("{key} outcome"), false, &outcome), counts(format!("{key} counts"), run)]
        })
    });
    scenes.chain(rows).collect()
}

/// The counts of a run: compared exactly if they are portable, otherwise only recorded.
pub(in crate::studies) fn counts(key: String, run: &Run) -> Fact {
    let counts = json!({
        "effort": run.effort,
        "modelled_s": run.modelled_s,
        "force_evaluations": run.force_evaluations,
        "matvecs": run.matvecs,
        "factorisations": run.factorisations,
        "cg_iterations": run.cg_iterations,
        "unconverged_steps": run.unconverged_steps,
    });
    fact(key, run.portable, if run.portable { &counts } else { &serde_json::Value::Null })
}
