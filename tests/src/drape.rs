//! The drape test: a disc of cloth, hung over a smaller one until it rests.

use crate::{build, largest, prepared};
use drape_model::{AngularLaw, SceneFile, drape_coefficient, load, projected_area};
use std::f64::consts::PI;

/// Radius of the disc that holds the cloth, m.
const SUPPORT: f64 = 0.09;

/// How the cloth hangs at the end.
#[derive(Clone, Copy, Debug)]
pub struct Drape {
    /// Share of the overhang that the shadow covers.
    pub coefficient: f64,
    /// Greatest speed that is left, m/s.
    pub speed: f64,
}

/// Runs the bundled scene `drape-test` with this flexural rigidity (N m), method and step (s) for
/// so many seconds.
///
/// Between equilateral triangles hinges of stiffness `k` give a rigidity of `3 k`: a sheet of
/// curvature `κ` along any direction has the energy `½ (3 k) κ²` over its area.
///
/// # Panics
/// When the scene or the method is refused.
pub fn drape(rigidity: f64, method: &str, h: f64, seconds: f64) -> Drape {
    let Ok(SceneFile::Scene(mut scene, _)) = load("drape-test") else { panic!("a bundled scene") };
    scene.effects.bending_hinge = Some(AngularLaw { stiffness_n_m: rigidity / 3.0 });
    let spec = scene.discretise().unwrap_or_else(|violation| panic!("{violation}"));
    let (system, start) = build(&spec);
    let specimen = projected_area(&start.x, &spec.triangles);
    let mut run = prepared(method, (system, start), h);
    for _ in 0..(seconds / h).round() as u32 {
        run.step();
    }
    let shadow = projected_area(&run.state.x, &spec.triangles);
    Drape {
        coefficient: drape_coefficient(shadow, PI * SUPPORT * SUPPORT, specimen),
        speed: largest(&run.state.v),
    }
}
