//! Scenes with contact, friction, wind, hinges and angles. They serve for judging only: no rule,
//! form or setting was chosen by looking at them.

use crate::HarnessError;
use drape_model::SystemSpec;

type Make = fn() -> Result<SystemSpec, HarnessError>;

/// Name and system of each scene.
pub(super) const SCENES: &[(&str, Make)] = &[
    ("towel-on-box", towel_on_box),
    ("scarf-on-ball", scarf_on_ball),
    ("sliding-cloth", sliding_cloth),
    ("rising-ball", rising_ball),
    ("flat-landing", flat_landing),
    ("pennant", pennant),
    ("laundry-in-gusts", laundry_in_gusts),
    ("falling-leaf", falling_leaf),
    ("hinged-strip", hinged_strip),
    ("hinged-mesh-in-wind", hinged_mesh_in_wind),
    ("angles-on-peg", angles_on_peg),
    ("dragged-cloth", dragged_cloth),
    // Made after these scenes had led to the first two rules of the comparison.
    ("blanket-over-edge", blanket_over_edge),
    ("banner-in-squall", banner_in_squall),
    ("cloth-on-two-balls", cloth_on_two_balls),
    // Made after the last rule.
    ("tarpaulin-on-edge", tarpaulin_on_edge),
    ("kite-on-strings", kite_on_strings),
    ("napkin-thrown", napkin_thrown),
];

fn read(cloth: &str, effects: &str, rest: &str) -> Result<SystemSpec, HarnessError> {
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "held-out", "cloth": {{ {cloth} }},
            "effects": {{ {effects}, "gravity": {{ "m_s2": [0, 0, -9.81] }} }}, {rest}
            "time": {{ "step_s": 0.01, "duration_s": 0.5 }} }}"#
    );
    Ok(drape_model::parse("held-out", &text)?.spec().clone())
}

/// A tablecloth-weight towel that falls across a box, off its middle.
fn towel_on_box() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 13, "columns": 17, "size_m": [0.8, 0.6],
        "center_m": [0.07, 0.02, 0.01], "mass_kg": 0.14 }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 180, "damping_n_s_per_m": 0.02 },
        "shear": { "stiffness_n_per_m": 30, "damping_n_s_per_m": 0.003 }"#;
    let rest = r#""obstacles": [{ "box": { "center_m": [0, 0, -0.1], "size_m": [0.4, 0.3, 0.2],
        "friction": 0.5 } }],"#;
    read(cloth, effects, rest)
}

/// A light square on a ball with much friction.
fn scarf_on_ball() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 15, "columns": 15, "size_m": [0.7, 0.7],
        "center_m": [0.03, -0.05, 0.26], "mass_kg": 0.04 }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 60, "damping_n_s_per_m": 0.006 },
        "shear": { "stiffness_n_per_m": 6, "damping_n_s_per_m": 0.0006 },
        "bending": { "stiffness_n_per_m": 0.05, "damping_n_s_per_m": 0.0001 }"#;
    let rest = r#""obstacles": [{ "sphere": { "center_m": [0, 0, 0], "radius_m": 0.25,
        "friction": 0.8 } }],"#;
    read(cloth, effects, rest)
}

/// A cloth that slides down a slope with little friction.
fn sliding_cloth() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 10, "columns": 14, "size_m": [0.6, 0.4],
        "center_m": [0, 0, 0.002], "mass_kg": 0.06,
        "rotation": { "axis": [0, 1, 0], "angle_deg": 35 }, "velocity_m_s": [0.3, 0.2, 0] }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 250, "damping_n_s_per_m": 0.03 },
        "shear": { "stiffness_n_per_m": 40, "damping_n_s_per_m": 0.004 }"#;
    let rest = r#""obstacles": [{ "plane": { "point_m": [0, 0, 0],
        "normal": [0.573576, 0, 0.819152], "friction": 0.2 } }],"#;
    read(cloth, effects, rest)
}

