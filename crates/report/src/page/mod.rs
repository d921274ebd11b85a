//! What the pages say: sections of prose, figures and tables, each made from one record.

mod html;
mod index;
mod inline;

pub(crate) use html::report;
pub(crate) use index::index;

use drape_records::{Figure, Provenance, Record, Timings};
use serde::Serialize;

/// All that the page says about one experiment.
#[derive(Serialize)]
pub(crate) struct Section {
    name: String,
    question: String,
    method: String,
    command: String,
    quick: bool,
    findings: Vec<String>,
    /// Sentences for the head of the report; where there are none the first findings stand there.
    answer: Vec<String>,
    /// File of the record, beside the page.
    record: String,
    notes: Vec<String>,
    figures: Vec<Figure>,
    tables: Vec<Table>,
    lessons: Vec<Lesson>,
    provenance: Vec<Origin>,
}

/// One step of a course: an idea, what came out, a figure.
#[derive(Serialize)]
pub(crate) struct Lesson {
    pub(crate) id: String,
    pub(crate) title: String,
    /// What was missing before.
    pub(crate) before: Option<String>,
    pub(crate) idea: String,
    pub(crate) finding: String,
    /// File of the figure, one of the section's.
    pub(crate) figure: String,
    /// The crate to read.
    pub(crate) docs: String,
    /// What repeats the runs.
    pub(crate) commands: Vec<String>,
}

/// A table of texts.
#[derive(Serialize)]
pub(crate) struct Table {
    pub(crate) title: String,
    pub(crate) header: Vec<String>,
    /// Number of leading columns that hold names, not numbers.
    pub(crate) names: usize,
    pub(crate) rows: Vec<Vec<String>>,
}

/// Provenance of one file.
#[derive(Serialize)]
struct Origin {
    file: String,
    lines: Vec<(String, String)>,
}

impl Section {
    /// The section of a record with its figures and tables; tables without rows are left out.
    pub(crate) fn new<F>(record: &Record<F>, figures: Vec<Figure>, tables: Vec<Table>) -> Self {
        let mut section = of_record(record, figures);
        section.tables = tables;
        section.tables.retain(|table| !table.rows.is_empty());
        section
    }

    /// The same with what is known of the timings that stand beside the record.
    pub(crate) fn with_timings<R>(mut self, timings: Option<&Timings<R>>) -> Self {
        let file = format!("timings/{}", self.record);
        match timings {
            Some(timings) => {
                self.notes.push(format!("How the times were taken: {}", timings.method));
                self.provenance.push(origin(&file, &timings.provenance));
            }
            None => self.notes.push(format!(
                "No timings were taken here (`{file}` is absent): figures and tables of times are left out."
            )),
        }
        self
    }

    /// The same with sentences for the head of the report.
    pub(crate) fn with_answer(mut self, sentences: impl IntoIterator<Item = String>) -> Self {
        self.answer = sentences.into_iter().collect();
        self
    }

    /// The same with lessons; their figures stand in them.
    pub(crate) fn with_lessons(mut self, lessons: Vec<Lesson>) -> Self {
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
        findings: record.findings.clone(),
        answer: Vec::new(),
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

/// A sign behind the number of a run that was not stable.
pub(crate) fn sign(verdict: &str) -> &'static str {
    match verdict {
        "stable" => "",
        "marginal" => " °",
        _ => " ✗",
    }
}

pub(crate) const SIGNS: &str = "° marginal, ✗ unstable or diverged.";

pub(crate) fn texts(parts: &[&str]) -> Vec<String> {
    parts.iter().map(|part| (*part).to_owned()).collect()
}

pub(crate) fn absent() -> String {
    "–".to_owned()
}
