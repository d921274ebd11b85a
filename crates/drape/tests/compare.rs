//! `drape compare` as a user meets it.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_harness::compare::facts::{End, Facts, Run as RaceRun};
use drape_harness::record::{Judged, Run};
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
    assert!(facts.runs.iter().any(|run| facts.is_met(run)), "{said}");
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
        assert!(!folder.path().join("compare/.unfinished").exists(), "{arguments:?}");
    }
}

/// A comparison that needs some seconds.
const LONG: [&str; 9] = [
    "compare",
    "hanging-textile-1e4",
    "--methods",
    "leapfrog,bdf2,midpoint",
    "--duration",
    "0.4",
    "--budget",
    "90s",
    "--exhaustive",
];

/// The journal of a folder; empty where there is none.
fn journal(folder: &Path) -> String {
    let Ok(entries) = std::fs::read_dir(folder.join(".unfinished")) else { return String::new() };
    let mut paths = entries.flatten().map(|entry| entry.path());
    let journal = paths.find(|path| path.extension().is_some_and(|ending| ending == "journal"));
    journal.and_then(|path| std::fs::read_to_string(path).ok()).unwrap_or_default()
}

/// The lines of a folder's journal that stand for finished runs.
fn runs_kept(folder: &Path) -> usize {
    journal(folder).lines().filter(|line| line.contains("\"runs of ")).count()
}

/// Whether a run was taken from a journal: its time stands there, unless it was timed again.
fn is_from(journal: &str, run: &RaceRun) -> bool {
    let time = serde_json::to_string(&run.frame_s).unwrap();
    run.repetitions > 1 || journal.contains(&format!("\"frame_s\":{time}"))
}

/// Killed after some runs, it goes on: what was run is not run again, and keeps its time.
#[test]
fn a_killed_comparison_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("compare");
    let mut killed = Command::new(env!("CARGO_BIN_EXE_drape"));
    killed.current_dir(folder.path()).args(LONG).stderr(std::process::Stdio::null());
    let mut child = killed.spawn().unwrap();
    let begin = std::time::Instant::now();
    while runs_kept(&out) < 3 && begin.elapsed().as_secs() < 80 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = runs_kept(&out);
    assert!(kept >= 3 && !out.join("compare.json").exists(), "{kept}");
    let before = journal(&out);
    let output = drape(folder.path(), &LONG);
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(told.contains("going on from"), "{told}");
    let facts = record(&out).facts;
    assert!(facts.runs.len() > kept, "{} and {kept}", facts.runs.len());
    // The first runs are those that the killed process had made, with its times.
    let found = facts.runs.iter().take(kept).filter(|run| is_from(&before, run));
    assert_eq!(found.count(), kept);
    assert!(!out.join(".unfinished").exists(), "nothing is left when it is done");
    // Nothing to go on from: the same command begins anew.
    let again = drape(folder.path(), &[&LONG[..3], &["leapfrog"], &LONG[4..]].concat());
    assert!(!text(&again.stderr).contains("going on"), "{}", text(&again.stderr));
}

/// All forms on scenes that need much longer end within a tenth of the time, page and all.
#[test]
fn the_budget_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    for (scene, budget, more) in
        [("square-table-2704-1e6", 12.0, ""), ("hanging-wool", 6.0, " --exhaustive")]
    {
        let begin = std::time::Instant::now();
        let words = format!("compare {scene} --budget {budget}s --out {scene}{more}");
        let output = drape(folder.path(), &words.split(' ').collect::<Vec<_>>());
        let took = begin.elapsed().as_secs_f64();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let facts = record(&folder.path().join(scene)).facts;
        assert!(facts.forms.iter().any(|form| form.end == End::OutOfTime), "{scene} had time");
        // The rest is the page; starting the process beside other tests takes its time besides.
        assert!(facts.seconds <= 1.05 * budget, "{scene}: {} s of {budget} s", facts.seconds);
        assert!(took <= 1.1 * budget + 1.0, "{scene}: {took} s of {budget} s");
    }
}

