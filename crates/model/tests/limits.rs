//! Scenes whose text is short and whose demands are not: refused, or held in little memory.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{SceneError, SpringEffect, Violation, parse};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A square sheet of so many rows and columns.
fn sheet(side: u32) -> Value {
    json!({
        "format": "drape-scene/1", "name": "sheet",
        "cloth": { "grid": {
            "rows": side, "columns": side, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 1
        } },
        "time": { "step_s": 0.1, "duration_s": 1 }
    })
}

fn refused(scene: &Value) -> Violation {
    match parse("file.json", &scene.to_string()).unwrap_err() {
        SceneError::Invalid { violation, .. } => violation,
        other => panic!("{other}"),
    }
}

fn balls(count: usize) -> Value {
    vec![json!({ "sphere": { "center_m": [0, 0, -1], "radius_m": 0.5 } }); count].into()
}

#[test]
fn more_obstacles_than_memory_for_their_contacts_are_refused() {
    for (side, most) in [(2, 1024), (1000, 16)] {
        let mut scene = sheet(side);
        scene["obstacles"] = balls(most);
        assert!(parse("file.json", &scene.to_string()).is_ok());
        scene["obstacles"] = balls(most + 1);
        let Violation { path, value, expected } = refused(&scene);
        assert_eq!(path, "obstacles");
        assert!(value.contains(&format!("length {}, for {}", most + 1, side * side)), "{value}");
        assert!(expected.contains(&format!("at most {most}")), "{expected}");
    }
}

#[test]
fn a_particle_in_very_many_selections_is_refused() {
    let mut scene = sheet(1000);
    scene["pins"] = vec![json!({ "within_m": [[-1, -1, -1], [1, 1, 1]] }); 9].into();
    let Violation { path, value, expected } = refused(&scene);
    assert_eq!(path, "pins[8]");
    assert!(value.contains("1000000 particles after 8000000"), "{value}");
    assert!(expected.contains("at most 8000000"), "{expected}");
}

#[test]
fn a_path_for_many_particles_does_not_fill_the_memory() {
    let mut scene = sheet(1000);
    let frames: Vec<_> =
        (1..=2000).map(|k| json!({ "time_s": k, "offset_m": [0, 0, k] })).collect();
    scene["pins"] = json!([{ "column": 0, "path": frames }]);
    let Violation { path, value, expected } = refused(&scene);
    assert_eq!(path, "pins[0].path");
    assert!(value.contains("2000 keyframes for 1000"), "{value}");
    assert!(expected.contains("at most 1000000 keyframes"), "{expected}");
}

#[test]
fn springs_of_one_law_share_their_pieces() {
    let mut scene = sheet(20);
    let pieces = |stiffness: f64| -> Value {
        let mut list: Vec<_> = (1..64)
            .map(|k| json!({ "up_to_strain": 0.01 * f64::from(k), "stiffness_n_per_m": stiffness }))
            .collect();
        list.push(json!({ "stiffness_n_per_m": stiffness }));
        json!({ "pieces": list })
    };
    scene["effects"] = json!({
        "tension": { "warp": pieces(1.0), "weft": pieces(2.0) }, "shear": pieces(3.0)
    });
    let input = parse("file.json", &scene.to_string()).unwrap();
    for (effect, expected) in [(SpringEffect::Tension, 2), (SpringEffect::Shear, 1)] {
        let springs = input.spec().springs.iter().filter(|spring| spring.effect == effect);
        let lists: BTreeSet<_> = springs.map(|spring| Arc::as_ptr(&spring.pieces).addr()).collect();
        assert_eq!(lists.len(), expected, "{}", effect.name());
    }
}
