//! The studies: each asks one question, runs methods, records facts and draws them.
//!
//! A study is one folder: `facts` (the types of its record), `run` (what is computed), `words`
//! (what the record says in prose) and `plates` (figures and tables, drawn from the facts alone).
//! One line of `studies!` makes it known to the list of experiments, to `experiment`,
//! `reproduce`, `report` and to the comparison of facts.

mod page;
pub(crate) mod sheet;
mod stepper;
mod variant;

use crate::facts::Difference;
use crate::journal::Journal;
use crate::methods::Choice;
use crate::run::{Counts, Simulation, count};
use crate::{HarnessError, provenance};
use drape_model::TimeSpan;
use drape_report::file::write_json;
use drape_report::page::Section;
use drape_report::{
    Figure, Files, Provenance, RECORD_FORMAT, Record, ReportError, TIMINGS_FORMAT, Timings,
};
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
        study: &Study,
        account: Account<F>,
    ) -> Result<PathBuf, HarnessError> {
        let Account { method, findings, facts, scenes, seed } = account;
        let name = study.name;
        let quick = if self.quick { " --quick" } else { "" };
        let record = Record {
            format: RECORD_FORMAT.to_owned(),
            experiment: name.to_owned(),
            question: study.question.to_owned(),
            method,
            command: format!("drape experiment {name}{quick}"),
            quick: self.quick,
            findings,
            figures: study.figures(),
            facts,
            provenance: Provenance { seed, ..provenance(scenes) },
        };
        let path = self.out.join(study.file());
        write_json(&path, &record)?;
        Ok(path)
    }

    /// Writes the timings of an experiment; `method` says how they were taken.
    fn write_timings<R: Serialize>(
        &self,
        study: &Study,
        method: String,
        rows: Vec<R>,
        scenes: BTreeMap<String, String>,
    ) -> Result<PathBuf, HarnessError> {
        let timings = Timings {
            format: TIMINGS_FORMAT.to_owned(),
            experiment: study.name.to_owned(),
            method,
            rows,
            provenance: provenance(scenes),
        };
        let path = self.out.join("timings").join(study.file());
        write_json(&path, &timings)?;
        Ok(path)
    }
}

type Comparison = Result<(usize, Vec<Difference>), HarnessError>;

/// An experiment.
pub struct Study {
    /// Its name on the command line.
    pub name: &'static str,
    /// The question that it answers.
    pub question: &'static str,
    /// Names of the experiments that a reader should know before this one.
    pub builds_on: &'static [&'static str],
    run: fn(&Context<'_>) -> Result<Vec<PathBuf>, HarnessError>,
    /// Compares the facts below two folders.
    compare: fn(&Path, &Path) -> Comparison,
    /// File, title and caption of every figure that can be drawn of its record.
    figures: fn() -> Vec<Figure>,
    /// Reads the records named after the study, adds the files of its figures and returns what the
    /// page says; `None` without records.
    section: fn(&Path, &str, &mut Files) -> Result<Option<Section>, ReportError>,
}

/// Declares the folders of the studies and lists them.
macro_rules! studies {
    ($($name:ident),* $(,)?) => {
        $(pub mod $name;)*
        static STUDIES: &[Study] = &[$($name::STUDY),*];
    };
}

// In teaching order: a study stands behind those that it builds on. The page keeps this order.
studies! {
    course,
    pictures,
    order,
    momentum,
    tables,
    cg_vs_stiffness,
    stability,
    locking,
    energy,
    hard_cases,
    collision,
    effects,
    post_correction,
    precomputed_inverse,
    work_precision,
    solver_control,
    scaling,
    claims,
}

/// All experiments, in teaching order, which is also that in which `drape reproduce` runs them.
pub fn all() -> &'static [Study] {
    STUDIES
}

/// Finds an experiment by name.
///
/// # Errors
/// [`HarnessError::UnknownExperiment`] naming the known ones.
pub fn find(name: &str) -> Result<&'static Study, HarnessError> {
    all().iter().find(|study| study.name == name).ok_or_else(|| {
        let known: Vec<_> = all().iter().map(|study| study.name).collect();
        HarnessError::UnknownExperiment { name: name.to_owned(), known: known.join(", ") }
    })
}

/// Method ids in the order of the lessons of the experiment `course`; none for any other experiment.
pub fn lessons(experiment: &str) -> Vec<&'static str> {
    if experiment == course::STUDY.name { course::run::lessons() } else { Vec::new() }
}

/// Draws every figure that the records in the folder `results` hold data for, the report and the
/// index page. Returns the files written, the pages last.
///
/// All records are read and all figures are drawn before the first file is written, so that a broken
/// record leaves the folder as it was.
///
/// # Errors
/// [`ReportError::NoRecords`] when the folder holds no record; otherwise the file that could not be
/// read, understood, drawn or written.
pub fn draw(results: &Path) -> Result<Vec<PathBuf>, ReportError> {
    let mut files = Files::new();
    let mut sections = Vec::new();
    for study in all() {
        sections.extend((study.section)(results, study.name, &mut files)?);
    }
    drape_report::write(results, &sections, &page::OUTLINE, files)
}

impl Study {
    /// File, title and caption of the figures drawn from its record and timings.
    #[must_use]
    pub fn figures(&self) -> Vec<Figure> {
        (self.figures)()
    }

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

impl std::fmt::Debug for Study {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Study").field("name", &self.name).finish_non_exhaustive()
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
        let names: Vec<_> = all().iter().map(|study| study.name).collect();
        for (n, study) in all().iter().enumerate() {
            for before in study.builds_on {
                assert!(names[..n].contains(before), "{}: {before}", study.name);
            }
        }
    }
}
