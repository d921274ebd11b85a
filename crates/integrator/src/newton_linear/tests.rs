use super::*;
use crate::random::Lcg;
use crate::{Implicit, ImplicitStage};
use drape_model::{State, parse};
use drape_solvers::{Coupling, LinearOperator, vector::dot, vector::norm};

const H: f64 = 0.01;
const OBSTACLE: &str = r#", "obstacles": [{ "plane": { "point_m": [0, 0, -9],
    "normal": [0, 0, 1] } }]"#;

/// A free sheet of `side` × `side` particles on tension springs, with `h² Σ k/m = theta` inside, in
/// random motion. It is light, so that single precision cannot hold another mass beside it, and so
/// slow that the exact Hessian is positive definite. `more` are further keys of the scene.
fn sheet(side: u32, theta: f64, more: &str) -> (System, State) {
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "sheet",
        "cloth": {{ "grid": {{ "rows": {side}, "columns": {side}, "size_m": [1, 1],
            "center_m": [0, 0, 0], "mass_kg": 4e-17 }} }},
        "effects": {{ "tension": {{ "stiffness_over_mass_per_s2": {} }} }},
        "time": {{ "step_s": {H}, "duration_s": 1 }}{more} }}"#,
        theta / (4.0 * H * H)
    );
    let (system, mut state) = parse("sheet", &text).expect("valid").spec().build().expect("valid");
    let mut random = Lcg::new();
    state.v.iter_mut().for_each(|v| *v = Vec3::from_fn(|_, _| 1e-6 * random.signed()));
    (system, state)
}

/// The linear systems of the first Newton iteration of a step.
struct First {
    system: System,
    potential: IncrementalPotential,
    matrix: NewtonMatrix,
    gradient: Vec<Vec3>,
    direction: Vec<Vec3>,
}

impl First {
    fn new((system, state): (System, State)) -> Self {
        let mut potential = IncrementalPotential::new(&system, Implicit::Everything);
        let linear = NewtonLinear::default();
        let mut matrix = NewtonMatrix::new(&system, &potential, linear).expect("a pattern");
        let none = vec![Vec3::zeros(); system.len()];
        potential.begin(&system, H, (&state.x, &state.v), state.level(), &none);
        let gradient = potential.gradient(&system, &state.v).to_vec();
        matrix.begin();
        Self { system, potential, matrix, gradient, direction: none }
    }

    /// Solves it, checks the residual, and returns the costs.
    fn solve(&mut self, forcing: f64) -> NewtonReport {
        let Self { system, potential, matrix, gradient, direction } = self;
        let (none, mut report) = (Constraints::free(system.len()), NewtonReport::default());
        let how = (NewtonLinear::default(), forcing);
        let vectors = (&gradient[..], &mut direction[..]);
        matrix.solve(system, potential, &none, how, vectors, &mut report).expect("solved");
        let solved = match &matrix.stiff {
            Some(stiff) if matrix.is_stiff(potential) => &stiff.matrix,
            _ => &matrix.matrix,
        };
        let mut left = direction.clone();
        solved.multiply(direction, &mut left);
        left.iter_mut().zip(&*gradient).for_each(|(left, g)| *left -= g);
        assert!(norm(&left) < 1.05 * forcing * norm(gradient));
        assert!(dot(gradient, direction) > 0.0, "it descends");
        report
    }

    fn by_multigrid(&self) -> bool {
        self.matrix.stiff.as_ref().is_some_and(|stiff| stiff.coarse_serves)
    }
}

#[test]
fn the_default_beside_a_saved_jacobian_is_the_saved_factor() {
    let (system, state) = sheet(8, 400.0, "");
    let potential = IncrementalPotential::new(&system, Implicit::Everything);
    let saved = NewtonLinear { jacobian: Jacobian::Saved, ..NewtonLinear::default() };
    let newton = crate::Newton::new(&system, &potential, saved).expect("a pattern");
    assert!(!newton.is_auto());
    assert_eq!(saved.resolved().solver, NewtonSolver::Cholesky);
    assert_eq!(NewtonLinear::default().resolved(), NewtonLinear::default());
    let run = |linear| {
        let mut stage = ImplicitStage::with_linear(&system, linear).expect("a pattern");
        let (mut contacts, mut constraints) =
            (crate::ContactSet::new(&system), Constraints::free(system.len()));
        let mut report = crate::StepReport::default();
        let input = crate::Stage {
            tau: H.into(),
            end: H,
            from: (&state.x, &state.v),
            lagged: state.level(),
            velocity: &state.v,
        };
        for _ in 0..3 {
            let settings = crate::StageSettings::default();
            let (contacts, constraints) = (&mut contacts, &mut constraints);
            let mut clock = crate::PhaseClock::off();
            stage
                .solve(
                    &system,
                    input,
                    &state.v,
                    contacts,
                    constraints,
                    settings,
                    &mut clock,
                    &mut report,
                )
                .expect("finite");
        }
        (stage.velocity().to_vec(), report)
    };
    let (v, report) = run(saved);
    assert_eq!((v, report), run(NewtonLinear { solver: NewtonSolver::Cholesky, ..saved }));
    assert!(report.factorisations > 0 && report.factorisations < report.newton_iterations);
    assert_eq!(report.cg_iterations, 0);
}

