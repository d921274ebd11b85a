//! `drape export`.

use drape_harness::export::{COLUMNS, Row, dictionary, table};
use drape_harness::studies;
use drape_model::Violation;
use drape_report::ReportError;
use drape_report::file::write_atomically;
use drape_report::tell;
use std::path::{Path, PathBuf};

use crate::cli::output::{check_folder, csv_line};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder with records (JSON files that `drape reproduce` writes)
    #[arg(default_value = "results")]
    folder: PathBuf,
    /// Format of the tables
    #[arg(long, value_enum, default_value = "csv")]
    format: Format,
    /// Folder for the tables [default: FOLDER/csv]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Only these studies, separated by commas
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Replace tables that are there
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Comma-separated values (RFC 4180), UTF-8: one table a study, and dictionary.csv
    Csv,
    /// Not built in
    Parquet,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let refuse = |path: &str, value: String, expected: String| Violation {
        path: path.to_owned(),
        value,
        expected,
    };
    if arguments.format == Format::Parquet {
        let expected = "csv: parquet is not built in; most readers of it also read CSV".to_owned();
        return Err(refuse("--format", "`parquet`".to_owned(), expected).into());
    }
    let folder = &arguments.folder;
    let chosen = match arguments.only.as_slice() {
        [] => studies::all().to_vec(),
        names => names.iter().map(|name| studies::find(name)).collect::<Result<Vec<_>, _>>()?,
    };
    let mut tables: Vec<(PathBuf, Vec<Row>)> = Vec::new();
    let out = arguments.out.clone().unwrap_or_else(|| folder.join("csv"));
    for study in chosen {
        if let Some(rows) = table(folder, study.name()).map_err(ReportError::from)? {
            tables.push((out.join(format!("{}.csv", study.name())), rows));
        }
    }
    if tables.is_empty() {
        return Err(ReportError::NoRecords { folder: folder.clone() }.into());
    }
    let words = out.join("dictionary.csv");
    let files = tables.iter().map(|(file, _)| file).chain([&words]);
    let present = files.filter(|file| file.exists()).find(|_| !arguments.force);
    if let Some(file) = present {
        let expected = "a file that is not there yet, or --force".to_owned();
        return Err(refuse("--out", format!("`{}`", file.display()), expected).into());
    }
    check_folder("--out", &out)?;
    let all: Vec<Row> = tables.iter().flat_map(|(_, rows)| rows).cloned().collect();
    for (file, rows) in &tables {
        let header = COLUMNS.map(|(name, _, _)| name);
        write(file, &header, rows.iter().map(|row| &row[..]))?;
    }
    let lines = dictionary(&all);
    write(&words, &["name", "kind", "unit", "meaning"], lines.iter().map(|line| &line[..]))
}

fn write<'a>(
    file: &Path,
    header: &[&str],
    rows: impl Iterator<Item = &'a [String]>,
) -> anyhow::Result<()> {
    let mut text = csv_line(header.iter().copied());
    let mut count = 0;
    for row in rows {
        text += &csv_line(row.iter().map(String::as_str));
        count += 1;
    }
    write_atomically(file, text.as_bytes())?;
    tell!("wrote {} ({count} rows)", file.display());
    Ok(())
}
