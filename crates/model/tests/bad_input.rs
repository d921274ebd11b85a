//! Every broken scene is refused with one line that names the file, the key, the value found and what was
//! expected, and none makes the reader panic.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{SceneError, load, parse};

const SCENE: &str = r#"{
  "format": "drape-scene/1", "name": "grid", "description": "d", "assumed": ["pins"],
  "cloth": { "grid": { "rows": 3, "columns": 4, "size_m": [1, 2], "center_m": [0, 0, 0.5], "mass_kg": 0.4 } },
  "effects": {
    "tension": { "stiffness_over_mass_per_s2": 1e4, "damping_over_mass_per_s": 40 },
    "shear": { "stiffness_n_per_m": 5 },
    "gravity": { "m_s2": [0, 0, -9.81] },
    "contact": { "detection": "penetration", "recovery_speed_limit_m_s": 2 }
  },
  "damping": "full",
  "pins": [{ "row": 0, "column": 0 }, { "particle": 11 }],
  "obstacles": [
    { "plane": { "point_m": [0, 0, 0], "normal": [0, 0, 1], "restitution": 0.5 } },
    { "box": { "center_m": [0, 0, 0], "size_m": [1, 1, 1] } },
    { "sphere": { "center_m": [0, 0, 0], "radius_m": 0.25 } }
  ],
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
    { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1, "stiffness_n_per_m": 10, "damping_n_s_per_m": 0.1 },
    { "effect": "bending", "i": 1, "j": 3, "rest_length_m": 2, "stiffness_n_per_m": 20 }
  ],
  "damping": "projected", "triangles": [[0, 1, 2]], "pins": [{ "particle": 0 }],
  "effects": { "gravity": { "m_s2": [0, 0, -9.81] } },
  "obstacles": [{ "plane": { "point_m": [0, 0, -1], "normal": [0, 0, 1] } }]
}"#;

/// Text to be replaced, its replacement; then path, value and expectation as the message gives them.
type Case = (&'static str, &'static str, &'static str, &'static str, &'static str);

fn explicit() -> String {
    let particles = r#"{ "particles": { "mass_kg": [1, 1], "position_m": [[0, 0, 0], [1, 0, 0]] },
        "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1, "stiffness_n_per_m": 9 }] }"#;
    format!(
        r#"{{ "format": "drape-scene/1", "name": "explicit", "cloth": {{ "particles": {particles} }},
        "effects": {{ "gravity": {{ "m_s2": [0, 0, -1] }} }}, "pins": [{{ "particle": 0 }}],
        "time": {{ "step_s": 0.1, "duration_s": 1 }} }}"#
    )
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

fn check(base: &str, cases: &[Case]) {
    parse("base", base).unwrap();
    for &(from, to, path, value, expected) in cases {
        assert_eq!(base.matches(from).count(), 1, "{from} must be unique in the base");
        let (error, message) = refused(&base.replace(from, to));
        let violation = match error {
            SceneError::Invalid { violation, .. } => violation,
            SceneError::Shape { violation, line, .. } => {
                assert!(message.ends_with(')') && line > 0, "{message}");
                violation
            }
            other => panic!("{to}: {other}"),
        };
        assert_eq!(violation.path, path, "{message}");
        assert!(violation.value.contains(value), "{value} in {message}");
        assert!(violation.expected.contains(expected), "{expected} in {message}");
    }
}

