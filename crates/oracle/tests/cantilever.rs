//! Strips of every bending model on the master curve of the cantilever, under refinement.

#![allow(clippy::print_stderr, reason = "tables for people")]

use drape_model::fabric::{
    BendingModel, HingeFit, MaterialChoice, ShearModel, Strip, TriangleStrip, Woven,
};
use drape_oracle::elastica::cantilever;
use drape_oracle::statics::rest;

/// A nearly inextensible cloth with this `Γ` on a free length of 0.1 m.
fn strip(gamma: f64, segments: u32, rows: u32, width_m: f64, model: BendingModel) -> Strip {
    let (length_m, density) = (0.1_f64, 0.2);
    let bending = density * 9.81 * length_m.powi(3) / gamma;
    let material = MaterialChoice {
        areal_density_kg_m2: Some(density),
        tension_n_per_m: Some(Woven::even(2e5)),
        shear_n_per_m: Some(2e4),
        bending_n_m: Some(Woven::even(bending)),
        shear_model: ShearModel::Angles,
        bending_model: model,
        ..MaterialChoice::default()
    };
    Strip { length_m, width_m, segments, rows, material }
}

/// Drop over reach of the middle of the free end.
fn bent(strip: &Strip) -> f64 {
    let gamma = strip.gamma().expect("a material");
    let spec = strip.scene().discretise().unwrap_or_else(|violation| panic!("{violation}"));
    let (system, mut state) = spec.build().expect("a valid strip");
    let shape = cantilever(gamma);
    for (x, _) in state.x.iter_mut().zip(system.pinned()).filter(|(_, pinned)| !**pinned) {
        let [reach, height] = shape.at(x.x / strip.length_m);
        (x.x, x.z) = (reach * strip.length_m, height * strip.length_m);
    }
    let outcome = rest(&system, &mut state.x, 1e-7, 400);
    if outcome.residual > 1e-5 {
        eprintln!("not at rest: {} {:?} {outcome:?}", strip.segments, strip.material.bending_model);
    }
    let columns = strip.segments as usize + 1;
    let end: Vec<_> =
        (0..strip.rows as usize).map(|row| state.x[row * columns + columns - 1]).collect();
    let mean = |axis: usize| end.iter().map(|x| x[axis]).sum::<f64>() / end.len() as f64;
    -mean(2) / mean(0)
}

/// Width of so many rows of squares.
fn square(mut strip: Strip) -> Strip {
    strip.width_m = f64::from(strip.rows - 1) * strip.spacing_m();
    strip
}

/// Drop over reach of a strip of equilateral triangles with this many edges along the free length.
fn equilateral(gamma: f64, edges: usize, rows: usize, fit: HingeFit) -> f64 {
    let length_m = 0.1;
    let mut material = strip(gamma, 1, 2, 0.01, BendingModel::Hinges).material;
    material.hinge_fit = fit;
    let strip = TriangleStrip { length_m, segments: edges as u32, rows: rows as u32, material };
    let scene = strip.scene().unwrap_or_else(|violation| panic!("{violation}"));
    let spec = scene.discretise().unwrap_or_else(|violation| panic!("{violation}"));
    let (system, mut state) = spec.build().expect("a valid strip");
    let end: Vec<usize> = (0..state.len()).filter(|&i| state.x[i].x > length_m - 1e-9).collect();
    let shape = cantilever(gamma);
    for (x, _) in state.x.iter_mut().zip(system.pinned()).filter(|(_, pinned)| !**pinned) {
        let [reach, height] = shape.at(x.x / length_m);
        (x.x, x.z) = (reach * length_m, height * length_m);
    }
    let outcome = rest(&system, &mut state.x, 1e-7, 400);
    assert!(outcome.residual < 1e-5, "{outcome:?}");
    let sum = |axis: usize| end.iter().map(|&i| state.x[i][axis]).sum::<f64>();
    -sum(2) / sum(0)
}

/// Exact drop over reach.
fn exact(gamma: f64) -> f64 {
    cantilever(gamma).drop_over_reach()
}

