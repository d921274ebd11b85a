//! What all studies share: the frame of a record, figures, tables and pages.
//!
//! A study hands its facts, figures and tables to this crate; the crate knows no study and runs
//! nothing. A figure is a [`plot::Sheet`], [`plot::Matrix`] or [`plot::Atlas`], drawn by a
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

pub use error::ReportError;
pub use file::RecordError;
pub use provenance::Provenance;
pub use record::{Figure, RECORD_FORMAT, Record, TIMINGS_FORMAT, Timings};

use file::{read_json, write_atomically};
use page::{Outline, Section, Table};
use plate::Plate;
use plot::Drawing;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// What a file holds.
#[derive(Debug)]
pub enum Content {
    /// A page, or a figure as SVG.
    Text(String),
    /// A picture.
    Png(Vec<u8>),
}

impl Content {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Text(text) => text.as_bytes(),
            Self::Png(bytes) => bytes,
        }
    }
}

/// The files of a page and its figures: names below the folder of the results, and contents.
pub type Files = Vec<(String, Content)>;

/// Writes the figures in `files`, the report and the index page below the folder `results`.
///
/// Returns the files written, the pages last. Every page is filled before the first file is
/// written, so that a failure leaves the folder as it was.
///
/// # Errors
/// [`ReportError::NoRecords`] without sections; otherwise the file that could not be filled or
/// written.
pub fn write(
    results: &Path,
    sections: &[Section],
    outline: &Outline,
    mut files: Files,
) -> Result<Vec<PathBuf>, ReportError> {
    if sections.is_empty() {
        return Err(ReportError::NoRecords { folder: results.to_owned() });
    }
    let report = page::report(sections, outline, &files)?;
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

/// The record of a study, or `None` when there is no such file.
pub fn read_record<F: DeserializeOwned>(
    results: &Path,
    study: &str,
) -> Result<Option<Record<F>>, ReportError> {
    let path = results.join(format!("{study}.json"));
    if !path.exists() {
        return Ok(None);
    }
    let record: Record<F> = read_json(&path)?;
    check_kind(&path, (RECORD_FORMAT, study), (&record.format, &record.experiment))?;
    Ok(Some(record))
}

/// The section of a study whose figures and tables need its record only; `None` without a record.
pub fn record_section<F: DeserializeOwned, D: Drawing>(
    results: &Path,
    study: &str,
    plates: &[Plate<Record<F>, D>],
    tables: fn(&Record<F>) -> Vec<Table>,
    files: &mut Files,
) -> Result<Option<Section>, ReportError> {
    let Some(record) = read_record::<F>(results, study)? else { return Ok(None) };
    let figures = plate::draw_all(plates, &record, files)?;
    Ok(Some(Section::new(&record, figures, tables(&record))))
}

/// The record of a study, with its timings where there are any.
pub struct Timed<F, R> {
    /// The facts with their frame.
    pub record: Record<F>,
    /// The timings, where they were taken.
    pub timings: Option<Timings<R>>,
}

/// The record of a study and its timings, or `None` without a record.
pub fn read_timed<F: DeserializeOwned, R: DeserializeOwned>(
    results: &Path,
    study: &str,
) -> Result<Option<Timed<F, R>>, ReportError> {
    let Some(record) = read_record(results, study)? else { return Ok(None) };
    Ok(Some(Timed { record, timings: read_timings(results, study)? }))
}

/// As [`record_section`], of a study that is timed.
pub fn timed_section<F: DeserializeOwned, R: DeserializeOwned, D: Drawing>(
    results: &Path,
    study: &str,
    plates: &[Plate<Timed<F, R>, D>],
    tables: fn(&Timed<F, R>) -> Vec<Table>,
    files: &mut Files,
) -> Result<Option<Section>, ReportError> {
    let Some(input) = read_timed(results, study)? else { return Ok(None) };
    let figures = plate::draw_all(plates, &input, files)?;
    let section = Section::new(&input.record, figures, tables(&input));
    Ok(Some(section.with_timings(input.timings.as_ref())))
}

/// The timings of a study, or `None` when there is no such file.
pub fn read_timings<R: DeserializeOwned>(
    results: &Path,
    study: &str,
) -> Result<Option<Timings<R>>, ReportError> {
    let path = results.join("timings").join(format!("{study}.json"));
    if !path.exists() {
        return Ok(None);
    }
    let timings: Timings<R> = read_json(&path)?;
    check_kind(&path, (TIMINGS_FORMAT, study), (&timings.format, &timings.experiment))?;
    Ok(Some(timings))
}

/// Refuses a file that says it is something else than its name says.
fn check_kind(path: &Path, expected: (&str, &str), found: (&str, &str)) -> Result<(), ReportError> {
    if expected == found {
        return Ok(());
    }
    let name = |(format, experiment): (&str, &str)| format!("{format} of `{experiment}`");
    Err(ReportError::Kind { path: path.to_owned(), expected: name(expected), found: name(found) })
}
