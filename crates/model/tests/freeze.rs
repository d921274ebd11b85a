//! A running system, frozen again, is the same system.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{
    Effect, EffectKind, EffectsSpec, PieceSpec, State, System, SystemSpec, Vec3, bundled, load,
    parse,
};

fn forces(system: &System, state: &State) -> Vec<[u64; 3]> {
    let mut out = vec![Vec3::zeros(); system.len()];
    system.forces(state.level(), &mut out);
    out.iter().map(|f| [f.x, f.y, f.z].map(f64::to_bits)).collect()
}

/// Sheared, so that every effect has a force.
fn moved(mut state: State) -> State {
    for (i, x) in state.x.iter_mut().enumerate() {
        let phase = i as f64;
        *x += Vec3::new(phase.sin(), (2.0 * phase).cos(), (3.0 * phase).sin()) * 1e-3;
    }
    for (i, v) in state.v.iter_mut().enumerate() {
        *v = Vec3::new((i as f64).cos(), 0.3, 0.1);
    }
    state
}

fn assert_same(spec: &SystemSpec, name: &str) {
    let (mut system, state) = spec.build().unwrap();
    assert!(system.scale_stiffness(EffectKind::Tension, 1.7), "{name}");
    let state = moved(state);
    let frozen = system.freeze(&state).unwrap();
    let (again, state_again) = frozen.build().unwrap();
    assert_eq!(state.x, state_again.x, "{name}");
    assert_eq!(state.v, state_again.v, "{name}");
    assert_eq!(system.mass(), again.mass(), "{name}");
    assert_eq!(system.pins(), again.pins(), "{name}");
    assert_eq!(system.obstacles(), again.obstacles(), "{name}");
    assert_eq!(forces(&system, &state), forces(&again, &state_again), "{name}");
    assert_eq!(again.freeze(&state_again).unwrap(), frozen, "{name}");
}

#[test]
fn a_bundled_scene_frozen_from_its_running_system_has_the_same_forces() {
    let mut seen = 0;
    for name in bundled::names() {
        let input = load(name).unwrap();
        if input.spec().springs.iter().any(|spring| !spring.pieces.is_empty()) {
            continue;
        }
        let has_tension = input.spec().build().unwrap().0.scale_stiffness(EffectKind::Tension, 1.0);
        if has_tension {
            assert_same(input.spec(), name);
            seen += 1;
        }
    }
    assert!(seen >= 5, "{seen}");
}

const DRIVEN: &str = r#"{ "format": "drape-scene/1", "name": "driven",
    "cloth": { "grid": { "rows": 4, "columns": 5, "size_m": [1, 1], "center_m": [0, 0, 0],
        "mass_kg": 0.2 } },
    "effects": {
        "tension": { "stiffness_over_mass_per_s2": 1e4, "damping_over_mass_per_s": 3 },
        "shear_angle": { "stiffness_n_m": 1e-3 }, "bending_hinge": { "stiffness_n_m": 1e-4 },
        "gravity": { "m_s2": [0, 0, -9.81] },
        "air": { "drag": { "quadratic": { "coefficient": 1.1 } }, "wind": {
            "velocity_m_s": [1, 2, 0],
            "gust": { "amplitude_m_s": [1, 0, 2], "period_s": 1.5, "seed": 7 } } } },
    "damping": "projected",
    "pins": [{ "row": 0, "column": 0, "path": [{ "time_s": 1, "offset_m": [0, 0, 1] }] }],
    "obstacles": [{ "sphere": { "center_m": [0, 0, -1], "radius_m": 0.3, "friction": 0.2,
        "path": [{ "time_s": 2, "offset_m": [0, 0, 0.5] }] } },
        { "box": { "center_m": [0, 0, -3], "size_m": [1, 2, 1] } }],
    "time": { "step_s": 0.01, "duration_s": 1 } }"#;

#[test]
fn paths_gusts_and_angles_are_kept_and_times_count_from_the_state() {
    let input = parse("driven", DRIVEN).unwrap();
    assert_same(input.spec(), "driven");
    let (system, mut state) = input.spec().build().unwrap();
    state.t = 0.25;
    state.x[0] = system.moving_pins()[0].position(0.25);
    let frozen = system.freeze(&state).unwrap();
    let (again, start) = frozen.build().unwrap();
    assert_eq!(again.moving_pins()[0].position(0.5), system.moving_pins()[0].position(0.75));
    assert_eq!(forces(&system, &state), forces(&again, &start));
}

#[derive(Clone, Debug)]
struct Own;

impl Effect for Own {
    fn kind(&self) -> EffectKind {
        EffectKind::Own("magnet")
    }
    fn energy(&self, _mass: &[f64], _x: &[Vec3]) -> f64 {
        0.0
    }
    fn add_force(&self, _mass: &[f64], _x: &[Vec3], _out: &mut [Vec3]) {}
    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

#[test]
fn what_a_frozen_system_cannot_hold_is_named() {
    let input = load("hanging-textile-1e4").unwrap();
    let (mut system, state) = input.spec().build().unwrap();
    system.add_effect(Box::new(Own));
    assert_eq!(system.freeze(&state), Err("magnet"));
    let mut spec = SystemSpec { effects: EffectsSpec::default(), ..input.spec().clone() };
    let piece = |up_to_strain| PieceSpec { up_to_strain, stiffness_n_per_m: 2.0 };
    for spring in &mut spec.springs {
        spring.stiffness_n_per_m = 2.0;
        spring.pieces = [piece(Some(0.1)), piece(None)].into();
    }
    let (system, state) = spec.build().unwrap();
    assert_eq!(system.freeze(&state), Err("tension"));
}
