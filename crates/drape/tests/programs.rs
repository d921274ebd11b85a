//! Programs as methods, on the command line.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common;

use drape_harness::record::{Ending, Run};
use serde_json::Value;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};

const HELLO: &str = r#"{"protocol":"drape-method/1","name":"test","order":1,"class":"dissipative","implicit":true,"supports":["tension","shear","gravity","pins","full damping"]}"#;

fn drape(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_drape")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Writes `mine.sh`, which answers steps as told; `$steps` counts them.
fn write(folder: &Path, step: &str) {
    let script = format!(
        "#!/bin/sh\nsteps=0\nwhile read -r line; do\ncase \"$line\" in\n*hello*) echo '{HELLO}';;\n\
         *'\"step\"'*) steps=$((steps + 1))\n{step}\n;;\n\
         *) echo '{{\"ok\":true}}';;\nesac\ndone\n"
    );
    write_script(folder, &script);
}

/// Writes `mine.sh` as it stands.
fn write_script(folder: &Path, script: &str) {
    let path = folder.join("mine.sh");
    std::fs::write(&path, script).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
}

/// 20 × 20 particles with two pins: 400 × 48 bytes of state, 48 of places of pins.
const ECHO: &str = "echo '{\"bytes\":19200}'\nhead -c 19200\nhead -c 48 >/dev/null";

fn run(folder: &Path, more: &[&str]) -> Output {
    let arguments = ["run", "hanging-textile-1e4", "--method", "program:./mine.sh", "--dt", "0.01"];
    let arguments = [&arguments[..], &["--duration", "0.05", "--out", "run.json"], more].concat();
    drape(folder, &arguments)
}

fn record(folder: &Path) -> Run {
    drape_report::file::read_json(&folder.join("run.json")).unwrap()
}

#[test]
fn a_program_runs_under_its_own_name() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), ECHO);
    let output = run(folder.path(), &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let run = record(folder.path());
    assert_eq!((run.method.as_str(), run.steps), ("program:./mine.sh", 5));
    assert_eq!(run.settings["command"], "./mine.sh");
    assert_eq!(run.totals.force_evaluations, 5);
}

/// One program stands still, another answers garbage: both take part, neither is advised.
#[test]
fn programs_are_compared_and_one_that_fails_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let compare = |out: &str| {
        let words = ["compare", "hanging-textile-1e4", "--duration", "0.1", "--budget", "60s"];
        let methods = ["--methods", "leapfrog,program:./mine.sh", "--out", out];
        let output = drape(folder.path(), &[&words[..], &methods].concat());
        let (said, told) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(0), "{told}");
        assert!(said.contains("leapfrog:"), "{said}");
        said
    };
    write(folder.path(), ECHO);
    let said = compare("still");
    let locks = said.lines().find(|line| line.starts_with("locks ")).unwrap_or_default();
    assert!(locks.contains("program:./mine.sh"), "{said}");
    write(folder.path(), "echo garbage");
    let said = compare("garbage");
    let refused = said.lines().find(|line| line.starts_with("refused ")).unwrap_or_default();
    assert!(refused.contains("`garbage`") && refused.contains("program:./mine.sh"), "{said}");
}

/// It may take a tenth of the budget for an answer, not the minute that it has in a run.
#[test]
fn a_program_that_hangs_does_not_take_the_budget_of_a_comparison() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "sleep 1000");
    let words = ["compare", "hanging-textile-1e4", "--duration", "0.1", "--budget", "20s"];
    let methods = ["--methods", "leapfrog,program:./mine.sh", "--out", "out"];
    let output = drape(folder.path(), &[&words[..], &methods].concat());
    let (said, told) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(said.contains("leapfrog:"), "{said}");
    let refused = said.lines().find(|line| line.starts_with("refused ")).unwrap_or_default();
    assert!(refused.contains("did not answer in a step within 2 s"), "{said}");
    let facts: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("out/compare.json")).unwrap())
            .unwrap();
    let seconds = facts["facts"]["seconds"].as_f64().unwrap();
    assert!(seconds <= 22.0, "{seconds} s of 20 s");
}

