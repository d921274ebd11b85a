//! Timings: one run at a time. A time counts only if the run repeats the error of the facts.

use super::runs::Timed;
use super::scenes::Setting;
use super::variants::{VARIANTS, Variant};
use crate::HarnessError;
use crate::studies::clocked::{Taken, about_probe, samples};
use crate::studies::work_precision::facts::{Facts, Run, TimingRow, cheapest, rows_of};

/// How the timings are taken.
pub(super) fn method() -> String {
    format!("{METHOD} {}", about_probe())
}

const METHOD: &str = "\
    One run at a time on one thread. The time includes set-up and all steps, but not the work of \
    the harness between steps; for `dop853` it is the whole run. Seconds are the \
    median of three repetitions; a run beyond 0.3 s is timed once. The study times the lightly \
    damped series over the stiffness, the heavily damped sheets from k/m = 10⁶ s⁻² on, and the \
    finest sheet of the same cloth. Of every form it times the quick runs and the runs that are \
    close to a front. A run is ranked only if it repeats the recorded error to the last bit.";

/// A run that takes longer than this is timed once, s.
const LONG_S: f64 = 0.3;
/// All runs up to this effort, in visits of a spring, are timed: the prices of work rest on them.
const QUICK: f64 = 1e7;
/// A run of more effort is timed if its modelled time is at most this many times the least for its
/// error.
const NEAR: f64 = 8.0;

/// A run of the facts that is timed, with its scene and its form.
pub(super) type Chosen<'a> = (&'a Setting, &'static Variant, &'a Run);

/// The runs of small effort and those near the front.
pub(super) fn chosen<'a>(settings: &'a [Setting], facts: &'a Facts) -> Vec<Chosen<'a>> {
    let mut chosen = Vec::new();
    for setting in settings.iter().filter(|setting| setting.case.is_timed()) {
        let rows = || rows_of(facts, &setting.scene.id);
        for row in rows() {
            let Some(variant) = form(&row.label) else { continue };
            let useful = |run: &&Run| {
                run.error.is_some_and(|error| {
                    let least = cheapest(rows(), error).map_or(0.0, |(_, run)| run.modelled_s);
                    run.effort <= QUICK || run.modelled_s <= NEAR * least
                })
            };
            chosen.extend(row.runs.iter().filter(useful).map(|run| (setting, variant, run)));
        }
    }
    chosen
}

/// The form of this label.
pub(super) fn form(label: &str) -> Option<&'static Variant> {
    VARIANTS.iter().find(|variant| variant.label == label)
}

/// Times a run.
pub(super) fn time(&(setting, variant, fact): &Chosen<'_>) -> Result<TimingRow, HarnessError> {
    // Only the positions at the end are compared: nothing watches a run that is timed.
    let setting = &Setting { truth: None, ..setting.clone() };
    let mut last = None;
    let Taken { samples_s, seconds, probe_s } = samples(LONG_S, || {
        let Timed { run, nanoseconds } = setting.run(variant, fact.value)?;
        last = run.error;
        Ok(1e-9 * nanoseconds as f64)
    })?;
    Ok(TimingRow {
        scene: setting.scene.id.clone(),
        label: variant.label.to_owned(),
        value: fact.value,
        seconds,
        samples_ns: samples_s.iter().map(|seconds| (1e9 * seconds).round() as u64).collect(),
        probe_s: Some(probe_s),
        error: last.unwrap_or(f64::MAX),
        is_verified: last.map(f64::to_bits) == fact.error.map(f64::to_bits),
    })
}