#[test]
fn scenes_with_unknown_missing_or_doubled_keys_are_refused() {
    check(
        SCENE,
        &[
            (r#""name": "grid""#, r#""nmae": "grid""#, "nmae", "unknown", "`name`"),
            (r#""rows": 3"#, r#""rows": 3, "row": 3"#, "cloth.grid.row", "unknown", "`columns`"),
            (r#""grid": {"#, r#""gird": {"#, "cloth.gird", "unknown", "`particles`"),
            (r#""gravity": {"#, r#""wind": {"#, "effects.wind", "unknown", "`gravity`"),
            (r#""m_s2":"#, r#""m_s":"#, "effects.gravity.m_s", "unknown", "`m_s2`"),
            (
                r#""stiffness_n_per_m": 5"#,
                r#""k": 5"#,
                "effects.shear.k",
                "unknown",
                "`stiffness_n_per_m`",
            ),
            (r#""detection""#, r#""detect""#, "effects.contact.detect", "unknown", "`detection`"),
            (r#""row": 0"#, r#""rwo": 0"#, "pins[0].rwo", "unknown", "`row`"),
            (r#""radius_m""#, r#""radius""#, "obstacles[2].sphere.radius", "unknown", "`radius_m`"),
            (r#""sphere""#, r#""ball""#, "obstacles[2].ball", "unknown", "`sphere`"),
            (r#""step_s""#, r#""dt""#, "time.dt", "unknown", "`step_s`"),
            (r#""cloth": {"#, r#""cloths": {"#, "cloths", "unknown", "`cloth`"),
            (
                r#""mass_kg": 0.4"#,
                r#""velocity_m_s": [0, 0, 0]"#,
                "cloth.grid.mass_kg",
                "missing",
                "this key",
            ),
            (r#", "duration_s": 1"#, "", "time.duration_s", "missing", "this key"),
            (r#", "normal": [0, 0, 1]"#, "", "obstacles[0].plane.normal", "missing", "this key"),
            (
                r#""time": { "step_s": 0.01, "duration_s": 1 }"#,
                r#""damping": "full""#,
                "damping",
                "twice",
                "once",
            ),
            (
                ",\n  \"time\": { \"step_s\": 0.01, \"duration_s\": 1 }",
                "",
                "time",
                "missing",
                "this key",
            ),
            (r#""format": "drape-scene/1", "#, "", "format", "missing", "\"drape-scene/1\""),
            (r#""format""#, r#""format": "drape-scene/1", "format""#, "format", "twice", "once"),
            (r#""rows": 3"#, r#""rows": 3, "rows": 4"#, "cloth.grid.rows", "twice", "once"),
        ],
    );
}

#[test]
fn scenes_with_values_of_the_wrong_type_are_refused() {
    let long = format!(r#""format": "{}""#, "x".repeat(3_000_000));
    assert!(refused(&SCENE.replace(r#""format": "drape-scene/1""#, &long)).1.contains("xx…xx"));
    check(
        SCENE,
        &[
            (
                r#""drape-scene/1""#,
                r#""drape-scene/2""#,
                "format",
                "drape-scene/2",
                "drape-scene/1",
            ),
            (r#""drape-scene/1""#, "17", "format", "17", "drape-scene/1"),
            (r#""drape-scene/1""#, "{ \"a\":\n null }", "format", "null", "drape-scene/1"),
            (r#""name": "grid""#, r#""name": 3"#, "name", "3", "a string"),
            (
                r#""rows": 3"#,
                r#""rows": "three""#,
                "cloth.grid.rows",
                "\"three\"",
                "a whole number",
            ),
            (r#""rows": 3"#, r#""rows": -3"#, "cloth.grid.rows", "-3", "a whole number from 0"),
            (r#""rows": 3"#, r#""rows": 3.5"#, "cloth.grid.rows", "3.5", "a whole number"),
            (
                r#""rows": 3"#,
                r#""rows": 4294967296"#,
                "cloth.grid.rows",
                "4294967296",
                "4294967295",
            ),
            (r#""rows": 3"#, r#""rows": null"#, "cloth.grid.rows", "null", "a whole number"),
            (
                r#""mass_kg": 0.4"#,
                r#""mass_kg": "0.4""#,
                "cloth.grid.mass_kg",
                "\"0.4\"",
                "a number",
            ),
            (r#""mass_kg": 0.4"#, r#""mass_kg": true"#, "cloth.grid.mass_kg", "true", "a number"),
            (r#""mass_kg": 0.4"#, r#""mass_kg": 1e999"#, "cloth.grid.mass_kg", "1e999", "1.8e308"),
            (
                r#""mass_kg": 0.4"#,
                r#""mass_kg": -1e999"#,
                "cloth.grid.mass_kg",
                "-1e999",
                "1.8e308",
            ),
            (
                r#""size_m": [1, 2]"#,
                r#""size_m": [1, 2, 3]"#,
                "cloth.grid.size_m",
                "[1, 2, 3]",
                "length 2",
            ),
            (r#""size_m": [1, 2]"#, r#""size_m": [1]"#, "cloth.grid.size_m", "[1]", "length 2"),
            (r#""size_m": [1, 2]"#, r#""size_m": 1"#, "cloth.grid.size_m", "1", "length 2"),
            (
                r#"{ "m_s2": [0, 0, -9.81] }"#,
                "[[0, 0, -9.81]]",
                "effects.gravity",
                "[[0, 0, -9.81]]",
                "an object",
            ),
            (r#"{ "stiffness_n_per_m": 5 }"#, "5", "effects.shear", "5", "an object"),
            (
                r#"{ "step_s": 0.01, "duration_s": 1 }"#,
                "[0.01, 1]",
                "time",
                "[0.01, 1]",
                "an object",
            ),
            (
                r#"{ "center_m": [0, 0, 0], "radius_m": 0.25 }"#,
                "[[0, 0, 0], 1, 0]",
                "obstacles[2].sphere",
                "[[0",
                "an object",
            ),
            (r#""damping": "full""#, r#""damping": "half""#, "damping", "\"half\"", "`projected`"),
            (r#""damping": "full""#, r#""damping": 1"#, "damping", "1", "`full`"),
            (r#""damping": "full""#, r#""damping": null"#, "damping", "null", "`full`"),
            (r#""penetration""#, "[]", "effects.contact.detection", "[]", "`speculative`"),
            (r#""cloth": {"#, r#""cloth": 5, "x": {"#, "cloth", "5", "`grid`"),
            (r#""cloth": {"#, r#""cloth": "grid", "x": {"#, "cloth", "\"grid\"", "an object"),
            (
                r#""cloth": {"#,
                r#""cloth": {}, "x": {"#,
                "cloth",
                "{}",
                "`grid`, `mesh`, `particles`",
            ),
            (
                r#""grid": {"#,
                r#""grid": {"rows":1,"columns":1,"size_m":[1,1],"center_m":[0,0,0],"mass_kg":1}, "particles": {"#,
                "cloth",
                "{",
                "one of the keys",
            ),
            (r#""assumed": ["pins"]"#, r#""assumed": ["pins", 3]"#, "assumed[1]", "3", "a string"),
            (r#""assumed": ["pins"]"#, r#""assumed": "pins""#, "assumed", "\"pins\"", "a list"),
            (r#"{ "particle": 11 }"#, "11", "pins[1]", "11", "an object"),
        ],
    );
}

#[test]
fn scenes_with_values_out_of_range_are_refused() {
    let tension = r#""stiffness_over_mass_per_s2": 1e4, "damping_over_mass_per_s": 40"#;
    check(
        SCENE,
        &[
            (r#""rows": 3"#, r#""rows": 0"#, "cloth.grid.rows", "0", "at least 1"),
            (
                r#""rows": 3, "columns": 4"#,
                r#""rows": 4000000000, "columns": 4000000000"#,
                "cloth.grid",
                "4000000000 × 4000000000",
                "at most 4000000 particles",
            ),
            (r#""size_m": [1, 2]"#, r#""size_m": [1, 0]"#, "cloth.grid.size_m[1]", "0", "above 0"),
            (
                r#""size_m": [1, 2]"#,
                r#""size_m": [9e8, 9e8]"#,
                "cloth.grid.size_m",
                "[9e8, 9e8]",
                "within 1e9 m",
            ),
            (r#""mass_kg": 0.4"#, r#""mass_kg": 0"#, "cloth.grid.mass_kg", "0", "above 0"),
            (
                r#""mass_kg": 0.4"#,
                r#""mass_kg": 5e-324"#,
                "cloth.grid.mass_kg",
                "5e-324",
                "every particle",
            ),
            (
                r#""center_m": [0, 0, 0.5]"#,
                r#""center_m": [0, 2e9, 0]"#,
                "cloth.grid.center_m[1]",
                "2e9",
                "from -1e9 to 1e9",
            ),
            (
                tension,
                r#""damping_over_mass_per_s": 40"#,
                "effects.tension",
                "without a stiffness",
                "`stiffness_n_per_m` or",
            ),
            (
                tension,
                r#""pieces": []"#,
                "effects.tension",
                "without a stiffness",
                "`pieces`, one at least, or `warp` and `weft`",
            ),
            (
                r#""gravity": {"#,
                r#""air": { "drag": "quadratic" }, "gravity": {"#,
                "effects.air.drag",
                "\"quadratic\"",
                "an object with one of the keys `quadratic`, `linear`",
            ),
            (
                tension,
                r#""stiffness_over_mass_per_s2": 1, "stiffness_n_per_m": 1"#,
                "effects.tension",
                "given twice",
                "exactly one",
            ),
            (
                tension,
                r#""stiffness_over_mass_per_s2": -1"#,
                "effects.tension.stiffness_over_mass_per_s2",
                "-1",
                "from 0 to 1e30",
            ),
            (
                tension,
                r#""stiffness_n_per_m": 1e300"#,
                "effects.tension.stiffness_n_per_m",
                "1e300",
                "from 0 to 1e30",
            ),
            (
                r#""damping_over_mass_per_s": 40"#,
                r#""damping_over_mass_per_s": -40"#,
                "effects.tension.damping_over_mass_per_s",
                "-40",
                "from 0",
            ),
            (
                r#""damping_over_mass_per_s": 40"#,
                r#""damping_over_mass_per_s": 40, "damping_n_s_per_m": 1"#,
                "effects.tension",
                "given twice",
                "at most one",
            ),
            (r#"[0, 0, -9.81]"#, "[0, 0, -1e10]", "effects.gravity.m_s2[2]", "-1e10", "from -1e9"),
            (
                r#""recovery_speed_limit_m_s": 2"#,
                r#""recovery_speed_limit_m_s": -2"#,
                "effects.contact.recovery_speed_limit_m_s",
                "-2",
                "from 0",
            ),
            (r#"{ "particle": 11 }"#, r#"{ "particle": 12 }"#, "pins[1].particle", "12", "0 to 11"),
            (r#"{ "particle": 11 }"#, "{}", "pins[1]", "{}", "exactly one of `particle`"),
            (
                r#"{ "particle": 11 }"#,
                r#"{ "particle": 1, "row": 1, "column": 1 }"#,
                "pins[1]",
                "\"row\":1",
                "exactly one of `particle`",
            ),
            (
                r#""row": 0, "column": 0"#,
                r#""name": "hem""#,
                "pins[0]",
                "\"name\":\"hem\"",
                "a mesh's file",
            ),
            (
                r#""row": 0, "column": 0"#,
                r#""near_m": [0, 1e10, 0]"#,
                "pins[0].near_m[1]",
                "1e10",
                "1e9",
            ),
            (
                r#""row": 0, "column": 0"#,
                r#""within_m": [[0, 1, 0], [0, 0, 0]]"#,
                "pins[0].within_m[1][1]",
                "0",
                "from 1",
            ),
            (
                r#""row": 0, "column": 0"#,
                r#""within_m": [[0, 0, 7], [1, 1, 8]]"#,
                "pins[0].within_m",
                "without a particle",
                "at least one",
            ),
            (r#""row": 0, "column": 0"#, r#""boundary": 1"#, "pins[0].boundary", "1", "0 to 0"),
            (r#""row": 0, "column": 0"#, r#""row": 3, "column": 0"#, "pins[0].row", "3", "0 to 2"),
            (
                r#""row": 0, "column": 0"#,
                r#""row": 0, "column": 4"#,
                "pins[0].column",
                "4",
                "0 to 3",
            ),
            (
                r#""restitution": 0.5"#,
                r#""restitution": 1.5"#,
                "obstacles[0].plane.restitution",
                "1.5",
                "from 0 to 1",
            ),
            (
                r#""normal": [0, 0, 1]"#,
                r#""normal": [0, 0, 0]"#,
                "obstacles[0].plane.normal",
                "[0",
                "longer than",
            ),
            (
                r#""size_m": [1, 1, 1]"#,
                r#""size_m": [1, 0, 1]"#,
                "obstacles[1].box.size_m[1]",
                "0",
                "above 0",
            ),
            (
                r#""radius_m": 0.25"#,
                r#""radius_m": 0"#,
                "obstacles[2].sphere.radius_m",
                "0",
                "above 0",
            ),
            (r#""step_s": 0.01"#, r#""step_s": 0"#, "time.step_s", "0", "above 0"),
            (r#""step_s": 0.01"#, r#""step_s": -0.01"#, "time.step_s", "-0.01", "above 0"),
            (r#""step_s": 0.01"#, r#""step_s": 1e-12"#, "time.step_s", "1e-12", "at least 1e-9"),
            (r#""duration_s": 1"#, r#""duration_s": 0"#, "time.duration_s", "0", "above 0"),
            (
                r#""duration_s": 1"#,
                r#""duration_s": 1e300"#,
                "time.duration_s",
                "1e300",
                "at most 1e9",
            ),
        ],
    );
}

#[test]
fn a_quotient_times_the_mass_must_be_in_range_too() {
    let heavy = SCENE.replace(r#""mass_kg": 0.4"#, r#""mass_kg": 1e25"#);
    check(
        &heavy,
        &[(
            r#""stiffness_over_mass_per_s2": 1e4"#,
            r#""stiffness_over_mass_per_s2": 1e7"#,
            "effects.tension.stiffness_over_mass_per_s2",
            "1e7",
            "from 0 to 1199999.99",
        )],
    );
}

#[test]
fn frozen_systems_that_contradict_themselves_are_refused() {
    check(
        SYSTEM,
        &[
            (
                r#""drape-system/1""#,
                r#""drape-system/0""#,
                "format",
                "drape-system/0",
                "drape-system/1",
            ),
            (r#""particles": {"#, r#""partikel": {"#, "partikel", "unknown", "`particles`"),
            (r#""mass_kg""#, r#""mass""#, "particles.mass", "unknown", "`mass_kg`"),
            ("0.5]", "-0.5]", "particles.mass_kg[3]", "-0.5", "above 0"),
            ("0.5]", "0]", "particles.mass_kg[3]", "0", "above 0"),
            ("0.5]", "1e999]", "particles.mass_kg[3]", "1e999", "1.8e308"),
            ("0.5]", "\"x\"]", "particles.mass_kg[3]", "\"x\"", "a number"),
            ("0.5]", "null]", "particles.mass_kg[3]", "null", "a number"),
            ("[1, 1, 1, 0.5]", "[]", "particles.mass_kg", "length 0", "1 to 4000000"),
            ("[1, 1, 1, 0.5]", "[1, 1, 1]", "particles.position_m", "length 4", "length 3"),
            (", [0, 0, 1]]", "]", "particles.velocity_m_s", "length 3", "length 4"),
            ("[3, 0, 0]", "[3, 0]", "particles.position_m[3]", "[3, 0]", "length 3"),
            ("[3, 0, 0]", "[3, 0, -1e300]", "particles.position_m[3][2]", "-1e300", "from -1e9"),
            (
                r#""effect": "tension""#,
                r#""effect": "magic""#,
                "springs[0].effect",
                "\"magic\"",
                "`shear`",
            ),
            (r#""effect": "tension""#, r#""effect": 2"#, "springs[0].effect", "2", "`shear`"),
            (r#""i": 0"#, r#""i": 4"#, "springs[0].i", "4", "0 to 3"),
            (r#""i": 0"#, r#""i": -1"#, "springs[0].i", "-1", "a whole number from 0"),
            (r#""i": 0"#, r#""i": 0.5"#, "springs[0].i", "0.5", "a whole number"),
            (r#""j": 3"#, r#""j": 1"#, "springs[1].j", "1", "another particle"),
            (
                r#""rest_length_m": 2"#,
                r#""rest_length_m": -2"#,
                "springs[1].rest_length_m",
                "-2",
                "from 0",
            ),
            (
                r#""stiffness_n_per_m": 20"#,
                r#""stiffness_n_per_m": -20"#,
                "springs[1].stiffness_n_per_m",
                "-20",
                "from 0",
            ),
            (
                r#""damping_n_s_per_m": 0.1"#,
                r#""damping_n_s_per_m": -0.1"#,
                "springs[0].damping_n_s_per_m",
                "-0.1",
                "from 0",
            ),
            ("[[0, 1, 2]]", "[[0, 1, 4]]", "triangles[0][2]", "4", "0 to 3"),
            ("[[0, 1, 2]]", "[[0, 1]]", "triangles[0]", "[0, 1]", "length 3"),
            (r#"[{ "particle": 0 }]"#, r#"[{ "particle": 9 }]"#, "pins[0].particle", "9", "0 to 3"),
            (
                r#"[{ "particle": 0 }]"#,
                r#"[{ "row": 0, "column": 0 }]"#,
                "pins[0].row",
                "unknown",
                "`particle`",
            ),
            (r#""gravity": {"#, r#""tension": {"#, "effects.tension", "unknown", "`gravity`"),
            (r#""springs": ["#, r#""springs": {}, "x": ["#, "springs", "{}", "a list"),
        ],
    );
}

#[test]
fn explicit_cloth_is_refused_with_the_paths_of_the_scene() {
    let tension = r#""effects": { "tension": { "stiffness_n_per_m": 3 }, "gravity""#;
    check(
        &explicit(),
        &[
            (
                r#""effects": { "gravity""#,
                tension,
                "effects.tension",
                "beside explicit springs",
                "no such key",
            ),
            (
                r#""mass_kg": [1, 1]"#,
                r#""mass_kg": [1, 0]"#,
                "cloth.particles.particles.mass_kg[1]",
                "0",
                "above 0",
            ),
            (
                r#""mass_kg": [1, 1], "#,
                "",
                "cloth.particles.particles.mass_kg",
                "missing",
                "this key",
            ),
            (
                r#"{ "particles": { "mass_kg": [1, 1], "position_m": [[0, 0, 0], [1, 0, 0]] },"#,
                "{",
                "cloth.particles.particles",
                "missing",
                "this key",
            ),
            (r#""j": 1"#, r#""j": 2"#, "cloth.particles.springs[0].j", "2", "0 to 1"),
            (
                r#"{ "particle": 0 }"#,
                r#"{ "row": 0, "column": 0 }"#,
                "pins[0]",
                "\"row\":0",
                "of a grid cloth",
            ),
        ],
    );
}

#[test]
fn what_is_no_json_is_refused_with_the_place() {
    let nan = SYSTEM.replace("0.5]", "NaN]");
    let infinity = SYSTEM.replace("0.5]", "-Infinity]");
    let cut = &SCENE[..SCENE.len() / 2];
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
    let (_, message) = refused(&format!("{SCENE}\n]"));
    assert!(message.contains("trailing"), "{message}");
    let (_, message) = refused("[1, 2]");
    assert!(message.contains("`.` is [1, 2]; expected an object"), "{message}");
    let (_, message) = refused("null");
    assert!(message.contains("`.` is null; expected an object"), "{message}");
}

#[test]
fn nesting_of_any_depth_is_refused_without_exhausting_the_stack() {
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let deep = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        refused(&deep);
        refused(&open.repeat(100_000));
        for key in ["\"description\": \"d\"", "\"assumed\": [\"pins\"]", "\"damping\": \"full\""] {
            let name = key.split(':').next().unwrap();
            refused(&SCENE.replace(key, &format!("{name}: {deep}")));
        }
        refused(&SCENE.replace("\"drape-scene/1\"", &deep));
        refused(&SCENE.replace("\"name\"", &format!("\"x\": {deep}, \"name\"")));
        refused(&SCENE.replace("NaN", &open.repeat(50)).replace("0.4", &open.repeat(1000)));
    }
}

#[test]
fn truncating_a_file_anywhere_is_an_error_and_no_panic() {
    for base in [SCENE, SYSTEM, &explicit()] {
        for end in (0..base.len()).filter(|&end| base.is_char_boundary(end)) {
            refused(&base[..end]);
        }
    }
}

#[test]
fn a_very_long_key_does_not_flood_the_message() {
    let key = format!("\"{}\\n\": 1, \"name\"", "k".repeat(1_000_000));
    let (_, message) = refused(&SCENE.replace("\"name\"", &key));
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
    assert!(matches!(error, SceneError::Io { .. }), "{error}");
    assert!(error.to_string().starts_with(&path(".")), "{error}");
    for (bytes, line, column) in [(&b"{\n \"name\": \"\xff\""[..], 2, 11), (b"\x89PNG\r\n", 1, 1)] {
        std::fs::write(path("binary.json"), bytes).unwrap();
        let error = load(&path("binary.json")).unwrap_err();
        let SceneError::Syntax { line: l, column: c, .. } = &error else { panic!("{error}") };
        assert_eq!((*l, *c), (line, column), "{error}");
        assert!(error.to_string().starts_with(&path("binary.json")), "{error}");
    }
    assert!(load("").is_err() && load("no\0name").is_err());
    std::fs::write(path("good.json"), SCENE).unwrap();
    assert_eq!(load(&path("good.json")).unwrap().spec().particles.mass_kg.len(), 12);
}

/// Tension by pieces, warp and weft apart, bending springs that buckle.
const FABRIC: &str = r#"{
  "format": "drape-scene/1", "name": "fabric",
  "cloth": { "grid": { "rows": 3, "columns": 3, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 0.4 } },
  "effects": {
    "tension": { "damping_over_mass_per_s": 4,
      "warp": { "pieces": [{ "up_to_strain": 0.02, "stiffness_n_per_m": 10 }, { "stiffness_n_per_m": 1000 }] },
      "weft": { "stiffness_n_per_m": 70, "compression_stiffness_n_per_m": 3 } },
    "shear": { "pieces": [{ "up_to_strain": 0.1, "stiffness_n_per_m": 5 }, { "stiffness_n_per_m": 50 }] },
    "bending": { "stiffness_n_per_m": 8, "buckling_rigidity_n_m2": 1e-4 }
  },
  "time": { "step_s": 0.01, "duration_s": 1 }
}"#;

#[test]
fn scenes_with_curves_that_make_no_sense_are_refused() {
    check(
        FABRIC,
        &[
            (
                r#""up_to_strain": 0.02, "#,
                "",
                "effects.tension.warp.pieces[0].up_to_strain",
                "missing",
                "only the last",
            ),
            (
                r#"{ "stiffness_n_per_m": 1000 }"#,
                r#"{ "stiffness_n_per_m": 1000, "up_to_strain": 1 }"#,
                "effects.tension.warp.pieces[1].up_to_strain",
                "1",
                "no such key",
            ),
            (
                r#""up_to_strain": 0.02"#,
                r#""up_to_strain": 0"#,
                "effects.tension.warp.pieces[0].up_to_strain",
                "0",
                "a number above 0",
            ),
            (
                r#"{ "stiffness_n_per_m": 1000 }"#,
                r#"{ "up_to_strain": 0.01, "stiffness_n_per_m": 1 }, { "stiffness_n_per_m": 1 }"#,
                "effects.tension.warp.pieces[1].up_to_strain",
                "0.01",
                "above 0.02",
            ),
            (
                r#""stiffness_n_per_m": 1000"#,
                r#""stiffness_n_per_m": -1"#,
                "effects.tension.warp.pieces[1].stiffness_n_per_m",
                "-1",
                "from 0",
            ),
            (
                r#""weft": { "stiffness_n_per_m": 70, "#,
                r#""weft": { "#,
                "effects.tension.weft",
                "without a stiffness",
                "`pieces`",
            ),
            (
                r#""compression_stiffness_n_per_m": 3"#,
                r#""compression_stiffness_n_per_m": 2e30"#,
                "effects.tension.weft.compression_stiffness_n_per_m",
                "2e30",
                "from 0",
            ),
            (
                r#""weft": { "stiffness_n_per_m": 70, "#,
                r#""weft": { "pieces": [{ "stiffness_n_per_m": 1 }], "stiffness_n_per_m": 70, "#,
                "effects.tension.weft",
                "given twice",
                "exactly one",
            ),
            (
                r#""warp""#,
                r#""stiffness_n_per_m": 3, "warp""#,
                "effects.tension.stiffness_n_per_m",
                "beside `warp`",
                "one of",
            ),
            (
                r#""warp""#,
                r#""compression_stiffness_n_per_m": 3, "warp""#,
                "effects.tension.compression_stiffness_n_per_m",
                "beside `warp`",
                "in `warp`",
            ),
            (
                r#""shear": {"#,
                r#""shear": { "stiffness_over_mass_per_s2": 2, "#,
                "effects.shear.stiffness_over_mass_per_s2",
                "beside `pieces`",
                "one of",
            ),
            (
                r#""shear": { "pieces": [{ "up_to_strain": 0.1, "stiffness_n_per_m": 5 }, { "stiffness_n_per_m": 50 }] }"#,
                r#""shear": { "warp": { "stiffness_n_per_m": 50 }, "weft": { "stiffness_n_per_m": 50 } }"#,
                "effects.shear.warp",
                "diagonals",
                "one law",
            ),
            (
                r#""shear": {"#,
                r#""shear": { "buckling_rigidity_n_m2": 1, "#,
                "effects.shear.buckling_rigidity_n_m2",
                "shear",
                "bending springs only",
            ),
            (
                r#""buckling_rigidity_n_m2": 1e-4"#,
                r#""buckling_rigidity_n_m2": 0"#,
                "effects.bending.buckling_rigidity_n_m2",
                "0",
                "above 0",
            ),
            (
                r#""buckling_rigidity_n_m2": 1e-4"#,
                r#""buckling_rigidity_n_m2": 1e29"#,
                "springs[20].buckling_rigidity_n_m2",
                "1e29",
                "at most 1e30",
            ),
            (
                r#""buckling_rigidity_n_m2": 1e-4"#,
                r#""warp": { "stiffness_n_per_m": 1 }"#,
                "effects.bending.weft",
                "missing",
                "`warp`",
            ),
            (
                r#""up_to_strain": 0.02"#,
                r#""strain": 0.02"#,
                "effects.tension.warp.pieces[0].strain",
                "unknown",
                "`up_to_strain`",
            ),
        ],
    );
    let pieces: Vec<_> =
        (1..66).map(|k| format!(r#"{{ "up_to_strain": {k}, "stiffness_n_per_m": 1 }}"#)).collect();
    let many = format!("[{}, {{ \"stiffness_n_per_m\": 50 }}]", pieces.join(", "));
    let from = r#"[{ "up_to_strain": 0.1, "stiffness_n_per_m": 5 }, { "stiffness_n_per_m": 50 }]"#;
    let (_, message) = refused(&FABRIC.replace(from, &many));
    assert!(
        message.contains("effects.shear.pieces") && message.contains("at most 64"),
        "{message}"
    );
}

#[test]
fn frozen_springs_with_curves_that_make_no_sense_are_refused() {
    check(
        SYSTEM,
        &[
            (
                r#""stiffness_n_per_m": 10"#,
                r#""pieces": [{ "stiffness_n_per_m": 11 }], "stiffness_n_per_m": 10"#,
                "springs[0].stiffness_n_per_m",
                "10",
                "11, that of the first piece",
            ),
            (
                r#""stiffness_n_per_m": 10"#,
                r#""buckling_rigidity_n_m2": 1, "stiffness_n_per_m": 10"#,
                "springs[0].buckling_rigidity_n_m2",
                "tension",
                "bending springs only",
            ),
            (
                r#""rest_length_m": 2, "#,
                r#""compression_stiffness_n_per_m": 1, "rest_length_m": 0, "#,
                "springs[1].rest_length_m",
                "0",
                "above 0",
            ),
            (
                r#""rest_length_m": 2, "#,
                r#""buckling_rigidity_n_m2": 1, "rest_length_m": 1e-300, "#,
                "springs[1].buckling_rigidity_n_m2",
                "1",
                "at most 1e30",
            ),
            (
                r#""rest_length_m": 2, "#,
                r#""compression_stiffness_n_per_m": -1, "rest_length_m": 2, "#,
                "springs[1].compression_stiffness_n_per_m",
                "-1",
                "from 0",
            ),
        ],
    );
}

#[test]
fn a_fabric_where_it_says_nothing_is_refused() {
    const TENSION: &str = r#""stiffness_over_mass_per_s2": 1e4"#;
    const FABRIC: &str = r#""fabric": "wool""#;
    let scene = SCENE.replace(TENSION, FABRIC);
    parse("file", &scene).unwrap();
    check(
        &scene,
        &[
            (r#""wool""#, r#""silk""#, "effects.tension.fabric", "silk", "`wool`"),
            (r#""wool""#, "3", "effects.tension.fabric", "3", "`wool`"),
            (
                FABRIC,
                r#""fabric": "wool", "stiffness_n_per_m": 3"#,
                "effects.tension.fabric",
                "beside `stiffness_n_per_m`",
                "one of",
            ),
            (
                FABRIC,
                r#""fabric": "wool", "pieces": [{ "stiffness_n_per_m": 3 }]"#,
                "effects.tension.fabric",
                "beside `pieces`",
                "one of",
            ),
            (
                FABRIC,
                r#""fabric": "wool", "warp": { "stiffness_n_per_m": 3 }"#,
                "effects.tension.fabric",
                "beside `warp`",
                "one of",
            ),
            (
                r#""shear": { "stiffness_n_per_m": 5 }"#,
                r#""shear": { "fabric": "wool" }"#,
                "effects.shear.fabric",
                "shear",
                "tension springs only",
            ),
            (
                r#""rows": 3"#,
                r#""rows": 1"#,
                "effects.tension.fabric",
                "single row",
                "at least 2 rows",
            ),
        ],
    );
    let mesh = r#""mesh": { "file": "bundled:sheet.obj", "areal_density_kg_m2": 0.15 }"#;
    let (from, to) =
        (scene.find(r#""grid": {"#).unwrap(), scene.find(" },\n  \"effects\"").unwrap());
    let (_, message) = refused(&format!("{}{mesh}{}", &scene[..from], &scene[to..]));
    assert!(
        message.contains("effects.tension.fabric") && message.contains("warp and weft"),
        "{message}"
    );
}