/// What a terminated command leaves behind would run on for ever.
#[test]
fn a_program_that_hangs_ends_with_the_command_that_started_it() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "echo $$ > id\nsleep 1000");
    let words = ["run", "hanging-textile-1e4", "--method", "program:./mine.sh", "--dt", "0.01"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
    let mut child = command.current_dir(folder.path()).args(words).spawn().unwrap();
    let id = loop {
        let id = std::fs::read_to_string(folder.path().join("id")).unwrap_or_default();
        if id.ends_with('\n') {
            break format!("-{}", id.trim());
        }
        assert!(child.try_wait().unwrap().is_none(), "it ended too early");
        std::thread::sleep(std::time::Duration::from_millis(5));
    };
    let kill = |signal: &str, id: &str| {
        let status = Command::new("kill").args([signal, "--", id]).output().unwrap().status;
        status.success()
    };
    assert!(kill("-0", &id), "its process group is there");
    // The first asks the command to end when the step is done, the second ends it.
    while child.try_wait().unwrap().is_none() {
        kill("-TERM", &child.id().to_string());
        std::thread::sleep(std::time::Duration::from_millis(200));
    }
    assert_eq!(child.wait().unwrap().code(), Some(143));
    // Who was killed is there until its parent, the first process of the machine, has asked for it.
    let is_gone = || {
        let listed = Command::new("ps").args(["-eo", "pgid=,stat="]).output().unwrap();
        text(&listed.stdout).lines().all(|line| {
            let (group, stat) = line.trim().split_once(' ').unwrap_or_default();
            group != &id[1..] || stat.trim().starts_with('Z')
        })
    };
    let begun = std::time::Instant::now();
    while !is_gone() {
        assert!(begun.elapsed().as_secs() < 10, "it still runs");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

/// What was recorded before the failure is kept, one sentence is said, and the exit code is 3.
#[test]
fn a_program_that_fails_in_a_run_is_named_and_the_record_is_kept() {
    let nan = "\\000\\000\\000\\000\\000\\000\\370\\177".repeat(100);
    let cases = [
        ("exit 4".to_owned(), "ended in a step with exit code 4"),
        ("echo garbage".to_owned(), "`garbage`, which is no answer in JSON"),
        ("sleep 1000".to_owned(), "did not answer in a step within 1 s and was killed"),
        ("echo '{\"bytes\":24}'".to_owned(), "announced 24 bytes in a step; expected 19200"),
        ("yes | tr -d '\\n'".to_owned(), "without an end of line"),
        (
            format!(
                "echo '{{\"bytes\":19200}}'\nhead -c 16800\nhead -c 2448 >/dev/null\nprintf '{nan}'\n\
                 printf '{nan}'\nprintf '{nan}'"
            ),
            "a position or velocity is not finite",
        ),
    ];
    for (failure, expected) in cases {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &format!("if [ $steps -gt 2 ]; then\n{failure}\nelse\n{ECHO}\nfi"));
        let output = run(folder.path(), &["--set", "step_timeout=1"]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{failure}: {said}");
        let last = said.lines().last().unwrap();
        assert!(last.starts_with("drape: program:./mine.sh "), "{said}");
        assert!(last.contains(expected), "{said}");
        let all = format!("{}{said}", text(&output.stdout));
        assert_eq!(all.matches(expected).count(), 1, "{all}");
        assert!(!said.contains("panicked"), "{said}");
        let run = record(folder.path());
        assert!(matches!(run.ending, Ending::Diverged { step: 3, .. }), "{:?}", run.ending);
        assert_eq!(run.series.len(), 3, "the start and two steps");
    }
}

#[test]
fn a_program_that_cannot_start_is_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), &[]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("program `./mine.sh` cannot be started"), "{said}");
    std::fs::write(folder.path().join("mine.sh"), "exit 1").unwrap();
    let said = text(&run(folder.path(), &[]).stderr);
    assert!(said.contains("make the file executable"), "{said}");
    write(folder.path(), ECHO);
    let arguments = ["run", "square-table-1e4", "--method", "program:./mine.sh", "--dt", "0.01"];
    let output = drape(folder.path(), &arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("program:./mine.sh does not support contact"), "{said}");
}

#[test]
fn a_study_names_the_failures_of_a_program_and_ends() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "exit 4");
    let method = ["--methods", "program:./mine.sh,symplectic-euler"];
    let arguments = [&["experiment", "order", "--quick"][..], &method].concat();
    let output = drape(folder.path(), &arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains(
            "drape: warning: program `./mine.sh` ended in a step with exit code 4 (8 times)"
        ),
        "{said}"
    );
    let record = std::fs::read_to_string(folder.path().join("results-own/order.json")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    let labels =
        record["facts"]["rows"].as_array().unwrap().iter().map(|row| row["label"].as_str());
    let labels: std::collections::BTreeSet<_> = labels.flatten().collect();
    let expected = ["program:./mine.sh", "symplectic-euler", "symplectic-euler, implicit damping"];
    assert!(labels.into_iter().eq(expected));
}

