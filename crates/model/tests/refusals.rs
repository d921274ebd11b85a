//! Every broken scene is refused with one line that names the file, the key, the value found and
//! what was expected.
//!
//! A row of a table edits a valid file and says what the message must name:
//!
//! | row | edit |
//! |---|---|
//! | `key = text → expected` | the value becomes this text, which the message finds at this key |
//! | `key gone → expected` | the key is left out, which the message calls missing |
//! | `key renamed other → expected` | the key gets another name, which the message does not know |
//!
//! `| found text` and `| at key` follow where the message names another value or key. The published
//! schemas must refuse keys and types too, and other values where `| schema` follows.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{Scene, SceneError, SystemSpec, load, parse};
use serde_json::Value;

const SCENE: &str = r#"{
  "format": "drape-scene/1", "name": "grid", "description": "d", "assumed": ["pins"],
  "cloth": { "grid": { "rows": 3, "columns": 4, "size_m": [1, 2], "center_m": [0, 0, 0.5],
    "mass_kg": 0.4 } },
  "effects": {
    "tension": { "stiffness_over_mass_per_s2": 1e4, "damping_over_mass_per_s": 40 },
    "shear": { "stiffness_n_per_m": 5 },
    "shear_angle": { "stiffness_n_m": 1 }, "bending_angle": { "stiffness_n_m": 1 },
    "bending_hinge": { "stiffness_n_m": 1 },
    "gravity": { "m_s2": [0, 0, -9.81] },
    "air": { "drag": { "quadratic": { "coefficient": 1.1 } }, "wind": { "velocity_m_s": [1, 2, 3],
      "gust": { "amplitude_m_s": [0, 1, 0], "period_s": 2 } } },
    "contact": { "detection": "penetration", "recovery_speed_limit_m_s": 2 }
  },
  "damping": "full",
  "pins": [{ "row": 0, "column": 0 }, { "particle": 11, "path": PATH }],
  "obstacles": OBSTACLES,
  "time": { "step_s": 0.01, "duration_s": 1 }
}"#;

const SYSTEM: &str = r#"{
  "format": "drape-system/1", "name": "chain",
  "particles": {
    "mass_kg": [1, 1, 1, 0.5],
    "position_m": [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]],
    "velocity_m_s": [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 1]]
  },
  "springs": [
    { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1, "stiffness_n_per_m": 10,
      "damping_n_s_per_m": 0.1 },
    { "effect": "bending", "i": 1, "j": 3, "rest_length_m": 2, "stiffness_n_per_m": 20 }
  ],
  "angles": [{ "effect": "bending_angle", "i": 0, "j": 1, "k": 2, "rest_rad": 3, "stiffness_n_m": 1 }],
  "hinges": [{ "i": 1, "j": 2, "k": 0, "l": 3, "rest_rad": -3, "stiffness_n_m": 1 }],
  "damping": "projected", "triangles": [[0, 1, 2]],
  "pins": [{ "particle": 0 }, { "particle": 3, "path": PATH }],
  "effects": { "gravity": { "m_s2": [0, 0, -9.81] } },
  "obstacles": OBSTACLES
}"#;

const PATH: &str =
    r#"[{ "time_s": 0.5, "offset_m": [0, 0, 1] }, { "time_s": 1.5, "offset_m": [0, 0, 3] }]"#;

const OBSTACLES: &str = r#"[
    { "plane": { "point_m": [0, 0, 0], "normal": [0, 0, 1], "restitution": 0.5, "friction": 0.5 } },
    { "box": { "center_m": [0, 0, 0], "size_m": [1, 1, 1] } },
    { "sphere": { "center_m": [0, 0, 0], "radius_m": 0.25 } },
    { "mesh": { "vertices_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "triangles": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        "path": [{ "time_s": 2, "offset_m": [0, 0, 7] }] } }
  ]"#;

/// Explicit particles that bend, at rest in a tent.
const TENT: &str = r#"{
  "format": "drape-scene/1", "name": "tent",
  "cloth": { "particles": {
    "particles": { "mass_kg": [1, 1, 1, 1],
      "position_m": [[0, 0, 0], [0, 2, 0], [-1, 1, -1], [1, 1, -1]] },
    "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1, "stiffness_n_per_m": 9 }],
    "triangles": [[0, 1, 2], [1, 0, 3]] } },
  "effects": { "bending_hinge": { "stiffness_n_m": 0.5 } }, "pins": [{ "particle": 0 }],
  "time": { "step_s": 0.1, "duration_s": 1 }
}"#;

