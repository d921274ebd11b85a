//! The published schemas bound every number, and the reader refuses what lies beyond.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{Scene, SystemSpec, bundled, parse};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// A walk through a schema, with its findings.
struct Walk<'a> {
    root: &'a Value,
    /// Pointer to each number of the example, and its schema.
    numbers: Vec<(String, &'a Value)>,
    /// Pointer to each list that may grow, and the most entries that it may have.
    lists: Vec<(String, u64)>,
    /// Keys that the example has, and all that there are, each after the name of its object.
    seen: BTreeSet<String>,
    known: BTreeSet<String>,
}

impl<'a> Walk<'a> {
    fn new(root: &'a Value) -> Self {
        let (numbers, lists) = Default::default();
        Self { root, numbers, lists, seen: BTreeSet::new(), known: BTreeSet::new() }
    }

    /// The schema behind a reference, and its name.
    fn resolve(&self, schema: &'a Value, name: &str) -> (&'a Value, String) {
        match schema["$ref"].as_str() {
            None => (schema, name.to_owned()),
            Some(reference) => {
                let target = self.root.pointer(reference.trim_start_matches('#')).unwrap();
                (target, reference.rsplit('/').next().unwrap().to_owned())
            }
        }
    }

    /// The alternative that has the keys of a value.
    fn choose(&self, branches: &'a [Value], value: &Value) -> Option<&'a Value> {
        let keys = value.as_object()?;
        branches.iter().find_map(|branch| {
            let (resolved, _) = self.resolve(branch, "");
            if let Some(inner) = resolved["anyOf"].as_array() {
                return self.choose(inner, value);
            }
            let known = resolved["properties"].as_object();
            known
                .is_some_and(|known| keys.keys().all(|key| known.contains_key(key)))
                .then_some(branch)
        })
    }

    fn value(&mut self, schema: &'a Value, value: &Value, name: &str, at: &str) {
        let (schema, name) = self.resolve(schema, name);
        let branches = schema["oneOf"].as_array().or(schema["anyOf"].as_array());
        if let Some(branch) = branches.and_then(|branches| self.choose(branches, value)) {
            return self.value(branch, value, &name, at);
        }
        match value {
            Value::Number(_) => self.numbers.push((at.to_owned(), schema)),
            Value::Object(map) => self.object(schema, map, &name, at),
            Value::Array(list) => {
                if let Some(most) = schema["maxItems"].as_u64()
                    && schema["minItems"] != schema["maxItems"]
                {
                    self.lists.push((at.to_owned(), most));
                }
                for (k, inner) in list.iter().enumerate() {
                    self.value(&schema["items"], inner, &name, &format!("{at}/{k}"));
                }
            }
            _ => {}
        }
    }

    fn object(&mut self, schema: &'a Value, map: &Map<String, Value>, name: &str, at: &str) {
        let properties = schema["properties"].as_object().unwrap();
        self.known.extend(properties.keys().map(|key| format!("{name}.{key}")));
        for (key, inner) in map {
            self.seen.insert(format!("{name}.{key}"));
            let inner_name = format!("{name}.{key}");
            self.value(&properties[key], inner, &inner_name, &format!("{at}/{key}"));
        }
    }
}

/// Numbers just beyond the bounds of a schema.
fn beyond(schema: &Value, at: &str) -> Vec<Value> {
    let whole = schema["type"].to_string().contains("integer");
    let bound = |key: &str| schema[key].as_f64();
    let high = bound("maximum").unwrap_or_else(|| panic!("{at} has no greatest value: {schema}"));
    let least = bound("minimum");
    if whole {
        assert_eq!(least.map(|least| least.fract()), Some(0.0), "{at}: {schema}");
        return vec![json!(high as u64 + 1), json!(least.unwrap() as i64 - 1)];
    }
    let low = match (least, bound("exclusiveMinimum")) {
        (Some(least), None) => least - 1e-9 * (1.0 + least.abs()),
        (None | Some(0.0), Some(excluded)) => excluded,
        other => panic!("{at} has no least value, or two: {other:?}"),
    };
    vec![json!(high + 1e-9 * (1.0 + high.abs())), json!(low), json!(1e300), json!(-1e300)]
}

const PATH: &str =
    r#"[{ "time_s": 0, "offset_m": [0, 0, 0] }, { "time_s": 1, "offset_m": [0, 0, 1] }]"#;
const EFFECTS: &str = r#""gravity": { "m_s2": [0, 0, -9.81] },
    "contact": { "detection": "speculative", "recovery_speed_limit_m_s": 1 }"#;
const AIR: [&str; 2] = [
    r#""drag": { "quadratic": { "coefficient": 1, "density_kg_m3": 1.2 } },
        "wind": { "velocity_m_s": [1, 0, 0],
        "gust": { "amplitude_m_s": [1, 0, 0], "period_s": 1, "seed": 1, "start_s": 1 } }"#,
    r#""drag": { "linear": { "coefficient_n_s_per_m3": 1 } }"#,
];

fn obstacles() -> String {
    let rest = format!(r#""restitution": 0.5, "friction": 0.5, "path": {PATH}"#);
    format!(
        r#"[{{ "plane": {{ "point_m": [0, 0, 0], "normal": [0, 0, 1], {rest} }} }},
        {{ "box": {{ "center_m": [0, 0, 0], "size_m": [1, 1, 1], {rest} }} }},
        {{ "sphere": {{ "center_m": [0, 0, 0], "radius_m": 1, {rest} }} }},
        {{ "mesh": {{ "vertices_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
            "triangles": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], {rest} }} }}]"#
    )
}