/// Every bundled scene, in a time that suffices for some of them alone. Whatever the clock lets it
/// find: one record, one page, at most twelve lines, a word where there is no true motion, and an
/// advice that can be followed: the method supports the scene, the command runs, and the run does
/// not stand still. On two particles a comparison ends long before its time.
#[test]
fn every_bundled_scene_gets_a_page_and_an_advice_that_can_be_followed() {
    let folder = tempfile::tempdir().unwrap();
    let mut advised = 0;
    for scene in drape_model::bundled::names() {
        let is_tiny = ["oscillator", "loaded-spring"].contains(&scene);
        let budget = if is_tiny { "120s" } else { "1s" };
        let words = ["compare", scene, "--budget", budget, "--duration", "0.1", "--out", scene];
        let output = drape(folder.path(), &words);
        let said = text(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{scene}: {}", text(&output.stderr));
        assert!((3..=12).contains(&said.lines().count()), "{said}");
        assert!(folder.path().join(scene).join("compare.html").is_file(), "{scene}");
        let Facts { truth, forms, .. } = record(&folder.path().join(scene)).facts;
        assert!(truth.is_trusted != said.contains("no true motion ("), "{said}");
        assert!(truth.is_trusted != said.contains("\nwarning "), "{said}");
        assert!(truth.is_trusted || truth.remark.is_some(), "{scene}: {truth:?}");
        let command = said.lines().find_map(|line| line.strip_prefix("run it"));
        let Some(command) = command.and_then(|line| line.trim().strip_prefix("drape ")) else {
            assert!(said.contains("take       none"), "{said}");
            continue;
        };
        advised += usize::from(is_tiny);
        let words: Vec<&str> = command.split(' ').collect();
        let method = words[words.iter().position(|word| *word == "--method").unwrap() + 1];
        assert!(forms.iter().any(|form| form.method == method && form.refusal.is_none()), "{said}");
        let choice = drape_harness::methods::Choice::parse(method, &[]).unwrap();
        let input = drape_model::load(scene).unwrap();
        let (system, _) = input.spec().build().unwrap();
        choice.method().check(&system).unwrap_or_else(|error| panic!("{scene}: {error}"));
        let out = format!("{scene}.json");
        let again = drape(folder.path(), &[&words[..], &["--out", &out]].concat());
        assert_eq!(again.status.code(), Some(0), "{command}: {}", text(&again.stderr));
        let run: Run = drape_report::file::read_json(&folder.path().join(out)).unwrap();
        assert!(
            !matches!(run.verdict.kind, Judged::Locked | Judged::Diverged),
            "{command}: {:?}",
            run.verdict
        );
    }
    assert_eq!(advised, 2);
}

#[test]
fn a_scene_without_a_true_motion_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let words = "compare square-table-2704-1e6 --methods imex-euler,xpbd --budget 3s --out here";
    let output = drape(folder.path(), &words.split(' ').collect::<Vec<_>>());
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(said.contains("no true motion (") && said.contains("half the steps"), "{said}");
    let facts = record(&folder.path().join("here")).facts;
    assert!(!facts.truth.is_trusted && facts.truth.remark.is_some(), "{:?}", facts.truth);
}

#[test]
fn shards_are_joined_and_those_of_another_question_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let compare = |more: &[&str]| {
        let words = ["compare", "hanging-textile-1e4", "--duration", "0.3", "--budget", "40s"];
        let methods = ["--methods", "leapfrog,bdf2,midpoint,imex-euler,xpbd"];
        drape(folder.path(), &[&words, &methods[..], more].concat())
    };
    let mut forms = 0;
    for (shard, out) in [("1/2", "one"), ("2/2", "two")] {
        let output = compare(&["--shard", shard, "--out", out]);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{told}");
        assert!(output.stdout.is_empty() && told.contains("to join shards"), "{told}");
        assert!(runs_kept(&folder.path().join(out)) > 0, "{told}");
        assert!(!folder.path().join(out).join("compare.json").exists());
        let count = told.split(" raced").next().unwrap().split(' ').rev().nth(2).unwrap();
        forms += count.parse::<usize>().unwrap();
    }
    let joined = compare(&["--parts", "one,two", "--out", "all"]);
    assert_eq!(joined.status.code(), Some(0), "{}", text(&joined.stderr));
    let facts = record(&folder.path().join("all")).facts;
    assert_eq!(facts.forms.len(), forms);
    assert!(facts.forms.iter().all(|form| form.end != End::OutOfTime), "{:?}", facts.forms);
    // Nothing was run again, and both shards have a part in it.
    let parts = ["one", "two"].map(|part| journal(&folder.path().join(part)));
    let both = parts.concat();
    assert!(facts.runs.iter().all(|run| is_from(&both, run)), "{:?}", facts.runs);
    // Beside the forms of the other shard, all forms of one may be dominated without a run.
    for part in &parts {
        assert!(facts.forms.iter().any(|form| part.contains(&form.method)), "{:?}", facts.forms);
    }
    let wrong = compare(&["--parts", "one,two", "--metric", "trajectory", "--out", "other"]);
    let told = text(&wrong.stderr);
    assert!(wrong.status.code() == Some(2) && told.contains("`--parts` is `one`"), "{told}");
    let nothing = compare(&["--parts", "two,all", "--out", "other"]);
    let told = text(&nothing.stderr);
    assert!(nothing.status.code() == Some(2) && told.contains("`--parts` is `all`"), "{told}");
    assert!(!folder.path().join("other/.unfinished").exists(), "a refusal leaves nothing");
    let timed = compare(&["--shard", "timed"]);
    assert!(timed.status.code() == Some(2), "{}", text(&timed.stderr));
}