/// A hanging sheet that a ball pushes from below.
fn rising_ball() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 14, "columns": 14, "size_m": [0.9, 0.9],
        "center_m": [0, 0, 0], "mass_kg": 0.16 }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 120, "damping_n_s_per_m": 0.02 },
        "shear": { "stiffness_n_per_m": 15, "damping_n_s_per_m": 0.002 }"#;
    let rest = r#""pins": [{ "row": 0, "column": 0 }, { "row": 0, "column": 13 },
        { "row": 13, "column": 0 }, { "row": 13, "column": 13 }],
        "obstacles": [{ "sphere": { "center_m": [0.1, 0.05, -0.35], "radius_m": 0.2,
        "friction": 0.3, "path": [{ "time_s": 0.1, "offset_m": [0, 0, 0] },
        { "time_s": 0.45, "offset_m": [0, 0, 0.3] }] } }],"#;
    read(cloth, effects, rest)
}

/// A tilted sheet that falls flat on a floor.
fn flat_landing() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 12, "columns": 12, "size_m": [0.5, 0.5],
        "center_m": [0, 0, 0.12], "mass_kg": 0.05,
        "rotation": { "axis": [1, 0.4, 0], "angle_deg": 20 } }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 90, "damping_n_s_per_m": 0.02 },
        "shear": { "stiffness_n_per_m": 12, "damping_n_s_per_m": 0.002 }"#;
    let rest = r#""obstacles": [{ "plane": { "point_m": [0, 0, -0.05], "normal": [0, 0, 1],
        "friction": 0.4 } }],"#;
    read(cloth, effects, rest)
}

/// A narrow flag in a steady wind.
fn pennant() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 7, "columns": 21, "size_m": [1.0, 0.3],
        "center_m": [0, 0, 0], "mass_kg": 0.03,
        "rotation": { "axis": [1, 0, 0], "angle_deg": 90 } }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 70, "damping_n_s_per_m": 0.005 },
        "shear": { "stiffness_n_per_m": 9, "damping_n_s_per_m": 0.0006 },
        "air": { "drag": { "quadratic": { "coefficient": 1.1 } },
            "wind": { "velocity_m_s": [6, 1.5, 0] } }"#;
    let rest = r#""pins": [{ "within_m": [[-0.51, -1, -1], [-0.49, 1, 1]] }],"#;
    read(cloth, effects, rest)
}

/// A sheet on a line, in gusts across it.
fn laundry_in_gusts() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 13, "columns": 13, "size_m": [0.8, 0.8],
        "center_m": [0, 0, 0], "mass_kg": 0.13,
        "rotation": { "axis": [1, 0, 0], "angle_deg": 90 } }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 140, "damping_n_s_per_m": 0.01 },
        "shear": { "stiffness_n_per_m": 25, "damping_n_s_per_m": 0.002 },
        "bending": { "stiffness_n_per_m": 0.2, "damping_n_s_per_m": 0.0002 },
        "air": { "drag": { "quadratic": { "coefficient": 1.3 } },
            "wind": { "velocity_m_s": [0.5, 3, 0], "gust": { "amplitude_m_s": [1, 3, 0.3],
            "period_s": 0.7, "seed": 3 } } }"#;
    let rest = r#""pins": [{ "within_m": [[-1, -1, 0.39], [1, 1, 0.41]] }],"#;
    read(cloth, effects, rest)
}

/// A free square that falls through still air.
fn falling_leaf() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 11, "columns": 11, "size_m": [0.4, 0.4],
        "center_m": [0, 0, 1], "mass_kg": 0.012,
        "rotation": { "axis": [0.2, 1, 0], "angle_deg": 30 } }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 40, "damping_n_s_per_m": 0.002 },
        "shear": { "stiffness_n_per_m": 8, "damping_n_s_per_m": 0.0005 },
        "bending": { "stiffness_n_per_m": 0.1, "damping_n_s_per_m": 0.00005 },
        "air": { "drag": { "quadratic": { "coefficient": 1.2 } } }"#;
    read(cloth, effects, "")
}