#[test]
fn an_unknown_method_is_refused_before_a_study_begins() {
    let folder = tempfile::tempdir().unwrap();
    let output = drape(folder.path(), &["experiment", "order", "--methods", "middpoint"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains(
            "no method `middpoint` (nearest: `midpoint`); expected one of: explicit-euler"
        ),
        "{said}"
    );
    assert!(!folder.path().join("results-own").exists());
}

/// The midpoint rule in Python has order 2. Without SciPy the test says that it was skipped; with
/// DRAPE_PROGRAMS=required it fails.
#[test]
fn implicit_midpoint_in_python_has_order_two_in_the_study_of_orders() {
    let python = common::python();
    let scipy = Command::new(&python).args(["-c", "import scipy"]).output();
    if !scipy.is_ok_and(|output| output.status.success()) {
        assert_ne!(std::env::var("DRAPE_PROGRAMS").as_deref(), Ok("required"), "no SciPy");
        common::skipped(&format!("`{python} -c 'import scipy'` fails on this machine"));
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/methods");
    let script = examples.join("implicit_midpoint.py");
    let method = format!("program:'{python}' -B '{}'", script.display());
    let arguments = ["experiment", "order", "--quick", "--out", "mine", "--methods", &method];
    let output = drape(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let record = std::fs::read_to_string(folder.path().join("mine/order.json")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    let rows = record["facts"]["rows"].as_array().unwrap();
    let smooth = rows.iter().find(|row| row["scene"] == "smooth").unwrap();
    let order = smooth["order"].as_f64().unwrap();
    assert!((order - 2.0).abs() < 0.005, "order {order}");
}

/// A program has what a method in Rust has: every study has its rows, which say what theory says of
/// symplectic Euler, and the pages show them. It needs Python alone; without it the test says that
/// it was skipped, and with DRAPE_PROGRAMS=required it fails.
#[test]
fn symplectic_euler_in_python_has_the_studies_the_comparison_and_the_pages() {
    let python = common::python();
    let answer = Command::new(&python).arg("--version").output();
    if !answer.is_ok_and(|output| output.status.success()) {
        assert_ne!(std::env::var("DRAPE_PROGRAMS").as_deref(), Ok("required"), "no Python");
        common::skipped(&format!("`{python} --version` fails on this machine"));
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/methods/symplectic_euler.py");
    write_script(folder.path(), &format!("#!/bin/sh\nexec '{python}' -B '{script}'\n"));
    let facts = |arguments: &[&str], record: &str| {
        let output = drape(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
        let record = std::fs::read_to_string(folder.path().join(record)).unwrap();
        serde_json::from_str::<Value>(&record).unwrap()["facts"].take()
    };
    let study = |name: &str, list: &str| {
        let words = ["experiment", name, "--quick", "--methods", "program:./mine.sh"];
        let arguments = [&words[..], &["--out", "mine"]].concat();
        let rows = facts(&arguments, &format!("mine/{name}.json"))[list].take();
        let rows = rows.as_array().unwrap().clone();
        for row in &rows {
            let named = [&row["label"], &row["method"]];
            assert!(named.iter().any(|name| **name == "program:./mine.sh"), "{name}: {row}");
        }
        rows
    };
    let float = |row: &Value, name: &str| {
        row[name].as_f64().unwrap_or_else(|| panic!("no number `{name}` in {row}"))
    };

    let orders = study("order", "rows");
    let smooth = orders.iter().find(|row| row["scene"] == "smooth").unwrap();
    assert!((float(smooth, "order") - 1.0).abs() < 0.005, "{smooth}");

    // A sheet bears h² k/m up to about a half, and these steps begin at 10.
    let cells = study("stability", "cells");
    assert_eq!(cells.len(), 4, "{cells:?}");
    for cell in &cells {
        assert_eq!(cell["verdict"], "diverged", "{cell}");
    }

    // It keeps momentum and spin to rounding.
    let drifts = study("momentum", "rows");
    assert_eq!(drifts.len(), 3, "{drifts:?}");
    for row in &drifts {
        assert_eq!(row["verdict"], "completed", "{row}");
        assert!(float(row, "momentum_drift") < 1e-12, "{row}");
        assert!(float(row, "angular_momentum_drift") < 1e-12, "{row}");
    }

    // It announces no contact, so the spinning sheet is the one scene for it.
    let energies = study("energy", "rows");
    assert_eq!(energies.len(), 2, "{energies:?}");
    for row in &energies {
        assert!(row["verdict"] == "stable" && float(row, "gain") < 1e-3, "{row}");
    }

    let cases = study("hard-cases", "cells");
    assert_eq!(cases.len(), 6, "{cases:?}");
    for cell in &cases {
        let is_still = cell["case"].as_str().unwrap().starts_with("H17");
        assert_eq!(cell["differs"], false, "{cell}");
        assert_eq!(cell["verdict"], if is_still { "stable" } else { "diverged" }, "{cell}");
    }

    let page = std::fs::read_to_string(folder.path().join("mine/report.html")).unwrap();
    let page = page.replace("&#x2f;", "/");
    for study in ["order", "stability", "momentum", "energy", "hard-cases"] {
        let (_, part) = page.split_once(&format!("<h3 id=\"{study}-heading\"")).unwrap();
        let part = part.split("<h3 id=\"").next().unwrap();
        assert!(part.contains(">program:./mine.sh</td>"), "{study}");
    }

    let words = ["compare", "hanging-textile-1e4", "--duration", "0.1", "--budget", "60s"];
    let methods = ["--methods", "leapfrog,program:./mine.sh", "--out", "compared"];
    let facts = facts(&[&words[..], &methods].concat(), "compared/compare.json");
    let mut forms = facts["forms"].as_array().unwrap().iter();
    let form = forms.find(|form| form["method"] == "program:./mine.sh").unwrap();
    assert_eq!(form["end"], "good", "{form}");
}
