//! Shared by all studies: the frame of a record, figures, tables and pages.
//!
//! A study hands its facts, figures and tables to this crate; the crate depends on no study and
//! runs nothing. A figure is a [`plot::Sheet`], [`plot::Matrix`] or [`plot::Atlas`], drawn by a
//! [`plate::Plate`] from the facts alone, so the same records give the same bytes. A
//! [`page::Section`] holds what the page says about one study; [`write()`] fills the templates with
//! all sections and writes the report, the index page and the figures.

mod error;
pub mod family;
pub mod file;
pub mod number;
pub mod page;
pub mod plate;
pub mod plot;
mod provenance;
mod record;
mod tell;
pub mod verdict;

pub use error::ReportError;
pub use file::RecordError;
pub use provenance::Provenance;
pub use record::{Figure, RECORD_FORMAT, Record, TIMINGS_FORMAT, Timings, Words};
pub use tell::{printable, tell};
pub use verdict::Verdict;

use file::{read_json, write_atomically};
use page::{Head, Outline, Section, Table};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// Content of a file.
#[derive(Debug)]
pub enum Content {
    /// A page, or a figure as SVG.
    Text(String),
    /// A picture.
    Png(Vec<u8>),
}

impl Content {
    /// The content as bytes.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Text(text) => text.as_bytes(),
            Self::Png(bytes) => bytes,
        }
    }
}

/// The files of a page and its figures: names relative to the folder of the results, and contents.
pub type Files = Vec<(String, Content)>;

/// Writes the figures in `files`, the report and the index page below the folder `results`. The
/// table `first`, if given, is shown beside the answer.
///
/// Returns the files that were written, the pages last. Every page is filled before the first file
/// is written, so that a failure leaves the folder unchanged.
///
/// # Errors
/// [`ReportError::NoRecords`] if there are no sections; otherwise an error that names the file that
/// could not be filled or written.
pub fn write(
    results: &Path,
    sections: &[Section],
    outline: &Outline,
    first: Option<Table>,
    mut files: Files,
) -> Result<Vec<PathBuf>, ReportError> {
    if sections.is_empty() {
        return Err(ReportError::NoRecords { folder: results.to_owned() });
    }
    let report = page::report(sections, outline, (page::ALL, first.as_ref()), &files)?;
    files.push(("report.html".to_owned(), Content::Text(report)));
    files.push(("README.md".to_owned(), Content::Text(page::index(sections, outline)?)));
    files
        .into_iter()
        .map(|(name, content)| {
            let path = results.join(name);
            write_atomically(&path, content.bytes())?;
            Ok(path)
        })
        .collect()
}

/// The text of one self-contained page with these sections. `files` holds its figures.
///
/// # Errors
/// [`ReportError`] if the page cannot be filled.
pub fn one_page(
    head: Head<'_>,
    sections: &[Section],
    outline: &Outline,
    files: &Files,
) -> Result<String, ReportError> {
    page::report(sections, outline, (head, None), files)
}

/// The record of a study, or `None` if the file does not exist.
pub fn read_record<F: DeserializeOwned>(
    results: &Path,
    study: &str,
) -> Result<Option<Record<F>>, RecordError> {
    let path = results.join(format!("{study}.json"));
    if !path.exists() {
        return Ok(None);
    }
    let record: Record<F> = read_json(&path)?;
    check_kind(&path, (RECORD_FORMAT, study), (&record.format, &record.experiment))?;
    Ok(Some(record))
}

/// The timings of a study, or `None` if the file does not exist.
pub fn read_timings<R: DeserializeOwned>(
    results: &Path,
    study: &str,
) -> Result<Option<Timings<R>>, RecordError> {
    let path = results.join("timings").join(format!("{study}.json"));
    if !path.exists() {
        return Ok(None);
    }
    let timings: Timings<R> = read_json(&path)?;
    check_kind(&path, (TIMINGS_FORMAT, study), (&timings.format, &timings.experiment))?;
    Ok(Some(timings))
}

/// Refuses a file that says it is something else than its name says.
fn check_kind(path: &Path, expected: (&str, &str), found: (&str, &str)) -> Result<(), RecordError> {
    if expected == found {
        return Ok(());
    }
    let name = |(format, experiment): (&str, &str)| format!("{format} of `{experiment}`");
    Err(RecordError::Kind { path: path.to_owned(), expected: name(expected), found: name(found) })
}
