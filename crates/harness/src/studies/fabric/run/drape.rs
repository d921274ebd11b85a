//! The drape test of the bundled materials.

use super::super::facts::{Band, Cloth, Drape};
use crate::HarnessError;
use drape_model::fabric::{Disc, Material, MaterialChoice};
use drape_model::{SystemSpec, drape_coefficient, projected_area};
use drape_oracle::statics::{is_minimum, rest};
use std::f64::consts::PI;

/// Radii of the cloth and of the table, m.
pub(super) const RADII: [f64; 2] = [0.15, 0.09];
/// Residual at which the search stops, and its largest number of iterations.
const TOLERANCE: f64 = 1e-5;
const MOST: usize = 600;
/// Phase of the waves of a start, rad. With it no start is symmetric about warp or weft.
const PHASE: f64 = 0.3;
/// Gravity, m/s².
const GRAVITY: f64 = 9.81;

/// Published bands of the drape coefficient by class.
const BANDS: [(&str, f64, f64); 5] = [
    ("silk", 0.20, 0.40),
    ("wool", 0.40, 0.70),
    ("leather", 0.47, 0.70),
    ("cotton", 0.60, 0.76),
    ("denim", 0.70, 0.90),
];
/// Class of each material that belongs to one.
const CLASSES: [(&str, &str); 2] = [("denim", "denim"), ("cotton-blend", "cotton")];

pub(super) fn bands() -> Vec<Band> {
    let band = |(class, least, greatest): (&str, f64, f64)| Band {
        class: class.to_owned(),
        least,
        greatest,
    };
    BANDS.into_iter().map(band).collect()
}

/// The properties of a material and its class.
pub(super) fn cloth(name: &str) -> Result<Cloth, HarnessError> {
    let material = Material::load(name)?;
    let bending_n_m = [material.bending_n_m.warp, material.bending_n_m.weft];
    let length = |b: f64| libm::cbrt(b / (material.areal_density_kg_m2 * GRAVITY));
    let class = CLASSES.iter().find(|(known, _)| *known == name);
    Ok(Cloth {
        name: name.to_owned(),
        areal_density_kg_m2: material.areal_density_kg_m2,
        bending_n_m,
        bending_length_m: bending_n_m.map(length),
        class: class.map(|(_, class)| (*class).to_owned()),
    })
}

/// The system of a drape test.
pub(super) fn system(name: &str, cells: u32) -> Result<SystemSpec, HarnessError> {
    let [radius_m, support_m] = RADII;
    let material = MaterialChoice::named(name);
    Ok(Disc { radius_m, support_m, cells, warp_deg: 0.0, material }.scene()?.discretise()?)
}

/// Lets a cloth with `waves` waves at its start drape over the table until it rests.
pub(super) fn drape(name: &str, cells: u32, waves: u32) -> Result<Drape, HarnessError> {
    let support = RADII[1];
    let spec = system(name, cells)?;
    let (system, mut state) = spec.build()?;
    let specimen = projected_area(&state.x, &spec.triangles);
    for (x, pinned) in state.x.iter_mut().zip(system.pinned()) {
        if !pinned {
            let (radius, angle) = (libm::hypot(x.x, x.y), libm::atan2(x.y, x.x));
            let beyond = (radius - support).max(0.0);
            let wave = 1.0 + 0.5 * libm::cos(f64::from(waves) * angle + PHASE);
            x.z = -4.0 * beyond * beyond * wave;
        }
    }
    let found = rest(&system, &mut state.x, TOLERANCE, MOST);
    let shadow = projected_area(&state.x, &spec.triangles);
    Ok(Drape {
        cloth: name.to_owned(),
        cells,
        waves,
        particles: state.len(),
        coefficient: drape_coefficient(shadow, PI * support * support, specimen),
        residual: found.residual,
        is_minimum: is_minimum(&system, &state.x),
        iterations: found.iterations,
        portable: true,
    })
}
