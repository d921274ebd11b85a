//! The scripts that submit shards, each with its scheduler. A test whose scheduler is absent says
//! that it was skipped.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{python, skipped};
use std::path::{Path, PathBuf};
use std::process::Command;

fn script(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/sweep")).join(name)
}

fn answers(program: &str, arguments: &[&str]) -> bool {
    Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
}

/// Sweeps a study in three shards, one of which is done before, and again where a shard was lost.
fn sweeps(mut command: impl FnMut() -> Command) {
    let folder = tempfile::tempdir().unwrap();
    let mut sweep = || {
        let mut command = command();
        command.arg(folder.path()).arg("3").arg(env!("CARGO_BIN_EXE_drape"));
        let output = command.args(["experiment", "momentum", "--quick"]).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        said
    };
    let said = sweep();
    assert!(said.contains("round 1") && !said.contains("round 2"), "{said}");
    let record = folder.path().join("results/momentum.json");
    let first = std::fs::read_to_string(&record).unwrap();
    let facts = |text: &str| text.split("\"provenance\"").next().unwrap().to_owned();
    // A shard that was killed left no sign that it is done; the others are not run again.
    std::fs::remove_dir_all(folder.path().join("results")).unwrap();
    std::fs::remove_dir_all(folder.path().join("part-2")).unwrap();
    let said = sweep();
    assert!(said.contains("shards 2 of 3") || said.contains("1 of 3 shards"), "{said}");
    assert_eq!(facts(&std::fs::read_to_string(&record).unwrap()), facts(&first));
}

#[test]
fn gnu_parallel() {
    if !answers("parallel", &["--version"]) {
        skipped("GNU parallel is not on the path");
        return;
    }
    sweeps(|| Command::new(script("parallel.sh")));
}

#[test]
fn slurm() {
    if !answers("sinfo", &["--noheader"]) {
        skipped("no Slurm controller answers `sinfo`");
        return;
    }
    sweeps(|| Command::new(script("slurm.sh")));
}

/// On a server and a worker of its own. `DRAPE_PYTHON` names the Python that has the package.
#[test]
fn hyperqueue() {
    let python = python();
    if !answers(&python, &["-c", "import hyperqueue"]) {
        skipped(&format!("`{python} -c 'import hyperqueue'` fails on this machine"));
        return;
    }
    sweeps(|| {
        let mut command = Command::new(&python);
        command.arg(script("with_hyperqueue.py")).arg("--local");
        command
    });
}
