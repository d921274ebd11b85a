//! C28: nothing depends on a regular mesh.

use super::meshes::Mesh;
use super::runs::{free_edge, track, true_motion};
use super::scenes::build;
use super::{Claim, Finding, Number, Verdict};
use crate::studies::short;
use crate::{HarnessError, reference_energy};

pub(super) const CLAIM: Claim = Claim {
    id: "C28",
    section: "5, 9",
    says: "nothing depends on a regular mesh",
    criterion: "same trends on triangle meshes and random meshes",
    is_quick: false,
    test,
    seconds: None,
};

const SIDE: u32 = 14;
const STEP: f64 = 0.01;
const STIFFNESSES: [f64; 4] = [1e4, 1e5, 1e6, 1e7];
const MESHES: [Mesh; 4] = [Mesh::Grid, Mesh::Triangles, Mesh::Random(1), Mesh::Random(2)];
/// Greatest stiffness over mass at which updated CG, in its safeguarded form, is run, 1/s².
const UPDATED_LIMIT: f64 = 1e5;
/// A change by less than this factor is no change.
const LEVEL: f64 = 1.15;

/// The names of the quantities whose trends are compared.
const QUANTITIES: [&str; 4] = [
    "retained motion, plain",
    "iterations a step, no preconditioner",
    "IC(0) over no preconditioner",
    "retained motion, updated (to k/m = 1e5)",
];

/// What is measured on one mesh, from the softest to the stiffest.
struct Row {
    mesh: String,
    quantities: [Vec<f64>; 4],
    /// Greatest gain of energy of plain IMEX Euler, solved to 1e-10, over what the scene sets free.
    gain: f64,
}

fn row(mesh: Mesh) -> Result<Row, HarnessError> {
    let mut row = Row { mesh: mesh.name(), quantities: Default::default(), gain: 0.0 };
    for stiffness in STIFFNESSES {
        let spec = mesh.hanging(SIDE, stiffness, 40.0)?;
        let (start, tracked) = (build(&spec)?, free_edge(&spec));
        let exact = true_motion(&start, 0.6, tracked)?;
        let run = |method: &str| track(&start, method, STEP, 0.6, tracked);
        let tight = run("imex-euler:forcing_term=1e-10")?;
        row.gain = row.gain.max(tight.gain / reference_energy(&start, 0.6)?);
        let bare = run("imex-euler:forcing_term=1e-3,preconditioner=none")?.per_step();
        let plain = run("imex-euler:forcing_term=1e-3")?.per_step();
        let mut values = vec![tight.path / exact.path, bare, plain / bare];
        if stiffness <= UPDATED_LIMIT {
            let updated = run("imex-updated:newton_above=1e300,max_outer=2000")?;
            values.push(updated.path / exact.path);
        }
        for (series, value) in row.quantities.iter_mut().zip(values) {
            series.push(value);
        }
    }
    Ok(row)
}

/// −1, 0 or 1 for each pair of neighbours: whether the series falls, stays or rises.
fn trend(series: &[f64]) -> Vec<i8> {
    let sign = |pair: &[f64]| match pair[1] / pair[0] {
        ratio if ratio > LEVEL => 1,
        ratio if ratio < 1.0 / LEVEL => -1,
        _ => 0,
    };
    series.windows(2).map(sign).collect()
}

/// Whether two trends never go opposite ways.
fn agree(a: &[f64], b: &[f64]) -> bool {
    trend(a).iter().zip(trend(b)).all(|(a, b)| a * b >= 0)
}

fn test() -> Result<Finding, HarnessError> {
    Ok(judge(&MESHES.into_iter().map(row).collect::<Result<Vec<_>, _>>()?))
}

fn judge(rows: &[Row]) -> Finding {
    let (mut numbers, mut differing) = (Vec::new(), Vec::new());
    for row in rows {
        for (name, (series, grid)) in
            QUANTITIES.iter().zip(row.quantities.iter().zip(&rows[0].quantities))
        {
            for (value, stiffness) in series.iter().zip(STIFFNESSES) {
                let what = format!("{name}, {}, k/m = {stiffness:e}", row.mesh);
                numbers.push(Number::new(what, *value, ""));
            }
            if !agree(series, grid) {
                differing.push(format!("{name} on {}", row.mesh));
            }
        }
        let what = format!("gain of energy over what is set free, {}", row.mesh);
        numbers.push(Number::new(what, row.gain, "").against(0.02));
    }
    let gain = rows.iter().fold(0.0_f64, |most, row| most.max(row.gain));
    let last = |quantity: usize| {
        let values = rows.iter().filter_map(|row| row.quantities[quantity].last());
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
            (low.min(*value), high.max(*value))
        });
        format!("{} to {}", short(low), short(high))
    };
    let seen = if differing.is_empty() {
        "no quantity rises on one mesh where it falls on another".to_owned()
    } else {
        format!("trends that go the other way: {}", differing.join("; "))
    };
    Finding {
        verdict: Verdict::of(differing.is_empty() && gain <= 0.02),
        numbers,
        reason: format!(
            "From k/m = 1e4 to 1e7 {seen}; no mesh gains more than {} of the energy set free. At 1e7 the meshes keep {} of the \
             motion without updates ({} with them at 1e5), take {} iterations a step without a preconditioner, and IC(0) takes {} times as many, although the random \
             meshes are numbered at random.",
            short(gain),
            last(0),
            last(3),
            last(1),
            last(2)
        ),
        repair: None,
        scenes: "sheets of about 196 particles that hang by two corners: grid, equilateral triangles, Delaunay meshes of random points \
                 (seeds 1 and 2, mass by area, numbered as drawn); k/m = 1e4 to 1e7, d/m = 40 1/s, h = 0.01 s, 0.6 s"
            .to_owned(),
        see: "claims.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_trends_differ_and_a_level_stretch_does_not() {
        assert!(agree(&[1.0, 2.0, 3.0], &[1.0, 1.1, 4.0]));
        assert!(!agree(&[1.0, 2.0, 3.0], &[1.0, 2.0, 1.0]));
        let row = |values: [f64; 3], gain| Row {
            mesh: String::new(),
            quantities: [(); 4].map(|()| values.to_vec()),
            gain,
        };
        let verdict = |values, gain| judge(&[row([1.0, 2.0, 3.0], 0.0), row(values, gain)]).verdict;
        assert_eq!(verdict([2.0, 3.0, 4.0], 0.0), Verdict::Confirmed);
        assert_eq!(verdict([2.0, 3.0, 1.0], 0.0), Verdict::Refuted);
        assert_eq!(verdict([2.0, 3.0, 4.0], 0.1), Verdict::Refuted);
    }
}
