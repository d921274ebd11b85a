//! The programs that ship with drape follow the exact recurrences of their methods.
//!
//! They need Python 3 (`DRAPE_PYTHON` names it), one of them SciPy, and the last a C++ compiler. Where one is missing its
//! test says that it was skipped; with DRAPE_PROGRAMS=required it fails.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "tests")]

use drape_integrator::{PhaseClock, Settings, TimeStep};
use drape_model::{DampingLaw, KeyframeSpec, SpringEffect, State, System, Vec3};
use drape_oracle::recurrence::{Amplification, implicit_midpoint, symplectic_euler};
use drape_oracle::scenes::{anchored, build, bundled, pin, stir};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A power of two, so that `θ = h²k/m` and `η = hc/m` are met exactly.
const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;
const STEPS: usize = 100;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../drape/examples/methods").join(name)
}

/// Whether a command succeeds; without it a test is skipped.
fn has(program: &str, arguments: &[&str]) -> bool {
    let is_there =
        Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success());
    if !is_there {
        let what = format!("`{program} {}` fails on this machine", arguments.join(" "));
        assert_ne!(std::env::var("DRAPE_PROGRAMS").as_deref(), Ok("required"), "{what}");
        // Past the capture of tests.
        writeln!(std::io::stderr().lock(), "SKIPPED: {what}").unwrap();
    }
    is_there
}

/// The Python of `DRAPE_PYTHON`, or `python3`.
fn interpreter() -> String {
    std::env::var("DRAPE_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

fn python(script: &str) -> String {
    format!("'{}' -B '{}'", interpreter(), file(script).display())
}

fn run(command: &str, (system, mut state): (System, State), steps: usize) -> Vec<State> {
    let registration = drape_program::load(command).unwrap();
    let method = registration.method;
    let settings = Settings::new(method.id, method.settings, []).unwrap();
    let mut integrator = (registration.build)(&settings).unwrap();
    let h = TimeStep::new(H).unwrap();
    integrator.prepare(&system, h).unwrap();
    let mut clock = PhaseClock::off();
    let step = |_| {
        let report = integrator.step(&system, &mut state, h, &mut clock).unwrap();
        assert!(report.force_evaluations > 0);
        state.clone()
    };
    (0..steps).map(step).collect()
}

/// `θ` and `η` at which the recurrences are met, all within the limit of symplectic Euler.
const OSCILLATORS: [(f64, f64); 4] = [(0.5, 0.0), (1.0, 0.25), (3.0, 0.1), (1e-3, 0.0)];

/// Greatest distance of the positions and velocities (times `h`) from the recurrence, over the
/// greatest amplitude, along a direction from a place.
fn distance(
    states: &[State],
    start: (Vec3, Vec3),
    matrix: Amplification,
    (from, along): (Vec3, Vec3),
) -> f64 {
    let of = |x: Vec3, v: Vec3| [(x - from).dot(&along), H * v.dot(&along)];
    let mut own = of(start.0, start.1);
    let (mut amplitude, mut error) = (own[0].abs(), 0.0_f64);
    for state in states {
        let row = |k| matrix[(k, 0)] * own[0] + matrix[(k, 1)] * own[1];
        own = [row(0), row(1)];
        amplitude = amplitude.max(own[0].abs());
        let found = of(state.x[1], state.v[1]);
        error = error.max((found[0] - own[0]).abs()).max((found[1] - own[1]).abs());
    }
    error / amplitude
}

/// The program is the recurrence: in space on a spring of rest length 0, and along a spring with a
/// rest length under both laws of damping.
fn follows(command: &str, law: fn(f64, f64) -> Amplification, tolerance: f64) {
    for (theta, eta) in OSCILLATORS {
        let (k, c) = (theta * MASS / (H * H), eta * MASS / H);
        let matrix = law(theta, eta);
        let (x, v) = (Vec3::new(1.0, -0.5, 2.0), Vec3::new(0.0, 4.0, 7.0));
        let start = build(&anchored(MASS, &[(SpringEffect::Tension, 0.0, k, c)], x, v));
        let states = run(command, start, STEPS);
        for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
            let error = distance(&states, (x, v), matrix, (Vec3::zeros(), axis));
            assert!(error < tolerance, "θ = {theta}, η = {eta}: {error:e}");
        }
        for damping in [DampingLaw::Full, DampingLaw::Projected] {
            let along = Vec3::new(2.0, 3.0, 6.0) / 7.0;
            let (x, v) = (along * 1.05, along * 0.1);
            let mut spec = anchored(MASS, &[(SpringEffect::Tension, 1.0, k, c)], x, v);
            spec.damping = damping;
            let states = run(command, build(&spec), STEPS);
            let error = distance(&states, (x, v), matrix, (along, along));
            assert!(error < 1e2 * tolerance, "{damping:?}, θ = {theta}, η = {eta}: {error:e}");
        }
    }
}

#[test]
fn symplectic_euler_in_python_is_its_recurrence() {
    if has(&interpreter(), &["--version"]) {
        follows(&python("symplectic_euler.py"), symplectic_euler, 1e-12);
    }
}

#[test]
fn implicit_midpoint_in_python_is_its_recurrence() {
    if has(&interpreter(), &["-c", "import scipy"]) {
        follows(&python("implicit_midpoint.py"), implicit_midpoint, 1e-11);
    }
}

/// Both find the same forces on a stirred sheet with gravity, damping, and a pin that is led.
#[test]
fn symplectic_euler_in_cpp_is_its_recurrence_and_moves_a_sheet_as_in_python() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("symplectic_euler");
    let (program, source) = (program.display().to_string(), file("symplectic_euler.cpp"));
    let source = source.display().to_string();
    if !has("c++", &["-std=c++17", "-O1", &source, "-o", &program]) {
        return;
    }
    let command = format!("'{program}'");
    follows(&command, symplectic_euler, 1e-12);
    if !has(&interpreter(), &["--version"]) {
        return;
    }
    for damping in [DampingLaw::Full, DampingLaw::Projected] {
        let mut spec = bundled("hanging-textile-1e4");
        spec.damping = damping;
        let mut led = pin(30);
        led.path = vec![KeyframeSpec { time_s: 1.0, offset_m: [0.1, 0.0, 0.3] }];
        spec.pins.push(led);
        let ends = [command.clone(), python("symplectic_euler.py")].map(|command| {
            let mut start = stir(build(&spec), 1e-3, 0.1);
            start.1.x[30] = start.0.moving_pins()[0].position(0.0);
            run(&command, start, 5).pop().unwrap()
        });
        let [one, other] = &ends;
        let far = one.x.iter().zip(&other.x).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(far < 1e-12, "{far:e}");
        assert!(one.is_finite() && (one.x[30] - other.x[30]).norm() == 0.0);
    }
}
