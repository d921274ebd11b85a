//! `drape export`, read back by the libraries that people read tables with.

#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn run(command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// A Python that has these packages: `DRAPE_PYTHON`, or `python3`. Without one the test says that
/// it is skipped, and fails if `DRAPE_PYTHON_PACKAGES=required`.
fn python(packages: &str) -> Option<String> {
    let python = common::python();
    let import = format!("import {packages}");
    let found = Command::new(&python).args(["-c", &import]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    let said = format!("`{python} -c '{import}'` fails; name another in DRAPE_PYTHON");
    let is_required = std::env::var("DRAPE_PYTHON_PACKAGES").is_ok_and(|word| word == "required");
    assert!(!is_required, "{said}");
    common::skipped(&said);
    None
}

fn export(folder: &Path, format: &str, more: &[&str]) -> PathBuf {
    let results = concat!(env!("CARGO_MANIFEST_DIR"), "/../../results");
    let out = folder.join(format);
    let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
    let command = command.args(["export", results, "--format", format, "--out"]).arg(&out);
    run(command.args(more));
    out
}

/// Every entry of every table, by three readers in both formats.
#[test]
fn pandas_polars_and_duckdb_read_the_same_tables() {
    let Some(python) = python("pandas, polars, duckdb, pyarrow") else { return };
    let folder = tempfile::tempdir().unwrap();
    // The other records are longer and have no other columns.
    let only = ["--only", "locking,claims,order,momentum,tables,hard-cases"];
    let folders = ["csv", "parquet"].map(|format| export(folder.path(), format, &only));
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/read_tables.py");
    let output = run(Command::new(python).arg(script).args(&folders));
    let entries: u64 = String::from_utf8_lossy(&output.stdout).trim().parse().unwrap();
    assert!(entries > 1_000_000, "{entries}");
}

/// Without Python: the files are there, with the marks of their format, and the same each time.
#[test]
fn all_records_are_written_as_parquet() {
    let folder = tempfile::tempdir().unwrap();
    let first = export(folder.path(), "parquet", &[]);
    let studies = std::fs::read_dir(&first).unwrap().count();
    assert!(studies > 15, "{studies}");
    let second = tempfile::tempdir().unwrap();
    let second = export(second.path(), "parquet", &["--only", "order"]);
    for name in ["order.parquet", "dictionary.parquet"] {
        let bytes = std::fs::read(first.join(name)).unwrap();
        assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"), "{name}");
    }
    let read = |folder: &Path| std::fs::read(folder.join("order.parquet")).unwrap();
    assert_eq!(read(&first), read(&second));
}
