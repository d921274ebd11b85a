//! Studies in shards: computed apart, killed, resubmitted and merged.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// Studies of one part and of several; `order` refuses some pairs, and `tables` reads a published
/// table.
const EXPERIMENTS: &str = "tables,order,momentum,post-correction";
const SHARDS: usize = 7;

fn drape(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
    command.args(arguments);
    command
}

fn reproduce(out: &Path, shard: Option<usize>) -> Command {
    let mut command = drape(&["reproduce", "--quick", "--only", EXPERIMENTS, "--out"]);
    command.arg(out);
    if let Some(shard) = shard {
        command.args(["--shard", &format!("{shard}/{SHARDS}")]);
    }
    command
}

fn merge(out: &Path, parts: &[PathBuf]) -> Output {
    drape(&["merge"]).arg(out).args(parts).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A text without its dates, such as 2026-11-23T17:58:06Z.
fn undated(text: &[u8]) -> Vec<u8> {
    const SHAPE: &[u8] = b"0000-00-00T00:00:00Z";
    let is_date = |window: &[u8]| {
        let fits = |(byte, shape): (&u8, &u8)| match shape {
            b'0' => byte.is_ascii_digit(),
            other => byte == other,
        };
        window.len() == SHAPE.len() && window.iter().zip(SHAPE).all(fits)
    };
    let mut rest = text;
    let mut undated = Vec::with_capacity(text.len());
    while let Some((first, after)) = rest.split_first() {
        if is_date(&rest[..rest.len().min(SHAPE.len())]) {
            rest = &rest[SHAPE.len()..];
        } else {
            undated.push(*first);
            rest = after;
        }
    }
    undated
}

/// Every file below a folder, without dates.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_owned();
                files.insert(name, undated(&std::fs::read(&path).unwrap()));
            }
        }
    }
    files
}

fn journals(out: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let is_journal = |name: &Path| name.extension().is_some_and(|e| e == "journal");
    // A running shard writes temporary files beside its journals, which come and go.
    let entries = std::fs::read_dir(out.join(".unfinished")).into_iter().flatten();
    let paths =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| is_journal(path));
    paths
        .filter_map(|path| Some((path.file_name()?.into(), undated(&std::fs::read(&path).ok()?))))
        .collect()
}

fn lines(journal: &[u8]) -> usize {
    journal.iter().filter(|byte| **byte == b'\n').count()
}

/// Runs a shard until it has written some cells, and kills it.
fn killed(part: &Path, shard: usize) {
    let mut child = reproduce(part, Some(shard)).stderr(Stdio::null()).spawn().unwrap();
    // Each journal has a first line; one more is a cell, or the end of a shard without cells.
    while !journals(part).values().any(|journal| lines(journal) > 2) {
        assert!(child.try_wait().unwrap().is_none(), "{shard}: it ended before it could be killed");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn seven_shards_of_which_three_are_killed_give_the_files_of_an_undivided_run() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, merged) = (folder.path().join("whole"), folder.path().join("merged"));
    assert!(reproduce(&whole, None).stderr(Stdio::null()).status().unwrap().success());
    let parts: Vec<_> = (1..=SHARDS).map(|n| folder.path().join(format!("part-{n}"))).collect();
    for (part, shard) in parts.iter().zip(1..) {
        if [2, 3, 6].contains(&shard) {
            killed(part, shard);
        } else {
            let output = reproduce(part, Some(shard)).output().unwrap();
            assert!(output.status.success(), "{}", said(&output));
        }
        assert_eq!(files(part).len(), journals(part).len() + 1, "journals and a lock alone");
    }
    let before = merge(&merged, &parts);
    assert_eq!(before.status.code(), Some(4), "{}", said(&before));
    let text = said(&before);
    assert!(text.contains("cells are missing: run the shards again"), "{text}");
    assert!(text.contains("momentum: methods: ") && !merged.join("report.html").exists(), "{text}");
    // Resubmitted, each of the seven computes what it lacks, and nothing again.
    for (part, shard) in parts.iter().zip(1..) {
        let before = journals(part);
        let output = reproduce(part, Some(shard)).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        let after = journals(part);
        for (name, journal) in &before {
            let whole = journal.iter().rposition(|b| *b == b'\n').map_or(0, |end| end + 1);
            assert!(after[name].starts_with(&journal[..whole]), "{shard}: {}", name.display());
        }
        if ![2, 3, 6].contains(&shard) {
            assert_eq!(before, after, "{shard}");
        }
    }
    // What was merged before is not lost: the parts that were whole then need not come again.
    let again = [2, 3, 6].map(|shard: usize| parts[shard - 1].clone());
    let output = merge(&merged, &again);
    assert!(output.status.success(), "{}", said(&output));
    let (whole, merged) = (files(&whole), files(&merged));
    assert_eq!(whole.keys().collect::<Vec<_>>(), merged.keys().collect::<Vec<_>>());
    for (name, bytes) in &whole {
        assert!(bytes == &merged[name], "{} differs", name.display());
    }
    assert!(whole.len() > 10 && whole.contains_key(Path::new("report.html")), "{:?}", whole.keys());
}

/// The same program with one byte more, which it never reads.
#[cfg(unix)]
#[test]
fn parts_of_another_program_or_subset_and_folders_without_parts_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let [other, part, full, empty, out] =
        ["drape-other", "part", "full", "empty", "out"].map(|name| folder.path().join(name));
    std::fs::copy(env!("CARGO_BIN_EXE_drape"), &other).unwrap();
    let mut file = std::fs::File::options().append(true).open(&other).unwrap();
    std::io::Write::write_all(&mut file, b"\n").unwrap();
    drop(file);
    let shard = ["experiment", "momentum", "--quick", "--shard", "1/99", "--out"];
    assert!(Command::new(&other).args(shard).arg(&part).output().unwrap().status.success());
    std::fs::create_dir(&empty).unwrap();
    let refused = |parts: &[PathBuf], expected: [&str; 2]| {
        let output = merge(&out, parts);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{text}");
        assert!(expected.iter().all(|expected| text.contains(expected)), "{text}");
    };
    refused(
        std::slice::from_ref(&part),
        ["part/.unfinished/momentum.journal", "another executable"],
    );
    refused(std::slice::from_ref(&empty), ["empty", "no journal lies there"]);
    refused(&[], ["out", "no part holds one"]);
    // The same cells, all instead of a subset.
    let quick = folder.path().join("quick");
    assert!(drape(&shard).arg(&quick).output().unwrap().status.success());
    std::fs::create_dir_all(full.join(".unfinished")).unwrap();
    let mut child = drape(&["experiment", "momentum", "--shard", "1/99", "--out"])
        .arg(&full)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while journals(&full).values().all(|journal| lines(journal) == 0) {
        std::thread::sleep(Duration::from_millis(1));
        if child.try_wait().unwrap().is_some() {
            break;
        }
    }
    let _ = child.kill();
    child.wait().unwrap();
    refused(&[quick, full], ["full/.unfinished/momentum.journal", "all cells"]);
}

#[test]
fn a_shard_that_cannot_be_is_refused() {
    for (shard, expected) in [("8/7", "from 1 to 7"), ("0/7", "from 1 to 7"), ("x", "such as 3/7")]
    {
        let output = drape(&["experiment", "order", "--out", "a", "--shard", shard]).output();
        let output = output.unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(said(&output).contains(expected), "{}", said(&output));
    }
    let output = drape(&["experiment", "order", "--shard", "1/7"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "parts need a folder of their own");
    assert!(said(&output).contains("--out"), "{}", said(&output));
}
