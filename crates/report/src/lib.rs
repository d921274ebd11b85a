//! Figures and pages, drawn from records alone.
//!
//! [`draw`] reads the records that an experiment left in a results folder and writes one SVG a
//! figure and an index page beside them. Nothing is run and no result is computed here: whatever a
//! figure shows stands as a number in the record, and a figure whose numbers are absent is left
//! out. The same records give the same bytes.
//!
//! | file read | needed | files written |
//! |---|---|---|
//! | `tables.json` | one of the records | `figures/tables-counts.svg`, `figures/tables-exponents.svg` |
//! | `timings/tables.json` | no | `figures/tables-cost.svg` |
//! | `cg-vs-stiffness.json` | one of the records | `figures/cg-*.svg`, `figures/motion-vs-stiffness.svg` |
//! | `order.json` | one of the records | `figures/order-*.svg` |
//! | `momentum.json` | one of the records | `figures/momentum-*.svg` |
//! | `hard-cases.json` | one of the records | `figures/hard-cases.svg` |
//! | all of them | | `README.md` |
//!
//! A figure is a `Sheet` of `Panel`s with `Series`, `Rule`s and `Bar`s (module `plot`), made by one
//! function in the module of its experiment (`tables`, `cg`); everything that figures have in
//! common, from the palette to the legend, is in `plot`. The index page is a template
//! (`templates/README.md.jinja`) filled from the same records (module `page`).

mod cg;
mod error;
mod family;
mod hard_cases;
mod momentum;
mod number;
mod order;
mod page;
mod plate;
mod plot;
mod tables;

pub use error::ReportError;

use drape_records::file::{read_json, write_atomically};
use drape_records::{Figure, RECORD_FORMAT, Record, TIMINGS_FORMAT, Timings};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// Name of the experiment whose record is `tables.json`.
const TABLES: &str = "tables";
/// Name of the experiment whose record is `cg-vs-stiffness.json`.
const CG: &str = "cg-vs-stiffness";
/// Name of the experiment whose record is `order.json`.
const ORDER: &str = "order";
/// Name of the experiment whose record is `momentum.json`.
const MOMENTUM: &str = "momentum";
/// Name of the experiment whose record is `hard-cases.json`.
const HARD_CASES: &str = "hard-cases";

/// File, title and caption of the figures drawn from the record of an experiment (and its timings);
/// none for an experiment that this crate does not know.
#[must_use]
pub fn figures_of(experiment: &str) -> Vec<Figure> {
    match experiment {
        TABLES => tables::PLATES.iter().map(plate::Plate::figure).collect(),
        CG => cg::PLATES.iter().map(plate::Plate::figure).collect(),
        ORDER => order::PLATES.iter().map(plate::Plate::figure).collect(),
        MOMENTUM => momentum::PLATES.iter().map(plate::Plate::figure).collect(),
        HARD_CASES => hard_cases::PLATES.iter().map(plate::Plate::figure).collect(),
        _ => Vec::new(),
    }
}

/// Draws every figure that the records in the folder `results` hold data for, and the index page.
///
/// Returns the files written, the page last. All records are read and all files are drawn before
/// the first one is written, so that a broken record leaves the folder as it was.
///
/// # Errors
/// [`ReportError::NoRecords`] when the folder holds no record; otherwise the file that could
/// not be read, understood, drawn or written.
pub fn draw(results: &Path) -> Result<Vec<PathBuf>, ReportError> {
    let tables = read_record::<drape_records::tables::Facts>(results, TABLES)?;
    let timings = read_timings(results)?;
    let cg = read_record::<drape_records::cg::Facts>(results, CG)?;
    let order = read_record::<drape_records::order::Facts>(results, ORDER)?;
    let momentum = read_record::<drape_records::momentum::Facts>(results, MOMENTUM)?;
    let hard_cases = read_record::<drape_records::hard_cases::Facts>(results, HARD_CASES)?;
    let mut files = Vec::new();
    let mut sections = Vec::new();
    if let Some(record) = tables {
        let input = tables::Input { record, timings };
        let drawn = plate::draw_all(tables::PLATES, &input, &mut files)?;
        sections.push(page::of_tables(&input, drawn));
    }
    if let Some(record) = cg {
        let drawn = plate::draw_all(cg::PLATES, &record, &mut files)?;
        sections.push(page::of_cg(&record, drawn));
    }
    if let Some(record) = order {
        let drawn = plate::draw_all(order::PLATES, &record, &mut files)?;
        sections.push(page::of_order(&record, drawn));
    }
    if let Some(record) = momentum {
        let drawn = plate::draw_all(momentum::PLATES, &record, &mut files)?;
        sections.push(page::of_momentum(&record, drawn));
    }
    if let Some(record) = hard_cases {
        let drawn = plate::draw_all(hard_cases::PLATES, &record, &mut files)?;
        sections.push(page::of_hard_cases(&record, drawn));
    }
    if sections.is_empty() {
        return Err(ReportError::NoRecords { folder: results.to_owned() });
    }
    files.push(("README.md".to_owned(), page::render(&sections)?));

    files
        .into_iter()
        .map(|(name, text)| {
            let path = results.join(name);
            write_atomically(&path, text.as_bytes())?;
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

/// The timings of `tables`, or `None` when there is no such file.
fn read_timings(
    results: &Path,
) -> Result<Option<Timings<drape_records::tables::TimingRow>>, ReportError> {
    let path = results.join("timings").join(format!("{TABLES}.json"));
    if !path.exists() {
        return Ok(None);
    }
    let timings: Timings<_> = read_json(&path)?;
    check_kind(&path, (TIMINGS_FORMAT, TABLES), (&timings.format, &timings.experiment))?;
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