#[test]
fn angles_follow_the_master_curve_with_second_order() {
    for gamma in [1.0, 4.0, 16.0] {
        let errors = [10, 20, 40].map(|n| {
            bent(&square(strip(gamma, n, 3, 0.02, BendingModel::Angles))) / exact(gamma) - 1.0
        });
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.15, "{gamma}: {errors:?}, order {order}");
        }
        assert!(errors[2].abs() < 1e-3, "{gamma}: {errors:?}");
    }
}

#[test]
fn a_strip_of_angles_is_as_stiff_per_width_as_a_sheet() {
    let of = |rows| bent(&square(strip(8.0, 20, rows, 0.0, BendingModel::Angles)));
    let (narrow, wide) = (of(2), of(15));
    assert!((narrow / wide - 1.0).abs() < 1e-5, "{narrow} {wide}");
}

#[test]
fn a_narrow_strip_of_a_grids_hinges_has_four_fifths_of_the_rigidity_of_the_sheet() {
    // Hinges fitted to the sheet bend as a strip of 5Γ/4; light ones, where the limit is clear.
    let of = |n, fit| {
        let mut strip = square(strip(0.5, n, 3, 0.0, BendingModel::Hinges));
        strip.material.hinge_fit = fit;
        bent(&strip)
    };
    let errors = [20, 40].map(|n| of(n, HingeFit::Sheet) / exact(0.5 * 1.25) - 1.0);
    let strip = [20, 40].map(|n| of(n, HingeFit::DiagonalStrip) / exact(0.5) - 1.0);
    for [coarse, fine] in [errors, strip] {
        assert!(fine.abs() < 0.02 && fine.abs() < 0.6 * coarse.abs(), "{coarse} {fine}");
    }
}

#[test]
fn a_narrow_strip_of_equilateral_hinges_needs_three_eighths_of_the_rigidity() {
    let errors = [10, 20, 30].map(|n| equilateral(1.0, n, 3, HingeFit::Strip) / exact(1.0) - 1.0);
    assert!(errors[2].abs() < 0.003 && errors[2].abs() < 0.1 * errors[0].abs(), "{errors:?}");
    // Fitted to the sheet, it bends as a strip of 9Γ/8.
    let sheet = equilateral(1.0, 30, 3, HingeFit::Sheet) / exact(9.0 / 8.0) - 1.0;
    assert!(sheet.abs() < 0.005, "{sheet}");
}

#[test]
#[ignore = "prints a table"]
fn table() {
    for gamma in [1.0, 2.0, 4.0, 8.0, 16.0] {
        for model in [BendingModel::Angles, BendingModel::Hinges] {
            let ratios = [10, 20, 40, 80]
                .map(|n| bent(&square(strip(gamma, n, 3, 0.02, model))) / exact(gamma) - 1.0);
            eprintln!("{gamma} {model:?} {:.4} {ratios:.5?}", exact(gamma));
        }
        let ratios = [5, 10].map(|n| {
            bent(&square(strip(gamma, n, 2, 0.02, BendingModel::Buckling))) / exact(gamma) - 1.0
        });
        eprintln!("{gamma} buckling, 5 and 10 segments {ratios:.5?}");
        let ratios = [10, 20, 30, 60].map(|n| equilateral(gamma, n, 7, HingeFit::Sheet));
        let strips = [10, 20, 30, 60].map(|n| equilateral(gamma, n, 3, HingeFit::Strip));
        eprintln!(
            "{gamma} equilateral: 7 rows, B/3 {ratios:.4?}, 9Γ/8 {:.4}; 3 rows, 3B/8 {strips:.4?}",
            exact(gamma * 9.0 / 8.0)
        );
    }
    for rows in [3, 5, 7, 15, 25] {
        let of = |fit| {
            let mut strip = square(strip(8.0, 30, rows, 0.1, BendingModel::Hinges));
            strip.material.hinge_fit = fit;
            bent(&strip)
        };
        let equal = equilateral(8.0, 30, rows as usize, HingeFit::Sheet);
        eprintln!(
            "{rows} rows, L/30: grid B/3 {:.4}, 5B/12 {:.4}; equilateral B/3 {equal:.4}",
            of(HingeFit::Sheet),
            of(HingeFit::DiagonalStrip)
        );
    }
    eprintln!("exact: Γ = 8 {:.4}, 9 {:.4}, 10 {:.4}", exact(8.0), exact(9.0), exact(10.0));
}
