//! The studies: each asks one question, runs methods, records facts and draws them.
//!
//! A study is one folder. `facts` has the types of its record, and `run` computes it. `words` has
//! the findings in prose. `plates` draws figures and tables from the facts alone. One line of
//! `STUDIES` adds a study to the list of experiments, to `experiment`, `reproduce` and `report`,
//! and to the comparison of facts.

pub mod animation;
pub mod cg_vs_stiffness;
pub mod claims;
mod clocked;
pub mod collision;
pub mod course;
pub mod effects;
pub mod energy;
pub mod fabric;
mod filmed;
pub mod hard_cases;
pub mod locking;
pub mod momentum;
mod names;
pub mod order;
mod page;
pub mod pictures;
pub mod post_correction;
pub mod precomputed_inverse;
pub mod regret;
pub mod rest;
pub mod scaling;
pub(crate) mod sheet;
pub mod solver_control;
pub mod stability;
mod stepper;
pub mod tables;
mod tiles;
pub mod trajectory;
pub mod uses;
pub(crate) mod variant;
pub mod work_precision;

use crate::facts::{Difference, Fact, compare};
use crate::journal::Journal;
use crate::methods::Choice;
use crate::run::{Counts, Runner, Simulation};
use crate::shard::Missing;
use crate::{HarnessError, Source, provenance, sha256};
use drape_integrator::PrepareError;
use drape_model::{SystemSpec, TimeSpan};
use drape_report::file::{read_json, write_json};
use drape_report::page::{Lesson, Section, Table};
use drape_report::plate::{self, Plate};
use drape_report::{
    Figure, Files, Provenance, RECORD_FORMAT, Record, ReportError, TIMINGS_FORMAT, Timings, Words,
    read_record, read_timings,
};
use rayon::prelude::*;
use schemars::{JsonSchema, Schema, schema_for};
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Receives the progress of an experiment.
pub trait Progress: Sync {
    /// A part with this many cells begins.
    fn begin(&self, part: &str, cells: usize);
    /// A cell is complete.
    fn done(&self);
    /// The part has ended.
    fn end(&self);
}

/// Returns the number of bytes that the process holds from the allocator.
pub type Allocated = fn() -> usize;

/// Options and services for running an experiment.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Folder for the records.
    pub out: &'a Path,
    /// Whether to compute only the quick subset of the cells.
    pub quick: bool,
    /// Whether to take the timings that take long. `drape reproduce` leaves these as they are.
    pub long: bool,
    /// Receives the progress.
    pub progress: &'a dyn Progress,
    /// Keeps finished cells until the record is written.
    pub journal: &'a Journal,
    /// Asks the allocator for the bytes in use, which only a binary can do. If `None`, no memory is
    /// recorded.
    pub allocated: Option<Allocated>,
    /// The source from which the program was built.
    pub source: &'a Source,
}

/// The results of a study's run.
struct Measured<F, T = ()> {
    facts: F,
    /// The rows of the timings, if they were taken.
    timings: Option<Vec<T>>,
    /// SHA-256 of each scene, by name.
    scenes: BTreeMap<String, String>,
    /// Seed of the random numbers, if any were drawn.
    seed: Option<u64>,
}

/// Input of a study's figures and tables: its facts, and its timings if they were taken.
pub(crate) struct Input<F, T = ()> {
    pub(crate) facts: F,
    pub(crate) timings: Option<Timings<T>>,
}

impl<F, T> Input<F, T> {
    /// A note that names the processor of the times; `None` without timings.
    pub(crate) fn machine(&self) -> Option<String> {
        let timings = self.timings.as_ref()?;
        Some(format!("Times of one core of {}.", timings.provenance.cpu))
    }
}

/// The parts of a study, from its folder. `F` are its facts, `T` is a row of its timings.
struct Parts<F: 'static, T: 'static = ()> {
    name: &'static str,
    question: &'static str,
    builds_on: &'static [&'static str],
    /// How the facts are measured.
    method: fn() -> String,
    /// The timings; `None` if nothing is timed.
    timing: Option<Timing<F, T>>,
    /// The systems from which its runs start.
    starts: fn() -> Vec<Start>,
    run: fn(&Context<'_>) -> Result<Measured<F, T>, HarnessError>,
    /// The facts in the form in which two records are compared.
    comparable: fn(&F) -> Vec<Fact>,
    words: fn(&F) -> Words,
    plates: &'static [Plate<Input<F, T>>],
    tables: fn(&Input<F, T>) -> Vec<Table>,
    lessons: Option<fn(&F) -> Vec<Lesson>>,
}

