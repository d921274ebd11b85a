//! The long study. It runs scene by scene, as far as its time allows.

use super::scenes::{self, Case, Setting};
use crate::studies::animation::facts::{Facts, Missing, Run, TimingRow};
use crate::studies::filmed::Stage as _;
use crate::studies::{Context, Measured, in_time};
use crate::{HarnessError, Journal, Verdict};
use std::collections::BTreeMap;

/// The part of the journal that keeps the scenes with their true motions' numbers.
const SCENES: &str = "true motion";

/// Runs the scenes in order. The record names the forms for which time was lacking. A later run of
/// the same program continues there.
pub(in crate::studies::animation) fn run(
    context: &Context<'_>,
) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let cases = if context.quick { Vec::new() } else { scenes::long() };
    let mut facts = Facts { scenes: Vec::new(), runs: Vec::new(), missing: Vec::new() };
    let (mut rows, mut hashes) = (Vec::new(), BTreeMap::new());
    for (number, case) in cases.iter().enumerate() {
        let mut setting = Setting::staged(case)?;
        setting.deadline = context.journal.deadline();
        let films = setting.films();
        let id = setting.scene.id.clone();
        let labels: Vec<_> = films.iter().map(|film| film.form.label.to_owned()).collect();
        // True motions of large cloth take minutes, so they are computed only for forms that still
        // have to run.
        let journal = context.journal;
        let is_due =
            |k: usize| journal.kept::<Vec<Run>>(&id, k).is_none() && journal.takes(&id, k, false);
        let known = journal.kept(SCENES, number);
        let is_due = known.is_none() || (0..films.len()).any(is_due);
        if is_due && !journal.is_late() && finds_true_motion(&mut setting, journal)? {
            setting.scene = journal.cell(SCENES, number, false, || Ok(setting.scene.clone()))?;
        } else if let Some(scene) = known {
            setting.scene = scene;
        }
        // Without a true motion the time is over. Then no form that is due runs.
        let over_budget = over_budget(case, &cases, &facts.runs);
        let is_out = |label: &str| over_budget.iter().any(|out| out == label);
        let mut runs = in_time(context, (&id, false), &films, |film| {
            if is_out(film.form.label) { Ok(Vec::new()) } else { setting.runs(film) }
        })?;
        // A program that ran another part of the study may have run them.
        let spared = runs.iter_mut().zip(&labels).filter(|(_, label)| is_out(label));
        spared.for_each(|(runs, _)| *runs = Some(Vec::new()));
        let part = format!("{id}, timings");
        let times = in_time(context, (&part, true), &runs, |runs| {
            let sound = runs.iter().flatten().filter(|run| Setting::is_timed(run));
            sound.map(|run| setting.time(run)).collect::<Result<Vec<_>, _>>()
        })?;
        let lacking = |has: &dyn Fn(usize) -> bool| -> Vec<String> {
            (0..labels.len()).filter(|&k| !has(k)).map(|k| labels[k].clone()).collect()
        };
        let missing = Missing {
            scene: id.clone(),
            not_run: lacking(&|k| runs[k].is_some()),
            not_timed: lacking(&|k| runs[k].is_none() || times[k].is_some() || is_out(&labels[k])),
            over_budget: over_budget.clone(),
        };
        if missing.names_any() {
            facts.missing.push(missing);
        }
        if runs.iter().all(Option::is_none) {
            continue;
        }
        hashes.insert(id, setting.hash.clone());
        facts.scenes.push(setting.scene);
        facts.runs.extend(runs.into_iter().flatten().flatten());
        rows.extend(times.into_iter().flatten().flatten());
    }
    if !facts.missing.is_empty() && !context.journal.is_alone() {
        return Err(HarnessError::Elsewhere);
    }
    let timings = (!context.quick).then_some(rows);
    Ok(Measured { facts, timings, scenes: hashes, seed: Some(scenes::SEED) })
}

/// Labels of the forms that a case leaves out: on the same cloth over a shorter span they have no
/// sound run and exceed the budget.
pub(super) fn over_budget(case: &Case, cases: &[Case], runs: &[Run]) -> Vec<String> {
    let starts: Vec<_> = cases.iter().filter(|c| case.leaves_out(c)).map(Case::id).collect();
    let own = || runs.iter().filter(|run| starts.contains(&run.scene));
    let sound: Vec<_> = own().filter(|run| run.is_sound()).map(|run| &run.label).collect();
    let spent = own().filter(|run| run.verdict == Verdict::OverBudget).map(|run| &run.label);
    let mut labels: Vec<_> = spent.filter(|label| !sound.contains(label)).cloned().collect();
    labels.dedup();
    labels
}

/// Computes the true motion of a scene. Returns `false` if there was not enough time; then the
/// journal keeps the films that are whole.
fn finds_true_motion(setting: &mut Setting, journal: &Journal) -> Result<bool, HarnessError> {
    match setting.find_true_motion(journal) {
        Err(HarnessError::Late) => Ok(false),
        result => result.map(|()| true),
    }
}
