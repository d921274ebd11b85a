//! The experiments: what is asked, what is run, what is recorded.

mod cg;
mod claims;
mod collision;
mod control;
mod course;
mod effects;
pub(crate) mod energy;
pub(crate) mod hard_cases;
mod locking;
pub(crate) mod momentum;
pub(crate) mod order;
mod pictures;
mod post_correction;
mod precomputed_inverse;
mod scaling;
pub(crate) mod sheet;
mod stability;
mod stepper;
pub(crate) mod tables;
mod variant;
mod work_precision;

use crate::facts::Difference;
use crate::journal::Journal;
use crate::methods::Choice;
use crate::run::{Counts, Simulation, count};
use crate::{HarnessError, provenance};
use drape_model::TimeSpan;
use drape_records::file::write_json;
use drape_records::{Figure, Provenance, RECORD_FORMAT, Record, TIMINGS_FORMAT, Timings};
use rayon::prelude::*;
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Told how far an experiment is.
pub trait Progress: Sync {
    /// A part begins that has this many cells.
    fn begin(&self, part: &str, cells: usize);
    /// A cell is done.
    fn done(&self);
    /// The part has ended.
    fn end(&self);
}

/// Tells how many bytes the process has allocated and not given back.
pub type Allocated = fn() -> usize;

/// What an experiment runs with.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Where records go.
    pub out: &'a Path,
    /// Only the quick subset of the cells.
    pub quick: bool,
    /// The figures that will be drawn from the record.
    pub figures: &'a [Figure],
    /// Told how far it is.
    pub progress: &'a dyn Progress,
    /// Where finished cells are kept until the record is written.
    pub journal: &'a Journal,
    /// Asks the allocator, which only a binary can see; without it no memory is recorded.
    pub allocated: Option<Allocated>,
}

/// What an experiment has to say about its facts.
struct Account<F> {
    /// How they were measured, in a few sentences.
    method: String,
    /// What they say.
    findings: Vec<String>,
    facts: F,
    /// SHA-256 of each scene, by name.
    scenes: BTreeMap<String, String>,
    /// Of the random numbers, where any were drawn.
    seed: Option<u64>,
}

impl Context<'_> {
    /// Writes the record of an experiment.
    fn write<F: Serialize>(
        &self,
        experiment: &Experiment,
        account: Account<F>,
    ) -> Result<PathBuf, HarnessError> {
        let Account { method, findings, facts, scenes, seed } = account;
        let name = experiment.name;
        let quick = if self.quick { " --quick" } else { "" };
        let record = Record {
            format: RECORD_FORMAT.to_owned(),
            experiment: name.to_owned(),
            question: experiment.question.to_owned(),
            method,
            command: format!("drape experiment {name}{quick}"),
            quick: self.quick,
            findings,
            figures: self.figures.to_vec(),
            facts,
            provenance: Provenance { seed, ..provenance(scenes) },
        };
        let path = self.out.join(experiment.file());
        write_json(&path, &record)?;
        Ok(path)
    }

    /// Writes the timings of an experiment; `method` says how they were taken.
    fn write_timings<R: Serialize>(
        &self,
        experiment: &Experiment,
        method: String,
        rows: Vec<R>,
        scenes: BTreeMap<String, String>,
    ) -> Result<PathBuf, HarnessError> {
        let timings = Timings {
            format: TIMINGS_FORMAT.to_owned(),
            experiment: experiment.name.to_owned(),
            method,
            rows,
            provenance: provenance(scenes),
        };
        let path = self.out.join("timings").join(experiment.file());
        write_json(&path, &timings)?;
        Ok(path)
    }
}

type Comparison = Result<(usize, Vec<Difference>), HarnessError>;

/// An experiment.
pub struct Experiment {
    /// Its name on the command line.
    pub name: &'static str,
    /// The question that it answers.
    pub question: &'static str,
    /// Names of the experiments that a reader should know before this one.
    pub builds_on: &'static [&'static str],
    run: fn(&Context<'_>) -> Result<Vec<PathBuf>, HarnessError>,
    /// Compares the facts below two folders.
    compare: fn(&Path, &Path) -> Comparison,
}

/// In teaching order: an experiment stands behind those that it builds on.
static EXPERIMENTS: &[Experiment] = &[
    course::EXPERIMENT,
    pictures::EXPERIMENT,
    order::EXPERIMENT,
    momentum::EXPERIMENT,
    tables::EXPERIMENT,
    cg::EXPERIMENT,
    stability::EXPERIMENT,
    locking::EXPERIMENT,
    energy::EXPERIMENT,
    hard_cases::EXPERIMENT,
    collision::EXPERIMENT,
    effects::EXPERIMENT,
    post_correction::EXPERIMENT,
    precomputed_inverse::EXPERIMENT,
    work_precision::EXPERIMENT,
    control::EXPERIMENT,
    scaling::EXPERIMENT,
    claims::EXPERIMENT,
];