/// The timings of a study.
struct Timing<F: 'static, T: 'static> {
    /// How they are taken.
    method: fn() -> String,
    /// What more a page says about these rows.
    about: fn(&[T]) -> Option<String>,
    /// Takes those of a record anew; `None` if they can only be taken with the facts.
    again: Option<Again<F, T>>,
}

/// Takes the timings of the runs in a record's facts. Returns these facts, without the timings that
/// they may have named as missing, and the rows.
type Again<F, T> = fn(&Context<'_>, F, &Recorded<'_>) -> Result<(F, Vec<T>), HarnessError>;

/// The record whose runs are timed anew.
struct Recorded<'a> {
    /// Path of the record.
    path: &'a Path,
    /// The hashes of its scenes, by name.
    hashes: &'a BTreeMap<String, String>,
    /// How many times all runs are timed, one round after the other.
    rounds: u32,
}

impl Recorded<'_> {
    /// Times all runs, round after round. The quickest timing of each run counts. `facts` are those
    /// of the record: a journal goes on only with the same.
    fn timed<T, R: Serialize + DeserializeOwned>(
        &self,
        context: &Context<'_>,
        facts: &impl Serialize,
        runs: &[T],
        (time, seconds): (impl Fn(&T) -> Result<R, HarnessError>, impl Fn(&R) -> f64),
    ) -> Result<Vec<R>, HarnessError> {
        let hash = sha256(&serde_json::to_vec(facts).unwrap_or_default());
        let mut rows = Vec::new();
        for round in 1..=self.rounds {
            let round = if round > 1 { format!(", round {round}") } else { String::new() };
            let part = format!("timings of the record {}{round}", &hash[..8]);
            rows = quickest(rows, timed(context, &part, runs, &time)?.all()?, &seconds);
        }
        Ok(rows)
    }

    /// Passes on this program's own scene of this name if the record has the same.
    fn same<S>(
        &self,
        scene: &str,
        own: Option<S>,
        hash: impl Fn(&S) -> &str,
    ) -> Result<S, HarnessError> {
        let other = |found: String| {
            let (record, scene) = (self.path.to_owned(), scene.to_owned());
            HarnessError::OtherScene { record, scene, found }
        };
        let own = own.ok_or_else(|| other("is unknown to this program".to_owned()))?;
        match self.hashes.get(scene) {
            Some(recorded) if recorded == hash(&own) => Ok(own),
            Some(recorded) => Err(other(format!("has the hash {recorded}, not {}", hash(&own)))),
            None => Err(other("has no hash".to_owned())),
        }
    }
}

impl<F, T> Timing<F, T> {
    /// Timings that are taken with the facts.
    const fn of(method: fn() -> String) -> Self {
        Self { method, about: |_| None, again: None }
    }
}

/// A function that makes a system.
type Maker = Box<dyn Fn() -> Result<SystemSpec, HarnessError>>;

/// A system from which a study starts runs, with its positions and velocities.
pub struct Start {
    name: String,
    make: Maker,
}

impl Start {
    fn new(
        name: impl Into<String>,
        make: impl Fn() -> Result<SystemSpec, HarnessError> + 'static,
    ) -> Self {
        Self { name: name.into(), make: Box::new(make) }
    }

    /// Its name within the study.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The system, with positions and velocities at the start.
    ///
    /// # Errors
    /// [`HarnessError`] if it cannot be built.
    pub fn system(&self) -> Result<SystemSpec, HarnessError> {
        (self.make)()
    }
}

impl std::fmt::Debug for Start {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Start").field("name", &self.name).finish_non_exhaustive()
    }
}

/// An experiment.
pub trait Study: Sync {
    /// Its name on the command line.
    fn name(&self) -> &'static str;

    /// The question that it answers.
    fn question(&self) -> &'static str;

