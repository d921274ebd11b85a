//! Scenes that serve for judging only: no rule, form or setting was chosen by looking at them.

use crate::HarnessError;
use crate::studies::sheet::{GRAVITY, Sheet};
use drape_model::{DampingLaw, KeyframeSpec, PinSpec, SystemSpec};

/// Simulated time, s: 30 frames.
pub(super) const DURATION_S: f64 = 0.5;
/// Largest errors that are asked for, over the longest side of the cloth.
const TARGETS: [f64; 2] = [0.01, 0.0025];

/// A scene of the facts.
#[derive(Clone, Copy)]
pub(super) struct Scene {
    pub(super) name: &'static str,
    pub(super) description: &'static str,
    /// Longest side of the cloth, m.
    size_m: f64,
    make: fn() -> Result<SystemSpec, HarnessError>,
}

/// A scene and the largest error that is asked for.
#[derive(Clone, Copy)]
pub(super) struct Question {
    pub(super) scene: Scene,
    pub(super) target_m: f64,
    /// Whether it belongs to the quick subset.
    pub(super) is_quick: bool,
}

impl Scene {
    /// The system of the scene.
    pub(super) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        (self.make)()
    }
}

/// The system of a grid, from JSON parts of a scene file.
fn grid(cloth: &str, effects: &str, rest: &str) -> Result<SystemSpec, HarnessError> {
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "held-out", "cloth": {{ "grid": {{ {cloth} }} }},
            "effects": {{ {effects}, "gravity": {{ "m_s2": [0, 0, -9.81] }} }}, {rest},
            "time": {{ "step_s": 0.01, "duration_s": 0.5 }} }}"#
    );
    Ok(drape_model::parse("held-out", &text)?.spec().clone())
}

/// The JSON text of a fabric with this tension (N/m), shear (N/m) and damping (N s/m).
fn fabric(tension: f64, shear: f64, damping: f64) -> String {
    let tenth = 0.1 * damping;
    format!(
        r#""tension": {{ "stiffness_n_per_m": {tension}, "damping_n_s_per_m": {damping} }},
           "shear": {{ "stiffness_n_per_m": {shear}, "damping_n_s_per_m": {tenth} }}"#
    )
}

fn strip() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""rows": 5, "columns": 21, "size_m": [1.0, 0.2], "center_m": [0, 0, 0],
        "mass_kg": 0.04"#;
    let bending = r#""bending": { "stiffness_n_per_m": 0.1, "damping_n_s_per_m": 1e-4 }"#;
    let effects = format!("{}, {bending}", fabric(80.0, 12.0, 0.01));
    grid(cloth, &effects, r#""pins": [{ "within_m": [[-0.51, -1, -1], [-0.49, 1, 1]] }]"#)
}

fn hammock() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""rows": 11, "columns": 12, "size_m": [1.2, 0.9], "center_m": [0, 0, 0],
        "mass_kg": 0.35"#;
    let pins = r#""pins": [{ "row": 0, "column": 0 }, { "row": 0, "column": 11 },
        { "row": 10, "column": 0 }, { "row": 10, "column": 11 }]"#;
    grid(cloth, &fabric(400.0, 90.0, 0.05), pins)
}

fn three_pegs() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""rows": 12, "columns": 11, "size_m": [0.7, 0.7], "center_m": [0, 0, 0],
        "mass_kg": 0.08, "rotation": { "axis": [1, 1, 0.3], "angle_deg": 40 }"#;
    let pins = r#""pins": [{ "row": 0, "column": 0 }, { "row": 5, "column": 10 },
        { "row": 11, "column": 3 }]"#;
    grid(cloth, &fabric(150.0, 8.0, 0.004), pins)
}

fn weighted_hem() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""rows": 14, "columns": 8, "size_m": [0.6, 1.1], "center_m": [0, 0, 0],
        "mass_kg": 0.13, "rotation": { "axis": [1, 0, 0], "angle_deg": 60 }"#;
    let pins = r#""pins": [{ "row": 13, "column": 0 }, { "row": 13, "column": 7 }]"#;
    let mut spec = grid(cloth, &fabric(900.0, 60.0, 0.03), pins)?;
    spec.particles.mass_kg[..8].iter_mut().for_each(|mass| *mass *= 25.0);
    Ok(spec)
}