const PIECES: &str =
    r#""pieces": [{ "up_to_strain": 0.1, "stiffness_n_per_m": 1 }, { "stiffness_n_per_m": 2 }]"#;

/// Three cloths that have all keys of a scene between them.
fn scenes() -> Vec<Value> {
    let stretch = format!(r#"{{ {PIECES}, "compression_stiffness_n_per_m": 1 }}"#);
    let scene = |cloth: &str, springs: &str, air: &str, pins: &str| {
        let text = format!(
            r#"{{ "format": "drape-scene/1", "name": "x", "description": "", "assumed": [],
                "cloth": {cloth},
            "effects": {{ {springs} {EFFECTS}, "air": {{ {air} }} }}, "damping": "full",
                "pins": {pins}, "obstacles": {}, "time": {{ "step_s": 0.1, "duration_s": 1 }} }}"#,
            obstacles()
        );
        serde_json::from_str(&text).unwrap()
    };
    let grid = r#"{ "grid": { "rows": 2, "columns": 3, "size_m": [1, 1], "center_m": [0, 0, 0],
        "mass_kg": 1, "velocity_m_s": [0, 0, 1] } }"#;
    let grid_springs = format!(
        r#""tension": {{ "warp": {stretch}, "weft": {{ "stiffness_n_per_m": 1 }},
            "damping_over_mass_per_s": 1 }},
        "shear": {{ {PIECES}, "compression_stiffness_n_per_m": 1, "damping_n_s_per_m": 1 }},
        "bending": {{ "stiffness_n_per_m": 1, "buckling_rigidity_n_m2": 1e-3 }},
        "shear_angle": {{ "stiffness_n_m": 1 }}, "bending_angle": {{ "stiffness_n_m": 1 }},
        "bending_hinge": {{ "stiffness_n_m": 1 }},"#
    );
    let grid_pins =
        format!(r#"[{{ "row": 0, "column": 0, "path": {PATH} }}, {{ "boundary": 0 }}]"#);
    let grid_pins = grid_pins.replace(r#"{ "boundary": 0 }"#, r#"{ "particle": 1 }"#);
    let mesh = r#"{ "mesh": { "file": "bundled:sheet.obj", "areal_density_kg_m2": 0.1, "scale": 1,
        "rotation": { "axis": [0, 0, 1], "angle_deg": 9 }, "translation_m": [0, 0, 1],
            "velocity_m_s": [0, 0, 1],
        "spin_rad_s": [0, 0, 1], "repair": true } }"#;
    let mesh_springs = r#""tension": { "stiffness_over_mass_per_s2": 1 },"#;
    let mesh_pins = r#"[{ "near_m": [0, 0, 0] }, { "within_m": [[-9, -9, -9], [9, 9, 9]] },
        { "boundary": 0 }]"#;
    let wool = r#""tension": { "fabric": "wool" },"#;
    let particles = r#"{ "particles": { "particles": { "mass_kg": [1, 1, 1],
        "position_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
            "velocity_m_s": [[0, 0, 0], [0, 0, 0], [0, 0, 0]] },
        "springs": [], "triangles": [[0, 1, 2]] } }"#;
    vec![
        scene(grid, &grid_springs, AIR[0], &grid_pins),
        scene(grid, wool, AIR[1], "[]"),
        scene(mesh, mesh_springs, AIR[0], mesh_pins),
        scene(particles, "", AIR[0], "[]"),
        with_material(scene(grid, "", AIR[1], "[]")),
    ]
}

