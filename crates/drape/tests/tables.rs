//! `drape export`, read back by the libraries that people read tables with.

#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common;

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

/// Every entry of every table of all committed records, by three readers in both formats.
#[test]
fn pandas_polars_and_duckdb_read_the_same_tables() {
    let Some(python) = python("pandas, polars, duckdb, pyarrow") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folders = ["csv", "parquet"].map(|format| export(folder.path(), format, &[]));
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/read_tables.py");
    let output = run(Command::new(python).arg(script).args(&folders));
    let entries: u64 = String::from_utf8_lossy(&output.stdout).trim().parse().unwrap();
    assert!(entries > 40_000_000, "{entries}");
}

/// Without Python: the files are there, with the marks of their format, and the same each time.
#[test]
fn all_records_are_written_as_parquet() {
    let folder = tempfile::tempdir().unwrap();
    let first = export(folder.path(), "parquet", &[]);
    let tables = std::fs::read_dir(&first).unwrap().count();
    assert!(tables > 35, "{tables}");
    let second = tempfile::tempdir().unwrap();
    let second = export(second.path(), "parquet", &["--only", "order,tables,peers"]);
    let names =
        ["order", "engines-order", "tables", "timings-tables", "timings-peers", "dictionary"];
    for name in names.map(|name| format!("{name}.parquet")) {
        let bytes = std::fs::read(first.join(&name)).unwrap();
        assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"), "{name}");
        if name != "dictionary.parquet" {
            assert!(bytes == std::fs::read(second.join(&name)).unwrap(), "{name}");
        }
    }
    assert_eq!(std::fs::read_dir(&second).unwrap().count(), names.len());
}

/// A comparison is a record like all others: its runs have scene, method and verdict, and each metric
/// has a meaning.
#[test]
fn a_comparison_is_exported_too() {
    let folder = tempfile::tempdir().unwrap();
    let drape = |words: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
        command.args(words.split(' ')).current_dir(folder.path()).output().unwrap()
    };
    let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let asked =
        "compare oscillator --methods leapfrog,midpoint --duration 0.1 --budget 30s --out here";
    for words in [asked, "export here", "export here --only compare --out only"] {
        let output = drape(words);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{words}: {said}");
    }
    let table = text("here/csv/compare.csv");
    assert_eq!(table, text("only/compare.csv"));
    assert_eq!(std::fs::read_dir(folder.path().join("only")).unwrap().count(), 2);
    for method in ["leapfrog", "midpoint"] {
        let is_run = |line: &&str| {
            line.starts_with("compare,") && line.contains("runs[") && line.contains("oscillator,2,")
        };
        let mut runs = table.lines().filter(is_run);
        assert!(runs.any(|line| line.contains(&format!(",{method},"))), "{method}: {table}");
    }
    assert!(table.lines().any(|line| line.contains(",error_m,")), "{table}");
    // The length of a frame is no cost of a run.
    let is_frame = |line: &&str| line.starts_with("compare,scene;") && line.contains(",frame_s,");
    let fields: Vec<&str> = table.lines().find(is_frame).unwrap().split(',').collect();
    assert_eq!((fields[8], fields[12], fields[13]), ("frame_s", "", ""), "{fields:?}");
    let dictionary = text("here/csv/dictionary.csv");
    for (metric, meaning) in [
        ("substeps,metric", "Steps a frame"),
        ("budget_s,metric", "Wall time that may be spent"),
        ("members,metric", "Number of true motions"),
        ("seconds,metric", "Wall time of all"),
    ] {
        let line = dictionary.lines().find(|line| line.starts_with(metric)).expect(metric);
        assert!(line.contains(meaning) && line.ends_with(",compare"), "{line}");
    }
    assert!(!dictionary.contains("number of this name in the record"), "{dictionary}");
    // A folder without a comparison has nothing to export.
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let nothing = drape("export empty --only compare");
    assert_eq!(nothing.status.code(), Some(2), "{}", String::from_utf8_lossy(&nothing.stderr));
}

/// The command says which tables it wrote, and which record it could not read.
#[test]
fn tables_are_listed_and_unreadable_timings_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let drape = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
        command.arg("export").args(arguments).current_dir(folder.path()).output().unwrap()
    };
    let results = concat!(env!("CARGO_MANIFEST_DIR"), "/../../results");
    let said = |output: &Output| {
        let texts = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
        texts.concat()
    };
    let output = drape(&[results, "--only", "order,tables", "--out", "out"]);
    assert!(output.status.success(), "{}", said(&output));
    for name in ["order", "engines-order", "tables", "timings-tables", "dictionary"] {
        let file = Path::new("out").join(format!("{name}.csv"));
        let line = format!("wrote {} (", file.display());
        assert!(said(&output).contains(&line), "{line}: {}", said(&output));
    }
    let unknown = drape(&[results, "--only", "no-study", "--out", "none"]);
    assert_eq!(unknown.status.code(), Some(2), "{}", said(&unknown));
    assert!(said(&unknown).contains("`no-study`"), "{}", said(&unknown));
    let broken = Path::new("timings").join("broken.json");
    std::fs::create_dir(folder.path().join("timings")).unwrap();
    std::fs::write(folder.path().join(&broken), "{}").unwrap();
    let output = drape(&[".", "--out", "none"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains(broken.to_str().unwrap()), "{}", said(&output));
    assert!(!folder.path().join("none").exists());
}
