//! What is run for claim C05.

use super::meshes::Mesh;
use super::runs::{free_edge, true_motion};
use super::scenes::{build, error, hanging, run, spinning};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c05::{DRIFT, ERROR};
use crate::run::Simulation;

pub(super) const TRIAL: Trial = Trial {
    id: "C05",
    scenes: || {
        format!(
            "error: hanging sheets (8 × 8 at k/m = 1e4 and 1e6/s², triangles), {SPAN} s, h = 0.01 \
             to 0.00001 s, against symplectic Euler at a quarter of its limit; drift: a free sheet \
             of 12 × 12 turning at 2 rad/s, undamped; {PUBLISHED}"
        )
    },
    portable: false,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// As published: torque correction in the printed units.
const PUBLISHED: &str = "desbrun:torque=literal";
const CONSISTENT: &str = "desbrun:torque=consistent";
const STEPS: [f64; 6] = [0.01, 0.0025, 0.000_625, 0.000_156_25, 0.000_039_062_5, 0.000_009_765_625];
const SPAN: f64 = 0.25;
const SPINS: [(f64, f64); 4] = [(1e4, 0.01), (1e4, 0.001), (1e6, 0.01), (1e6, 0.001)];

/// Share of the angular momentum that is lost, or won, within one second; and the drift of the
/// momentum over that of the edge's speed.
fn drift(start: &Simulation, method: &str, step: f64) -> Result<(f64, f64), HarnessError> {
    let system = &start.system;
    let before = system.angular_momentum(&start.state);
    let end = run(start, method, step, 1.0, None)?.state;
    let lost = (system.angular_momentum(&end) - before).norm() / before.norm();
    let mass: f64 = system.mass().iter().sum();
    let speed = start.state.v.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let moved = (system.momentum(&end) - system.momentum(&start.state)).norm() / (mass * speed);
    Ok((if lost.is_nan() { f64::INFINITY } else { lost }, moved))
}

/// What was measured.
#[derive(Clone, Debug, Default)]
struct Measured {
    /// Scene, and errors over the falling steps.
    errors: Vec<(String, Vec<f64>)>,
    /// Angular drift: k/m, h, published, consistent.
    drifts: Vec<(f64, f64, f64, f64)>,
    /// Greatest drift of the momentum.
    momentum: f64,
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut measured = Measured::default();
    for (name, spec) in [
        ("grid, k/m = 1e4", hanging(8, 1e4, 10.0).spec()?),
        ("triangles, k/m = 1e4", Mesh::Triangles.hanging(7, 1e4, 10.0)?),
        ("grid, k/m = 1e6", hanging(8, 1e6, 10.0).spec()?),
    ] {
        let start = build(&spec)?;
        let truth = true_motion(&start, SPAN, free_edge(&spec))?.state;
        let of = |step: &f64| -> Result<f64, HarnessError> {
            Ok(error(&start, &truth, &run(&start, PUBLISHED, *step, SPAN, None)?.state))
        };
        let errors = STEPS.iter().map(of).collect::<Result<_, _>>()?;
        measured.errors.push((name.to_owned(), errors));
    }
    for (stiffness, step) in SPINS {
        let start = spinning(12, stiffness, 2.0)?;
        let (published, moved) = drift(&start, PUBLISHED, step)?;
        let (consistent, _) = drift(&start, CONSISTENT, step)?;
        measured.drifts.push((stiffness, step, published, consistent));
        measured.momentum = measured.momentum.max(moved);
    }
    Ok(numbers(&measured))
}

fn numbers(measured: &Measured) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (name, errors) in &measured.errors {
        for (step, error) in STEPS.iter().zip(errors) {
            let what = format!("error over motion, {name}, h = {step} s");
            numbers.push(Number::new(what, *error, "").against(ERROR));
        }
    }
    for (stiffness, step, published, consistent) in &measured.drifts {
        let at = format!("k/m = {stiffness:.0e}, h = {step} s");
        let what = format!("angular drift in 1 s as published, {at}");
        numbers.push(Number::new(what, *published, "").against(DRIFT));
        let what = format!("angular drift in 1 s with the consistent correction, {at}");
        numbers.push(Number::new(what, *consistent, ""));
    }
    let momentum = measured.momentum;
    numbers.push(Number::new("greatest drift of the momentum, as published", momentum, ""));
    numbers
}
