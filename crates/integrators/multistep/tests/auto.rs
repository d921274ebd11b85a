//! `solver=auto`, the default, finds the solution of the factorisations, by the solver that fits
//! the stiffness.

use drape_integrator::{Integrator, PhaseClock, SolveStatus, TimeStep};
use drape_model::{State, System, Vec3};
use drape_multistep::{Bdf, BdfSettings};

/// A sheet of 12 × 12 particles with this `k/m`, 1/s², held by two corners, above a ball.
fn sheet(stiffness: f64, obstacle: bool) -> (System, State) {
    sheet_of(12, stiffness, obstacle)
}

/// The same with so many particles along an edge.
fn sheet_of(side: u32, stiffness: f64, obstacle: bool) -> (System, State) {
    let law = |factor: f64| {
        format!(
            r#"{{ "stiffness_over_mass_per_s2": {}, "damping_over_mass_per_s": {} }}"#,
            factor * stiffness,
            factor * 40.0
        )
    };
    let ball = r#", "obstacles": [{ "sphere": { "center_m": [0, 0, -0.31], "radius_m": 0.3 } }]"#;
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "sheet",
        "cloth": {{ "grid": {{ "rows": {side}, "columns": {side}, "size_m": [1, 1],
            "center_m": [0, 0, 0], "mass_kg": 0.4 }} }},
        "effects": {{ "tension": {}, "shear": {}, "bending": {},
            "gravity": {{ "m_s2": [0, 0, -9.81] }} }},
        "damping": "full",
        "pins": [{{ "row": 0, "column": 0 }}, {{ "row": 0, "column": {} }}],
        "time": {{ "step_s": 0.01, "duration_s": 1 }}{} }}"#,
        law(1.0),
        law(0.1),
        law(0.1),
        side - 1,
        if obstacle { ball } else { "" }
    );
    drape_model::parse("sheet", &text).expect("valid").spec().build().expect("valid")
}

/// What some steps took.
#[derive(Default)]
struct Work {
    newton: u32,
    cg: u32,
    products: u32,
}

/// The state after some steps, and what they took.
fn steps(start: &(System, State), settings: &[(&str, &str)], count: u32) -> (State, Work) {
    ended(start, settings, count, SolveStatus::Converged)
}

/// The same, where each solve has this end.
fn ended(
    start: &(System, State),
    settings: &[(&str, &str)],
    count: u32,
    end: SolveStatus,
) -> (State, Work) {
    let (system, mut state) = start.clone();
    let mut method = Bdf::new(BdfSettings::from_pairs(settings.to_vec()).expect("in range"));
    let h = TimeStep::new(0.01).expect("positive");
    method.prepare(&system, h).expect("supported");
    let mut work = Work::default();
    for _ in 0..count {
        let report = method.step(&system, &mut state, h, &mut PhaseClock::off()).expect("finite");
        assert_eq!(report.solve, end, "{settings:?}");
        work.newton += report.newton_iterations;
        work.cg += report.cg_iterations;
        work.products += report.matvecs;
    }
    (state, work)
}

/// The greatest distance of a particle from its place in another state, m.
fn apart(one: &[Vec3], other: &[Vec3]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn the_solution_is_that_of_factors_and_the_solver_follows_the_stiffness() {
    const LOOSE: (&str, &str) = ("forcing", "eisenstat-walker");
    for (stiffness, is_stiff) in [(1e4, false), (1e7, true)] {
        for obstacle in [false, true] {
            let start = sheet(stiffness, obstacle);
            let (expected, _) = steps(&start, &[("solver", "cholesky")], 15);
            let (found, work) = steps(&start, &[], 15);
            let apart = apart(&expected.x, &found.x);
            assert!(apart < 1e-7, "{stiffness:e}, {obstacle}: {apart:e}");
            let (_, by_blocks) = steps(&start, &[("solver", "cg"), LOOSE], 15);
            let saved = f64::from(by_blocks.cg) / f64::from(work.cg);
            assert_eq!(saved > 2.0, is_stiff, "{stiffness:e}, {obstacle}: {saved}");
        }
    }
}

/// A step with one linear solve, which no later one mends, has to solve it well: an Eisenstat-Walker
/// sequence starts at 0.5 or 0.03, and with that error the cloth hangs still or stretches. Both
/// forms start at the same candidate here.
#[test]
fn a_linearised_step_is_that_of_factors() {
    const ONCE: (&str, &str) = ("max_iterations", "1");
    for (side, stiffness) in [(12, 1e3), (12, 1e4), (12, 1e5), (12, 1e7), (34, 1e4), (34, 1e6)] {
        let start = sheet_of(side, stiffness, false);
        let run = |settings: &[(&str, &str)]| {
            let (state, work) = ended(&start, settings, 20, SolveStatus::IterationLimit);
            assert_eq!(work.newton, 20);
            state.x
        };
        let (expected, found) = (run(&[ONCE, ("solver", "cholesky")]), run(&[ONCE]));
        let (apart, moved) = (apart(&expected, &found), apart(&expected, &start.1.x));
        assert!(apart < 5e-4 * moved, "{side}, {stiffness:e}: {apart:e} m of {moved:e} m");
    }
}

/// From 1000 particles on, coarse matrices are kept, and without obstacles conjugate gradients run in
/// single precision: such a solve needs no product for its first residual.
#[test]
fn large_grids_end_at_the_same_solution_in_single_and_in_double_precision() {
    for stiffness in [1e3, 1e5, 1e6, 1e8] {
        for obstacle in [false, true] {
            let start = sheet_of(34, stiffness, obstacle);
            // From the eighth step on, three after the first contact, the stiffest sheet buckles on
            // the ball, and a step has several solutions.
            let count = if obstacle && stiffness > 1e7 { 7 } else { 15 };
            let (expected, _) = steps(&start, &[("solver", "cholesky")], count);
            let (found, work) = steps(&start, &[], count);
            let apart = apart(&expected.x, &found.x);
            assert!(work.cg > 0 && apart < 1e-7, "{stiffness:e}, {obstacle}: {apart:e}");
            let is_single = work.products < work.cg + work.newton;
            assert_eq!(is_single, !obstacle && stiffness <= 1e6, "{stiffness:e}, {obstacle}");
        }
    }
}
