//! Tension of a fabric: the springs of a sheet pull as its force-strain tests say.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{SystemSpec, Vec3, parse};

const ROWS: usize = 5;
const COLUMNS: usize = 4;

/// Steps of the strain between the pieces' ends, along x and y.
const STEP: [f64; 2] = [4.0 * 0.00048614, 4.0 * 0.004078];
/// Tension per width, N/m, of warp and weft there.
const TENSION: [[f64; 8]; 2] = [
    [0.0, 33.93213573, 79.6812749, 198.8071571, 476.1904762, 1069.306931, 1897.233202, 2998.027613],
    [0.0, 14.76377953, 48.4496124, 95.41984733, 211.4661654, 365.7407407, 656.9343066, 1052.158273],
];

/// A sheet whose cells are 0.1 m by 0.05 m.
fn sheet() -> SystemSpec {
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "wool",
            "cloth": {{ "grid": {{ "rows": {ROWS}, "columns": {COLUMNS}, "size_m": [0.3, 0.2],
                "center_m": [0, 0, 0],
                "mass_kg": 0.009 }} }},
            "effects": {{ "tension": {{ "fabric": "wool" }} }},
            "time": {{ "step_s": 0.001, "duration_s": 1 }} }}"#
    );
    parse("text", &text).unwrap().spec().clone()
}

/// Force per width, N/m, on the first column (axis 0) or row (axis 1) of a sheet that is stretched
/// by this strain along the axis. Every spring stands for a strip as wide as the mesh.
fn pull(axis: usize, strain: f64) -> f64 {
    let (system, mut state) = sheet().build().unwrap();
    state.x.iter_mut().for_each(|x| x[axis] *= 1.0 + strain);
    let mut force = vec![Vec3::zeros(); system.len()];
    system.forces(state.level(), &mut force);
    let edge: Vec<usize> = match axis {
        0 => (0..ROWS).map(|row| row * COLUMNS).collect(),
        _ => (0..COLUMNS).collect(),
    };
    let width = [0.05, 0.1][axis] * edge.len() as f64;
    edge.iter().map(|&i| force[i][axis]).sum::<f64>() / width
}

#[test]
fn a_stretched_sheet_pulls_with_the_measured_tension_per_width() {
    for axis in 0..2 {
        for (k, tension) in TENSION[axis].into_iter().enumerate() {
            let found = pull(axis, k as f64 * STEP[axis]);
            assert!(
                (found - tension).abs() < 1e-8 * TENSION[axis][7],
                "{axis} {k}: {found} {tension}"
            );
        }
        // Linear between two samples, and beyond the last one as before it.
        let [.., before, last] = TENSION[axis];
        for (at, expected) in [(6.5, 0.5 * (before + last)), (8.0, 2.0 * last - before)] {
            let found = pull(axis, at * STEP[axis]);
            assert!((found - expected).abs() < 1e-8 * last, "{axis} {at}: {found} {expected}");
        }
    }
}

#[test]
fn warp_is_an_order_of_magnitude_stiffer_than_weft() {
    for strain in [0.001, 0.005, 0.01, 0.013] {
        let [warp, weft] = [0, 1].map(|axis| pull(axis, strain));
        assert!(warp > 10.0 * weft, "{strain}: {warp} {weft}");
    }
}

#[test]
fn a_compressed_sheet_resists_with_a_tenth_of_the_first_slope() {
    for axis in 0..2 {
        let slope = TENSION[axis][1] / STEP[axis];
        let found = pull(axis, -0.01);
        assert!((found + 0.001 * slope).abs() < 1e-8 * slope, "{axis}: {found}");
    }
}
