//! The scene, and what is added to it.

use crate::HarnessError;
use drape_model::{SystemSpec, parse};
use drape_records::effects::{EVERYTHING, NOTHING};
use serde_json::{Value, json};

/// The scene to which effects are added.
pub(super) fn base() -> Value {
    json!({
        "format": "drape-scene/1", "name": "effects",
        "cloth": { "grid": {
            "rows": 20, "columns": 20, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 0.4 } },
        "effects": { "tension": { "stiffness_over_mass_per_s2": 1e4 }, "gravity": { "m_s2": [0, 0, -9.81] } },
        "pins": [{ "row": 0, "column": 0 }, { "row": 0, "column": 19 }],
        "time": { "step_s": 0.01, "duration_s": 0.5 }
    })
}

/// Something that is added to the scene.
#[derive(Clone, Debug)]
pub(super) struct Addition {
    pub(super) name: &'static str,
    /// Keys to be merged into the scene: objects key by key, lists by appending.
    pub(super) adds: Value,
    /// Whether it stands among all together; what takes the place of something else does not.
    is_among_all: bool,
}

impl Addition {
    fn new(name: &'static str, adds: Value) -> Self {
        Self { name, adds, is_among_all: true }
    }

    /// One that takes the place of another.
    fn instead(name: &'static str, adds: Value) -> Self {
        Self { is_among_all: false, ..Self::new(name, adds) }
    }
}

/// A ball below the sheet.
fn sphere(height: f64, radius: f64, restitution: f64) -> Value {
    json!({ "obstacles": [{ "sphere": {
        "center_m": [0, 0, height], "radius_m": radius, "restitution": restitution } }] })
}

/// Each addition by itself.
fn each() -> Vec<Addition> {
    let springs = |name, effect: &str, stiffness: f64| {
        Addition::new(
            name,
            json!({ "effects": { effect: { "stiffness_over_mass_per_s2": stiffness } } }),
        )
    };
    let damping = json!({ "effects": { "tension": { "damping_over_mass_per_s": 10 } } });
    let mut projected = damping.clone();
    merge(&mut projected, json!({ "damping": "projected" }));
    vec![
        springs("shear springs", "shear", 1e3),
        springs("bending springs", "bending", 1e2),
        Addition::new("full damping", damping),
        Addition::instead("projected damping", projected),
        Addition::instead("obstacle out of reach", sphere(-9.0, 1.0, 0.0)),
        Addition::new("sphere", sphere(-0.35, 0.3, 0.0)),
        Addition::instead("bouncing sphere", sphere(-0.35, 0.3, 0.5)),
    ]
}

/// Nothing, each addition by itself, all together.
pub(super) fn all() -> Vec<Addition> {
    let mut additions = vec![Addition::new(NOTHING, json!({}))];
    additions.extend(each());
    let mut together = json!({});
    for addition in additions.iter().filter(|addition| addition.is_among_all) {
        merge(&mut together, addition.adds.clone());
    }
    additions.push(Addition::new(EVERYTHING, together));
    additions
}

/// The scene with more keys, discretised.
///
/// # Errors
/// What is wrong with them.
pub(super) fn scene(name: &str, adds: &Value) -> Result<SystemSpec, HarnessError> {
    let mut scene = base();
    merge(&mut scene, adds.clone());
    Ok(parse(name, &scene.to_string())?.spec().clone())
}

/// Merges objects key by key, appends lists, replaces everything else.
fn merge(into: &mut Value, more: Value) {
    match (into, more) {
        (Value::Object(into), Value::Object(more)) => {
            for (key, value) in more {
                merge(into.entry(key).or_insert(Value::Null), value);
            }
        }
        (Value::Array(into), Value::Array(more)) => into.extend(more),
        (into, more) => *into = more,
    }
}
