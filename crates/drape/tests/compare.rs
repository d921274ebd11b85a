//! `drape compare` as a user meets it.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_harness::compare::facts::{End, Facts};
use drape_report::{RECORD_FORMAT, Record};
use std::path::Path;
use std::process::{Command, Output};

fn drape(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_drape")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn record(folder: &Path) -> Record<Facts> {
    serde_json::from_slice(&std::fs::read(folder.join("compare.json")).unwrap()).unwrap()
}

/// Runs a comparison on a bundled scene and checks what holds for every one.
fn compared(scene: &str, more: &[&str]) -> (Record<Facts>, String) {
    let folder = tempfile::tempdir().unwrap();
    let output = drape(folder.path(), &[&["compare", scene], more].concat());
    let (told, said) = (text(&output.stderr), text(&output.stdout));
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!((3..=12).contains(&said.lines().count()), "{said}");
    let record = record(&folder.path().join("compare"));
    assert_eq!((&record.format[..], &record.experiment[..]), (RECORD_FORMAT, "compare"));
    assert!(record.command.starts_with(&format!("drape compare {scene}")), "{}", record.command);
    let page = std::fs::read_to_string(folder.path().join("compare/compare.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("image/png"), "the figure and the pictures");
    // The advised command runs as it stands.
    let run = said.lines().find_map(|line| line.strip_prefix("run it")).unwrap();
    let words: Vec<&str> = run.trim().strip_prefix("drape ").unwrap().split(' ').collect();
    let again = drape(folder.path(), &words);
    assert_eq!(again.status.code(), Some(0), "{run}: {}", text(&again.stderr));
    (record, said)
}

#[test]
fn a_grid_gets_advice_that_meets_the_target_and_a_page() {
    let methods = ["--methods", "leapfrog,bdf2,desbrun", "--duration", "0.5", "--budget", "60s"];
    let (record, said) = compared("hanging-textile-1e4", &methods);
    let facts = &record.facts;
    assert!(facts.truth.is_trusted, "{:?}", facts.truth);
    assert!(facts.runs.iter().any(|run| run.meets(facts.good_m())), "{said}");
    assert!(said.contains("\ntake ") && said.contains("\nexpect "), "{said}");
    assert_eq!(record.facts.scene.frames, 30);
}

#[test]
fn a_mesh_on_an_obstacle_names_what_is_refused() {
    let methods =
        ["--methods", "exponential,backward-euler", "--duration", "0.2", "--budget", "60s"];
    let (record, said) = compared("round-table", &methods);
    let end = |id: &str| {
        let found = record.facts.forms.iter().find(|form| form.method.starts_with(id));
        found.map(|form| form.end)
    };
    assert_eq!(end("exponential"), Some(End::Refused));
    assert!(end("backward-euler").is_some_and(|end| end != End::Refused));
    assert!(said.contains("\nrefused ") && said.contains("exponential"), "{said}");
}

#[test]
fn bad_arguments_give_one_line_and_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("broken.json"), "{").unwrap();
    std::fs::write(folder.path().join("taken"), "").unwrap();
    let scene = "hanging-textile-1e4";
    let cases: [(&[&str], &str); 9] = [
        (&["no-such-scene"], "no-such-scene"),
        (&["broken.json"], "broken.json"),
        (&[scene, "--methods", "no-such-method"], "no-such-method"),
        (&[scene, "--methods", "xpbd:order=9"], "order"),
        (&[scene, "--target", "-1"], "--target"),
        (&[scene, "--frame", "0"], "--frame"),
        (&[scene, "--budget", "soon"], "--budget"),
        (&[scene, "--duration", "-1"], "--duration"),
        (&[scene, "--out", "taken"], "--out"),
    ];
    for (arguments, named) in cases {
        let output = drape(folder.path(), &[&["compare"], arguments].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(named) && !message.contains("panicked"), "{message}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
}