/// A strip with hinges, held at one end.
fn hinged_strip() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 5, "columns": 25, "size_m": [0.6, 0.1],
        "center_m": [0, 0, 0], "mass_kg": 0.015 }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 60, "damping_n_s_per_m": 0.004 },
        "shear": { "stiffness_n_per_m": 20, "damping_n_s_per_m": 0.001 },
        "bending_hinge": { "stiffness_n_m": 2e-5 }"#;
    let rest = r#""pins": [{ "within_m": [[-0.31, -1, -1], [-0.27, 1, 1]] }],"#;
    read(cloth, effects, rest)
}

/// A mesh with hinges on a pole, in wind.
fn hinged_mesh_in_wind() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""mesh": { "file": "bundled:sheet.obj", "areal_density_kg_m2": 0.18,
        "scale": 0.6, "rotation": { "axis": [1, 0, 0], "angle_deg": 90 } }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 80, "damping_n_s_per_m": 0.01 },
        "bending_hinge": { "stiffness_n_m": 1e-5 },
        "air": { "drag": { "quadratic": { "coefficient": 1.2 } },
            "wind": { "velocity_m_s": [4, 2, 0] } }"#;
    let rest = r#""pins": [{ "within_m": [[-0.46, -1, -1], [-0.44, 1, 1]] }],"#;
    read(cloth, effects, rest)
}

/// A square whose shear and bending are angles, on a peg.
fn angles_on_peg() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 12, "columns": 12, "size_m": [0.6, 0.6],
        "center_m": [0, 0, 0], "mass_kg": 0.07 }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 110, "damping_n_s_per_m": 0.008 },
        "shear_angle": { "stiffness_n_m": 1e-3 }, "bending_angle": { "stiffness_n_m": 2e-5 }"#;
    read(cloth, effects, r#""pins": [{ "row": 4, "column": 7 }],"#)
}

/// A cloth on a floor that is pulled along by a corner.
fn dragged_cloth() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 12, "columns": 12, "size_m": [0.6, 0.6],
        "center_m": [0, 0, 0.001], "mass_kg": 0.08 }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 160, "damping_n_s_per_m": 0.02 },
        "shear": { "stiffness_n_per_m": 20, "damping_n_s_per_m": 0.002 }"#;
    let rest = r#""pins": [{ "row": 0, "column": 0, "path": [
        { "time_s": 0.05, "offset_m": [0, 0, 0] }, { "time_s": 0.45, "offset_m": [-0.3, -0.1, 0.1] }] }],
        "obstacles": [{ "plane": { "point_m": [0, 0, 0], "normal": [0, 0, 1], "friction": 0.35 } }],"#;
    read(cloth, effects, rest)
}

/// A heavy blanket, half of which hangs over the edge of a box.
fn blanket_over_edge() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 11, "columns": 19, "size_m": [1.1, 0.6],
        "center_m": [0.45, 0, 0.01], "mass_kg": 0.4 }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 420, "damping_n_s_per_m": 0.05 },
        "shear": { "stiffness_n_per_m": 55, "damping_n_s_per_m": 0.006 },
        "bending": { "stiffness_n_per_m": 1.5, "damping_n_s_per_m": 0.001 }"#;
    let rest = r#""obstacles": [{ "box": { "center_m": [0, 0, -0.15], "size_m": [0.9, 0.9, 0.3],
        "friction": 0.6 } }],"#;
    read(cloth, effects, rest)
}