/// All experiments, in teaching order, which is also that in which `drape reproduce` runs them.
pub fn all() -> &'static [Experiment] {
    EXPERIMENTS
}

/// Finds an experiment by name.
///
/// # Errors
/// [`HarnessError::UnknownExperiment`] naming the known ones.
pub fn find(name: &str) -> Result<&'static Experiment, HarnessError> {
    all().iter().find(|experiment| experiment.name == name).ok_or_else(|| {
        let known: Vec<_> = all().iter().map(|experiment| experiment.name).collect();
        HarnessError::UnknownExperiment { name: name.to_owned(), known: known.join(", ") }
    })
}

/// Method ids in the order of the lessons of the experiment `course`; none for any other experiment.
pub fn lessons(experiment: &str) -> Vec<&'static str> {
    if experiment == course::EXPERIMENT.name { course::lessons() } else { Vec::new() }
}

impl Experiment {
    /// Runs it and writes its records; returns the files written.
    ///
    /// # Errors
    /// [`HarnessError`] when a run is refused or a record cannot be written.
    pub fn run(&self, context: &Context<'_>) -> Result<Vec<PathBuf>, HarnessError> {
        (self.run)(context)
    }

    /// Compares its facts below `fresh`, which may be the quick subset, with those below `committed`; returns how
    /// many were compared and those that differ.
    ///
    /// # Errors
    /// [`HarnessError::Record`] when a record is missing or unreadable.
    pub fn compare(
        &self,
        fresh: &Path,
        committed: &Path,
    ) -> Result<(usize, Vec<Difference>), HarnessError> {
        (self.compare)(fresh, committed)
    }

    /// Name of its record's file.
    fn file(&self) -> String {
        format!("{}.json", self.name)
    }
}

impl std::fmt::Debug for Experiment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Experiment").field("name", &self.name).finish_non_exhaustive()
    }
}

/// Computes what cells start from, scenes and references, in parallel and in the order given.
fn prepared<T: Sync, R: Send>(
    context: &Context<'_>,
    part: &str,
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError> + Sync,
) -> Result<Vec<R>, HarnessError> {
    context.progress.begin(part, inputs.len());
    let compute = |input| {
        let result = compute(input);
        context.progress.done();
        result
    };
    let results = inputs.par_iter().with_max_len(1).map(compute).collect();
    context.progress.end();
    results
}

/// Computes independent cells in parallel, in the order given, telling the progress. Those that stand in the journal
/// are not computed again.
fn cells<T: Sync, R: Send + Serialize + DeserializeOwned>(
    context: &Context<'_>,
    part: &str,
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError> + Sync,
) -> Result<Vec<R>, HarnessError> {
    let numbered: Vec<_> = inputs.iter().enumerate().collect();
    prepared(context, part, &numbered, |&(number, input)| {
        context.journal.cell(part, number, || compute(input))
    })
}

/// As [`cells`], one after the other on this thread: what is timed must not be disturbed.
fn timed<T, R: Serialize + DeserializeOwned>(
    context: &Context<'_>,
    part: &str,
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError>,
) -> Result<Vec<R>, HarnessError> {
    context.progress.begin(part, inputs.len());
    let compute = |(number, input)| {
        let result = context.journal.cell(part, number, || compute(input));
        context.progress.done();
        result
    };
    let results = inputs.iter().enumerate().map(compute).collect();
    context.progress.end();
    results
}

/// One simulated second (or another span) of a choice.
fn counts(
    simulation: &Simulation,
    method: &str,
    step_s: f64,
    duration_s: f64,
) -> Result<(Choice, Counts), HarnessError> {
    let choice = Choice::parse(method, &[])?;
    let counts = count(simulation, &choice, TimeSpan { step_s, duration_s })?;
    Ok((choice, counts))
}

/// Energy gain for a record, where JSON knows no infinity.
pub(crate) fn finite(energy: f64) -> f64 {
    if energy.is_nan() { f64::MAX } else { energy.clamp(f64::MIN, f64::MAX) }
}

/// An energy gain in prose.
fn gain(energy: f64) -> String {
    if energy < f64::MAX { format!("{} J", short(energy)) } else { "beyond all bounds".to_owned() }
}

/// A number in prose: three significant digits.
pub(crate) fn short(value: f64) -> String {
    let scientific = format!("{value:.2e}");
    let exponent: i32 = scientific.split('e').nth(1).and_then(|e| e.parse().ok()).unwrap_or(0);
    match usize::try_from(2 - exponent) {
        Ok(digits) if digits <= 5 => format!("{value:.digits$}"),
        _ if exponent == 3 => format!("{value:.0}"),
        _ => scientific,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_experiment_stands_behind_those_that_it_builds_on() {
        let names: Vec<_> = all().iter().map(|experiment| experiment.name).collect();
        for (n, experiment) in all().iter().enumerate() {
            for before in experiment.builds_on {
                assert!(names[..n].contains(before), "{}: {before}", experiment.name);
            }
        }
    }
}
