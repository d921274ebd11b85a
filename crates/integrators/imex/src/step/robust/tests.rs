//! The robust form pass by pass.

use super::*;
use crate::settings::ImexUpdatedSettings;
use drape_integrator::Weights;
use drape_oracle::Random;
use drape_solvers::{Constraints, Filter};

/// A sheet of 6 × 6 particles with tension, shear and bending springs, pinned at two corners;
/// `stiffness` is `k/m` of the tension springs, 1/s²; `steep` is its factor beyond 2 % of strain,
/// if any.
fn sheet(stiffness: f64, law: &str, steep: Option<f64>) -> (System, State) {
    let [shear, bending] = [0.3, 0.1].map(|part| part * stiffness);
    let tension = match steep {
        None => format!(r#""stiffness_over_mass_per_s2": {stiffness}"#),
        Some(ratio) => format!(
            r#""pieces": [{{ "up_to_strain": 0.02, "stiffness_n_per_m": {} }},
                {{ "stiffness_n_per_m": {} }}]"#,
            1e-3 * stiffness,
            1e-3 * stiffness * ratio
        ),
    };
    let text = format!(
        r#"{{
            "format": "drape-scene/1", "name": "sheet", "damping": "{law}",
            "cloth": {{ "grid": {{ "rows": 6, "columns": 6, "size_m": [1, 1], "center_m": [0, 0, 0],
                "mass_kg": 0.036 }} }},
            "effects": {{
                "tension": {{ {tension}, "damping_over_mass_per_s": 5 }},
                "shear": {{ "stiffness_over_mass_per_s2": {shear}, "damping_over_mass_per_s": 1 }},
                "bending": {{ "stiffness_over_mass_per_s2": {bending} }},
                "gravity": {{ "m_s2": [0, 0, -9.81] }} }},
            "pins": [ {{ "row": 0, "column": 0 }}, {{ "row": 0, "column": 5 }} ],
            "time": {{ "step_s": 0.01, "duration_s": 1 }}
        }}"#
    );
    let input = drape_model::parse("sheet", &text).unwrap_or_else(|error| panic!("{error}"));
    input.spec().build().unwrap_or_else(|violation| panic!("{violation}"))
}

/// Theorem: a pass minimises, however roughly, a quadratic that lies above the incremental
/// potential and touches it at the present velocity; so no pass raises the potential.
#[test]
fn no_pass_raises_the_incremental_potential() {
    const H: f64 = 0.01;
    let mut random = Random::new(13);
    let (mut passes, mut falls) = (0, 0);
    for theta in [0.1, 1.0, 10.0, 100.0, 1e4] {
        for (law, steep) in
            [("full", None), ("projected", None), ("full", Some(100.0)), ("full", Some(0.01))]
        {
            for text in ["forcing_term=0.5", "forcing_term=1e-2", "solver=cholesky"] {
                let (key, value) = text.split_once('=').unwrap_or_default();
                let pairs = [(key, value), ("max_outer", "1"), ("start", "last")];
                let settings = ImexUpdatedSettings::from_pairs(pairs)
                    .unwrap_or_else(|error| panic!("{error}"));
                let (system, mut state) = sheet(theta / (H * H), law, steep);
                let mut constraints = Constraints::free(state.len());
                for i in (0..state.len()).filter(|&i| system.pinned()[i]) {
                    constraints.set(i, Filter::Fixed, Vec3::zeros());
                }
                for (x, v) in state.x.iter_mut().zip(&mut state.v) {
                    *x += random.vector() * 0.1; // stretched and compressed
                    *v = random.vector() * 3.0;
                }
                let problem = Problem {
                    reference: drape_solvers::Reference::FilteredRightHandSide,
                    system: &system,
                    state: &state,
                    h: H,
                    constraints: &constraints,
                    settings: &settings,
                };
                let implicit = settings.implicit;
                let weights = Weights::StiffnessAndDamping;
                let mut linear =
                    LaplacianSolver::new(&system, implicit, weights, settings.linear(), H)
                        .unwrap_or_else(|error| panic!("{error}"));
                let mut rhs = RightHandSide::updated(state.len(), implicit);
                let mut descent =
                    Descent::new(&system, implicit).unwrap_or_else(|error| panic!("{error}"));
                rhs.freeze(&system, &state, H, None);
                descent.begin(&system, &state, H, &rhs.explicit_force);
                // A start that has nothing to do with the motion.
                let mut v: Vec<Vec3> = state.v.iter().map(|_| random.vector() * 10.0).collect();
                constraints.impose(&mut v);
                let tolerance = settings.forcing_term * descent.potential.scale();
                let mut value = descent.potential.value(&system, &v);
                for pass in 0..40 {
                    let mut report = StepReport::default();
                    let (linear, rhs) = (&mut linear, &mut rhs);
                    let done =
                        descent.update_until(problem, rhs, linear, &mut v, tolerance, &mut report);
                    let next = descent.potential.value(&system, &v);
                    let case = format!(
                        "θ={theta}, {law}, {steep:?}, {text}, pass {pass}: {value} → {next} J"
                    );
                    assert_eq!((report.outer_passes, report.newton_iterations), (1, 0), "{case}");
                    assert_eq!(report.solve, SolveStatus::Converged, "{case}");
                    assert!(next <= value + 1e-13 * value.abs(), "{case}");
                    (passes, falls) = (passes + 1, falls + usize::from(next < value));
                    value = next;
                    if done {
                        break;
                    }
                }
            }
        }
    }
    assert!(passes > 500 && falls > 500, "{falls} of {passes} passes lowered the potential");
}

/// A direct solve takes no iterations, which must not end the updates.
#[test]
fn direct_solves_update_until_the_residual_is_small() {
    let (system, mut state) = sheet(1e4, "full", None);
    state.x.iter_mut().enumerate().for_each(|(i, x)| x.z = 0.05 * (i as f64).sin());
    let passes = |text| {
        let pairs = [("solver", text), ("forcing_term", "1e-6"), ("max_outer", "10000")];
        let settings = ImexUpdatedSettings::from_pairs(pairs);
        let mut method =
            crate::ImexUpdated::new(settings.unwrap_or_else(|error| panic!("{error}")));
        let h = drape_integrator::TimeStep::new(0.01).unwrap_or_else(|error| panic!("{error}"));
        let (mut state, mut clock) = (state.clone(), drape_integrator::PhaseClock::off());
        use drape_integrator::Integrator;
        method.prepare(&system, h).unwrap_or_else(|error| panic!("{error}"));
        let report = method.step(&system, &mut state, h, &mut clock);
        let report = report.unwrap_or_else(|error| panic!("{error}"));
        assert!(report.relative_residual <= 1e-6, "{report:?}");
        (report.outer_passes, state)
    };
    let ((direct, a), (iterative, b)) = (passes("cholesky"), passes("cg"));
    assert!(direct > 5 && iterative > 5, "{direct} and {iterative} passes");
    let difference = a.x.iter().zip(&b.x).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(difference < 1e-6, "{difference:e}");
}
