//! Step size control, saved Jacobians and variable forcing with the real methods.

use drape_harness::methods::Choice;
use drape_integrator::{SolveStatus, StepReport};
use drape_model::{State, System};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::order::position_error;
use drape_oracle::reference::reference;
use drape_tests::{Sheet, apart, bundled, prepared, stir};

const FRAME: f64 = 0.01;

/// A sheet that swings and vibrates.
fn sheet() -> (System, State) {
    let sheet = Sheet { side: 6, shear: 500.0, damping: 2.0, ..Sheet::default() };
    stir(sheet.build(), 0.02, 0.0)
}

/// The position error after some frames, and the sum of the reports.
fn after(id: &str, frames: u32) -> (f64, u32, u32) {
    let (system, start) = sheet();
    let end = f64::from(frames) * FRAME;
    let exact = reference(&system, &start, &[end], AdaptiveSettings::default()).expect("smooth");
    let mut run = prepared(id, (system.clone(), start.clone()), FRAME);
    let (mut substeps, mut rejected) = (0, 0);
    for frame in 1..=frames {
        let before = run.state.t;
        let report = run.step();
        assert_eq!(run.state.t.to_bits(), (before + FRAME).to_bits(), "{id}: frame {frame}");
        assert_eq!(report.solve, SolveStatus::Converged, "{id}: frame {frame}");
        assert!(report.error_estimate <= 1.0, "{id}: {report:?}");
        substeps += report.substeps;
        rejected += report.rejected;
    }
    let error = position_error(&system, &start.x, &exact.states[0].x, &run.state.x);
    (error, substeps, rejected)
}

/// A tenth of the tolerance is at least two thirds of the error less (order 1: the step falls by
/// √10, and the error with it; order 2: by the power 2/3).
#[test]
fn the_error_of_adaptive_runs_falls_with_the_tolerance() {
    let methods = [
        ("backward-euler:", 0.5),
        ("bdf2:", 0.4),
        ("bdf2:steps=1,", 0.5),
        ("imex-euler:implicit=springs,forcing_term=1e-8,", 0.5),
        ("imex-updated:forcing_term=1e-6,", 0.5),
        ("imex-sbdf2:forcing_term=1e-8,", 0.4),
        ("imex-cnab2:forcing_term=1e-8,", 0.4),
        ("imex-mcnab2:forcing_term=1e-8,", 0.4),
    ];
    for (id, factor) in methods {
        let run = |tolerance: &str| after(&format!("{id}tolerance={tolerance}"), 20);
        let (loose, few, _) = run("1e-2");
        let (tight, many, rejected) = run("1e-3");
        assert!(many > few, "{id}: {few}, {many} substeps");
        assert!(tight < factor * loose, "{id}: error {loose:.2e}, then {tight:.2e}");
        assert!(rejected < many / 4, "{id}: {rejected} of {many} rejected");
    }
}

/// Whatever the linear systems are solved with, the residual is the same and so is the solution.
#[test]
fn saved_jacobians_and_conjugate_gradients_solve_the_same_equation() {
    let forms = [
        "solver=auto",
        "jacobian=saved",
        "solver=cg",
        "solver=cg,forcing=eisenstat-walker",
        "jacobian=saved,solver=cg,forcing=eisenstat-walker",
        "solver=multigrid",
        "solver=multigrid,forcing=eisenstat-walker",
    ];
    for method in ["backward-euler", "bdf2"] {
        for scene in ["hanging-textile-sheared-1e6", "square-table-1e4"] {
            let run = |form: &str| {
                let id = format!("{method}:residual=1e-12{form}");
                let mut run = prepared(&id, bundled(scene), FRAME);
                let reports = run.steps(15);
                (run.state, reports)
            };
            let (direct, direct_reports) = run(",solver=cholesky");
            let sum =
                |reports: &[StepReport]| -> u32 { reports.iter().map(|r| r.factorisations).sum() };
            for form in forms {
                let (other, reports) = run(&format!(",{form}"));
                let apart = apart(&direct.x, &other.x);
                assert!(apart < 1e-8, "{method}, {form} on {scene}: {apart:.2e} m");
                let (few, many) = (sum(&reports), sum(&direct_reports));
                assert!(few < many, "{method}, {form} on {scene}: {few} of {many} factorisations");
            }
        }
    }
}

#[test]
fn conjugate_gradients_with_a_fresh_jacobian_are_portable() {
    let portable = |id: &str| Choice::parse(id, &[]).expect("known").is_portable();
    assert!(portable("backward-euler:solver=cg") && portable("bdf2:solver=cg"));
    assert!(!portable("backward-euler") && !portable("bdf2:solver=cg,jacobian=saved"));
    assert!(!portable("bdf2:solver=multigrid"));
}

/// Updates solved by their progress end at the same fixed point.
#[test]
fn updated_cg_ends_where_it_did_whatever_the_forcing() {
    for safeguard in ["paper", "robust"] {
        let run = |forcing: &str| {
            let id = format!(
                "imex-updated:safeguard={safeguard},forcing_term=1e-9,max_outer=5000,forcing={forcing}"
            );
            let mut run = prepared(&id, sheet(), FRAME);
            run.steps(5);
            run.state.x
        };
        let (a, b) = (run("constant"), run("eisenstat-walker"));
        let apart = apart(&a, &b);
        assert!(apart < 1e-8, "{safeguard}: {apart:.2e} m");
    }
}

/// On its way through an impact an adaptive run neither hangs nor loses the table.
#[test]
fn an_adaptive_fall_on_a_table_ends_in_time() {
    for id in ["backward-euler:tolerance=0.1", "imex-sbdf2:tolerance=0.1", "bdf2:tolerance=0.1"] {
        let mut run = prepared(id, bundled("square-table-1e4"), FRAME);
        let substeps: u32 = (0..30).map(|_| run.step().substeps).sum();
        assert!(substeps < 1500, "{id}: {substeps}");
        let middle = run.state.x[10 * 20 + 10].z;
        assert!(run.state.is_finite() && middle > -0.05, "{id}: {middle}");
    }
}

#[test]
fn a_tolerance_is_refused_by_name_where_the_method_cannot_vary_its_steps() {
    let refusal = |id: &str| match Choice::parse(id, &[]) {
        Err(error) => error.to_string(),
        Ok(choice) => choice.build().err().map_or_else(String::new, |error| error.to_string()),
    };
    assert!(refusal("imex-cnlf:tolerance=0.1").contains("has no setting `tolerance`"));
    assert!(refusal("bdf2:steps=3,tolerance=0.1").contains("does not go with `steps=3`"));
    for bad in ["-1", "2", "1e-9", "nan", "x"] {
        let text = refusal(&format!("backward-euler:tolerance={bad}"));
        assert!(text.contains("expected 0 or a number from 1e-8 to 1e0"), "{text}");
    }
    assert_eq!(refusal("bdf2:steps=3,tolerance=0"), "");
}