    /// Names of the experiments that a reader should know before this one.
    fn builds_on(&self) -> &'static [&'static str];

    /// The systems from which its runs start, under the names by which its record keeps their
    /// hashes.
    fn starts(&self) -> Vec<Start>;

    /// File, title and caption of every figure that its record and timings may have.
    fn figures(&self) -> Vec<Figure>;

    /// JSON Schema of its facts and of a row of its timings, as a pair.
    fn schema(&self) -> Schema;

    /// Runs it and writes its records. Returns the files that were written.
    ///
    /// # Errors
    /// [`HarnessError::Elsewhere`] if its journal belongs to a shard, or lacks cells and must not
    /// compute them. [`HarnessError`] if a run is refused or a record cannot be written.
    fn run(&self, context: &Context<'_>) -> Result<Vec<PathBuf>, HarnessError>;

    /// Whether its timings can be taken anew without its facts.
    fn has_own_timings(&self) -> bool;

    /// Takes the timings of the runs anew that its record in the folder of the results has, and
    /// computes no other run. It takes them in several rounds, one after the other; the quickest
    /// timing of each run counts. Returns the files that were written.
    ///
    /// # Errors
    /// [`HarnessError::NoOwnTimings`] if they can only be taken with its facts;
    /// [`HarnessError::OtherScene`] or [`HarnessError::OtherForm`] if the record has a scene or a form
    /// that this program does not have. [`HarnessError`] if a record cannot be read or written.
    fn retime(&self, context: &Context<'_>, rounds: u32) -> Result<Vec<PathBuf>, HarnessError>;

    /// Compares its facts below `fresh`, which may be the quick subset, with those below
    /// `committed`. Returns the number of facts that were compared, and those that differ.
    ///
    /// # Errors
    /// [`HarnessError::Record`] if a record is missing or unreadable.
    fn compare(
        &self,
        fresh: &Path,
        committed: &Path,
    ) -> Result<(usize, Vec<Difference>), HarnessError>;

    /// The values of its comparable facts below `results`.
    ///
    /// # Errors
    /// [`HarnessError::Record`] if the record is missing or unreadable.
    fn comparable(&self, results: &Path) -> Result<Vec<serde_json::Value>, HarnessError>;

    /// Rewrites the question, method, words and captions of its record below `results`, as the code
    /// computes them from the facts. Returns whether the record changed.
    ///
    /// # Errors
    /// [`ReportError`] if the record cannot be read or written.
    fn reword(&self, results: &Path) -> Result<bool, ReportError>;

    /// Reads its records, adds the files of its figures to `files`, and returns its section of the
    /// page. Returns `None` without records.
    ///
    /// # Errors
    /// [`ReportError`] if a record cannot be read or a figure cannot be drawn.
    fn section(&self, results: &Path, files: &mut Files) -> Result<Option<Section>, ReportError>;
}

impl<F, T> Parts<F, T>
where
    F: Serialize + DeserializeOwned + JsonSchema + 'static,
    T: Serialize + DeserializeOwned + JsonSchema + 'static,
{
    /// Name of the record's file.
    fn file(&self) -> String {
        format!("{}.json", self.name)
    }

    /// Writes the timings, which were taken in so many rounds, and returns their path.
    fn write_timings(
        &self,
        context: &Context<'_>,
        (timing, rows, rounds): (&Timing<F, T>, Vec<T>, u32),
        provenance: Provenance,
    ) -> Result<PathBuf, HarnessError> {
        let timings = Timings {
            format: TIMINGS_FORMAT.to_owned(),
            experiment: self.name.to_owned(),
            method: (timing.method)() + &told_rounds(rounds),
            rows,
            provenance,
        };
        let path = context.out.join("timings").join(self.file());
        write_json(&path, &timings)?;
        Ok(path)
    }

    /// The same facts with the texts that the code makes of them.
    fn worded(&self, record: Record<F>) -> Record<F> {
        Record {
            question: self.question.to_owned(),
            method: (self.method)(),
            words: (self.words)(&record.facts),
            figures: self.figures(),
            ..record
        }
    }

    fn record(&self, quick: bool, facts: F, provenance: Provenance) -> Record<F> {
        let flag = if quick { " --quick" } else { "" };
        let methods = crate::methods::options();
        self.worded(Record {
            format: RECORD_FORMAT.to_owned(),
            experiment: self.name.to_owned(),
            question: String::new(),
            method: String::new(),
            words: Words::default(),
            command: format!("drape experiment {}{flag}{methods}", self.name),
            quick,
            figures: Vec::new(),
            facts,
            provenance,
        })
    }
}

impl<F, T> Study for Parts<F, T>
where
    F: Serialize + DeserializeOwned + JsonSchema + 'static,
    T: Serialize + DeserializeOwned + JsonSchema + 'static,
{
    fn name(&self) -> &'static str {
        self.name
    }

    fn question(&self) -> &'static str {
        self.question
    }

    fn builds_on(&self) -> &'static [&'static str] {
        self.builds_on
    }

    fn starts(&self) -> Vec<Start> {
        (self.starts)()
    }

    fn figures(&self) -> Vec<Figure> {
        self.plates.iter().map(Plate::figure).collect()
    }

    fn schema(&self) -> Schema {
        schema_for!((F, T))
    }

    fn run(&self, context: &Context<'_>) -> Result<Vec<PathBuf>, HarnessError> {
        let Measured { facts, timings, scenes, seed } = (self.run)(context)?;
        if context.journal.is_part() {
            return Err(HarnessError::Elsewhere);
        }
        let provenance = provenance(context.source, scenes);
        let path = context.out.join(self.file());
        let own = Provenance { seed, ..provenance.clone() };
        write_json(&path, &self.record(context.quick, facts, own))?;
        let mut files = vec![path];
        if let Some((rows, timing)) = timings.zip(self.timing.as_ref()) {
            files.push(self.write_timings(context, (timing, rows, 1), provenance)?);
        }
        Ok(files)
    }

    fn has_own_timings(&self) -> bool {
        self.timing.as_ref().is_some_and(|timing| timing.again.is_some())
    }

    fn retime(&self, context: &Context<'_>, rounds: u32) -> Result<Vec<PathBuf>, HarnessError> {
        let own = self.timing.as_ref().and_then(|timing| Some((timing, timing.again?)));
        let Some((timing, again)) = own else {
            let known = all().iter().filter(|study| study.has_own_timings());
            let known = known.map(|study| study.name()).collect::<Vec<_>>().join(", ");
            return Err(HarnessError::NoOwnTimings { study: self.name, known });
        };
        let path = context.out.join(self.file());
        // Without a file the error of `read_json` names it.
        let record = read_record::<F>(context.out, self.name)?;
        let mut record: Record<F> = record.map_or_else(|| read_json(&path), Ok)?;
        let scenes = record.provenance.scene_sha256.clone();
        let recorded = Recorded { path: &path, hashes: &scenes, rounds };
        let (facts, rows) = again(context, record.facts, &recorded)?;
        record.facts = facts;
        let written = self.write_timings(
            context,
            (timing, rows, rounds),
            provenance(context.source, scenes),
        )?;
        // The facts may have named timings as missing, and so the words.
        write_json(&path, &self.worded(record))?;
        Ok(vec![path, written])
    }

    fn compare(
        &self,
        fresh: &Path,
        committed: &Path,
    ) -> Result<(usize, Vec<Difference>), HarnessError> {
        compare(&self.file(), fresh, committed, self.comparable)
    }

    fn comparable(&self, results: &Path) -> Result<Vec<serde_json::Value>, HarnessError> {
        let record: Record<F> = read_json(&results.join(self.file()))?;
        Ok((self.comparable)(&record.facts).into_iter().map(|fact| fact.values).collect())
    }

    fn reword(&self, results: &Path) -> Result<bool, ReportError> {
        let Some(record) = read_record::<F>(results, self.name)? else { return Ok(false) };
        let said = |record: &Record<F>| {
            let Record { question, method, words, figures, .. } = record;
            (question.clone(), method.clone(), words.clone(), figures.clone())
        };
        let before = said(&record);
        let record = self.worded(record);
        let has_changed = said(&record) != before;
        if has_changed {
            write_json(&results.join(self.file()), &record)?;
        }
        Ok(has_changed)
    }

    fn section(&self, results: &Path, files: &mut Files) -> Result<Option<Section>, ReportError> {
        let Some(record) = read_record::<F>(results, self.name)? else { return Ok(None) };
        let timings = match self.timing {
            Some(_) => read_timings(results, self.name)?,
            None => None,
        };
        let (frame, facts) = record.split();
        let input = Input { facts, timings };
        let figures = plate::draw_all(self.plates, &input, files)?;
        let mut section = Section::new(&frame, figures, (self.tables)(&input));
        if let Some(timing) = &self.timing {
            let timings = input.timings.as_ref();
            let more = timings.and_then(|timings| (timing.about)(&timings.rows));
            section = section.with_timings(timings, more.as_deref());
        }
        let lessons = self.lessons.map_or_else(Vec::new, |lessons| lessons(&input.facts));
        Ok(Some(section.with_lessons(lessons)))
    }
}

