//! Figures and pages, drawn from records alone.
//!
//! [`draw`] reads the records that an experiment left in a results folder and writes one SVG (or, of cloth, one PNG) a
//! figure, a report and an index page beside them. Nothing is run and no result is computed here: whatever a
//! figure shows stands as a number in the record, and a figure whose numbers are absent is left
//! out. The same records give the same bytes.
//!
//! | file read | needed | files written |
//! |---|---|---|
//! | `tables.json` | one of the records | `figures/tables-counts.svg`, `figures/tables-exponents.svg` |
//! | `timings/tables.json` | no | `figures/tables-cost.svg` |
//! | `cg-vs-stiffness.json` | one of the records | `figures/cg-*.svg`, `figures/motion-vs-stiffness.svg` |
//! | `pictures.json` | one of the records | `figures/pictures-*.png` |
//! | `order.json` | one of the records | `figures/order-*.svg` |
//! | `momentum.json` | one of the records | `figures/momentum-*.svg` |
//! | `energy.json` | one of the records | `figures/energy-*.svg` |
//! | `stability.json` | one of the records | `figures/stability-*.svg` |
//! | `locking.json` | one of the records | `figures/locking-*.svg` |
//! | `solver-control.json` | one of the records | `figures/control-*.svg` |
//! | `timings/solver-control.json` | no | a table of the page |
//! | `hard-cases.json` | one of the records | `figures/hard-cases.svg` |
//! | `collision.json` | one of the records | `figures/collision-*.svg` |
//! | `effects.json` | one of the records | `figures/effects-support.svg` |
//! | `timings/effects.json` | no | a table of the page |
//! | `post-correction.json` | one of the records | `figures/post-correction-*.svg` |
//! | `precomputed-inverse.json` | one of the records | `figures/inverse-counts.svg` |
//! | `timings/precomputed-inverse.json` | no | `figures/inverse-cost.svg` |
//! | `work-precision.json` | one of the records | `figures/work-precision-*.svg` |
//! | `timings/work-precision.json` | no | seconds in `figures/work-precision.svg` |
//! | `scaling.json` | one of the records | `figures/scaling-cg.svg` |
//! | `timings/scaling.json` | no | `figures/scaling-cost.svg` |
//! | `claims.json` | one of the records | `figures/claims.svg` |
//! | `timings/claims.json` | no | |
//! | `course.json` | one of the records | `figures/course-*.svg` |
//! | all of them | | `report.html`, `README.md` |
//!
//! A figure is a `Sheet` of `Panel`s with `Series`, `Rule`s and `Bar`s (module `plot`), made by one
//! function in the module of its experiment (`tables`, `cg`); everything that figures have in
//! common, from the palette to the legend, is in `plot`. The report, one file that needs no other, and the index
//! page are templates (`templates/`) filled from the same records (module `page`).

mod cg;
mod claims;
mod collision;
mod control;
mod course;
mod effects;
mod energy;
mod error;
mod family;
mod hard_cases;
mod locking;
mod momentum;
mod number;
mod order;
mod page;
mod pictures;
mod plate;
mod plot;
mod post_correction;
mod precomputed_inverse;
mod scaling;
mod stability;
mod tables;
mod work_precision;

pub use error::ReportError;