/// An irregular mesh of triangles.
fn scrap() -> Result<SystemSpec, HarnessError> {
    Sheet {
        side: 11,
        tension: 2e5,
        shear: 0.0,
        damping: 6.0,
        law: DampingLaw::Full,
        gravity: GRAVITY,
        is_pinned: true,
    }
    .triangulated(0.2, 7)
}

/// An irregular mesh that is held by a particle inside.
fn napkin_on_peg() -> Result<SystemSpec, HarnessError> {
    let sheet = Sheet {
        side: 12,
        tension: 5e4,
        shear: 0.0,
        damping: 10.0,
        law: DampingLaw::Projected,
        gravity: GRAVITY,
        is_pinned: false,
    };
    let mut spec = sheet.triangulated(0.24, 8)?;
    spec.pins = vec![PinSpec::still(5 * 12 + 6)];
    Ok(spec)
}

fn tug() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""rows": 11, "columns": 11, "size_m": [0.8, 0.8], "center_m": [0, 0, 0],
        "mass_kg": 0.15"#;
    let pins = r#""pins": [{ "row": 0, "column": 0 }, { "row": 10, "column": 10 }]"#;
    let mut spec = grid(cloth, &fabric(250.0, 40.0, 0.08), pins)?;
    spec.pins[1].path = vec![
        KeyframeSpec { time_s: 0.1, offset_m: [0.0; 3] },
        KeyframeSpec { time_s: 0.35, offset_m: [-0.3, -0.2, 0.25] },
    ];
    Ok(spec)
}

fn taut_banner() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""rows": 12, "columns": 12, "size_m": [1.0, 1.0], "center_m": [0, 0, 0],
        "mass_kg": 0.2, "velocity_m_s": [0, 1.0, 0],
        "rotation": { "axis": [1, 0, 0], "angle_deg": 90 }"#;
    let pins = r#""pins": [{ "within_m": [[-1, -1, 0.49], [1, 1, 0.51]] }]"#;
    grid(cloth, &fabric(2000.0, 300.0, 0.02), pins)
}

fn canvas() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""rows": 12, "columns": 12, "size_m": [1.0, 1.0], "center_m": [0, 0, 0],
        "mass_kg": 0.4"#;
    let pins = r#""pins": [{ "row": 0, "column": 1 }, { "row": 3, "column": 11 }]"#;
    grid(cloth, &fabric(8000.0, 800.0, 2.0), pins)
}

fn kerchief() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""rows": 12, "columns": 12, "size_m": [0.6, 0.6], "center_m": [0, 0, 0],
        "mass_kg": 0.05, "rotation": { "axis": [0.3, 1, 0], "angle_deg": 70 }"#;
    let pins = r#""pins": [{ "row": 6, "column": 0 }, { "row": 0, "column": 4 }]"#;
    grid(cloth, &fabric(5000.0, 1500.0, 0.4), pins)
}

/// All scenes. They have springs, gravity and pins only, since the prices of work cover no other
/// effect.
fn scenes() -> Vec<Scene> {
    let scene = |name, size_m, description, make| Scene { name, description, size_m, make };
    vec![
        scene(
            "strip",
            1.0,
            "A strip that is held at one end and swings from the horizontal.",
            strip,
        ),
        scene("hammock", 1.2, "A heavy rectangle that is let go between four corners.", hammock),
        scene("three-pegs", 0.7, "A tilted square that hangs from three points.", three_pegs),
        scene(
            "weighted-hem",
            1.1,
            "A firm curtain, the hem of which is 25 times as heavy.",
            weighted_hem,
        ),
        scene("scrap", 1.0, "An irregular mesh of triangles that hangs by two corners.", scrap),
        scene("napkin-on-peg", 1.0, "An irregular mesh of triangles on a peg.", napkin_on_peg),
        scene("tug", 0.8, "A square between two corners, one of which is tugged.", tug),
        scene(
            "taut-banner",
            1.0,
            "A very firm banner that swings from its upper edge.",
            taut_banner,
        ),
        scene(
            "canvas",
            1.0,
            "A stiff and heavily damped sheet that is held at two places.",
            canvas,
        ),
        scene(
            "kerchief",
            0.6,
            "A light and stiff square that hangs from two places of its border.",
            kerchief,
        ),
    ]
}

/// All questions, scene by scene.
pub(super) fn questions() -> Vec<Question> {
    let of = |scene: Scene| {
        TARGETS.map(|target| {
            let is_quick = scene.name == "strip" && target == TARGETS[0];
            Question { scene, target_m: target * scene.size_m, is_quick }
        })
    };
    scenes().into_iter().flat_map(of).collect()
}
