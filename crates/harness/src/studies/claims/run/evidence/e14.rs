//! What is run for claim C14.

use super::meshes::Mesh;
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::HarnessError;
use crate::studies::sheet::{MASS, Sheet};
use drape_integrator::LargestEigenvalue;
use drape_model::SystemSpec;

pub(super) const TRIAL: Trial = Trial {
    id: "C14",
    scenes: || {
        "sheets of 0.2 kg/m² at rest with springs of 100 N/m (shear: 10 N/m) on grids, grids with \
         shear springs and triangle meshes, N = 5 to 80 particles along an edge"
            .to_owned()
    },
    portable: true,
    is_quick: true,
    run: evidence,
    seconds: None,
};

const SIDES: [u32; 5] = [5, 10, 20, 40, 80];
/// Products of a power iteration: the estimate is off by less than a thousandth then.
const PRODUCTS: usize = 60;
/// Stiffness of a spring of the fabric, N/m, and the mass of 1 m² of it, kg.
const STIFFNESS: f64 = 100.0;
const AREA_MASS: f64 = 0.2;

/// Largest angular frequency at rest, 1/s.
fn frequency(spec: &SystemSpec) -> Result<f64, HarnessError> {
    let start = build(spec)?;
    let mut eigenvalue = LargestEigenvalue::new(&start.system);
    Ok(eigenvalue.estimate(&start.system, &start.state.x, PRODUCTS).sqrt())
}

/// The same fabric on any mesh: the mass of the area is shared out, and a spring keeps its
/// stiffness, since a wider mesh has longer springs that each stand for a wider strip.
fn fabric(mut spec: SystemSpec) -> SystemSpec {
    let all: f64 = spec.particles.mass_kg.iter().sum();
    spec.particles.mass_kg.iter_mut().for_each(|m| *m *= AREA_MASS / all);
    for spring in &mut spec.springs {
        spring.stiffness_n_per_m *= STIFFNESS / MASS;
    }
    spec
}

/// A family of meshes over the number of particles along an edge; stiffness over mass of 1/s².
type Family = fn(u32) -> Result<SystemSpec, HarnessError>;

const FAMILIES: [(&str, Family); 3] = [
    ("grid", |side| hanging(side, 1.0, 0.0).spec()),
    ("grid with shear", |side| Sheet { shear: 0.1, ..hanging(side, 1.0, 0.0) }.spec()),
    ("triangles", |side| Mesh::Triangles.hanging(side, 1.0, 0.0)),
];

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for (name, family) in FAMILIES {
        let frequencies: Vec<_> = SIDES
            .iter()
            .map(|&side| frequency(&fabric(family(side)?)))
            .collect::<Result<_, HarnessError>>()?;
        for (side, frequency) in SIDES.iter().zip(&frequencies) {
            let what = format!("largest frequency, {name}, N = {side}");
            numbers.push(Number::new(what, *frequency, "1/s"));
        }
    }
    // The paper's tables keep k/m instead.
    let quotient: Vec<_> = SIDES
        .iter()
        .map(|&side| frequency(&hanging(side, 1e4, 0.0).spec()?))
        .collect::<Result<_, HarnessError>>()?;
    let spread = quotient[quotient.len() - 1] / quotient[0];
    numbers.push(Number::new("the same, N = 80 over N = 5, at fixed k/m, grid", spread, ""));
    Ok(numbers)
}