use drape_records::file::{read_json, write_atomically};
use drape_records::{Figure, RECORD_FORMAT, Record, TIMINGS_FORMAT, Timings};
use page::{Section, Table};
use plate::Plate;
use plot::Drawing;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// What a file holds.
enum Content {
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
type Files = Vec<(String, Content)>;

/// What this crate draws of one experiment.
struct Chapter {
    /// Name of the experiment.
    experiment: &'static str,
    /// Every figure that can be drawn.
    figures: fn() -> Vec<Figure>,
    /// Reads the records, adds the files of the figures and returns what the page says; `None` without records.
    section: fn(&Path, &mut Files) -> Result<Option<Section>, ReportError>,
}

/// In the order of the page.
const CHAPTERS: &[Chapter] = &[
    course::CHAPTER,
    pictures::CHAPTER,
    order::CHAPTER,
    momentum::CHAPTER,
    tables::CHAPTER,
    cg::CHAPTER,
    stability::CHAPTER,
    locking::CHAPTER,
    energy::CHAPTER,
    hard_cases::CHAPTER,
    collision::CHAPTER,
    effects::CHAPTER,
    post_correction::CHAPTER,
    precomputed_inverse::CHAPTER,
    work_precision::CHAPTER,
    control::CHAPTER,
    scaling::CHAPTER,
    claims::CHAPTER,
];

/// File, title and caption of the figures drawn from the record of an experiment (and its timings);
/// none for an experiment that this crate does not know.
#[must_use]
pub fn figures_of(experiment: &str) -> Vec<Figure> {
    let chapter = CHAPTERS.iter().find(|chapter| chapter.experiment == experiment);
    chapter.map_or_else(Vec::new, |chapter| (chapter.figures)())
}

/// Draws every figure that the records in the folder `results` hold data for, the report and the index page.
///
/// Returns the files written, the pages last. All records are read and all files are drawn before
/// the first one is written, so that a broken record leaves the folder as it was.
///
/// # Errors
/// [`ReportError::NoRecords`] when the folder holds no record; otherwise the file that could
/// not be read, understood, drawn or written.
pub fn draw(results: &Path) -> Result<Vec<PathBuf>, ReportError> {
    let mut files = Files::new();
    let mut sections = Vec::new();
    for chapter in CHAPTERS {
        sections.extend((chapter.section)(results, &mut files)?);
    }
    if sections.is_empty() {
        return Err(ReportError::NoRecords { folder: results.to_owned() });
    }
    files.push(("report.html".to_owned(), Content::Text(page::report(&sections, &files)?)));
    files.push(("README.md".to_owned(), Content::Text(page::index(&sections)?)));

    files
        .into_iter()
        .map(|(name, content)| {
            let path = results.join(name);
            write_atomically(&path, content.bytes())?;
            Ok(path)
        })
        .collect()
}

/// The record of an experiment, or `None` when there is no such file.
fn read_record<F: DeserializeOwned>(
    results: &Path,
    experiment: &str,
) -> Result<Option<Record<F>>, ReportError> {
    let path = results.join(format!("{experiment}.json"));
    if !path.exists() {
        return Ok(None);
    }
    let record: Record<F> = read_json(&path)?;
    check_kind(&path, (RECORD_FORMAT, experiment), (&record.format, &record.experiment))?;
    Ok(Some(record))
}

/// The section of an experiment whose figures and tables need its record only; `None` without a record.
fn section<F: DeserializeOwned, D: Drawing>(
    results: &Path,
    experiment: &str,
    plates: &[Plate<Record<F>, D>],
    tables: fn(&Record<F>) -> Vec<Table>,
    files: &mut Files,
) -> Result<Option<Section>, ReportError> {
    let Some(record) = read_record::<F>(results, experiment)? else { return Ok(None) };
    let figures = plate::draw_all(plates, &record, files)?;
    Ok(Some(Section::new(&record, figures, tables(&record))))
}

/// The record of an experiment, with its timings where there are any.
struct Timed<F, R> {
    record: Record<F>,
    timings: Option<Timings<R>>,
}

/// The record of an experiment and its timings, or `None` without a record.
fn read_timed<F: DeserializeOwned, R: DeserializeOwned>(
    results: &Path,
    experiment: &str,
) -> Result<Option<Timed<F, R>>, ReportError> {
    let Some(record) = read_record(results, experiment)? else { return Ok(None) };
    Ok(Some(Timed { record, timings: read_timings(results, experiment)? }))
}

/// As [`section`], of an experiment that is timed.
fn timed_section<F: DeserializeOwned, R: DeserializeOwned, D: Drawing>(
    results: &Path,
    experiment: &str,
    plates: &[Plate<Timed<F, R>, D>],
    tables: fn(&Timed<F, R>) -> Vec<Table>,
    files: &mut Files,
) -> Result<Option<Section>, ReportError> {
    let Some(input) = read_timed(results, experiment)? else { return Ok(None) };
    let figures = plate::draw_all(plates, &input, files)?;
    let section = Section::new(&input.record, figures, tables(&input));
    Ok(Some(section.with_timings(input.timings.as_ref())))
}

/// The timings of an experiment, or `None` when there is no such file.
fn read_timings<R: DeserializeOwned>(
    results: &Path,
    experiment: &str,
) -> Result<Option<Timings<R>>, ReportError> {
    let path = results.join("timings").join(format!("{experiment}.json"));
    if !path.exists() {
        return Ok(None);
    }
    let timings: Timings<R> = read_json(&path)?;
    check_kind(&path, (TIMINGS_FORMAT, experiment), (&timings.format, &timings.experiment))?;
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
