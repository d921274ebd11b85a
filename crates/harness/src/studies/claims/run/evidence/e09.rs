//! What is run for claim C09.

use super::meshes::Mesh;
use super::runs::{free_edge, true_motion};
use super::scenes::{build, error, greatest, run, shake};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c09::{LIMITS, ORDER};
use drape_oracle::order::position_error;

pub(super) const TRIAL: Trial = Trial {
    id: "C09",
    scenes: || {
        format!(
            "hanging textile on a grid and of triangles, N = 20 and 10: the paper's k/m = 1e4/s² \
             and d/m = 40/s, and softer and less damped ones, h = 0.002 and 0.005 s, after {SPAN} \
             s; Provot's correction, one sweep a step in four orders at limit 0.1, forward at 0.1, \
             0.03, 0.01; stiff reference: k/m = 1e6/s², symplectic Euler at a quarter of its limit"
        )
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const ORDERS: [&str; 4] = ["forward", "backward", "alternating", "shuffled"];
/// The hanging textile of the paper, and a coarser one.
const SIDES: [u32; 2] = [20, 10];
/// Step (s), stiffness over mass (1/s²) and damping over mass (1/s): the paper's fabric, which
/// weight stretches beyond the limit at the pins only, softer ones, which the limit must keep short
/// everywhere, and these lightly damped in longer steps, with fewer sweeps a second.
const SETTINGS: [(f64, f64, f64); 5] = [
    (0.002, 1e4, 40.0),
    (0.002, 1e3, 40.0),
    (0.002, 200.0, 40.0),
    (0.005, 1e3, 1.0),
    (0.005, 200.0, 1.0),
];
/// Nearly inextensible ones.
const STIFF: f64 = 1e6;
const SPAN: f64 = 1.0;
/// Of the control: how far two starts of one run are apart, m.
const NUDGE: f64 = 1e-9;

/// What was measured on a mesh after a span.
#[derive(Clone, Debug)]
struct Measured {
    name: String,
    /// Greatest distance between two orders at the first limit, over the motion.
    spread: f64,
    /// The same between two runs of one order whose starts are a nanometre apart.
    control: f64,
    /// Distance from the stiff reference over its motion, at the falling limits.
    errors: Vec<f64>,
}

fn measure(
    mesh: Mesh,
    side: u32,
    (step, soft, damping): (f64, f64, f64),
) -> Result<Measured, HarnessError> {
    let spec = mesh.hanging(side, soft, damping)?;
    let start = build(&spec)?;
    let stiff = mesh.hanging(side, STIFF, damping)?;
    let truth = true_motion(&build(&stiff)?, SPAN, free_edge(&stiff))?.state;
    let method = |limit: f64, order: &str| format!("provot:limit={limit},order={order}");
    let mut ends = Vec::new();
    for order in ORDERS {
        ends.push(run(&start, &method(LIMITS[0], order), step, SPAN, None)?.state);
    }
    let apart = |a: &[_], b: &[_]| position_error(&start.system, &start.state.x, a, b);
    let pairs = ends.iter().flat_map(|a| ends.iter().map(move |b| apart(&a.x, &b.x)));
    let spread = greatest(pairs.map(|d| if d.is_nan() { f64::INFINITY } else { d }));
    let mut nudged = start.clone();
    shake(&mut nudged, NUDGE, 1);
    let nudged = run(&nudged, &method(LIMITS[0], ORDERS[0]), step, SPAN, None)?.state;
    let control = apart(&ends[0].x, &nudged.x);
    let errors = LIMITS.iter().map(|&limit| {
        Ok(error(&start, &truth, &run(&start, &method(limit, ORDERS[0]), step, SPAN, None)?.state))
    });
    Ok(Measured {
        name: format!(
            "{}, N = {side}, k/m = {soft}/s², d/m = {damping}/s, h = {step} s",
            mesh.name()
        ),
        spread,
        control,
        errors: errors.collect::<Result<_, HarnessError>>()?,
    })
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut measured = Vec::new();
    for mesh in [Mesh::Grid, Mesh::Triangles] {
        for side in SIDES {
            for setting in SETTINGS {
                measured.push(measure(mesh, side, setting)?);
            }
        }
    }
    Ok(numbers(&measured))
}

fn numbers(measured: &[Measured]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for Measured { name, spread, control, errors } in measured {
        let what = format!("difference between orders over motion, {name}");
        numbers.push(Number::new(what, *spread, "").against(ORDER));
        let what = format!("the same between starts 1e-9 m apart, {name}");
        numbers.push(Number::new(what, *control, ""));
        for (limit, error) in LIMITS.iter().zip(errors) {
            let what =
                format!("distance from the stiff reference over motion, limit {limit}, {name}");
            numbers.push(Number::new(what, *error, ""));
        }
    }
    numbers
}
