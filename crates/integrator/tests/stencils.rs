//! Angles, hinges and air in an implicit stage, and their stiffness.

use drape_integrator::{
    ContactSet, Implicit, ImplicitStage, IncrementalPotential, LargestEigenvalue, PhaseClock,
    Stage, StageSettings, StepReport, StiffnessBound,
};
use drape_model::{Level, State, System, Vec3, parse};
use drape_solvers::Constraints;

const TAU: f64 = 0.05;

/// Two triangles that shear, bend and meet a wind.
fn sheet(drag: &str) -> (System, State) {
    let text = format!(
        r#"{{ "format": "drape-system/1", "triangles": [[0, 1, 2], [1, 3, 2]],
        "particles": {{ "mass_kg": [1, 0.5, 2, 0.7],
            "position_m": [[0, 0, 0], [1, 0, 0.1], [0, 1, 0.2], [1, 1, -0.1]] }},
        "angles": [
            {{ "effect": "shear_angle", "i": 1, "j": 0, "k": 2, "rest_rad": 1.5,
                "stiffness_n_m": 3 }},
            {{ "effect": "bending_angle", "i": 0, "j": 1, "k": 3, "rest_rad": 2,
                "stiffness_n_m": 2 }}],
        "hinges": [{{ "i": 1, "j": 2, "k": 0, "l": 3, "rest_rad": 0.2, "stiffness_n_m": 4 }}],
        "effects": {{ "air": {{ "drag": {drag}, "wind": {{ "velocity_m_s": [3, -1, 5],
            "gust": {{ "amplitude_m_s": [0, 1, 4], "period_s": 1, "seed": 5 }} }} }} }} }}"#
    );
    parse("sheet", &text).expect("valid").spec().build().expect("valid")
}

const DRAGS: [&str; 2] = [
    r#"{ "linear": { "coefficient_n_s_per_m3": 3 } }"#,
    r#"{ "quadratic": { "coefficient": 2, "density_kg_m3": 1.2 } }"#,
];

/// Irregular vectors.
fn vectors(seed: f64) -> Vec<Vec3> {
    let at = |i: usize| {
        let s = seed + 7.0 * i as f64;
        Vec3::new(s.sin(), (1.7 * s).cos(), (2.9 * s).sin())
    };
    (0..4).map(at).collect()
}

#[test]
fn the_gradient_of_the_potential_is_its_slope_with_a_wind_too() {
    for drag in DRAGS {
        let (system, state) = sheet(drag);
        let mut potential = IncrementalPotential::new(&system, Implicit::Everything);
        for seed in 0..10 {
            let seed = f64::from(seed);
            let (v_star, v_lagged, mut v) =
                (vectors(seed), vectors(seed + 0.3), vectors(seed + 0.6));
            let lagged = Level { t: 0.4, x: &state.x, v: &v_lagged };
            potential.begin(&system, TAU, (&state.x, &v_star), lagged, &[Vec3::z(); 4]);
            let gradient = potential.gradient(&system, &v).to_vec();
            for (i, axis) in [(0, 0), (1, 2), (2, 1), (3, 2)] {
                let mut value = |offset: f64| {
                    let old = v[i][axis];
                    v[i][axis] = old + offset;
                    let value = potential.value(&system, &v);
                    v[i][axis] = old;
                    value
                };
                let slope = (value(1e-5) - value(-1e-5)) / 2e-5;
                assert!((slope - gradient[i][axis]).abs() < 1e-7, "{slope} {}", gradient[i][axis]);
            }
        }
    }
}

#[test]
fn a_stage_takes_angles_at_its_end_and_air_with_lagged_coefficients() {
    for drag in DRAGS {
        let (system, state) = sheet(drag);
        let mut stage = ImplicitStage::new(&system).expect("a pattern");
        let (v_star, v_lagged, x_lagged) = (vectors(0.1), vectors(0.2), vectors(0.3));
        let lagged = Level { t: 0.7, x: &x_lagged, v: &v_lagged };
        let input = Stage {
            tau: TAU.into(),
            end: TAU,
            from: (&state.x, &v_star),
            lagged,
            velocity: &v_star,
        };
        let settings = StageSettings { residual: 1e-13, ..StageSettings::default() };
        let (mut contacts, mut constraints) = (ContactSet::new(&system), Constraints::free(4));
        let (mut clock, mut report) = (PhaseClock::off(), StepReport::default());
        stage
            .solve(
                &system,
                input,
                &v_star,
                &mut contacts,
                &mut constraints,
                settings,
                &mut clock,
                &mut report,
            )
            .expect("finite");
        let (v, x) = (stage.velocity().to_vec(), stage.positions().to_vec());
        let mut force = vec![Vec3::zeros(); 4];
        for effect in system.effects() {
            effect.add_force(system.mass(), &x, &mut force);
            effect.add_lagged_damping_force(lagged, &v, &mut force);
        }
        for i in 0..4 {
            let wrong = (v[i] - v_star[i]) * system.mass()[i] - force[i] * TAU;
            assert!(wrong.norm() < 1e-11, "{drag}, particle {i}: {wrong:?}");
            assert!(force[i].norm() > 1e-3, "{drag}, particle {i}");
        }
        assert_eq!(stage.explicit_force(), [Vec3::zeros(); 4]);
    }
}

/// A straight row of three particles: mass 0.1 kg, mesh width 0.5 m, `k` = 2 N m.
fn row(more: &str) -> (System, State) {
    let text = format!(
        r#"{{ "format": "drape-system/1", "triangles": [[0, 1, 2]], {more}
        "particles": {{ "mass_kg": [0.1, 0.1, 0.1],
            "position_m": [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]] }} }}"#
    );
    parse("row", &text).expect("valid").spec().build().expect("valid")
}

const ANGLE: &str = r#""angles": [{ "effect": "bending_angle", "i": 0, "j": 1, "k": 2,
    "rest_rad": 3.141592653589793, "stiffness_n_m": 2 }],"#;
const AIR: &str =
    r#""effects": { "air": { "drag": { "linear": { "coefficient_n_s_per_m3": 1 } } } },"#;

#[test]
fn the_largest_eigenvalue_sees_the_stiffness_of_a_straight_row() {
    // K = k/h² r rᵀ in both directions across, r = (1, −2, 1): λ = 6 k/(h² m).
    let (system, state) = row(ANGLE);
    let (estimate, _) = LargestEigenvalue::new(&system).converge(&system, &state.x);
    assert!((estimate / (6.0 * 2.0 / (0.25 * 0.1)) - 1.0).abs() < 1e-9, "{estimate}");
}

#[test]
fn there_is_no_bound_with_angles_and_air_has_no_stiffness() {
    assert!(StiffnessBound::new(&row(ANGLE).0).is_none());
    let (system, _) = row(AIR);
    assert_eq!(StiffnessBound::new(&system).map(|mut bound| bound.evaluate(&system)), Some(0.0));
}