/// A light banner between two poles, pressed by a squall.
fn banner_in_squall() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 9, "columns": 17, "size_m": [1.2, 0.5],
        "center_m": [0, 0, 0], "mass_kg": 0.05,
        "rotation": { "axis": [1, 0, 0], "angle_deg": 90 } }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 300, "damping_n_s_per_m": 0.01 },
        "shear": { "stiffness_n_per_m": 30, "damping_n_s_per_m": 0.001 },
        "air": { "drag": { "quadratic": { "coefficient": 1.2 } },
            "wind": { "velocity_m_s": [1, 7, 0], "gust": { "amplitude_m_s": [0, 4, 1],
            "period_s": 0.4, "seed": 8 } } }"#;
    let rest = r#""pins": [{ "within_m": [[-0.61, -1, -1], [-0.59, 1, 1]] },
        { "within_m": [[0.59, -1, -1], [0.61, 1, 1]] }],"#;
    read(cloth, effects, rest)
}

/// A square that falls between two balls of unlike size.
fn cloth_on_two_balls() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 14, "columns": 14, "size_m": [0.7, 0.7],
        "center_m": [0.02, -0.03, 0.2], "mass_kg": 0.09 }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 130, "damping_n_s_per_m": 0.012 },
        "shear": { "stiffness_n_per_m": 18, "damping_n_s_per_m": 0.0015 }"#;
    let rest = r#""obstacles": [{ "sphere": { "center_m": [-0.22, 0, 0], "radius_m": 0.17,
        "friction": 0.5 } }, { "sphere": { "center_m": [0.25, 0.05, -0.03], "radius_m": 0.12,
        "friction": 0.2 } }],"#;
    read(cloth, effects, rest)
}

/// A stiff sheet that stands almost upright on a floor and falls over.
fn tarpaulin_on_edge() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 13, "columns": 13, "size_m": [0.8, 0.8],
        "center_m": [0, 0, 0.41], "mass_kg": 0.35,
        "rotation": { "axis": [1, 0.1, 0], "angle_deg": 78 } }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 900, "damping_n_s_per_m": 0.06 },
        "shear": { "stiffness_n_per_m": 200, "damping_n_s_per_m": 0.01 },
        "bending": { "stiffness_n_per_m": 6, "damping_n_s_per_m": 0.003 }"#;
    let rest = r#""obstacles": [{ "plane": { "point_m": [0, 0, 0], "normal": [0, 0, 1],
        "friction": 0.7 } }],"#;
    read(cloth, effects, rest)
}

/// A diamond that two corners hold in a wind from below.
fn kite_on_strings() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 12, "columns": 15, "size_m": [0.7, 0.5],
        "center_m": [0, 0, 0], "mass_kg": 0.03,
        "rotation": { "axis": [0, 1, 0], "angle_deg": 25 } }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 100, "damping_n_s_per_m": 0.004 },
        "shear": { "stiffness_n_per_m": 25, "damping_n_s_per_m": 0.001 },
        "bending": { "stiffness_n_per_m": 0.3, "damping_n_s_per_m": 0.0002 },
        "air": { "drag": { "quadratic": { "coefficient": 1.2 } },
            "wind": { "velocity_m_s": [2, 0.5, 4] } }"#;
    let rest = r#""pins": [{ "row": 0, "column": 0 }, { "row": 11, "column": 14 }],"#;
    read(cloth, effects, rest)
}

/// A napkin that is thrown at a box and slides off.
fn napkin_thrown() -> Result<SystemSpec, HarnessError> {
    let cloth = r#""grid": { "rows": 11, "columns": 11, "size_m": [0.4, 0.4],
        "center_m": [-0.25, 0.03, 0.12], "mass_kg": 0.02, "velocity_m_s": [1.2, 0, 0],
        "rotation": { "axis": [0.3, 1, 0], "angle_deg": -40 } }"#;
    let effects = r#""tension": { "stiffness_n_per_m": 70, "damping_n_s_per_m": 0.005 },
        "shear": { "stiffness_n_per_m": 10, "damping_n_s_per_m": 0.0008 }"#;
    let rest = r#""obstacles": [{ "box": { "center_m": [0.2, 0, 0], "size_m": [0.3, 0.5, 0.2],
        "friction": 0.3 } }],"#;
    read(cloth, effects, rest)
}