/// Tension by pieces, warp and weft apart, bending springs that buckle.
const PIECES: &str = r#"{
  "format": "drape-scene/1", "name": "pieces",
  "cloth": { "grid": { "rows": 3, "columns": 3, "size_m": [1, 1], "center_m": [0, 0, 0],
    "mass_kg": 0.4 } },
  "effects": {
    "tension": { "damping_over_mass_per_s": 4,
      "warp": { "pieces": [{ "up_to_strain": 0.02, "stiffness_n_per_m": 10 },
        { "stiffness_n_per_m": 1000 }] },
      "weft": { "stiffness_n_per_m": 70, "compression_stiffness_n_per_m": 3 } },
    "shear": { "pieces": [{ "up_to_strain": 0.1, "stiffness_n_per_m": 5 },
      { "stiffness_n_per_m": 50 }] },
    "bending": { "stiffness_n_per_m": 8, "buckling_rigidity_n_m2": 1e-4 }
  },
  "time": { "step_s": 0.01, "duration_s": 1 }
}"#;

fn text(base: &str) -> String {
    base.replace("OBSTACLES", OBSTACLES).replace("PATH", PATH)
}

/// Parses, and checks the form that every message has.
fn refused(text: &str) -> (SceneError, String) {
    let error = parse("dir/file.json", text).unwrap_err();
    let message = error.to_string();
    assert!(message.starts_with("dir/file.json: "), "{message}");
    assert!(!message.contains(['\n', '\r', '\0']), "{message}");
    assert!(message.chars().count() < 420, "{message}");
    assert!(message.contains("expected"), "{message}");
    (error, message)
}

/// Stands for a text that need not be JSON.
const MARK: &str = "edited here";

/// The object or list around a value, and the value's key in it; the key as messages write it.
fn parent<'v>(base: &'v mut Value, key: &'v str) -> (&'v mut Value, &'v str) {
    let (outer, last) = match (key.rfind('.'), key.rfind('[')) {
        (dot, Some(bracket)) if dot.is_none_or(|dot| dot < bracket) => {
            (&key[..bracket], key[bracket + 1..].trim_end_matches(']'))
        }
        (Some(dot), _) => (&key[..dot], &key[dot + 1..]),
        _ => ("", key),
    };
    let pointer = outer.replace(['.', '['], "/").replace(']', "");
    let pointer = if outer.is_empty() { pointer } else { format!("/{pointer}") };
    (base.pointer_mut(&pointer).unwrap_or_else(|| panic!("no {outer}")), last)
}

/// The edited text; key and value that the message names unless the row says otherwise.
fn edited(base: &str, edit: &str) -> (String, String, String) {
    let mut value: Value = serde_json::from_str(base).unwrap();
    let mark = Value::String(MARK.to_owned());
    if let Some((key, text)) = edit.split_once(" = ") {
        match parent(&mut value, key) {
            (Value::Array(list), place) => list[place.parse::<usize>().unwrap()] = mark,
            (object, key) => object[key] = mark,
        }
        let edited = value.to_string().replace(&format!("\"{MARK}\""), text);
        return (edited, key.to_owned(), text.to_owned());
    }
    let (key, new) = edit.split_once(" renamed ").unwrap_or_else(|| {
        (edit.strip_suffix(" gone").unwrap_or_else(|| panic!("no edit: {edit}")), "")
    });
    let (object, last) = parent(&mut value, key);
    let object = object.as_object_mut().unwrap();
    let moved = object.remove(last).unwrap_or_else(|| panic!("no {key}"));
    if new.is_empty() {
        return (value.to_string(), key.to_owned(), "missing".to_owned());
    }
    object.insert(new.to_owned(), moved);
    let at = format!("{}{new}", &key[..key.len() - last.len()]);
    (value.to_string(), at, "unknown".to_owned())
}

