//! C09: post-correction of elongated springs is not physically sound.

use super::meshes::Mesh;
use super::runs::{free_edge, true_motion};
use super::scenes::{build, error, greatest, run, shake};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::studies::short;
use drape_oracle::order::position_error;

pub(super) const CLAIM: Claim = Claim {
    id: "C09",
    section: "3",
    says: "post-correction of elongated springs is not physically sound",
    criterion: "at limit 0.1 on the hanging textile, grid and triangle mesh: final positions depend on the order of the \
                sweep by > 1 % of the motion, or do not approach the stiff reference as the limit goes from 0.1 to 0.01",
    is_quick: false,
    test,
    seconds: None,
};

const ORDER: f64 = 0.01;
const LIMITS: [f64; 3] = [0.1, 0.03, 0.01];
const ORDERS: [&str; 4] = ["forward", "backward", "alternating", "shuffled"];
/// The hanging textile of the paper, and a coarser one.
const SIDES: [u32; 2] = [20, 10];
/// Step (s), stiffness over mass (1/s²) and damping over mass (1/s): the paper's fabric, which weight stretches beyond the
/// limit at the pins only, softer ones, which the limit must keep short everywhere, and these lightly damped in longer
/// steps, with fewer sweeps a second.
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

impl Measured {
    fn depends_on_order(&self) -> bool {
        self.spread > ORDER
    }

    /// The criterion.
    fn is_unsound(&self) -> bool {
        self.depends_on_order() || !self.approaches()
    }

    fn approaches(&self) -> bool {
        self.errors.windows(2).all(|pair| pair[1] < pair[0])
    }
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

fn test() -> Result<Finding, HarnessError> {
    let mut measured = Vec::new();
    for mesh in [Mesh::Grid, Mesh::Triangles] {
        for side in SIDES {
            for setting in SETTINGS {
                measured.push(measure(mesh, side, setting)?);
            }
        }
    }
    Ok(judge(&measured))
}

fn judge(measured: &[Measured]) -> Finding {
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
    let depending = measured.iter().filter(|m| m.depends_on_order()).count();
    let astray = measured.iter().filter(|m| !m.approaches()).count();
    let by_spread = |a: &&Measured, b: &&Measured| a.spread.total_cmp(&b.spread);
    let name = |m: Option<&Measured>| m.map_or("none", |m| m.name.as_str()).to_owned();
    let most = name(measured.iter().max_by(by_spread));
    let least = name(measured.iter().min_by(by_spread));
    let spread = greatest(measured.iter().map(|m| m.spread));
    let control = greatest(measured.iter().map(|m| m.control));
    let last = greatest(measured.iter().filter_map(|m| m.errors.last().copied()));
    Finding {
        verdict: match measured.iter().filter(|m| m.is_unsound()).count() {
            0 => Verdict::Refuted,
            count if count == measured.len() => Verdict::Confirmed,
            _ => Verdict::Undecided,
        },
        numbers,
        reason: format!(
            "The order of the sweep changes the final positions by more than 1 % of the motion in {depending} of {} cases (by up to \
             {}; starts a nanometre apart differ by at most {}), and in {astray} the distance from the stiff sheet does not fall with \
             the limit: it is up to {} of the motion at 0.01. Most depends on the order: {most}; least: {least}.",
            measured.len(),
            short(spread),
            short(control),
            short(last)
        ),
        repair: None,
        scenes: format!(
            "hanging textile on a grid and of triangles, N = 20 and 10: the paper's k/m = 1e4/s² and d/m = 40/s, and softer and \
             less damped ones, h = 0.002 and 0.005 s, after {SPAN} s; Provot's correction, one sweep a step in four orders at limit \
             0.1, forward at 0.1, 0.03, 0.01; stiff reference: k/m = 1e6/s², symplectic Euler at a quarter of its limit"
        ),
        see: "post-correction-order.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(spread: f64, errors: [f64; 3]) -> Measured {
        Measured { name: "a sheet".to_owned(), spread, control: 0.0, errors: errors.to_vec() }
    }

    #[test]
    fn all_cases_must_agree() {
        let sound = measured(0.001, [0.3, 0.2, 0.1]);
        let depending = measured(0.02, [0.3, 0.2, 0.1]);
        let astray = measured(0.001, [0.3, 0.2, 0.25]);
        assert_eq!(judge(&[depending.clone(), astray.clone()]).verdict, Verdict::Confirmed);
        assert_eq!(judge(&[depending, sound.clone()]).verdict, Verdict::Undecided);
        assert_eq!(judge(&[sound]).verdict, Verdict::Refuted);
        assert_eq!(judge(&[astray]).verdict, Verdict::Confirmed);
    }
}