#[test]
fn single_precision_is_for_large_grids_without_obstacles() {
    for (side, more, expected) in [(34, "", true), (34, OBSTACLE, false), (20, "", false)] {
        for (theta, limit) in [(100.0, 1.0), (400.0, 1.0), (4000.0, 0.0)] {
            let mut first = First::new(sheet(side, theta, more));
            assert_eq!(first.matrix.single.is_some(), expected, "{side}, {more}");
            let report = first.solve(0.1);
            let in_single = report.matvecs == report.cg_iterations;
            assert_eq!(in_single, expected && limit > 0.0, "{side}, {more}, {theta}: {report:?}");
            let is_stiff = theta > if expected { 2000.0 } else { 200.0 };
            assert_eq!(first.by_multigrid(), is_stiff, "{side}, {more}, {theta}");
        }
    }
}

/// Only contacts and factors need compressed rows.
#[test]
fn stiff_stages_have_the_fast_layouts() {
    let cholesky = NewtonLinear::CHOLESKY;
    let auto = NewtonLinear::default();
    for (more, linear, expected) in [
        ("", auto, Coupling::Bands(vec![1, 12])),
        (OBSTACLE, auto, Coupling::Rows),
        ("", cholesky, Coupling::Rows),
    ] {
        let (system, _) = sheet(12, 400.0, more);
        let potential = IncrementalPotential::new(&system, Implicit::Everything);
        let matrix = NewtonMatrix::new(&system, &potential, linear).expect("a pattern");
        let stiff = matrix.stiff.as_deref().unwrap_or(&matrix);
        assert_eq!(stiff.matrix.coupling(), expected, "{more}, {linear:?}");
    }
}

/// A mass that single precision cannot hold beside the others, on the corner, which one coarse point
/// represents on each level: elsewhere coarse matrices may not hold it either. Its failure costs a product with
/// each of the two Hessians, which counts, and is not repeated in the stage.
#[test]
fn where_single_precision_fails_the_stiffness_chooses_as_without_it() {
    for (theta, is_stiff) in [(100.0, false), (400.0, true)] {
        let (mut system, state) = sheet(34, theta, "");
        let mut mass = system.mass().to_vec();
        mass[0] = 1e30;
        assert!(system.set_mass(&mass));
        let mut state = state;
        state.v[0] = Vec3::zeros();
        let mut first = First::new((system, state));
        assert!(first.matrix.single_serves);
        let once = first.solve(0.1);
        assert!(!first.matrix.single_serves, "{theta}");
        assert_eq!(first.by_multigrid(), is_stiff, "{theta}");
        let again = first.solve(0.1);
        let stiff = first.matrix.stiff.as_ref().expect("the default has one");
        let coarse = stiff.multigrid.as_ref().map_or(0, |multigrid| multigrid.products().update);
        let coarse = if is_stiff { coarse as u32 } else { 0 };
        assert_eq!(once.matvecs, again.matvecs + coarse + 2, "{theta}: {once:?}, {again:?}");
        assert_eq!(once.cg_iterations, again.cg_iterations, "{theta}");
        first.matrix.begin();
        assert!(first.matrix.single_serves, "the next stage tries again");
    }
}

/// Coarse matrices sum a mass with those beside it: what is left of these is rounding, and some
/// coarse matrix need not be positive definite.
#[test]
fn a_mass_beyond_all_digits_is_solved_wherever_it_is() {
    let mut without = 0;
    for heavy in (0..34 * 34).step_by(7) {
        let (mut system, mut state) = sheet(34, 400.0, "");
        let mut mass = system.mass().to_vec();
        mass[heavy] = 1e30;
        assert!(system.set_mass(&mass));
        state.v[heavy] = Vec3::zeros();
        let mut first = First::new((system, state));
        first.solve(0.1);
        without += u32::from(!first.by_multigrid());
    }
    assert!(without > 0, "none lost its coarse matrices");
}

/// Compressed springs make the exact Hessian indefinite. Single precision goes on with the projected
/// one, and the product that found it counts.
#[test]
fn an_indefinite_hessian_is_projected_in_single_precision() {
    // Each diagonal block stays positive definite: 1 − 4 · 100 · 0.0018 across the sheet.
    let (system, mut state) = sheet(34, 400.0, "");
    state.x.iter_mut().for_each(|x| *x *= 1.0 - 0.0018);
    state.v.iter_mut().for_each(|v| v.z *= 2e4);
    let mut first = First::new((system, state));
    let report = first.solve(1e-4);
    assert!(first.matrix.single_serves && !first.by_multigrid());
    assert_eq!(report.matvecs, report.cg_iterations + 1, "{report:?}");
}

#[test]
fn large_sheets_keep_their_coarse_matrices_within_a_stage() {
    for side in [20, 34] {
        let mut first = First::new(sheet(side, 4e4, ""));
        let made = first.solve(0.1);
        let kept = first.solve(0.1);
        let stiff = first.matrix.stiff.as_ref().expect("the default has one");
        let products = stiff.multigrid.as_ref().expect("of multigrid").products();
        let saved = if side * side < 1000 { 0 } else { products.update as u32 };
        assert!(made.cg_iterations <= MANY_ITERATIONS && products.update > 0);
        assert_eq!(made.cg_iterations, kept.cg_iterations);
        assert_eq!(made.matvecs, kept.matvecs + saved, "{side}");
        first.matrix.begin();
        assert_eq!(first.solve(0.1).matvecs, made.matvecs, "{side}: the next stage makes them");
        // A solve of many cycles says that they no longer serve.
        let slow = first.solve(1e-9);
        assert!(slow.cg_iterations > MANY_ITERATIONS, "{slow:?}");
        assert_eq!(first.solve(0.1).matvecs, made.matvecs, "{side}: after a slow solve");
    }
}
