//! The lab: a pane and the command that repeats it end in the same state.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_lab::{Pane, Phase, Runs, Setup};
use drape_model::State;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(120);

/// Positions and velocities as bits.
fn bits(x: impl Iterator<Item = [f64; 3]>) -> Vec<[u64; 3]> {
    x.map(|x| x.map(f64::to_bits)).collect()
}

/// Lets a pane go until a time, and waits until it has got there or is over.
fn go(pane: &Pane, until: f64, steps: u64) -> (Phase, u64, State) {
    pane.go_until(until);
    let begin = Instant::now();
    loop {
        let (_, phase, snapshot) = pane.look();
        if phase.is_over() || snapshot.numbers.step == steps {
            return (phase, snapshot.numbers.step, snapshot.state.clone().unwrap());
        }
        assert!(begin.elapsed() < PATIENCE, "{phase:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Runs the command that a pane names.
fn repeat(pane: &Pane, step: u64) -> drape_harness::record::Run {
    let repeat = pane.scenery().unwrap().stage.repeat(step).unwrap();
    let folder = tempfile::tempdir().unwrap();
    if let Some(file) = &repeat.file {
        std::fs::write(folder.path().join(file), &repeat.scene).unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_drape"))
        .current_dir(folder.path())
        .args(&repeat.arguments)
        .args(["--out", "run.json"])
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}: {message}", repeat.command);
    drape_report::file::read_json(&folder.path().join("run.json")).unwrap()
}

fn check(setup: &Setup, until: f64, steps: u64) {
    let pane = Pane::start(setup.clone(), &Runs::default()).unwrap();
    let (phase, step, state) = go(&pane, until, steps);
    let run = repeat(&pane, if phase.is_over() { 0 } else { step });
    let method = &setup.method;
    assert_eq!(run.final_state.time_s.to_bits(), state.t.to_bits(), "{method}");
    let of = |x: &[drape_model::Vec3]| bits(x.iter().map(|&x| x.into()));
    assert_eq!(bits(run.final_state.position_m.iter().copied()), of(&state.x), "{method}");
    assert_eq!(bits(run.final_state.velocity_m_s.iter().copied()), of(&state.v), "{method}");
    let named = pane.look().2.opinion.clone().unwrap();
    if phase.is_over() {
        assert_eq!((named.kind, named.reason), (run.verdict.kind, run.verdict.reason), "{method}");
    }
}

fn setup(method: &str) -> Setup {
    Setup {
        scene: "hanging-textile-1e6".to_owned(),
        method: method.to_owned(),
        stiffness: None,
        damping: None,
        step: Some(0.01),
        duration: Some(0.25),
        particles: None,
    }
}

#[test]
fn a_pane_ends_as_the_command_that_repeats_it() {
    for method in ["explicit-euler", "imex-euler:forcing_term=0.05", "imex-updated", "xpbd"] {
        check(&setup(method), f64::INFINITY, u64::MAX);
    }
}

#[test]
fn a_pane_with_turned_knobs_ends_as_the_command_that_reads_its_scene() {
    let knobs = |method: &str| Setup {
        stiffness: Some(12345.678),
        damping: Some(3.3),
        particles: Some(13),
        duration: Some(0.123),
        ..setup(method)
    };
    for method in ["imex-euler", "baraff-witkin", "leapfrog"] {
        check(&knobs(method), f64::INFINITY, u64::MAX);
    }
}

#[test]
fn a_paused_pane_is_where_the_command_of_so_many_steps_ends() {
    for steps in [1, 7] {
        check(&setup("imex-updated"), 0.01 * steps as f64, steps);
    }
}

#[test]
fn other_scenes_are_repeated_too() {
    for scene in ["skirt", "flag", "square-table-1e4", "hanging-wool"] {
        let scene =
            Setup { scene: scene.to_owned(), duration: Some(0.03), ..setup("imex-updated") };
        check(&scene, f64::INFINITY, u64::MAX);
    }
}

#[test]
fn the_command_prints_an_address_with_a_token_and_refuses_a_port_that_is_taken() {
    let start = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
        command.args(["lab", "--no-open"]).args(more);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let mut lab = start(&["--setup", "#rate=1"]);
    let mut address = String::new();
    BufReader::new(lab.stdout.take().unwrap()).read_line(&mut address).unwrap();
    let rest = address.trim_end().strip_prefix("http://127.0.0.1:").unwrap().to_owned();
    let parts: Vec<_> = rest.split('/').collect();
    assert_eq!((parts[1].len(), parts[2]), (32, "#rate=1"));
    let taken = start(&["--port", parts[0]]).wait_with_output().unwrap();
    assert_eq!(taken.status.code(), Some(2));
    let message = String::from_utf8(taken.stderr).unwrap();
    assert!(message.contains("--port") && message.contains("expected a port that is free"));
    lab.kill().unwrap();
    lab.wait().unwrap();
}