/// The scene with all keys of a material and a rotation.
fn with_material(mut scene: Value) -> Value {
    scene["material"] = json!({ "of": "denim", "areal_density_kg_m2": 0.2,
        "tension_n_per_m": { "warp": 300, "weft": 200 }, "shear_n_per_m": 20,
        "bending_n_m": { "warp": 1e-5, "weft": 2e-5 }, "retardation_s": 0.001,
        "shear_model": "angles", "bending_model": "hinges", "hinge_fit": "sheet",
        "directions": "woven" });
    scene["cloth"]["grid"]["rotation"] = json!({ "axis": [0, 0, 1], "angle_deg": 9 });
    scene
}

/// Two systems that have all keys between them.
fn systems() -> Vec<Value> {
    let system = |air: &str| {
        let text = format!(
            r#"{{ "format": "drape-system/1", "name": "x", "particles": {{ "mass_kg": [1, 1, 1, 1],
            "position_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]],
            "velocity_m_s": [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]] }},
            "springs": [{{ "effect": "bending", "i": 0, "j": 1, "rest_length_m": 1,
                "stiffness_n_per_m": 1,
                "damping_n_s_per_m": 1, {PIECES}, "compression_stiffness_n_per_m": 1,
                "buckling_rigidity_n_m2": 1e-3 }}],
            "angles": [{{ "effect": "shear_angle", "i": 1, "j": 0, "k": 2, "rest_rad": 1,
                "stiffness_n_m": 1 }}],
            "hinges": [{{ "i": 1, "j": 2, "k": 0, "l": 3, "rest_rad": 0, "stiffness_n_m": 1 }}],
            "damping": "full", "triangles": [[0, 1, 2]], "pins": [{{ "particle": 0,
                "path": {PATH} }}],
            "effects": {{ {EFFECTS}, "air": {{ {air} }} }}, "obstacles": {} }}"#,
            obstacles()
        );
        serde_json::from_str(&text).unwrap()
    };
    AIR.map(system).into()
}

fn check(schema: &Value, examples: &[Value]) {
    let validator = jsonschema::validator_for(schema).unwrap();
    let mut walk = Walk::new(schema);
    let refused = |example: &Value, what: &str| {
        assert!(!validator.is_valid(example), "the schema takes {what}");
        assert!(parse("example", &example.to_string()).is_err(), "the reader takes {what}");
    };
    for example in examples {
        parse("example", &example.to_string()).unwrap_or_else(|error| panic!("{error}"));
        let errors: Vec<_> = validator.iter_errors(example).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{errors:?}");
        walk.value(schema, example, "", "");
        for (at, schema) in std::mem::take(&mut walk.numbers) {
            for bad in beyond(schema, &at) {
                let mut broken = example.clone();
                *broken.pointer_mut(&at).unwrap() = bad.clone();
                refused(&broken, &format!("{bad} as {at}"));
            }
        }
        // Longer lists would take their time.
        let lists = std::mem::take(&mut walk.lists).into_iter().filter(|(_, most)| *most < 2_000);
        for (at, most) in lists {
            let mut broken = example.clone();
            let list = broken.pointer_mut(&at).unwrap().as_array_mut().unwrap();
            list.resize(most as usize + 1, list[0].clone());
            refused(&broken, &format!("{} entries of {at}", most + 1));
        }
    }
    let unseen: Vec<_> = walk.known.difference(&walk.seen).collect();
    assert!(unseen.is_empty(), "no example has {unseen:?}");
}

#[test]
fn the_schema_of_scenes_bounds_every_number_as_the_reader_does() {
    // Only a bundled scene has a mesh's named group.
    let mut examples = scenes();
    examples.push(serde_json::from_str(bundled::text("drape-test").unwrap()).unwrap());
    let dir = tempfile::tempdir().unwrap();
    let table = dir.path().join("table.csv");
    let head = "density[kg.m-2], linear warp[SI*1e9], linear weft[SI*1e9]";
    std::fs::write(&table, format!("{head}\n0.1, 1, 2\n")).unwrap();
    let mut of_table = examples[1].clone();
    of_table["material"] = json!({ "of": table, "row": 1, "shear_n_per_m": 20,
        "tension_n_per_m": { "warp": 300, "weft": 200 } });
    examples.push(of_table);
    check(schemars::schema_for!(Scene).as_value(), &examples);
}

#[test]
fn the_schema_of_systems_bounds_every_number_as_the_reader_does() {
    check(schemars::schema_for!(SystemSpec).as_value(), &systems());
}
