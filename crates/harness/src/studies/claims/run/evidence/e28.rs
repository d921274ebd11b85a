//! What is run for claim C28.

use super::meshes::Mesh;
use super::runs::{free_edge, track, true_motion};
use super::scenes::build;
use super::{Number, Trial};
use crate::claims::c28::{GAIN, QUANTITIES};
use crate::{HarnessError, reference_energy};

pub(super) const TRIAL: Trial = Trial {
    id: "C28",
    scenes: || {
        "sheets of about 196 particles that hang by two corners: grid, equilateral triangles, \
         Delaunay meshes of random points (seeds 1 and 2, mass by area, numbered as drawn); k/m = \
         1e4 to 1e7, d/m = 40 1/s, h = 0.01 s, 0.6 s"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const SIDE: u32 = 14;
const STEP: f64 = 0.01;
const STIFFNESSES: [f64; 4] = [1e4, 1e5, 1e6, 1e7];
const MESHES: [Mesh; 4] = [Mesh::Grid, Mesh::Triangles, Mesh::Random(1), Mesh::Random(2)];
/// Greatest stiffness over mass at which updated CG, in its safeguarded form, is run, 1/s².
const UPDATED_LIMIT: f64 = 1e5;

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
        let tight = run("imex-euler:norm=euclid,forcing_term=1e-10")?;
        row.gain = row.gain.max(tight.gain / reference_energy(&start, 0.6)?);
        let bare = run("imex-euler:norm=euclid,forcing_term=1e-3,preconditioner=none")?.per_step();
        let plain = run("imex-euler:norm=euclid,forcing_term=1e-3")?.per_step();
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

fn evidence() -> Result<Vec<Number>, HarnessError> {
    Ok(numbers(&MESHES.into_iter().map(row).collect::<Result<Vec<_>, _>>()?))
}

fn numbers(rows: &[Row]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for row in rows {
        for (name, series) in QUANTITIES.iter().zip(&row.quantities) {
            for (value, stiffness) in series.iter().zip(STIFFNESSES) {
                let what = format!("{name}, {}, k/m = {stiffness:e}", row.mesh);
                numbers.push(Number::new(what, *value, ""));
            }
        }
        let what = format!("gain of energy over what is set free, {}", row.mesh);
        numbers.push(Number::new(what, row.gain, "").against(GAIN));
    }
    numbers
}
