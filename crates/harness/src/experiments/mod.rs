//! The experiments: what is asked, what is run, what is recorded.

mod cg;
mod hard_cases;
mod momentum;
mod order;
mod sheet;
mod tables;
mod variant;

use crate::HarnessError;
use crate::methods::Choice;
use crate::run::{Counts, Simulation, count};
use drape_model::TimeSpan;
use drape_records::Figure;
use rayon::prelude::*;
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
}

impl Context<'_> {
    /// The command that writes the record of an experiment again.
    fn command(&self, experiment: &str) -> String {
        format!("drape experiment {experiment}{}", if self.quick { " --quick" } else { "" })
    }
}

/// An experiment.
pub struct Experiment {
    /// Its name on the command line.
    pub name: &'static str,
    /// The question that it answers.
    pub question: &'static str,
    run: fn(&Context<'_>) -> Result<Vec<PathBuf>, HarnessError>,
}

static EXPERIMENTS: &[Experiment] = &[
    Experiment { name: tables::NAME, question: tables::QUESTION, run: tables::run },
    Experiment { name: cg::NAME, question: cg::QUESTION, run: cg::run },
    Experiment { name: order::NAME, question: order::QUESTION, run: order::run },
    Experiment { name: momentum::NAME, question: momentum::QUESTION, run: momentum::run },
    Experiment { name: hard_cases::NAME, question: hard_cases::QUESTION, run: hard_cases::run },
];

/// All experiments, in the order in which `drape reproduce` runs them.
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

impl Experiment {
    /// Runs it and writes its records; returns the files written.
    ///
    /// # Errors
    /// [`HarnessError`] when a run is refused or a record cannot be written.
    pub fn run(&self, context: &Context<'_>) -> Result<Vec<PathBuf>, HarnessError> {
        (self.run)(context)
    }
}

impl std::fmt::Debug for Experiment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Experiment").field("name", &self.name).finish_non_exhaustive()
    }
}

/// Computes independent cells in parallel, in the order given, telling the progress.
fn cells<T: Sync, R: Send>(
    context: &Context<'_>,
    part: &str,
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError> + Sync,
) -> Result<Vec<R>, HarnessError> {
    context.progress.begin(part, inputs.len());
    let results = inputs
        .par_iter()
        .with_max_len(1)
        .map(|input| {
            let result = compute(input);
            context.progress.done();
            result
        })
        .collect();
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
fn finite(energy: f64) -> f64 {
    if energy.is_nan() { f64::MAX } else { energy.clamp(f64::MIN, f64::MAX) }
}

/// An energy gain in prose.
fn gain(energy: f64) -> String {
    if energy < f64::MAX { format!("{} J", short(energy)) } else { "beyond all bounds".to_owned() }
}

/// A number in prose: three significant digits.
fn short(value: f64) -> String {
    let scientific = format!("{value:.2e}");
    let exponent: i32 = scientific.split('e').nth(1).and_then(|e| e.parse().ok()).unwrap_or(0);
    match usize::try_from(2 - exponent) {
        Ok(digits) if digits <= 5 => format!("{value:.digits$}"),
        _ if exponent == 3 => format!("{value:.0}"),
        _ => scientific,
    }
}
