//! The reference against motions that are known in closed form.

use super::*;
use drape_model::{
    EffectsSpec, GravitySpec, KeyframeSpec, ObstacleSpec, ParticlesSpec, PinSpec, SpringEffect,
    SpringSpec, SystemSpec,
};

/// A particle on a spring of rest length 0 whose other end is pinned at the origin.
fn oscillator(stiffness: f64, damping: f64, gravity: f64) -> SystemSpec {
    SystemSpec {
        name: "oscillator".into(),
        particles: ParticlesSpec {
            mass_kg: vec![1.0, 0.5],
            position_m: vec![[0.0; 3], [1.0, -0.5, 0.25]],
            velocity_m_s: vec![[9.0; 3], [0.0, 2.0, 1.0]],
        },
        springs: vec![SpringSpec {
            effect: SpringEffect::Tension,
            i: 0,
            j: 1,
            rest_length_m: 0.0,
            stiffness_n_per_m: stiffness,
            damping_n_s_per_m: damping,
            ..SpringSpec::default()
        }],
        pins: vec![PinSpec::still(0)],
        effects: EffectsSpec {
            gravity: Some(GravitySpec { m_s2: [0.0, 0.0, -gravity] }),
            ..EffectsSpec::default()
        },
        ..SystemSpec::default()
    }
}

/// `x'' = −κ(x − a) − δx'` under-damped, from `(x, v)`.
fn exact(x: Vec3, v: Vec3, rest: Vec3, kappa: f64, delta: f64, t: f64) -> Vec3 {
    let omega = (kappa - 0.25 * delta * delta).sqrt();
    let offset = x - rest;
    let sine = (v + offset * (0.5 * delta)) / omega;
    rest + (offset * (omega * t).cos() + sine * (omega * t).sin()) * (-0.5 * delta * t).exp()
}

#[test]
fn a_damped_oscillator_is_met_within_the_stated_error() {
    let (k, c, g) = (40.0, 0.3, 9.81);
    let (system, start) = oscillator(k, c, g).build().expect("valid");
    let times = [0.1, 0.5, 3.0];
    let found = reference(&system, &start, &times, AdaptiveSettings::default()).expect("smooth");
    assert!(found.position_error < 1e-9, "{}", found.position_error);
    let rest = Vec3::new(0.0, 0.0, -g * 0.5 / k);
    for (state, t) in found.states.iter().zip(times) {
        assert_eq!(state.t, t);
        let expected = exact(start.x[1], start.v[1], rest, 2.0 * k, 2.0 * c, t);
        let error = (state.x[1] - expected).norm();
        assert!(error <= 2.0 * found.position_error.max(1e-12), "{error} at {t} s");
        assert_eq!((state.x[0], state.v[0]), (Vec3::zeros(), Vec3::zeros()), "the pin holds");
    }
}

#[test]
fn a_looser_tolerance_states_a_larger_error() {
    let (system, start) = oscillator(40.0, 0.0, 9.81).build().expect("valid");
    let error = |tolerance| {
        let settings = AdaptiveSettings { tolerance, max_steps: 10_000 };
        reference(&system, &start, &[2.0], settings).expect("smooth").position_error
    };
    assert!(error(1e-6) > 10.0 * error(1e-9) && error(1e-9) > 0.0);
}

#[test]
fn a_run_of_many_steps_is_no_less_exact() {
    let (k, settings) = (2e5, AdaptiveSettings::default());
    let (system, start) = oscillator(k, 0.0, 0.0).build().expect("valid");
    let found = reference(&system, &start, &[1.0], settings).expect("smooth");
    let expected = exact(start.x[1], start.v[1], Vec3::zeros(), 2.0 * k, 0.0, 1.0);
    let error = (found.states[0].x[1] - expected).norm();
    assert!(error < 1e-8, "{error}, stated {}", found.position_error);
}

#[test]
fn what_has_no_reference_is_refused_by_name() {
    let spec = oscillator(1.0, 0.0, 0.0);
    let (system, start) = spec.build().expect("valid");
    let settings = AdaptiveSettings::default();
    let refuse = |system: &System, start: &State, times: &[f64], settings| {
        reference(system, start, times, settings).expect_err("refused")
    };
    let floor = ObstacleSpec::plane([0.0; 3], [0.0, 0.0, 1.0], 0.0);
    let path = vec![KeyframeSpec { time_s: 1.0, offset_m: [1.0; 3] }];
    let led = PinSpec { path, ..PinSpec::still(0) };
    let (led, _) = SystemSpec { pins: vec![led], ..spec.clone() }.build().expect("valid");
    assert!(matches!(refuse(&led, &start, &[1.0], settings), AdaptiveError::MovingPins(1)));
    let (table, _) = SystemSpec { obstacles: vec![floor], ..spec }.build().expect("valid");
    assert!(matches!(refuse(&table, &start, &[1.0], settings), AdaptiveError::Contact(1)));
    let lone = State { t: 0.0, x: vec![Vec3::zeros()], v: vec![Vec3::zeros()] };
    let error = refuse(&system, &lone, &[1.0], settings);
    assert!(matches!(error, AdaptiveError::SizeMismatch { expected: 2, found: 1 }));
    for times in [[1.0, 1.0], [0.0, 1.0], [1.0, f64::INFINITY]] {
        assert!(matches!(refuse(&system, &start, &times, settings), AdaptiveError::Times { .. }));
    }
    let none = AdaptiveSettings { tolerance: 0.0, ..settings };
    assert!(matches!(refuse(&system, &start, &[1.0], none), AdaptiveError::Tolerance(_)));
    let few = AdaptiveSettings { max_steps: 20, ..settings };
    match refuse(&system, &start, &[1e3], few) {
        AdaptiveError::StepLimit { steps: 20, time } => assert!(time > 0.0 && time < 1e3),
        other => panic!("{other}"),
    }
    let mut broken = start.clone();
    broken.x[1].x = f64::NAN;
    let error = refuse(&system, &broken, &[1.0], settings);
    assert!(matches!(error, AdaptiveError::NotFinite { .. }), "{error}");
}
