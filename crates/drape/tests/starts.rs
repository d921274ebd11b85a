//! The scenes from which studies start, as scenes of the command.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_harness::record::Run;
use std::path::Path;
use std::process::{Command, Output};

fn drape(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_drape")).args(arguments).output().unwrap()
}

/// A tenth of a second with a method; the record.
fn run(scene: &str, out: &Path) -> Run {
    let out = out.to_str().unwrap();
    let time = ["--dt", "0.01", "--duration", "0.1", "--out", out];
    let output = drape(&[&["run", scene, "--method", "imex-euler"][..], &time].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&std::fs::read(out).unwrap()).unwrap()
}

/// The record of the study names the hash of its own start; a run from the printed system, and one
/// from the name, begin there and have the same bits.
#[test]
fn a_start_is_printed_and_run_again_with_the_bits_of_the_study() {
    let folder = tempfile::tempdir().unwrap();
    let results = concat!(env!("CARGO_MANIFEST_DIR"), "/../../results/energy.json");
    let record: serde_json::Value =
        serde_json::from_slice(&std::fs::read(results).unwrap()).unwrap();
    for name in ["spinning-1e4 damped", "sphere-1e4 undamped"] {
        let scene = format!("energy/{name}");
        let printed = drape(&["system", &scene]);
        assert!(printed.status.success());
        let file = folder.path().join("system.json");
        std::fs::write(&file, &printed.stdout).unwrap();
        let by_name = run(&scene, &folder.path().join("name.json"));
        let by_file = run(file.to_str().unwrap(), &folder.path().join("file.json"));
        assert_eq!(by_name.final_state, by_file.final_state, "{name}");
        let hash = record["provenance"]["scene_sha256"][name].as_str().unwrap();
        assert_eq!([&by_name.scene_hash, &by_file.scene_hash], [hash, hash], "{name}");
    }
}

/// Systems of which a record has no hash are printed and run again, too.
#[test]
fn stiff_and_pushed_systems_are_printed_and_run_again() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["post-correction/grid, stiff", "regret/strip, pushed"] {
        let printed = drape(&["system", scene]);
        assert!(printed.status.success(), "{}", String::from_utf8_lossy(&printed.stderr));
        let file = folder.path().join("system.json");
        std::fs::write(&file, &printed.stdout).unwrap();
        let by_name = run(scene, &folder.path().join("name.json"));
        let by_file = run(file.to_str().unwrap(), &folder.path().join("file.json"));
        assert_eq!(by_name.final_state, by_file.final_state, "{scene}");
        assert_eq!(by_name.scene_hash, by_file.scene_hash, "{scene}");
    }
}

#[test]
fn starts_are_listed_and_a_wrong_name_is_refused_with_the_right_ones() {
    let listed = drape(&["list", "study-scenes"]);
    let text = String::from_utf8(listed.stdout).unwrap();
    assert!(
        text.lines().count() > 200 && text.lines().any(|line| line == "order/smooth"),
        "{text}"
    );
    for line in ["post-correction/triangles, stiff", "regret/strip, pushed", "regret/flag, pushed"]
    {
        assert!(text.lines().any(|listed| listed == line), "{line}");
    }
    // The beginning of a study's name will do where only one begins so.
    let scene = "hanging light 1e2 n=400";
    let [whole, begun] =
        ["work-precision", "work"].map(|study| drape(&["system", &format!("{study}/{scene}")]));
    assert!(whole.status.success() && whole.stdout == begun.stdout);
    let doubtful = drape(&["system", &format!("s/{scene}")]);
    assert_eq!(doubtful.status.code(), Some(2), "several studies begin so");
    let refused = drape(&["system", "order/rough"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(said.contains("no scene `rough`") && said.contains("smooth-projected"), "{said}");
}

/// A claim writes what its runs start from, and each file runs by hand.
#[test]
fn a_claim_writes_the_systems_of_its_runs() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("scenes");
    let output = drape(&["claim", "C20", "--scenes", scenes.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    let mut files: Vec<_> =
        std::fs::read_dir(&scenes).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty() && said.contains(&format!("{} systems", files.len())), "{said}");
    for file in [files.first().unwrap(), files.last().unwrap()] {
        let record = run(file.to_str().unwrap(), &folder.path().join("run.json"));
        assert_eq!(record.steps, 10);
    }
}
