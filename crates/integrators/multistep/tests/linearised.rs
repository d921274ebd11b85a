//! One Newton iteration a step on a stiff sheet gains energy, and its safeguard prevents that.

use drape_integrator::{Integrator, PhaseClock, TimeStep};
use drape_model::{State, System};
use drape_multistep::{Bdf, BdfSettings};

/// Calls in a second.
const FRAMES_PER_S: f64 = 60.0;
/// Energy that the sheet sets free in its fall, roughly, J.
const RELEASED: f64 = 1.0;

/// A square metre of cloth of 0.2 kg with 20 × 20 particles, held by two corners.
fn sheet() -> (System, State) {
    let text = r#"{ "format": "drape-scene/1", "name": "sheet",
        "cloth": { "grid": { "rows": 20, "columns": 20, "size_m": [1, 1],
            "center_m": [0, 0, 0], "mass_kg": 0.2 } },
        "effects": {
            "tension": { "stiffness_n_per_m": 2000, "damping_n_s_per_m": 0.02 },
            "shear": { "stiffness_n_per_m": 40, "damping_n_s_per_m": 0.0004 },
            "bending_hinge": { "stiffness_n_m": 3.3e-6 },
            "gravity": { "m_s2": [0, 0, -9.81] } },
        "damping": "projected",
        "pins": [{ "row": 0, "column": 0 }, { "row": 0, "column": 19 }],
        "time": { "step_s": 0.01, "duration_s": 5 } }"#;
    drape_model::parse("sheet", text).expect("valid").spec().build().expect("valid")
}

fn energy(system: &System, state: &State) -> f64 {
    system.kinetic_energy(&state.v) + system.energies(&state.x).map(|(_, u)| u).sum::<f64>()
}

/// What some seconds did.
#[derive(Debug)]
struct Fall {
    /// Greatest rise of the energy above its start, J.
    gain: f64,
    /// Greatest rise above the least energy before, J.
    climb: f64,
    /// Newton iterations a step.
    iterations: f64,
}

fn fall(settings: &[(&str, &str)], substeps: u32, seconds: f64) -> Fall {
    let (system, mut state) = sheet();
    let mut method = Bdf::new(BdfSettings::from_pairs(settings.to_vec()).expect("in range"));
    let rate = FRAMES_PER_S * f64::from(substeps);
    let h = TimeStep::new(1.0 / rate).expect("positive");
    method.prepare(&system, h).expect("supported");
    let start = energy(&system, &state);
    let (mut least, mut iterations) = (start, 0);
    let mut fall = Fall { gain: f64::NEG_INFINITY, climb: 0.0, iterations: 0.0 };
    let steps = (seconds * rate).round() as u32;
    for _ in 0..steps {
        let report = method.step(&system, &mut state, h, &mut PhaseClock::off()).expect("finite");
        let now = energy(&system, &state);
        fall.gain = fall.gain.max(now - start);
        fall.climb = fall.climb.max(now - least);
        least = least.min(now);
        iterations += report.newton_iterations;
    }
    fall.iterations = f64::from(iterations) / f64::from(steps);
    fall
}

const LINEARISED: [(&str, &str); 3] =
    [("max_iterations", "1"), ("solver", "cg"), ("cg_tolerance", "0.01")];

#[test]
fn one_iteration_gains_energy_unless_the_work_of_its_residual_asks_for_more() {
    for substeps in [1, 2, 4] {
        let unsafe_form = fall(&LINEARISED, substeps, 3.0);
        assert_eq!(unsafe_form.iterations, 1.0, "{substeps}");
        assert!(unsafe_form.gain > 0.5 * RELEASED, "{substeps}: {unsafe_form:?}");
        let settings = [&LINEARISED[..], &[("safeguard", "work")]].concat();
        let safe = fall(&settings, substeps, 5.0);
        assert!(safe.gain < 0.0 && safe.climb < 0.03 * RELEASED, "{substeps}: {safe:?}");
        assert!(safe.iterations > 1.2 && safe.iterations < 3.0, "{substeps}: {safe:?}");
    }
}