/// Checks each row of a table against a valid file.
fn check(base: &str, rows: &str) {
    let base = &text(base);
    parse("base", base).unwrap();
    let schema = if base.contains("drape-scene/1") {
        schemars::schema_for!(Scene)
    } else {
        schemars::schema_for!(SystemSpec)
    };
    let schema = jsonschema::validator_for(schema.as_value()).unwrap();
    assert!(schema.is_valid(&serde_json::from_str(base).unwrap()));
    for row in rows.lines().map(str::trim).filter(|row| !row.is_empty()) {
        let (edit, rest) = row.split_once('→').unwrap_or_else(|| panic!("no arrow: {row}"));
        let mut parts = rest.split(" | ");
        let expected = parts.next().unwrap().trim();
        let (text, mut at, mut found) = edited(base, edit.trim());
        let mut in_schema = false;
        for part in parts.map(str::trim) {
            match part.split_once(' ').unwrap_or((part, "")) {
                ("at", key) => at = key.to_owned(),
                ("found", value) => found = value.to_owned(),
                ("schema", "") => in_schema = true,
                _ => panic!("none of `at`, `found` and `schema`: {row}"),
            }
        }
        let (error, message) = refused(&text);
        let violation = match error {
            SceneError::Invalid { violation, .. } => violation,
            SceneError::Shape { violation, line, .. } => {
                assert!(message.ends_with(')') && line > 0, "{message}");
                // A doubled key is no matter of schemas.
                in_schema = found != "twice";
                violation
            }
            other => panic!("{row}: {other}"),
        };
        // Numbers that no float64 holds are no values.
        if let (true, Ok(value)) = (in_schema, serde_json::from_str(&text)) {
            assert!(!schema.is_valid(&value), "the schema takes {row}");
        }
        assert_eq!(violation.path, at, "{row}: {message}");
        assert!(violation.value.contains(&found), "{row}: {message}");
        for phrase in expected.split(" & ") {
            assert!(violation.expected.contains(phrase), "{phrase}: {message}");
        }
    }
}

#[test]
fn scenes_with_unknown_missing_or_doubled_keys_are_refused() {
    check(
        SCENE,
        r#"
        name renamed nmae                              → `name`
        cloth renamed cloths                           → `cloth`
        cloth.grid renamed gird                        → `particles`
        cloth.grid.row = 3                             → `columns` | found unknown
        effects.gravity renamed wind                   → `gravity`
        effects.gravity.m_s2 renamed m_s               → `m_s2`
        effects.shear.stiffness_n_per_m renamed k      → `stiffness_n_per_m`
        effects.shear_angle.k = 1                      → `stiffness_n_m` | found unknown
        effects.bending_angle.k = 1                    → `stiffness_n_m` | found unknown
        effects.bending_hinge.k = 1                    → `stiffness_n_m` | found unknown
        effects.contact.detection renamed detect       → `detection`
        pins[0].row renamed rwo                        → `row`
        obstacles[2].sphere renamed ball               → `sphere`
        obstacles[2].sphere.radius_m renamed radius    → `radius_m`
        time.step_s renamed dt                         → `step_s`
        format gone                                    → "drape-scene/1"
        cloth.grid.mass_kg gone                        → this key
        obstacles[0].plane.normal gone                 → this key
        time gone                                      → this key
        time.duration_s gone                           → this key
        format = "drape-scene/1", "format": "drape-scene/1" → once | found twice
        damping = "full", "damping": "full"            → once | found twice
        cloth.grid.rows = 3, "rows": 4                 → once | found twice
        "#,
    );
}