impl std::fmt::Debug for dyn Study {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Study").field("name", &self.name()).finish_non_exhaustive()
    }
}

/// The studies in teaching order: a study comes after those on which it builds. The page keeps this
/// order.
static STUDIES: [&dyn Study; 24] = [
    &course::STUDY,
    &pictures::STUDY,
    &order::STUDY,
    &momentum::STUDY,
    &tables::STUDY,
    &cg_vs_stiffness::STUDY,
    &stability::STUDY,
    &locking::STUDY,
    &energy::STUDY,
    &hard_cases::STUDY,
    &collision::STUDY,
    &effects::STUDY,
    &post_correction::STUDY,
    &precomputed_inverse::STUDY,
    &work_precision::STUDY,
    &trajectory::STUDY,
    &animation::STUDY,
    &animation::LONG,
    &rest::STUDY,
    &regret::STUDY,
    &fabric::STUDY,
    &solver_control::STUDY,
    &scaling::STUDY,
    &claims::STUDY,
];

/// All experiments in teaching order. `drape reproduce` runs them in this order, the [long](is_long)
/// ones apart.
pub fn all() -> &'static [&'static dyn Study] {
    &STUDIES
}

/// Experiments that only `drape reproduce --long` runs: those on large cloth, for long, or on the many
/// scenes where methods fail; the one to whose runs prices are fitted, with the one that tests advice
/// from it; and the side studies of effects, fabrics and solvers. `drape reproduce` leaves their
/// records as they are.
const LONG: [&str; 8] = [
    hard_cases::STUDY.name,
    effects::STUDY.name,
    work_precision::STUDY.name,
    animation::LONG.name,
    regret::STUDY.name,
    fabric::STUDY.name,
    solver_control::STUDY.name,
    scaling::STUDY.name,
];

