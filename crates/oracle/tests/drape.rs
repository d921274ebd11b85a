//! The drape test on three meshes, by rest positions.

#![allow(clippy::print_stderr, reason = "tables for people")]

use drape_model::fabric::{Disc, MaterialChoice};
use drape_model::{drape_coefficient, projected_area};
use drape_oracle::statics::rest;
use std::f64::consts::PI;

/// Drape coefficient of a material, from a start with this many waves.
fn drape(name: &str, cells: u32, waves: f64) -> (f64, f64, usize) {
    let disc = Disc {
        radius_m: 0.15,
        support_m: 0.09,
        cells,
        warp_deg: 0.0,
        material: MaterialChoice::named(name),
    };
    let scene = disc.scene().unwrap_or_else(|violation| panic!("{violation}"));
    let spec = scene.discretise().unwrap_or_else(|violation| panic!("{violation}"));
    let (system, mut state) = spec.build().expect("a valid disc");
    let specimen = projected_area(&state.x, &spec.triangles);
    for (x, _) in state.x.iter_mut().zip(system.pinned()).filter(|(_, pinned)| !**pinned) {
        let (radius, angle) = (x.x.hypot(x.y), x.y.atan2(x.x));
        let beyond = (radius - disc.support_m).max(0.0);
        x.z = -4.0 * beyond * beyond * (1.0 + 0.5 * (waves * angle).cos());
    }
    let outcome = rest(&system, &mut state.x, 1e-4, 1500);
    let shadow = projected_area(&state.x, &spec.triangles);
    let support = PI * disc.support_m * disc.support_m;
    (drape_coefficient(shadow, support, specimen), outcome.residual, outcome.iterations)
}

#[test]
fn denim_drapes_alike_on_three_meshes() {
    let found = [24, 32, 40].map(|cells| drape("denim", cells, 4.0));
    let mean = found.iter().map(|found| found.0).sum::<f64>() / 3.0;
    for (coefficient, residual, _) in found {
        assert!(residual < 1e-4, "{found:?}");
        assert!((coefficient - mean).abs() < 0.02, "{found:?}");
    }
    // The band of denim: 0.7 to 0.9.
    assert!((0.7..0.9).contains(&mean), "{found:?}");
}

#[test]
#[ignore = "prints a table"]
fn table() {
    for name in drape_model::fabric::Material::bundled() {
        for cells in [16, 24, 32, 40, 48] {
            eprintln!("{name} {cells}: {:?}", [2.0, 4.0].map(|waves| drape(name, cells, waves)));
        }
    }
}
