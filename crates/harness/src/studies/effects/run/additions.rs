//! The bare scene and the additions.

use crate::HarnessError;
use crate::studies::effects::facts::{EVERYTHING, NOTHING};
use drape_model::{SystemSpec, parse};
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

/// An addition to the scene.
#[derive(Clone, Debug)]
pub(super) struct Addition {
    pub(super) name: &'static str,
    /// Keys to merge into the scene. Objects are merged key by key, lists are appended, and `null`
    /// removes a key.
    pub(super) adds: Value,
    /// Name of the addition that holds the same place in all together; `None` if this addition
    /// does.
    pub(super) holder: Option<&'static str>,
}

impl Addition {
    fn new(name: &'static str, adds: Value) -> Self {
        Self { name, adds, holder: None }
    }

    /// An addition that all together leaves out, since `holder` has its place there.
    fn instead(holder: &'static str, name: &'static str, adds: Value) -> Self {
        Self { holder: Some(holder), ..Self::new(name, adds) }
    }
}

/// A ball below the sheet, with further keys.
fn sphere(height: f64, more: Value) -> Value {
    let mut sphere = json!({ "center_m": [0, 0, height], "radius_m": 0.3 });
    merge(&mut sphere, more);
    json!({ "obstacles": [{ "sphere": sphere }] })
}

/// Height of the centre of a ball on which the sheet falls, m.
const BELOW: f64 = -0.35;

/// An octahedron below the sheet, as a mesh of triangles.
fn octahedron() -> Value {
    json!({ "obstacles": [{ "mesh": {
        "vertices_m": [
            [0.3, 0, BELOW], [0, 0.3, BELOW], [-0.3, 0, BELOW], [0, -0.3, BELOW],
            [0, 0, BELOW + 0.3], [0, 0, BELOW - 0.3]
        ],
        "triangles": [
            [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]
        ] } }] })
}

/// Drag of a sheet in a wind, or in still air.
fn air(wind: Option<Value>) -> Value {
    let mut air = json!({ "drag": { "quadratic": { "coefficient": 1.2 } } });
    if let Some(wind) = wind {
        merge(&mut air, json!({ "wind": wind }));
    }
    json!({ "effects": { "air": air } })
}

/// Name of the tension springs of the bare scene.
const BARE: &str = "tension springs";

/// The additions, each by itself.
///
/// All together has one addition for each place of a scene: one law of tension, of shear, of
/// bending and of damping, one air and one obstacle. A key holds only one law. Two resistances to
/// the same shape, or two balls at one place, would be a scene that nobody writes. All together
/// therefore leaves the others out.
fn each() -> Vec<Addition> {
    let effect = |key: &str, law: Value| json!({ "effects": { key: law } });
    let springs = |stiffness: f64| json!({ "stiffness_over_mass_per_s2": stiffness });
    let angles = |stiffness: f64| json!({ "stiffness_n_m": stiffness });
    let damping = effect("tension", json!({ "damping_over_mass_per_s": 10 }));
    let mut projected = damping.clone();
    merge(&mut projected, json!({ "damping": "projected" }));
    let mut buckling = springs(1e2);
    merge(&mut buckling, json!({ "buckling_rigidity_n_m2": 1e-7 }));
    let pieces = json!({
        "stiffness_over_mass_per_s2": null,
        "pieces": [{ "up_to_strain": 0.02, "stiffness_n_per_m": 10 }, { "stiffness_n_per_m": 100 }]
    });
    let steady = json!({ "velocity_m_s": [0, 3, 0] });
    let gusting = json!({
        "velocity_m_s": [0, 3, 0],
        "gust": { "amplitude_m_s": [1, 1, 0.5], "period_s": 0.2, "seed": 1 }
    });
    let led = json!({ "pins": [{
        "row": 19, "column": 10,
        "path": [{ "time_s": 0.25, "offset_m": [0, 0, 0.2] }, { "time_s": 0.5, "offset_m": [0, 0, 0] }]
    }] });
    let rising = json!({ "path": [{ "time_s": 0.5, "offset_m": [0, 0, 0.2] }] });
    vec![
        Addition::instead(BARE, "tension in pieces", effect("tension", pieces)),
        Addition::new("shear springs", effect("shear", springs(1e3))),
        Addition::instead("shear springs", "shear by angle", effect("shear_angle", angles(1e-3))),
        Addition::new("bending springs", effect("bending", springs(1e2))),
        Addition::instead(
            "bending springs",
            "bending springs that buckle",
            effect("bending", buckling),
        ),
        Addition::instead(
            "bending springs",
            "bending by angle",
            effect("bending_angle", angles(1e-5)),
        ),
        Addition::instead(
            "bending springs",
            "bending over hinges",
            effect("bending_hinge", angles(1e-6)),
        ),
        Addition::new("full damping", damping),
        Addition::instead("full damping", "projected damping", projected),
        Addition::instead("gusting wind", "drag in still air", air(None)),
        Addition::instead("gusting wind", "steady wind", air(Some(steady))),
        Addition::new("gusting wind", air(Some(gusting))),
        Addition::new("pin on a path", led),
        Addition::instead("rough sphere", "obstacle out of reach", sphere(-9.0, json!({}))),
        Addition::instead("rough sphere", "sphere", sphere(BELOW, json!({}))),
        Addition::instead(
            "rough sphere",
            "bouncing sphere",
            sphere(BELOW, json!({ "restitution": 0.5 })),
        ),
        Addition::new("rough sphere", sphere(BELOW, json!({ "friction": 0.5 }))),
        Addition::instead("rough sphere", "rising sphere", sphere(BELOW - 0.2, rising)),
        Addition::instead("rough sphere", "obstacle of triangles", octahedron()),
    ]
}

/// All additions: nothing, each by itself, and all together.
pub(super) fn all() -> Vec<Addition> {
    let mut additions = vec![Addition::new(NOTHING, json!({}))];
    additions.extend(each());
    let mut together = json!({});
    for addition in additions.iter().filter(|addition| addition.holder.is_none()) {
        merge(&mut together, addition.adds.clone());
    }
    additions.push(Addition::new(EVERYTHING, together));
    additions
}

/// The scene with additional keys, discretised.
///
/// # Errors
/// [`HarnessError`] if the scene with these keys is not valid.
pub(super) fn scene(name: &str, adds: &Value) -> Result<SystemSpec, HarnessError> {
    let mut scene = base();
    merge(&mut scene, adds.clone());
    Ok(parse(name, &scene.to_string())?.spec().clone())
}

/// Merges objects key by key, appends lists and replaces everything else. `null` removes a key.
fn merge(into: &mut Value, more: Value) {
    match (into, more) {
        (Value::Object(into), Value::Object(more)) => {
            for (key, value) in more {
                match value {
                    Value::Null if into.remove(&key).is_some() => {}
                    value => merge(into.entry(key).or_insert(Value::Null), value),
                }
            }
        }
        (Value::Array(into), Value::Array(more)) => into.extend(more),
        (into, more) => *into = more,
    }
}