/// Whether only `drape reproduce --long` runs an experiment.
pub fn is_long(study: &dyn Study) -> bool {
    LONG.contains(&study.name())
}

/// Finds an experiment by name.
///
/// # Errors
/// [`HarnessError::UnknownExperiment`], which names the known ones.
pub fn find(name: &str) -> Result<&'static dyn Study, HarnessError> {
    all().iter().copied().find(|study| study.name() == name).ok_or_else(|| {
        let known: Vec<_> = all().iter().map(|study| study.name()).collect();
        HarnessError::UnknownExperiment { name: name.to_owned(), known: known.join(", ") }
    })
}

/// The study with this name, or the only one whose name begins with it.
fn beginning(name: &str) -> Option<&'static dyn Study> {
    let mut others = all().iter().copied().filter(|study| study.name().starts_with(name));
    let only = others.next().filter(|_| !name.is_empty() && others.next().is_none());
    find(name).ok().or(only)
}

/// The start with the name `STUDY/NAME`; `None` if no study has that name. An unambiguous beginning
/// of the study's name suffices.
///
/// # Errors
/// [`HarnessError::UnknownStart`], which names the starts of the study.
pub fn start(path: &str) -> Result<Option<Start>, HarnessError> {
    let parts = path.split_once('/');
    let study = parts.and_then(|(study, name)| Some((beginning(study)?, name)));
    let Some((study, name)) = study else { return Ok(None) };
    let mut starts = study.starts();
    match starts.iter().position(|start| start.name == name) {
        Some(place) => Ok(Some(starts.swap_remove(place))),
        None => {
            let known: Vec<_> = starts.iter().map(|start| start.name.as_str()).collect();
            let (study, name) = (study.name(), name.to_owned());
            Err(HarnessError::UnknownStart { study, name, known: known.join("; ") })
        }
    }
}

/// Method ids in the order of the lessons of the experiment `course`. Empty for any other
/// experiment.
pub fn lessons(experiment: &str) -> Vec<&'static str> {
    if experiment == course::STUDY.name { course::run::lessons() } else { Vec::new() }
}

/// Draws every figure for which the folder `results` has data, the report and the index page.
/// Returns the files that were written, the pages last.
///
/// All records are read and all figures are drawn before the first file is written. A broken record
/// therefore leaves the folder as it was.
///
/// # Errors
/// [`ReportError::NoRecords`] if the folder has no record. Otherwise [`ReportError`] names the file
/// that could not be read, understood, drawn or written.
pub fn draw(results: &Path) -> Result<Vec<PathBuf>, ReportError> {
    let mut files = Files::new();
    let mut sections = Vec::new();
    for study in all() {
        sections.extend(study.section(results, &mut files)?);
    }
    drape_report::write(results, &sections, &page::OUTLINE, uses::table(results), files)
}

