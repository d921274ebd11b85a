//! `drape experiment --timings`: the timings of a record, taken anew.

#![allow(clippy::unwrap_used, reason = "tests")]

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// The scenes that the record of these tests keeps, from the committed one.
const SCENE: &str = "held on a ball, cotton-blend, light, n=400, 5 s";
const LARGE: &str = "hanging, cotton-blend, light, n=10000";

fn timings(study: &str, out: &Path) -> Output {
    experiment(study, out, &["--timings"])
}

fn experiment(study: &str, out: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
    command.args(["experiment", study]).args(options).arg("--out").arg(out).output().unwrap()
}

fn committed() -> Value {
    of("animation-long")
}

fn of(study: &str) -> Value {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results");
    read(&results.join(study).with_extension("json"))
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn refused(study: &str, record: &Value) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("{study}.json"));
    std::fs::write(&path, record.to_string()).unwrap();
    let output = timings(study, folder.path());
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(!folder.path().join("timings").exists(), "half-written");
    assert_eq!(read(&path), *record);
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn the_sound_runs_of_a_record_are_timed_anew_and_its_facts_stay() {
    let mut record = committed();
    let facts = &mut record["facts"];
    let is_kept = |run: &Value| run["scene"] == SCENE && run["label"] == "symplectic-euler";
    facts["runs"].as_array_mut().unwrap().retain(is_kept);
    let lacking = |not_run: &[&str]| serde_json::json!({ "scene": LARGE, "not_run": not_run, "not_timed": ["leapfrog"] });
    facts["missing"] = serde_json::json!([lacking(&[]), lacking(&["rkc"])]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("animation-long.json");
    std::fs::write(&path, record.to_string()).unwrap();
    let output = timings("animation-long", folder.path());
    assert!(output.status.success(), "{output:?}");
    let after = read(&path);
    let facts = &after["facts"];
    assert_eq!(facts["runs"], record["facts"]["runs"]);
    assert_eq!(facts["scenes"], record["facts"]["scenes"]);
    assert_eq!(after["provenance"], record["provenance"]);
    // What is timed is missing no more. What was not run still is.
    assert_eq!(facts["missing"].as_array().unwrap().len(), 1, "{}", facts["missing"]);
    assert_eq!(facts["missing"][0]["not_timed"].as_array().unwrap().len(), 0);
    let rows = read(&folder.path().join("timings/animation-long.json"))["rows"].take();
    let rows = rows.as_array().unwrap();
    let runs = facts["runs"].as_array().unwrap();
    let sound: Vec<_> = runs.iter().filter(|run| run["verdict"] == "stable").collect();
    assert!(!sound.is_empty() && sound.len() < runs.len());
    assert_eq!(rows.len(), sound.len());
    for (row, run) in rows.iter().zip(sound) {
        assert_eq!((&row["label"], &row["substeps"]), (&run["label"], &run["substeps"]));
        assert!(row["frame_s"].as_f64().unwrap() > 0.0 && row["probe_s"].as_f64().unwrap() > 0.0);
    }
    assert!(!folder.path().join(".unfinished").exists());
}

#[test]
fn runs_are_timed_in_rounds_and_repeat_their_errors() {
    const SCENE: &str = "hanging light 1e2 n=400";
    let mut record = of("work-precision");
    let facts = &mut record["facts"];
    let is_kept = |row: &Value| row["scene"] == SCENE && row["label"] == "symplectic-euler";
    facts["rows"].as_array_mut().unwrap().retain(is_kept);
    facts["scenes"].as_array_mut().unwrap().retain(|scene| scene["id"] == SCENE);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("work-precision.json");
    std::fs::write(&path, record.to_string()).unwrap();
    let output = experiment("work-precision", folder.path(), &["--timings", "--rounds", "2"]);
    assert!(output.status.success(), "{output:?}");
    assert_eq!(read(&path)["facts"], record["facts"]);
    let timings = read(&folder.path().join("timings/work-precision.json"));
    assert!(timings["method"].as_str().unwrap().contains("in 2 rounds"), "{timings}");
    let rows = timings["rows"].as_array().unwrap();
    assert!(!rows.is_empty() && rows.iter().all(|row| row["is_verified"] == true), "{rows:?}");
    assert!(!folder.path().join(".unfinished").exists());
}

#[test]
fn rounds_are_a_number_of_timings() {
    let folder = tempfile::tempdir().unwrap();
    for (options, expected) in
        [(&["--timings", "--rounds", "0"][..], "1..=20"), (&["--rounds", "2"], "--timings")]
    {
        let output = experiment("rest", folder.path(), options);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn a_record_of_another_format_is_refused() {
    let mut record = committed();
    record["format"] = "drape-record/0".into();
    let said = refused("animation-long", &record);
    assert!(said.contains("expected drape-record/") && said.contains("drape-record/0"), "{said}");
}

#[test]
fn a_record_of_another_scene_or_form_is_refused_before_anything_is_timed() {
    let mut record = committed();
    record["provenance"]["scene_sha256"][LARGE] = "0123".into();
    let said = refused("animation-long", &record);
    for expected in ["animation-long.json", LARGE, "has the hash 0123, not", "compute the record"] {
        assert!(said.contains(expected), "{said}");
    }
    let mut record = committed();
    let runs = record["facts"]["runs"].as_array_mut().unwrap();
    runs[0]["scene"] = "in a storm".into();
    let said = refused("animation-long", &record);
    assert!(said.contains("`in a storm`") && said.contains("is unknown to this program"), "{said}");
    let mut record = of("work-precision");
    record["facts"]["scenes"][0]["id"] = "in a storm".into();
    let said = refused("work-precision", &record);
    assert!(said.contains("`in a storm`") && said.contains("is unknown to this program"), "{said}");
    let mut record = of("work-precision");
    record["facts"]["rows"][0]["label"] = "crank-nicolson".into();
    let said = refused("work-precision", &record);
    assert!(
        said.contains("no form `crank-nicolson`") && said.contains("compute the record"),
        "{said}"
    );
}

#[test]
fn a_study_whose_timings_need_its_runs_is_refused() {
    let said = refused("order", &Value::Null);
    for expected in ["order", "work-precision, animation, animation-long, rest"] {
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn timings_need_a_record() {
    let folder = tempfile::tempdir().unwrap();
    let output = timings("rest", folder.path());
    assert!(!output.status.success());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("rest.json"), "{said}");
}
