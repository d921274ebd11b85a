//! The bundled meshes come from their generator, and drape reads them as an independent reader
//! does.

#![allow(clippy::unwrap_used, reason = "tests")]

#[path = "../examples/meshes.rs"]
mod meshes;

use drape_model::{bundled, parse};

#[test]
fn the_bundled_meshes_are_those_of_the_generator() {
    let made = meshes::all();
    assert_eq!(made.len(), bundled::meshes().count());
    for (name, text) in made {
        assert!(bundled::mesh(name) == Some(&text), "{name}: run the example `meshes`");
    }
}

#[test]
fn vertices_and_triangles_are_those_that_tobj_reads() {
    for name in bundled::meshes() {
        let scene = format!(
            r#"{{ "format": "drape-scene/1", "name": "x",
                "cloth": {{ "mesh": {{ "file": "bundled:{name}", "areal_density_kg_m2": 1 }} }},
                "time": {{ "step_s": 0.1, "duration_s": 1 }} }}"#
        );
        let spec = parse("x", &scene).unwrap().spec().clone();
        let mut text = bundled::mesh(name).unwrap().as_bytes();
        let options = tobj::LoadOptions::default();
        let (models, _) =
            tobj::load_obj_buf(&mut text, &options, |_| Ok(Default::default())).unwrap();
        // tobj numbers the vertices of each group anew, so the test compares the places of corners.
        let flat: Vec<f64> = spec.particles.position_m.iter().flatten().copied().collect();
        let mut own = spec.triangles.as_slice();
        for model in &models {
            let mesh = &model.mesh;
            let arities = match mesh.face_arities.as_slice() {
                [] => vec![3; mesh.indices.len() / 3],
                arities => arities.iter().map(|&n| n as usize).collect(),
            };
            let mut indices = mesh.indices.as_slice();
            for n in arities {
                let (corners, triangles);
                (corners, indices) = indices.split_at(n);
                (triangles, own) = own.split_at(n - 2);
                let triangles = triangles.as_flattened();
                assert_eq!(places(&flat, triangles), places(&mesh.positions, corners), "{name}");
            }
        }
        assert!(own.is_empty(), "{name}");
    }
}

/// Where some corners are, each place once.
fn places(x: &[f64], corners: &[u32]) -> Vec<[f64; 3]> {
    let place = |&i: &u32| [0, 1, 2].map(|k| x[3 * i as usize + k]);
    let mut places: Vec<_> = corners.iter().map(place).collect();
    places.sort_by(|a, b| a.partial_cmp(b).unwrap());
    places.dedup();
    places
}