/// Computes the inputs of cells, i.e. scenes and references, in parallel. Results keep the order of
/// `inputs`.
fn prepared<T: Sync, R: Send>(
    context: &Context<'_>,
    part: &str,
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError> + Sync,
) -> Result<Vec<R>, HarnessError> {
    context.progress.begin(part, inputs.len());
    let results =
        inputs.par_iter().with_max_len(1).map(|input| told(context, compute(input))).collect();
    context.progress.end();
    results
}

/// As [`prepared`], but one after the other on this thread.
fn one_by_one<T, R>(
    context: &Context<'_>,
    part: &str,
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError>,
) -> Result<Vec<R>, HarnessError> {
    context.progress.begin(part, inputs.len());
    let results = inputs.iter().map(|input| told(context, compute(input))).collect();
    context.progress.end();
    results
}

/// Passes on a result and reports progress.
fn told<R>(context: &Context<'_>, result: R) -> R {
    context.progress.done();
    result
}

/// The cells of a part, in order; `None` in a process that computes only a shard of them.
#[must_use]
struct Cells<R>(Option<Vec<R>>);

impl<R> Cells<R> {
    /// All cells. A study asks for them only after it has named all its parts. Thus a shard
    /// computes its cells of each part.
    fn all(self) -> Result<Vec<R>, HarnessError> {
        self.0.ok_or(HarnessError::Elsewhere)
    }
}

