//! Content of the pages: sections of prose, figures and tables, each made from one record.

mod html;
mod index;
mod inline;

pub(crate) use html::{ALL, report};
pub(crate) use index::index;

use crate::{Figure, Provenance, Record, Timings, Words};
use serde::Serialize;

/// The order of the page, and the studies whose sentences open it.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// Parts of the report in order.
    pub parts: &'static [Part],
    /// Studies whose conclusions answer the reader's question, if their records exist.
    pub answers: &'static [&'static str],
    /// How many of these studies the answer quotes at most.
    pub longest_answer: usize,
    /// Groups of figures for the place beside the answer. The first group with a drawn figure is
    /// shown; if there is none, the first figure of all is shown.
    pub leads: &'static [&'static [&'static str]],
}

/// The head of the page, above all parts.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Head<'a> {
    /// Heading, and title of the window.
    pub title: &'a str,
    /// Lead: the subject of the page.
    pub lead: &'a str,
}

/// A part of the report. The studies that it names come in this order; a part without names takes
/// all others.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Heading.
    pub title: &'static str,
    /// Names of the studies in this part.
    pub studies: &'static [&'static str],
    /// Whether the first table of a section is shown, unfolded, before its conclusion.
    pub table_first: bool,
}

/// The content of the page about one study.
#[derive(Serialize)]
pub struct Section {
    name: String,
    question: String,
    method: String,
    command: String,
    quick: bool,
    words: Words,
    /// File of the record, beside the page.
    record: String,
    notes: Vec<String>,
    figures: Vec<Figure>,
    tables: Vec<Table>,
    lessons: Vec<Lesson>,
    provenance: Vec<Origin>,
}

/// One step of a course: an idea, its result, a figure.
#[derive(Serialize)]
pub struct Lesson {
    /// Id of the method that the lesson teaches.
    pub id: String,
    /// Heading.
    pub title: String,
    /// What the methods before it lacked.
    pub before: Option<String>,
    /// The idea of the method.
    pub idea: String,
    /// The result.
    pub finding: String,
    /// File of the figure, which is one of the section's figures.
    pub figure: String,
    /// The equations and the code of a step; `None` for a method that a user added.
    pub step: Option<Step>,
    /// Name of the crate to read.
    pub docs: String,
    /// Commands that repeat the runs.
    pub commands: Vec<String>,
}

/// The step of a method, and its effect on a single spring.
#[derive(Serialize)]
pub struct Step {
    /// The equations, as the documentation of the method has them.
    pub equation: String,
    /// The code that computes them.
    pub code: String,
    /// Paths of the files with the equations and the code, relative to the root of drape.
    pub files: [String; 2],
    /// Description of the spring.
    pub spring: String,
    /// Step sizes, s, and factors by which a step multiplies the motion.
    pub factors: Vec<[String; 2]>,
}

/// A table of texts.
#[derive(Serialize)]
pub struct Table {
    /// Heading.
    pub title: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// Number of leading columns that hold names, not numbers.
    pub names: usize,
    /// One text for each column.
    pub rows: Vec<Vec<String>>,
}

/// Provenance of one file.
#[derive(Serialize)]
struct Origin {
    file: String,
    lines: Vec<(String, String)>,
}

impl Section {
    /// The section of a record with its figures and tables. Tables without rows are left out.
    pub fn new<F>(record: &Record<F>, figures: Vec<Figure>, tables: Vec<Table>) -> Self {
        let mut section = of_record(record, figures);
        section.tables = tables;
        section.tables.retain(|table| !table.rows.is_empty());
        section
    }

    /// The same section, with a note on the timings that belong to the record. `more` is a sentence
    /// about these timings.
    pub fn with_timings<R>(mut self, timings: Option<&Timings<R>>, more: Option<&str>) -> Self {
        let file = format!("timings/{}", self.record);
        match timings {
            Some(timings) => {
                let more = more.map_or_else(String::new, |more| format!(" {more}"));
                self.notes.push(format!("How the times were taken: {}{more}", timings.method));
                self.provenance.push(origin(&file, &timings.provenance));
            }
            None => self.notes.push(format!(
                "No timings were taken here (`{file}` is absent), so figures and tables of times \
                 are missing."
            )),
        }
        self
    }

    /// The same section, with lessons that contain their own figures.
    pub fn with_lessons(mut self, lessons: Vec<Lesson>) -> Self {
        self.lessons = lessons;
        self
    }
}

fn of_record<F>(record: &Record<F>, figures: Vec<Figure>) -> Section {
    let file = format!("{}.json", record.experiment);
    Section {
        name: record.experiment.clone(),
        question: record.question.clone(),
        method: record.method.clone(),
        command: record.command.clone(),
        quick: record.quick,
        words: record.words.clone(),
        notes: Vec::new(),
        figures,
        tables: Vec::new(),
        lessons: Vec::new(),
        provenance: vec![origin(&file, &record.provenance)],
        record: file,
    }
}

fn origin(file: &str, provenance: &Provenance) -> Origin {
    let unknown = || "unknown".to_owned();
    let dirty = match provenance.dirty {
        Some(true) => "with uncommitted changes",
        Some(false) => "clean",
        None => "state of the tree unknown",
    };
    let commit = provenance.commit.clone().unwrap_or_else(unknown);
    let rustc = provenance.rustc.lines().next().unwrap_or_default();
    let mut lines = vec![
        ("commit".to_owned(), format!("{commit}, {dirty}")),
        ("version".to_owned(), provenance.version.clone()),
        ("rustc".to_owned(), rustc.to_owned()),
        ("build".to_owned(), provenance.build.clone()),
        ("cpu".to_owned(), provenance.cpu.clone()),
        ("threads".to_owned(), provenance.threads.to_string()),
        ("Cargo.lock (SHA-256)".to_owned(), provenance.cargo_lock_sha256.clone()),
        (
            "seed".to_owned(),
            provenance.seed.map_or_else(|| "none drawn".to_owned(), |s| s.to_string()),
        ),
        ("date (UTC)".to_owned(), provenance.date.clone()),
    ];
    lines.extend(
        provenance
            .scene_sha256
            .iter()
            .map(|(scene, hash)| (format!("scene {scene} (SHA-256)"), hash.clone())),
    );
    Origin { file: file.to_owned(), lines }
}

/// Converts texts to owned strings, for a header.
pub fn texts(parts: &[&str]) -> Vec<String> {
    parts.iter().map(|part| (*part).to_owned()).collect()
}

/// The cell for a value that was not recorded.
pub fn absent() -> String {
    "–".to_owned()
}
