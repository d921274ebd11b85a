//! Broken paths, coefficients of friction and meshes of obstacles are refused with the key, the value and what was
//! expected, in scenes and in frozen systems.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{SceneError, parse};

const MOTION: &str = r#"
  "obstacles": [
    { "plane": { "point_m": [0, 0, 0], "normal": [0, 0, 1], "friction": 0.5 } },
    { "mesh": { "vertices_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "triangles": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        "path": [{ "time_s": 2, "offset_m": [0, 0, 7] }] } }
  ]"#;

/// The first pin of a scene is a whole row.
fn scene() -> String {
    format!(
        r#"{{ "format": "drape-scene/1", "name": "x",
        "cloth": {{ "grid": {{ "rows": 2, "columns": 3, "size_m": [1, 1], "center_m": [0, 0, 5], "mass_kg": 1 }} }},
        "pins": [{{ "row": 0 }}, {{ "row": 1, "column": 0,
            "path": [{{ "time_s": 0.5, "offset_m": [0, 0, 1] }}, {{ "time_s": 1.5, "offset_m": [0, 0, 3] }}] }}],
        {MOTION}, "time": {{ "step_s": 0.1, "duration_s": 1 }} }}"#
    )
}

fn system() -> String {
    format!(
        r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": [1, 1], "position_m": [[0, 0, 5], [1, 0, 5]] }},
        "pins": [{{ "particle": 0 }}, {{ "particle": 1,
            "path": [{{ "time_s": 0.5, "offset_m": [0, 0, 1] }}, {{ "time_s": 1.5, "offset_m": [0, 0, 3] }}] }}],
        {MOTION} }}"#
    )
}

/// What a message must name: path, value and expectation.
fn check(base: &str, from: &str, to: &str, [path, value, expected]: [&str; 3]) {
    parse("base", base).unwrap();
    assert_eq!(base.matches(from).count(), 1, "{from} must be unique in the base");
    let error = parse("dir/file.json", &base.replace(from, to)).unwrap_err();
    let message = error.to_string();
    assert!(message.starts_with("dir/file.json: ") && message.lines().count() == 1, "{message}");
    let violation = match error {
        SceneError::Invalid { violation, .. } | SceneError::Shape { violation, .. } => violation,
        other => panic!("{to}: {other}"),
    };
    assert_eq!(violation.path, path, "{message}");
    assert!(violation.value.contains(value), "{value} in {message}");
    assert!(violation.expected.contains(expected), "{expected} in {message}");
}

#[test]
fn paths_that_lead_nowhere_are_refused() {
    for base in [scene(), system()] {
        for (from, to, named) in [
            (r#""time_s": 0.5"#, r#""time_s": -0.5"#, ["pins[1].path[0].time_s", "-0.5", "from 0"]),
            (
                r#""time_s": 0.5"#,
                r#""time_s": 1.5"#,
                ["pins[1].path[1].time_s", "1.5", "after 1.5"],
            ),
            (r#""time_s": 0.5"#, r#""time_s": 9"#, ["pins[1].path[1].time_s", "1.5", "after 9"]),
            (r#""time_s": 1.5"#, r#""time_s": 1e10"#, ["pins[1].path[1].time_s", "1e10", "1e9"]),
            (r#""time_s": 1.5"#, r#""time": 1.5"#, ["pins[1].path[1].time", "unknown", "`time_s`"]),
            (r#""time_s": 1.5, "#, "", ["pins[1].path[1].time_s", "missing", "this key"]),
            (r#""time_s": 0.5"#, r#""time_s": 0"#, ["pins[1].path[0].offset_m", "1", "at time 0"]),
            ("[0, 0, 3]", "[0, 0, 1e300]", ["pins[1].path[1].offset_m[2]", "1e300", "1e9"]),
            ("[0, 0, 3]", "[0, 3]", ["pins[1].path[1].offset_m", "[0, 3]", "length 3"]),
            (
                r#""time_s": 2"#,
                r#""time_s": -2"#,
                ["obstacles[1].mesh.path[0].time_s", "-2", "from 0"],
            ),
            (
                "[0, 0, 7]",
                "[0, 0, null]",
                ["obstacles[1].mesh.path[0].offset_m[2]", "null", "number"],
            ),
        ] {
            check(&base, from, to, named);
        }
    }
}

#[test]
fn friction_and_meshes_that_make_no_sense_are_refused() {
    for base in [scene(), system()] {
        for (from, to, named) in [
            (r#"n": 0.5"#, r#"n": -0.5"#, ["obstacles[0].plane.friction", "-0.5", "from 0 to 100"]),
            (r#"n": 0.5"#, r#"n": 101"#, ["obstacles[0].plane.friction", "101", "from 0 to 100"]),
            (r#"n": 0.5"#, r#"n": "rough""#, ["obstacles[0].plane.friction", "rough", "a number"]),
            ("[1, 2, 3]]", "[1, 2, 4]]", ["obstacles[1].mesh.triangles[3][2]", "4", "below 4"]),
            (
                "[1, 2, 3]]",
                "[1, 2, 2]]",
                ["obstacles[1].mesh.triangles[3]", "[1, 2, 2]", "an area"],
            ),
            ("[1, 2, 3]]", "[1, 3, 2]]", ["obstacles[1].mesh.triangles[3]", "[1, 3, 2]", "closed"]),
            (", [1, 2, 3]]", "]", ["obstacles[1].mesh.triangles", "length 3", "4 to"]),
            (
                "[1, 0, 0], [0, 1, 0]",
                "[0, 1, 0], [1, 0, 0]",
                ["obstacles[1].mesh.triangles[0]", "volume", "counter-clockwise"],
            ),
            (
                "[1, 0, 0], [0, 1, 0]",
                "[1, 0, 0], [0, 1e99, 0]",
                ["obstacles[1].mesh.vertices_m[2][1]", "1e99", "1e9"],
            ),
        ] {
            check(&base, from, to, named);
        }
    }
}

#[test]
fn a_particle_that_is_led_has_one_path() {
    let twice = ["pins[1]", "particle 0", "once where a pin has a path"];
    check(&scene(), r#""row": 1, "column": 0"#, r#""row": 0, "column": 0"#, twice);
    let twice = ["pins[1].particle", "0", "once where a pin has a path"];
    check(&system(), r#""particle": 1"#, r#""particle": 0"#, twice);
}

#[test]
fn a_path_for_many_particles_does_not_fill_the_memory() {
    let frames: Vec<String> =
        (1..=2000).map(|k| format!(r#"{{ "time_s": {k}, "offset_m": [0, 0, {k}] }}"#)).collect();
    let frames = frames.join(",");
    let scene = format!(
        r#"{{ "format": "drape-scene/1", "name": "x",
        "cloth": {{ "grid": {{ "rows": 1000, "columns": 1000, "size_m": [1, 1], "center_m": [0, 0, 5], "mass_kg": 1 }} }},
        "pins": [{{ "column": 0, "path": [{frames}] }}], "time": {{ "step_s": 0.1, "duration_s": 1 }} }}"#
    );
    let error = parse("x", &scene).unwrap_err().to_string();
    assert!(error.contains("pins[0].path") && error.contains("2000 keyframes for 1000"), "{error}");
    assert!(error.contains("at most 1000000 keyframes"), "{error}");
}
