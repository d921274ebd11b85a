//! `drape export`.

use super::refusal;
use drape_harness::compare;
use drape_harness::export::{COLUMNS, dictionary, tables};
use drape_harness::studies;
use drape_report::ReportError;
use drape_report::file::write_atomically;
use drape_report::tell;
use std::path::{Path, PathBuf};

use crate::cli::output::{check_folder, csv_line};
use crate::cli::parquet;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder with records (JSON files that `drape reproduce` writes), with timings and engines in
    /// its folders `timings` and `engines`; or the folder of a comparison
    #[arg(default_value = "results")]
    folder: PathBuf,
    /// Format of the tables
    #[arg(long, value_enum, default_value = "csv")]
    format: Format,
    /// Folder for the tables [default: FOLDER/csv or FOLDER/parquet]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Only these studies, separated by commas; `compare` is the record of `drape compare`
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Replace existing tables
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Comma-separated values (RFC 4180), UTF-8: one table a record (STUDY.csv, timings-STUDY.csv,
    /// engines-STUDY.csv, compare.csv), and dictionary.csv
    Csv,
    /// Apache Parquet, with types and compressed: the same tables, and dictionary.parquet
    Parquet,
}

impl Format {
    /// Ending of the files.
    fn ending(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let folder = &arguments.folder;
    let ending = arguments.format.ending();
    let out = arguments.out.clone().unwrap_or_else(|| folder.join(ending));
    let tables = tables(folder, &arguments.only)?;
    for name in &arguments.only {
        // A study without a record is no fault; what is no study has to be there.
        if name != compare::NAME && !tables.iter().any(|table| table.study == *name) {
            studies::find(name)?;
        }
    }
    if tables.is_empty() {
        return Err(ReportError::NoRecords { folder: folder.clone() }.into());
    }
    let file = |name: &str| out.join(format!("{name}.{ending}"));
    let words = file("dictionary");
    let files: Vec<_> = tables.iter().map(|table| file(&table.name())).collect();
    let present = files.iter().chain([&words]).find(|file| !arguments.force && file.exists());
    if let Some(file) = present {
        let value = format_args!("`{}`", file.display());
        let expected = "a file that does not exist yet, or --force to replace it";
        return Err(refusal("--out", value, expected).into());
    }
    check_folder("--out", &out)?;
    let header = COLUMNS.map(|(name, _, _)| name);
    for (file, table) in files.iter().zip(&tables) {
        let rows: Vec<&[String]> = table.rows.iter().map(|row| &row[..]).collect();
        write(arguments.format, file, &header, &rows)?;
    }
    let lines = dictionary(&tables);
    let lines: Vec<&[String]> = lines.iter().map(|line| &line[..]).collect();
    write(arguments.format, &words, &["name", "kind", "unit", "meaning", "table"], &lines)
}

fn write(format: Format, file: &Path, header: &[&str], rows: &[&[String]]) -> anyhow::Result<()> {
    let bytes = match format {
        Format::Csv => {
            let mut text = csv_line(header.iter().copied());
            rows.iter().for_each(|row| text += &csv_line(row.iter().map(String::as_str)));
            text.into_bytes()
        }
        Format::Parquet => parquet::table(header, rows)
            .map_err(|error| anyhow::anyhow!("{}: {error}", file.display()))?,
    };
    write_atomically(file, &bytes)?;
    tell!("wrote {} ({} rows)", file.display(), rows.len());
    Ok(())
}
