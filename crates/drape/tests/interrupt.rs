//! Ctrl-C and SIGTERM keep what was finished, say how to go on, and end with exit code 130 and 143.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "tests")]

use drape_harness::record::{Ending, Run};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

fn drape(arguments: &[&str], out: &Path) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
    command.args(arguments).arg("--out").arg(out);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Presses Ctrl-C once `is_at_work` says so.
fn interrupted(child: Child, is_at_work: impl Fn() -> bool) -> (Output, String) {
    ended_by(("-INT", 130), child, is_at_work)
}

/// Sends a signal once `is_at_work` says so, and checks the exit code.
fn ended_by(
    (signal, code): (&str, i32),
    mut child: Child,
    is_at_work: impl Fn() -> bool,
) -> (Output, String) {
    while !is_at_work() {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it could be interrupted");
        std::thread::sleep(Duration::from_millis(2));
    }
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(kill.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{said}");
    (output, said)
}

#[test]
fn an_interrupted_study_keeps_its_cells_and_the_command_that_it_names_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let journal = out.join(".unfinished/momentum.journal");
    let arguments = ["experiment", "momentum", "--quick", "--fresh"];
    let cells = || std::fs::read_to_string(&journal).map_or(0, |text| text.lines().count());
    // Batch systems send this signal before they kill.
    let (_, said) = ended_by(("-TERM", 143), drape(&arguments, &out), || cells() > 2);
    let command = format!("drape experiment momentum --quick --out {}", out.display());
    assert!(said.contains("interrupted; finished cells are kept"), "{said}");
    assert!(said.trim_end().ends_with(&command), "{said}");
    let again = drape(&arguments[..3], &out).wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(again.status.success() && said.contains("cells were finished before"), "{said}");
}

/// The handler is there as soon as the frames are: they are the only sign of a run at work.
#[test]
fn an_interrupted_run_keeps_its_record_until_then() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run.json");
    let scene = "hanging-textile-1e4";
    let arguments = ["run", scene, "--method", "symplectic-euler", "--dt", "1e-5"];
    let frames = folder.path().join("frames");
    let more = ["--duration", "100", "--frames", frames.to_str().unwrap()];
    let child = drape(&[&arguments[..], &more].concat(), &out);
    let is_at_work = || frames.read_dir().is_ok_and(|entries| entries.count() > 0);
    let (_, said) = interrupted(child, is_at_work);
    assert!(said.contains("interrupted at step") && said.contains("run.json"), "{said}");
    assert!(said.contains("to run it whole: drape run hanging-textile-1e4"), "{said}");
    let run: Run = serde_json::from_slice(&std::fs::read(&out).unwrap()).unwrap();
    let Ending::Interrupted { step, time_s, .. } = run.ending else { panic!("{:?}", run.ending) };
    assert_eq!((step, time_s), (run.steps, run.final_state.time_s));
    assert!(step > 0 && time_s < 100.0 && run.verdict.reason.contains("interrupted"));
}

/// The runs that a comparison has finished are its result, and the same command goes on.
#[test]
fn an_interrupted_comparison_advises_from_its_runs_and_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let scene = "hanging-textile-1e4";
    let arguments = ["compare", scene, "--methods", "leapfrog,bdf2", "--exhaustive"];
    let arguments = [&arguments[..], &["--duration", "0.2", "--budget", "40s"]].concat();
    let unfinished = out.join(".unfinished");
    let runs = || {
        let entries = unfinished.read_dir().into_iter().flatten().flatten();
        let texts = entries.filter_map(|entry| std::fs::read_to_string(entry.path()).ok());
        texts.map(|text| text.matches("\"runs of ").count()).sum::<usize>()
    };
    let (output, said) = interrupted(drape(&arguments, &out), || runs() > 1);
    let advice = String::from_utf8(output.stdout).unwrap();
    assert!((3..=12).contains(&advice.lines().count()), "{advice}");
    assert!(!said.contains("\\n") && !advice.contains("\\n"), "{said}{advice}");
    let last = said.lines().last().unwrap();
    let command = format!("drape {} --out {}", arguments.join(" "), out.display());
    assert!(last.starts_with("drape: interrupted after ") && last.ends_with(&command), "{said}");
    assert!(out.join("compare.html").is_file() && unfinished.is_dir());
    let again = drape(&arguments, &out).wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(again.status.success() && said.contains("going on from"), "{said}");
    assert!(!unfinished.exists(), "nothing is left when it is done");
}