/// The inputs of the cells that this process has or computes, with their numbers, and whether these
/// are all cells. Missing cells are noted in the journal.
fn turns<'a, T>(
    journal: &Journal,
    part: &str,
    inputs: &'a [T],
    is_timed: bool,
) -> (Vec<(usize, &'a T)>, bool) {
    let numbered = inputs.iter().enumerate();
    let (turns, rest): (Vec<_>, Vec<_>) =
        numbered.partition(|(number, _)| journal.takes(part, *number, is_timed));
    let is_whole = rest.is_empty();
    if !is_whole {
        let numbers = rest.into_iter().map(|(number, _)| number).collect();
        journal.miss(Missing { part: part.to_owned(), of: inputs.len(), numbers, is_timed });
    }
    (turns, is_whole)
}

/// Computes independent cells in parallel and reports progress. Results keep the order of `inputs`.
/// Cells in the journal are not computed again.
fn cells<T: Sync, R: Send + Serialize + DeserializeOwned>(
    context: &Context<'_>,
    part: &str,
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError> + Sync,
) -> Result<Cells<R>, HarnessError> {
    let (turns, is_whole) = turns(context.journal, part, inputs, false);
    let results = prepared(context, part, &turns, |&(number, input)| {
        context.journal.cell(part, number, false, || compute(input))
    })?;
    Ok(Cells(is_whole.then_some(results)))
}

/// As [`cells`], but without cells whose method does not support the scene.
fn taken<T: Sync, R: Send + Serialize + DeserializeOwned>(
    context: &Context<'_>,
    part: &str,
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError> + Sync,
) -> Result<Cells<R>, HarnessError> {
    let results = cells(context, part, inputs, |input| match compute(input) {
        Err(HarnessError::Prepare(PrepareError::Unsupported { .. })) => Ok(None),
        result => result.map(Some),
    })?;
    Ok(Cells(results.0.map(|results| results.into_iter().flatten().collect())))
}

/// As [`cells`], but one after the other on this thread, since nothing may disturb a timed run.
fn timed<T, R: Serialize + DeserializeOwned>(
    context: &Context<'_>,
    part: &str,
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError>,
) -> Result<Cells<R>, HarnessError> {
    let (turns, is_whole) = turns(context.journal, part, inputs, true);
    let results = one_by_one(context, part, &turns, |&(number, input)| {
        context.journal.cell(part, number, true, || compute(input))
    })?;
    Ok(Cells(is_whole.then_some(results)))
}

/// What the text about timings says of several rounds.
fn told_rounds(rounds: u32) -> String {
    match rounds {
        1 => String::new(),
        _ => format!(
            " All runs were timed in {rounds} rounds, one after the other; the quickest timing of \
             each counts."
        ),
    }
}

/// The quicker timing of each run, of two rounds with the same runs. The first may be empty.
fn quickest<T>(rows: Vec<T>, others: Vec<T>, seconds: impl Fn(&T) -> f64) -> Vec<T> {
    if rows.is_empty() {
        return others;
    }
    let pairs = rows.into_iter().zip(others);
    pairs.map(|(row, other)| if seconds(&other) < seconds(&row) { other } else { row }).collect()
}

/// As [`cells`] or [`timed`]. A cell for which this process has no time, or which it may not
/// compute, is `None` and noted as missing.
fn in_time<T: Sync, R: Send + Serialize + DeserializeOwned>(
    context: &Context<'_>,
    (part, is_timed): (&str, bool),
    inputs: &[T],
    compute: impl Fn(&T) -> Result<R, HarnessError> + Sync,
) -> Result<Vec<Option<R>>, HarnessError> {
    let journal = context.journal;
    let numbered: Vec<_> = inputs.iter().enumerate().collect();
    let one = |&(number, input): &(usize, &T)| match journal.kept(part, number) {
        Some(kept) => Ok(Some(kept)),
        None if !journal.takes(part, number, is_timed) || journal.is_late() => Ok(None),
        None => match journal.cell(part, number, is_timed, || compute(input)) {
            Err(HarnessError::Late) => Ok(None),
            result => result.map(Some),
        },
    };
    let results: Vec<Option<R>> = if is_timed {
        one_by_one(context, part, &numbered, one)?
    } else {
        prepared(context, part, &numbered, one)?
    };
    let numbers: Vec<_> = (0..results.len()).filter(|&n| results[n].is_none()).collect();
    if !numbers.is_empty() {
        journal.miss(Missing { part: part.to_owned(), of: inputs.len(), numbers, is_timed });
    }
    Ok(results)
}

/// Runs a method for `duration_s` and returns its counts.
fn counts(
    simulation: &Simulation,
    method: &str,
    step_s: f64,
    duration_s: f64,
) -> Result<(Choice, Counts), HarnessError> {
    let choice = Choice::parse(method, &[])?;
    let counts = Runner::new(&choice, TimeSpan { step_s, duration_s }).count(simulation)?;
    Ok((choice, counts))
}

/// An energy gain for a record. JSON has no infinity.
pub(crate) fn finite(energy: f64) -> f64 {
    if energy.is_nan() { f64::MAX } else { energy.clamp(f64::MIN, f64::MAX) }
}

/// A number in prose, with three significant digits.
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
    fn of_several_rounds_the_quickest_timing_of_each_run_counts() {
        let own = |row: &(&str, f64)| row.1;
        let first = quickest(Vec::new(), vec![("a", 3.0), ("b", 1.0)], own);
        let both = quickest(first, vec![("a again", 2.0), ("b again", 1.5)], own);
        assert_eq!(both, [("a again", 2.0), ("b", 1.0)]);
        assert!(told_rounds(1).is_empty() && told_rounds(4).contains("in 4 rounds"));
    }

    #[test]
    fn every_experiment_stands_behind_those_that_it_builds_on() {
        let names: Vec<_> = all().iter().map(|study| study.name()).collect();
        for (n, study) in all().iter().enumerate() {
            for before in study.builds_on() {
                assert!(names[..n].contains(before), "{}: {before}", study.name());
            }
        }
    }

    /// The committed record of a study has the hash of each system from which it started, with
    /// positions and velocities. A name must give that system.
    #[test]
    fn the_start_of_each_name_is_that_of_the_committed_record() {
        let results = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../results"));
        let mut seen = 0;
        for study in all() {
            let name = study.name();
            let record: Record<serde_json::Value> =
                read_json(&results.join(format!("{name}.json"))).expect(name);
            let starts = study.starts();
            for (n, start) in starts.iter().enumerate() {
                assert!(starts[..n].iter().all(|s| s.name != start.name), "{name}/{}", start.name);
            }
            for (scene, hash) in &record.provenance.scene_sha256 {
                let start = start(&format!("{name}/{scene}")).expect(name).expect(scene);
                let found = crate::system_hash(&start.system().expect(scene));
                assert_eq!(&found, hash, "{name}/{scene}");
                seen += 1;
            }
        }
        assert!(seen > 200, "{seen}");
    }

    /// Records have no hash of large systems, of stiff references and of pushed cloths. The names
    /// of these follow from the cells.
    #[test]
    fn what_a_committed_record_ran_without_a_hash_has_a_start_too() {
        let results = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../results"));
        let cells = |(file, place): (&str, &str)| -> Vec<serde_json::Value> {
            let record: serde_json::Value = read_json(&results.join(file)).expect(file);
            record.pointer(place).and_then(|cells| cells.as_array()).expect(place).clone()
        };
        let word = |cell: &serde_json::Value, key: &str| cell[key].as_str().map(str::to_owned);
        let mut expected = std::collections::BTreeSet::new();
        let sheets = [("scaling.json", "/facts/cells"), ("timings/scaling.json", "/rows")];
        for cell in sheets.into_iter().flat_map(cells) {
            // The memory of a sheet and the bandwidth have no series.
            let Some(series) = word(&cell, "series") else { continue };
            expected.insert(("scaling", format!("{series} n={}", cell["particles"])));
        }
        for row in cells(("post-correction.json", "/facts/rows")) {
            let mesh = word(&row, "mesh").expect("a mesh");
            let order = word(&row, "order").expect("an order");
            let is_other = order.starts_with("list") || order == post_correction::facts::PERTURBED;
            expected.insert(("post-correction", format!("{mesh}, stiff")));
            expected.extend(is_other.then(|| ("post-correction", format!("{mesh}, {order}"))));
        }
        for spin in cells(("post-correction.json", "/facts/spins")) {
            let mesh = word(&spin, "mesh").expect("a mesh");
            expected.insert(("post-correction", format!("{mesh}, spinning")));
        }
        let asked = [("regret.json", "/facts/cases"), ("timings/regret.json", "/rows")];
        for case in asked.into_iter().flat_map(cells) {
            let scene = word(&case, "scene").expect("a scene");
            expected.insert(("regret", format!("{scene}, pushed")));
        }
        for (study, name) in &expected {
            let found = start(&format!("{study}/{name}")).unwrap_or_else(|error| panic!("{error}"));
            let start = found.expect(study);
            // Large systems are only named here: each takes up to a gigabyte.
            let particles = name.split_once("n=").map(|(_, n)| n.parse::<usize>().expect(name));
            if particles.is_none_or(|particles| particles < 10_000) {
                start.system().expect(name).build().expect(name);
            }
        }
        assert!(expected.len() >= 13 + 10 + 40, "{expected:?}");
    }

    #[test]
    fn a_start_that_is_not_there_is_refused_with_those_that_are() {
        assert!(start("hanging-wool").expect("a scene").is_none());
        assert!(start("no-study/smooth").expect("a file").is_none());
        let error = start("order/rough").expect_err("no such start").to_string();
        assert!(error.contains("`rough`") && error.contains("smooth; smooth-projected"), "{error}");
    }

    /// Number of sentences. A sentence ends with a mark and a space, or with the text.
    fn sentences(text: &str) -> usize {
        let ends = [". ", "? ", "! "].iter().map(|end| text.matches(end).count()).sum::<usize>();
        ends + usize::from(!text.is_empty())
    }

    #[test]
    fn committed_words_follow_from_their_facts_and_are_few() {
        let results = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../results"));
        let folder = tempfile::tempdir().expect("a folder");
        for study in all() {
            let (name, file) = (study.name(), format!("{}.json", study.name()));
            let copy = folder.path().join(&file);
            std::fs::copy(results.join(&file), &copy).expect("a committed record");
            let is_stale = study.reword(folder.path()).expect("a readable record");
            assert!(!is_stale, "{name}: run `cargo run -p drape-tests --bin splice`");
            let record: Record<serde_json::Value> =
                drape_report::file::read_json(&copy).expect("a record");
            let Words { conclusion, observations, caveats } = record.words;
            assert!((1..=3).contains(&sentences(&conclusion)), "{name}: {conclusion}");
            assert!(observations.len() <= 5, "{name}: {} observations", observations.len());
            for text in observations.iter().chain(&caveats) {
                assert!(!text.is_empty() && text.ends_with('.'), "{name}: {text}");
            }
            for sentence in &observations {
                assert_eq!(sentences(sentence), 1, "{name}: {sentence}");
            }
        }
    }

    #[test]
    fn a_stale_word_is_seen_and_written_anew() {
        let results = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../results"));
        let folder = tempfile::tempdir().expect("a folder");
        let text = std::fs::read_to_string(results.join("order.json")).expect("a record");
        let stale = text.replacen("\"conclusion\": \"", "\"conclusion\": \"Once. ", 1);
        assert_ne!(text, stale);
        std::fs::write(folder.path().join("order.json"), stale).expect("written");
        let study = find("order").expect("a study");
        assert!(study.reword(folder.path()).expect("reworded"));
        assert!(!study.reword(folder.path()).expect("as it should be"));
    }
}