#[test]
fn scenes_with_values_of_the_wrong_type_are_refused() {
    let long = text(SCENE).replace("drape-scene/1", &"x".repeat(3_000_000));
    assert!(refused(&long).1.contains("xx…xx"));
    check(
        SCENE,
        r#"
        format = "drape-scene/2"                       → drape-scene/1 | schema
        format = 17                                    → drape-scene/1
        format = { "a": null }                         → drape-scene/1
        name = 3                                       → a string
        assumed = "pins"                               → a list
        assumed[0] = 3                                 → a string
        cloth = 5                                      → `grid`
        cloth = "grid"                                 → an object
        cloth = {}                                     → `grid`, `mesh`, `particles`
        cloth = { "grid": {"rows": 1, "columns": 1, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 1}, "particles": {} } → one of the keys | found {
        cloth.grid.rows = "three"                      → a whole number
        cloth.grid.rows = -3                           → a whole number from 0
        cloth.grid.columns = -1                        → a whole number from 0
        cloth.grid.rows = 3.5                          → a whole number
        cloth.grid.rows = 4294967296                   → 4294967295
        cloth.grid.rows = null                         → a whole number
        cloth.grid.mass_kg = "0.4"                     → a number
        cloth.grid.mass_kg = true                      → a number
        cloth.grid.mass_kg = 1e999                     → 1.8e308
        cloth.grid.mass_kg = -1e999                    → 1.8e308
        cloth.grid.size_m = [1, 2, 3]                  → length 2
        cloth.grid.size_m = [1]                        → length 2
        cloth.grid.size_m = 1                          → length 2
        effects.gravity = [[0, 0, -9.81]]              → an object
        effects.shear = 5                              → an object
        effects.tension.damping_over_mass_per_s = "1"  → a number
        effects.shear_angle.stiffness_n_m = "stiff"    → number
        effects.bending_angle.stiffness_n_m = "stiff"  → number
        effects.bending_hinge.stiffness_n_m = "stiff"  → number
        effects.air.drag = "quadratic"                 → an object with one of the keys `quadratic`, `linear`
        effects.air.drag = { "cubic": {} }             → `quadratic` or `linear` | at effects.air.drag.cubic | found unknown
        effects.air.wind.velocity_m_s = [0, 1]         → length 3
        effects.air.wind.gust.seed = -1                → a whole number from 0
        effects.contact.detection = []                 → `speculative`
        damping = "half"                               → `projected`
        damping = 1                                    → `full`
        damping = null                                 → `full`
        pins[1] = 11                                   → an object
        obstacles[2].sphere = [[0, 0, 0], 1, 0]        → an object
        time = [0.01, 1]                               → an object
        "#,
    );
}

#[test]
fn scenes_with_values_out_of_range_are_refused() {
    check(
        SCENE,
        r#"
        cloth.grid.rows = 0                            → at least 1
        cloth.grid.rows = 4000000000                   → at most 4000000 particles | at cloth.grid | found 4000000000 × 4
        cloth.grid.size_m[1] = 0                       → above 0
        cloth.grid.size_m = [9e8, 9e8]                 → within 1e9 m
        cloth.grid.mass_kg = 0                         → above 0
        cloth.grid.mass_kg = 1e-162                    → every particle to have a mass of 1e-30 | found 1e-162
        cloth.grid.center_m[1] = 2e9                   → from -1e9 to 1e9

        effects.tension = {}                           → one of `stiffness_n_per_m` and & `pieces` with at least one piece, or `warp` and `weft` | found without a stiffness
        effects.tension.stiffness_n_per_m = 1          → exactly one | at effects.tension | found given twice
        effects.tension.damping_n_s_per_m = 1          → at most one | at effects.tension | found given twice
        effects.tension.stiffness_over_mass_per_s2 = -1 → from 0 to 1e30
        effects.tension.damping_over_mass_per_s = -40  → from 0
        effects.shear.stiffness_n_per_m = 1e300        → from 0 to 1e30
        effects.shear_angle.stiffness_n_m = -1         → from 0 to 1e30
        effects.bending_angle.stiffness_n_m = -1       → from 0 to 1e30
        effects.bending_hinge.stiffness_n_m = -1       → from 0 to 1e30
        effects.gravity.m_s2[2] = -1e10                → from -1e9
        effects.air.drag.quadratic.coefficient = -0.1  → from 0
        effects.air.drag.quadratic.density_kg_m3 = 1e10 → 1e9
        effects.air.drag = { "linear": { "coefficient_n_s_per_m3": -2 } } → from 0 | at effects.air.drag.linear.coefficient_n_s_per_m3 | found -2
        effects.air.wind.velocity_m_s[1] = 1e10        → from -1e9
        effects.air.wind.gust.period_s = 0             → from
        effects.air.wind.gust.amplitude_m_s[2] = -1e10 → from -1e9
        effects.contact.recovery_speed_limit_m_s = -2  → from 0

        pins[1].particle = 12                          → 0 to 11
        pins[1] = {}                                   → exactly one of `particle`
        pins[1] = { "particle": 1, "row": 1, "column": 1 } → exactly one of `particle` | found "row":1
        pins[0] = { "name": "hem" }                    → a mesh's file | found "name":"hem"
        pins[0] = { "near_m": [0, 1e10, 0] }           → 1e9 | at pins[0].near_m[1] | found 1e10
        pins[0] = { "within_m": [[0, 1, 0], [0, 0, 0]] } → from 1 | at pins[0].within_m[1][1] | found 0
        pins[0] = { "within_m": [[0, 0, 7], [1, 1, 8]] } → at least one | at pins[0].within_m | found without a particle
        pins[0] = { "boundary": 1 }                    → 0 to 0 | at pins[0].boundary | found 1
        pins[0].row = 3                                → 0 to 2
        pins[0].column = 4                             → 0 to 3
        pins[0] = { "particle": 11 }                   → once where a pin has a path | at pins[1] | found particle 11

        obstacles[0].plane.restitution = 1.5           → from 0 to 1
        obstacles[0].plane.normal = [0, 0, 0]          → longer than | found [0
        obstacles[1].box.size_m[1] = 0                 → above 0
        obstacles[2].sphere.radius_m = 0               → above 0

        time.step_s = 0                                → above 0
        time.step_s = -0.01                            → above 0
        time.step_s = 1e-12                            → at least 1e-9
        time.duration_s = 0                            → above 0
        time.duration_s = 1e300                        → at most 1e9
        "#,
    );
    // A quotient times the mass must be in range too.
    check(
        &SCENE.replace(r#""mass_kg": 0.4"#, r#""mass_kg": 1e25"#),
        "effects.tension.stiffness_over_mass_per_s2 = 1e7 → from 0 to 1199999.99",
    );
}

#[test]
fn paths_friction_and_meshes_that_make_no_sense_are_refused() {
    for base in [SCENE, SYSTEM] {
        check(
            base,
            r#"
            pins[1].path[0].time_s = -0.5              → from 0
            pins[1].path[0].time_s = 1.5               → after 1.5 | at pins[1].path[1].time_s
            pins[1].path[0].time_s = 9                 → after 9 | at pins[1].path[1].time_s | found 1.5
            pins[1].path[1].time_s = 1e10              → 1e9
            pins[1].path[1].time_s renamed time        → `time_s`
            pins[1].path[1].time_s gone                → this key
            pins[1].path[0].time_s = 0                 → at time 0 | at pins[1].path[0].offset_m | found 1
            pins[1].path[1].offset_m[2] = 1e300        → 1e9
            pins[1].path[1].offset_m = [0, 3]          → length 3
            obstacles[3].mesh.path[0].time_s = -2      → from 0
            obstacles[3].mesh.path[0].offset_m[2] = null → number

            obstacles[0].plane.friction = -0.5         → from 0 to 100
            obstacles[0].plane.friction = 101          → from 0 to 100
            obstacles[0].plane.friction = "rough"      → a number
            obstacles[3].mesh.triangles[3][2] = 4      → below 4
            obstacles[3].mesh.triangles[3] = [1, 2, 2] → an area
            obstacles[3].mesh.triangles[3] = [1, 3, 2] → closed
            obstacles[3].mesh.triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2]] → 4 to | found length 3 | schema
            obstacles[3].mesh.triangles[0] = [0, 1]    → length 3
            obstacles[3].mesh.triangles[0][0] = -1     → a whole number
            obstacles[3].mesh.vertices_m[0] = [0, 1]   → length 3
            obstacles[3].mesh.path[0].ease = 1         → `time_s` | found unknown
            pins[1].path = 1                           → a list
            obstacles[3].mesh.vertices_m = [[0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1]] → counter-clockwise | at obstacles[3].mesh.triangles[0] | found volume
            obstacles[3].mesh.vertices_m[2][1] = 1e99  → 1e9
            "#,
        );
    }
}

#[test]
fn frozen_systems_that_contradict_themselves_are_refused() {
    check(
        SYSTEM,
        r#"
        format = "drape-system/0"                      → drape-system/1 | schema
        particles renamed partikel                     → `particles`
        particles.mass_kg renamed mass                 → `mass_kg`
        particles.mass_kg[3] = -0.5                    → from 1e-30 to 1e30
        particles.mass_kg[3] = 0                       → from 1e-30
        particles.mass_kg[3] = 1e-162                  → from 1e-30 | found 1e-162 | schema
        particles.mass_kg[3] = 1e999                   → 1.8e308
        particles.mass_kg[3] = "x"                     → a number
        particles.mass_kg[3] = null                    → a number
        particles.mass_kg = []                         → 1 to 4000000 | found length 0
        particles.mass_kg = [1, 1, 1]                  → length 3 | at particles.position_m | found length 4
        particles.velocity_m_s = [[0, 0, 0]]           → length 4 | found length 1
        particles.position_m[3] = [3, 0]               → length 3
        particles.position_m[3][2] = -1e300            → from -1e9

        springs = {}                                   → a list
        springs[0].effect = "magic"                    → `shear`
        springs[0].effect = 2                          → `shear`
        springs[0].i = 4                               → 0 to 3
        springs[0].i = -1                              → a whole number from 0
        springs[0].i = 0.5                             → a whole number
        springs[1].j = 1                               → another particle
        springs[1].rest_length_m = -2                  → from 0
        springs[1].stiffness_n_per_m = -20             → from 0
        springs[0].damping_n_s_per_m = -0.1            → from 0
        springs[0].pieces = [{ "stiffness_n_per_m": 11 }] → 11, the stiffness of the first piece | at springs[0].stiffness_n_per_m | found 10
        springs[0].buckling_rigidity_n_m2 = 1          → bending springs only | found tension
        springs[1].compression_stiffness_n_per_m = -1  → from 0
        springs[1].rest_length_m = 0, "compression_stiffness_n_per_m": 1 → above 0 | found 0
        springs[1].rest_length_m = 1e-300, "buckling_rigidity_n_m2": 1 → at most 1e30 | at springs[1].buckling_rigidity_n_m2 | found 1

        angles[0].effect = "twist"                     → shear_angle
        angles[0].k = 4                                → from 0 to 3
        angles[0].k = 0                                → another particle than `i`
        angles[0].rest_rad = -0.1                      → from 0 to 3.14
        angles[0].stiffness_n_m = 2e30                 → from 0
        hinges[0].l = 9                                → from 0 to 3
        hinges[0].l = 2                                → another particle than `j`
        hinges[0].rest_rad = 3.2                       → from -3.14
        hinges[0].stiffness_n_m = -1                   → from 0

        triangles[0][2] = 4                            → 0 to 3
        triangles[0] = [0, 1]                          → length 3
        pins[0].particle = 9                           → 0 to 3
        pins[0].particle renamed row                   → `particle`
        pins[0].particle = 3                           → once where a pin has a path | at pins[1].particle
        effects.gravity renamed tension                → `gravity`
        "#,
    );
}

#[test]
fn explicit_cloth_is_refused_with_the_paths_of_the_scene() {
    check(
        TENT,
        r#"
        effects.tension = { "stiffness_n_per_m": 3 }   → no such key | found beside explicit springs
        effects.shear_angle = { "stiffness_n_m": 1 }   → a grid | found without rows
        effects.bending_angle = { "stiffness_n_m": 1 } → a grid | found without rows
        cloth.particles.particles.mass_kg[1] = 0       → from 1e-30
        cloth.particles.particles.mass_kg gone         → this key
        cloth.particles.particles.position_m = []      → length 4 | found length 0
        cloth.particles.particles.position_m[2] = [0, 1, 0] → an area | at effects.bending_hinge | found 0 to 1
        cloth.particles.particles gone                 → this key
        cloth.particles.springs[0].j = 4               → 0 to 3
        pins[0] = { "row": 0, "column": 0 }            → of a grid cloth | found "row":0
        "#,
    );
    check(
        &TENT.replace("[[0, 1, 2], [1, 0, 3]]", "[]"),
        r#"effects.air = { "drag": { "linear": { "coefficient_n_s_per_m3": 1 } } } → triangles | found without triangles"#,
    );
}

#[test]
fn curves_that_make_no_sense_are_refused() {
    check(
        PIECES,
        r#"
        effects.tension.warp.pieces[0].up_to_strain gone  → only the last
        effects.tension.warp.pieces[1].up_to_strain = 1   → no such key
        effects.tension.warp.pieces[0].up_to_strain = 0   → a number above 0
        effects.tension.warp.pieces[1] = { "up_to_strain": 0.01, "stiffness_n_per_m": 1 }, { "stiffness_n_per_m": 1 } → above 0.02 | at effects.tension.warp.pieces[1].up_to_strain | found 0.01
        effects.tension.warp.pieces[1].stiffness_n_per_m = -1 → from 0
        effects.tension.warp.pieces[0].up_to_strain renamed strain → `up_to_strain`
        effects.tension.weft.stiffness_n_per_m gone       → `pieces` | at effects.tension.weft | found without a stiffness
        effects.tension.weft.compression_stiffness_n_per_m = 2e30 → from 0
        effects.tension.weft.pieces = [{ "stiffness_n_per_m": 1 }] → exactly one | at effects.tension.weft | found given twice
        effects.tension.weft gone                         → `warp`
        effects.tension.stiffness_n_per_m = 3             → one of | found beside `warp`
        effects.tension.compression_stiffness_n_per_m = 3 → in `warp` | found beside `warp`
        effects.tension.pieces = [{ "stiffness_n_per_m": 1 }] → in `warp` | found beside `warp`
        effects.shear.stiffness_over_mass_per_s2 = 2      → one of | found beside `pieces`
        effects.shear = { "warp": { "stiffness_n_per_m": 50 }, "weft": { "stiffness_n_per_m": 50 } } → one law | at effects.shear.warp | found diagonals
        effects.shear.buckling_rigidity_n_m2 = 1          → bending springs only | found shear
        effects.bending.buckling_rigidity_n_m2 = 0        → above 0
        effects.bending.buckling_rigidity_n_m2 = 1e29     → at most 1e30 | at springs[20].buckling_rigidity_n_m2
        effects.bending.warp = { "stiffness_n_per_m": 1 } → `warp` | at effects.bending.weft | found missing
        "#,
    );
    let pieces: Vec<_> =
        (1..66).map(|k| format!(r#"{{ "up_to_strain": {k}, "stiffness_n_per_m": 1 }}"#)).collect();
    let many = format!("[{}, {{ \"stiffness_n_per_m\": 50 }}]", pieces.join(", "));
    check(PIECES, &format!("effects.shear.pieces = {many} → at most 64 | found of length 66"));
}

#[test]
fn a_fabric_where_it_says_nothing_is_refused() {
    let scene = SCENE.replace(r#""stiffness_over_mass_per_s2": 1e4"#, r#""fabric": "wool""#);
    check(
        &scene,
        r#"
        effects.tension.fabric = "silk"                → `wool`
        effects.tension.fabric = 3                     → `wool`
        effects.tension.stiffness_n_per_m = 3          → one of | at effects.tension.fabric | found beside `stiffness_n_per_m`
        effects.tension.pieces = [{ "stiffness_n_per_m": 3 }] → one of | at effects.tension.fabric | found beside `pieces`
        effects.tension.warp = { "stiffness_n_per_m": 3 } → one of | at effects.tension.fabric | found beside `warp`
        effects.shear = { "fabric": "wool" }           → tension springs only | at effects.shear.fabric | found shear
        cloth.grid.rows = 1                            → at least 2 rows | at effects.tension.fabric | found single row
        cloth = { "mesh": { "file": "bundled:sheet.obj", "areal_density_kg_m2": 0.15 } } → warp and weft | at effects.tension.fabric | found a mesh
        "#,
    );
}

#[test]
fn what_is_no_json_is_refused_with_the_place() {
    let [scene, system] = [SCENE, SYSTEM].map(text);
    let nan = system.replace("0.5]", "NaN]");
    let infinity = system.replace("0.5]", "-Infinity]");
    let cut = scene.split("tration").next().unwrap();
    let long_line = format!("{{ \"name\": \"{}\", ? }}", "ü".repeat(100_000));
    let cases: [(&str, &str, &str); 13] = [
        ("", ".", "an empty file"),
        (" \n\t \n", ".", "an empty file"),
        ("cloth: grid", ".", "`cloth"),
        ("\u{feff}{}", ".", "\\u{feff}{}"),
        ("{", ".", "`{`"),
        ("\u{0}\u{1}PNG", ".", "\\u{0}\\u{1}PNG"),
        (&nan, "particles.mass_kg[3]", "NaN"),
        (&infinity, "particles.mass_kg[3]", "-Infinity"),
        (cut, "effects.contact.detection", "detection"),
        ("{ \"name\": \"a", "name", "\"a"),
        ("{ \"name\": 'a' }", "name", "'a'"),
        ("{ \"a\": 1, }", ".", "1, }"),
        (&long_line, ".", "?"),
    ];
    for (text, at, found_text) in cases {
        let (error, message) = refused(text);
        let SceneError::Syntax { line, path, found, .. } = error else { panic!("{message}") };
        assert!(found.contains(found_text), "{found_text:?} in {message}");
        assert!(path.starts_with(at), "{at} in {message}");
        assert!(line <= text.lines().count() + 1, "{message}");
    }
    let (_, message) = refused(&format!("{scene}\n]"));
    assert!(message.contains("trailing"), "{message}");
    let (_, message) = refused("[1, 2]");
    assert!(message.contains("`.` is [1, 2]; expected an object"), "{message}");
    let (_, message) = refused("null");
    assert!(message.contains("`.` is null; expected an object"), "{message}");
}

#[test]
fn nesting_of_any_depth_is_refused_without_exhausting_the_stack() {
    let scene = text(SCENE);
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let deep = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        refused(&deep);
        refused(&open.repeat(100_000));
        for key in ["\"description\": \"d\"", "\"assumed\": [\"pins\"]", "\"damping\": \"full\""] {
            let name = key.split(':').next().unwrap();
            refused(&scene.replace(key, &format!("{name}: {deep}")));
        }
        refused(&scene.replace("\"drape-scene/1\"", &deep));
        refused(&scene.replace("\"name\"", &format!("\"x\": {deep}, \"name\"")));
        refused(&scene.replace("NaN", &open.repeat(50)).replace("0.4", &open.repeat(1000)));
    }
}

#[test]
fn truncating_a_file_anywhere_is_an_error_and_no_panic() {
    for base in [SCENE, SYSTEM, TENT].map(text) {
        for end in (0..base.len()).filter(|&end| base.is_char_boundary(end)) {
            refused(&base[..end]);
        }
    }
}

#[test]
fn a_very_long_key_does_not_flood_the_message() {
    let key = format!("\"{}\\n\": 1, \"name\"", "k".repeat(1_000_000));
    let (_, message) = refused(&text(SCENE).replace("\"name\"", &key));
    assert!(message.contains("kkk…"), "{message}");
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let message = load(&path("missing.json")).unwrap_err().to_string();
    assert!(
        message.contains("missing.json") && message.contains("hanging-textile-1e4"),
        "{message}"
    );
    let error = load(&path(".")).unwrap_err();
    let said = error.to_string();
    assert!(said.starts_with(&path(".")) && said.contains("no regular file"), "{said}");
    for (bytes, line, column) in [(&b"{\n \"name\": \"\xff\""[..], 2, 11), (b"\x89PNG\r\n", 1, 1)] {
        std::fs::write(path("binary.json"), bytes).unwrap();
        let error = load(&path("binary.json")).unwrap_err();
        let SceneError::Syntax { line: l, column: c, .. } = &error else { panic!("{error}") };
        assert_eq!((*l, *c), (line, column), "{error}");
        assert!(error.to_string().starts_with(&path("binary.json")), "{error}");
    }
    assert!(load("").is_err() && load("no\0name").is_err());
    std::fs::write(path("good.json"), text(SCENE)).unwrap();
    assert_eq!(load(&path("good.json")).unwrap().spec().particles.mass_kg.len(), 12);
}
