//! The lab: a pane and the command that repeats it end in the same state.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_lab::{Files, Pane, Phase, Runs, Setup, Touch};
use drape_model::State;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};
use std::sync::Arc;
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
        if phase.is_over() || phase == Phase::Ready && snapshot.step == steps {
            return (phase, snapshot.step, snapshot.state.clone().unwrap());
        }
        assert!(begin.elapsed() < PATIENCE, "{phase:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Runs a command that reads a file, beside other files.
fn run(arguments: &[String], files: &[(&str, &str)]) -> drape_harness::record::Run {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_drape"))
        .current_dir(folder.path())
        .args(arguments)
        .args(["--out", "run.json"])
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{arguments:?}: {message}");
    drape_report::file::read_json(&folder.path().join("run.json")).unwrap()
}

/// Runs the command that a pane names; `mesh` is what stands beside its scene.
fn repeat(pane: &Pane, step: u64, mesh: &str) -> drape_harness::record::Run {
    let repeat = pane.scenery().unwrap().stage.repeat(step).unwrap();
    let mut files = Vec::new();
    files.extend(repeat.file.as_deref().map(|file| (file, repeat.scene.as_str())));
    files.extend(repeat.mesh.as_deref().map(|file| (file, mesh)));
    run(&repeat.arguments, &files)
}

fn check(setup: &Setup, until: f64, steps: u64) {
    check_with(setup, Files::default(), "", until, steps);
}

fn check_with(setup: &Setup, files: Files, mesh: &str, until: f64, steps: u64) {
    let pane = Pane::start_with(setup.clone(), Arc::new(files), &Runs::default()).unwrap();
    check_pane(&pane, mesh, until, steps);
}

/// Lets a pane go and compares its end with that of its command. Returns the state.
fn check_pane(pane: &Pane, mesh: &str, until: f64, steps: u64) -> State {
    let (phase, step, state) = go(pane, until, steps);
    let run = repeat(pane, if phase.is_over() { 0 } else { step }, mesh);
    let method = pane.scenery().unwrap().stage.choice.full_id();
    assert_eq!(run.final_state.time_s.to_bits(), state.t.to_bits(), "{method}");
    let of = |x: &[drape_model::Vec3]| bits(x.iter().map(|&x| x.into()));
    assert_eq!(bits(run.final_state.position_m.iter().copied()), of(&state.x), "{method}");
    assert_eq!(bits(run.final_state.velocity_m_s.iter().copied()), of(&state.v), "{method}");
    let named = pane.look().2.opinion.clone().unwrap();
    if phase.is_over() {
        assert_eq!((named.kind, named.reason), (run.verdict.kind, run.verdict.reason), "{method}");
    }
    state
}

fn setup(method: &str) -> Setup {
    Setup {
        scene: "hanging-textile-1e6".to_owned(),
        method: method.to_owned(),
        step: Some(0.01),
        duration: Some(0.25),
        ..Setup::default()
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
fn gravity_and_wind_are_knobs_of_the_scene() {
    let knobs = Setup {
        gravity: Some(1.62),
        wind: Some([0.5, 2.0, 0.0]),
        duration: Some(0.1),
        ..setup("imex-updated")
    };
    check(&knobs, f64::INFINITY, u64::MAX);
    let pane = Pane::start(knobs, &Runs::default()).unwrap();
    go(&pane, 0.01, 1);
    let spec = &pane.scenery().unwrap().stage.spec;
    assert_eq!(spec.effects.gravity.unwrap().m_s2[2], -1.62);
    assert_eq!(spec.effects.air.unwrap().wind.unwrap().velocity_m_s, [0.5, 2.0, 0.0]);
}

/// A strip of three by two squares.
const STRIP: &str = "v 0 0 1\nv 1 0 1\nv 2 0 1\nv 3 0 1\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\n\
    f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n";

#[test]
fn a_dropped_mesh_is_repeated_from_its_scene_and_the_mesh_beside_it() {
    // A name that a shell would take apart.
    let name = "my 'strip'.obj";
    for knobs in [
        setup("imex-updated"),
        Setup { stiffness: Some(3e3), gravity: Some(3.0), ..setup("leapfrog") },
    ] {
        let mut files = Files::default();
        files.add(name, STRIP.as_bytes()).unwrap();
        let dropped = Setup { scene: format!("file:{name}"), ..knobs };
        check_with(&dropped, files, STRIP, f64::INFINITY, u64::MAX);
    }
}

#[test]
fn dropped_scenes_and_systems_are_repeated() {
    let scene = r#"{ "format": "drape-scene/1", "name": "../outside",
        "cloth": { "mesh": { "file": "strip.obj", "areal_density_kg_m2": 0.3 } },
        "effects": { "tension": { "stiffness_n_per_m": 80 }, "gravity": { "m_s2": [0, 0, -9.81] } },
        "pins": [{ "particle": 0 }], "time": { "step_s": 0.01, "duration_s": 1 } }"#;
    let system = r#"{ "format": "drape-system/1",
        "particles": { "mass_kg": [1, 2], "position_m": [[0, 0, 1], [1, 0, 1]] },
        "springs": [{ "effect": "tension", "i": 0, "j": 1, "stiffness_n_per_m": 50, "rest_length_m": 0.9 }],
        "pins": [{ "particle": 0, "path": [{ "time_s": 0.1, "offset_m": [0, 0.1, 0] }] }],
        "effects": { "gravity": { "m_s2": [0, 0, -9.81] } } }"#;
    for (name, text) in [("scene.json", scene), ("system.json", system)] {
        let mut files = Files::default();
        files.add("strip.obj", STRIP.as_bytes()).unwrap();
        files.add(name, text.as_bytes()).unwrap();
        let dropped = Setup { scene: format!("file:{name}"), ..setup("imex-updated") };
        check_with(&dropped, files, STRIP, f64::INFINITY, u64::MAX);
    }
}

/// A particle is gripped, led along two legs and let go; each run between two touches is repeated by
/// the command that the pane names then, and the way by a run with a driven pin.
#[test]
fn a_cloth_that_is_moved_by_hand_is_repeated_from_each_touch_on() {
    let runs = Runs::default();
    for (method, particle) in
        [("imex-updated", 210), ("baraff-witkin", 399), ("leapfrog", 0), ("bdf2", 210)]
    {
        // Soft enough for an explicit method.
        let knobs = Setup { stiffness: Some(1e3), damping: Some(1.0), ..setup(method) };
        let mut pane = Pane::start(knobs, &runs).unwrap();
        let start = check_pane(&pane, "", 0.05, 5);
        let mut state = start.clone();
        let grip: [f64; 3] = state.x[particle].into();
        let (mut step, mut since) = (5, 0_u32);
        for (to, steps) in [([0.1, 0.0, 0.05], 3_u32), ([0.1, 0.2, 0.1], 6)] {
            let stage = pane.scenery().unwrap().stage.clone();
            let to = [0, 1, 2].map(|axis| grip[axis] + to[axis]);
            let led = stage.led(&state, step, particle as u32, to, 0.05).unwrap();
            assert!(led.is_led() && led.is_touched());
            pane = Pane::resume(led, &runs).unwrap();
            let until = f64::from(5 + since + steps) * 0.01;
            state = check_pane(&pane, "", until, steps.into());
            (step, since) = (u64::from(steps), since + steps);
        }
        // The second leg ended before it was let go, so the particle is where the hand was.
        let place = state.x[particle] - drape_model::Vec3::from(grip);
        assert!(
            (place - drape_model::Vec3::new(0.1, 0.2, 0.1)).norm() < 1e-12,
            "{method}: {place}"
        );
        let free = pane.scenery().unwrap().stage.let_go(&state, step).unwrap();
        assert!(!free.is_led());
        let pins = free.spec.pins.iter().filter(|pin| pin.particle == particle as u32).count();
        // Corners 0 and 19 were pinned before, and are again.
        assert_eq!(pins, usize::from(particle == 0), "{method}");
        let way = free.repeat(0).unwrap().way.unwrap();
        assert!(free.repeat(0).unwrap().note.contains("moved by hand"));
        let moved = run(&way.arguments, &[(&way.file, &way.scene)]);
        assert!((moved.final_state.time_s - f64::from(since) * 0.01).abs() < 1e-9, "{method}");
        let led: drape_model::Vec3 = moved.final_state.position_m[particle].into();
        assert!((led - state.x[particle]).norm() < 1e-9, "{method}");
        if method != "bdf2" {
            // A method without memory makes the same move in one run, up to round-off and its solver.
            let far =
                |x: &[f64; 3], y: &drape_model::Vec3| (drape_model::Vec3::from(*x) - y).norm();
            let pairs = moved.final_state.position_m.iter().zip(&state.x);
            let most = pairs.map(|(x, y)| far(x, y)).fold(0.0, f64::max);
            assert!(most < 1e-3, "{method}: {most} m");
        }
        pane = Pane::resume(free, &runs).unwrap();
        let end = check_pane(&pane, "", f64::INFINITY, u64::MAX);
        assert!((pane.look().2.numbers.time - 0.25).abs() < 1e-9, "{method}");
        assert_ne!(bits(end.x.iter().map(|&x| x.into())), bits(state.x.iter().map(|&x| x.into())));
    }
}

/// Knobs are turned twice on the way; each run from there on is repeated by its command.
#[test]
fn a_cloth_that_goes_on_after_a_change_is_repeated_from_there_on() {
    let runs = Runs::default();
    for method in ["imex-updated", "leapfrog", "bdf2"] {
        let soft = Setup { stiffness: Some(1e3), damping: Some(1.0), ..setup(method) };
        let turned = Setup { stiffness: Some(4e3), gravity: Some(1.62), ..soft.clone() };
        let slower = Setup { step: Some(0.005), method: "imex-euler".to_owned(), ..turned.clone() };
        let mut pane = Pane::start(soft, &runs).unwrap();
        let mut state = check_pane(&pane, "", 0.05, 5);
        for (setup, until, steps) in [(turned, 0.08, 3), (slower, 0.1, 4)] {
            let before = pane.scenery().unwrap().stage.clone();
            let step = pane.look().2.step;
            let stage = setup.stage().unwrap().going_on(&before, &state, step).unwrap();
            assert_eq!(stage.touch(), Some(Touch::Knob));
            pane = Pane::resume(stage, &runs).unwrap();
            let (_, _, start) = go(&pane, 0.0, 0);
            assert_eq!((&start.x, &start.v), (&state.x, &state.v), "{method}");
            state = check_pane(&pane, "", until, steps);
            assert!((pane.look().2.numbers.time - until).abs() < 1e-9, "{method}");
        }
        // 5 steps, then 3, then 4.
        assert_eq!(pane.look().2.numbers.step, 12, "{method}");
        let note = pane.scenery().unwrap().stage.repeat(4).unwrap().note;
        assert!(note.contains("A knob was turned on the way") && note.contains("0.08"), "{note}");
    }
}

/// What follows the time of a scene goes on as well: pins and obstacles on paths, and gusts.
#[test]
fn a_change_that_changes_nothing_leaves_the_motion_as_it_was() {
    for scene in ["flag", "curtain", "drape-test"] {
        let same =
            Setup { scene: scene.to_owned(), duration: Some(0.4), ..setup("backward-euler") };
        let whole = Pane::start(same.clone(), &Runs::default()).unwrap();
        let (_, _, expected) = go(&whole, 0.2, 20);
        let pane = Pane::start(same.clone(), &Runs::default()).unwrap();
        let (_, step, state) = go(&pane, 0.1, 10);
        let stage = pane.scenery().unwrap().stage.clone();
        let stage = same.stage().unwrap().going_on(&stage, &state, step).unwrap();
        let pane = Pane::resume(stage, &Runs::default()).unwrap();
        let (_, _, found) = go(&pane, 0.2, 10);
        let pairs = expected.x.iter().zip(&found.x);
        let apart = pairs.map(|(x, y)| (x - y).norm()).fold(0.0, f64::max);
        let moved =
            expected.x.iter().zip(&state.x).map(|(x, y)| (x - y).norm()).fold(0.0, f64::max);
        // Both solve to a tolerance. A path or a gust that began anew would be seen in centimetres.
        assert!(apart < 1e-4 && moved > 1e-2, "{scene}: {apart} m apart, {moved} m moved");
    }
}

#[test]
fn a_change_that_leaves_no_time_or_another_cloth_is_refused() {
    let pane = Pane::start(setup("imex-updated"), &Runs::default()).unwrap();
    let (_, step, state) = go(&pane, 0.02, 2);
    let before = &pane.scenery().unwrap().stage;
    let short = Setup { duration: Some(0.02), ..setup("imex-updated") };
    let other = Setup { particles: Some(10), ..setup("imex-updated") };
    for (changed, step, named) in
        [(short, step, "more than 0.02 s"), (other, step, "100"), (setup("xpbd"), 25, "knob")]
    {
        let stage = changed.stage().unwrap();
        let error = stage.going_on(before, &state, step).unwrap_err().to_string();
        assert!(error.contains(named) && error.contains("press Restart"), "{error}");
    }
}

#[test]
fn a_hand_that_cannot_act_is_refused() {
    let pane = Pane::start(setup("imex-updated"), &Runs::default()).unwrap();
    let (_, step, state) = go(&pane, 0.02, 2);
    let stage = &pane.scenery().unwrap().stage;
    let error = stage.led(&state, step, 400, [0.0; 3], 0.1).unwrap_err().to_string();
    assert!(error.contains("particle") && error.contains("from 0 to 399"), "{error}");
    let error = stage.led(&state, 25, 7, [0.0; 3], 0.1).unwrap_err().to_string();
    assert!(error.contains("press Restart"), "{error}");
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
