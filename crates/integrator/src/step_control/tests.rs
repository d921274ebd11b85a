use super::*;
use drape_model::parse;

#[test]
fn the_controller_is_the_formula_with_its_bounds() {
    for (order, exponent) in [(Order::One, 0.5), (Order::Two, 1.0 / 3.0)] {
        let mut controller = StepController::new();
        let mut last = 1.0_f64;
        for error in [0.2, 0.02, 0.3, 0.9] {
            let decision = controller.judge(order, error, true);
            let factor = 0.9 * f64::powf(error, -0.7 * exponent) * f64::powf(last, 0.4 * exponent);
            let factor = factor.clamp(0.2, 2.0);
            let kept = if (0.9..=1.3).contains(&factor) { 1.0 } else { factor };
            assert!(decision.accepted);
            assert!((decision.factor - kept).abs() < 1e-12, "{order:?} at {error}: {decision:?}");
            last = error;
        }
    }
}

#[test]
fn a_large_error_is_rejected_and_the_next_step_does_not_grow() {
    let mut controller = StepController::new();
    let rejected = controller.judge(Order::One, 4.0, true);
    assert_eq!(rejected, Decision { accepted: false, factor: 0.45 });
    let after = controller.judge(Order::One, 1e-6, true);
    assert_eq!(after, Decision { accepted: true, factor: 1.0 });
    assert_eq!(controller.judge(Order::One, 1e-6, true).factor, 2.0);
    for (error, solved) in [(f64::NAN, true), (f64::INFINITY, true), (0.1, false)] {
        let decision = controller.judge(Order::Two, error, solved);
        assert!(!decision.accepted && decision.factor <= 0.5, "{error}, {solved}");
    }
}

/// Particle 0 is pinned and 1 moves on `x(t)`; levels at times with uneven steps.
fn measured(order: Order, constant: f64, x: impl Fn(f64) -> f64) -> (f64, f64) {
    let text = r#"{ "format": "drape-system/1", "pins": [{ "particle": 0 }], "particles": {
        "mass_kg": [1, 1], "position_m": [[0, 0, 0], [1, 0, 0]] }, "springs": [
        { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 0.25, "stiffness_n_per_m": 1 }] }"#;
    let (system, _) = parse("test", text).expect("valid").spec().build().expect("valid");
    let steps = [0.010, 0.012, 0.009];
    let state =
        |t: f64| State { t, x: vec![Vec3::zeros(), Vec3::y() * x(t)], v: vec![Vec3::zeros(); 2] };
    let mut error = LocalError::new(2);
    let mut t = 0.0;
    for h in &steps[..2] {
        error.accept(&state(t), *h, None);
        t += h;
    }
    let h = steps[2];
    error.measure(order, |_| constant, &state(t), &state(t + h).x, h);
    (error.norm(&system, None), h)
}

/// On polynomials of the next degree the divided differences are exact.
#[test]
fn the_estimates_see_the_leading_derivative_whatever_the_steps_were() {
    let (error, h) = measured(Order::One, 0.0, |t| 3.0 * t * t + t - 2.0);
    assert!((error - 3.0 * h * h).abs() < 1e-14, "h²/2 x'': {error}");
    let (error, _) = measured(Order::One, 0.0, |t| 5.0 * t - 2.0);
    assert!(error < 1e-15, "no bend, no error: {error}");
    let (error, _) = measured(Order::Two, 2.0 / 9.0, |t| 3.0 * t * t + t - 2.0);
    assert!(error < 1e-15, "no third derivative: {error}");
    // The error of a method with this constant.
    let (h0, h1, h2): (f64, f64, f64) = (0.009, 0.012, 0.010);
    let extrapolation = (h0 + h1) * (h0 + h1 + h2) * h0 / 6.0;
    let c = 2.0 / 9.0;
    let (error, h) = measured(Order::Two, c, |t| t * t * t);
    let expected = 6.0 * c * h.powi(3) * extrapolation / (c * h.powi(3) + extrapolation);
    assert!((error - expected).abs() < 1e-15, "{error}, not {expected}");
}

#[test]
fn without_a_past_the_velocity_stands_in() {
    let mut error = LocalError::new(1);
    let from = State { t: 0.0, x: vec![Vec3::x()], v: vec![Vec3::y()] };
    error.measure(Order::Two, |_| 1.0, &from, &[Vec3::new(1.0, 0.1, 0.02)], 0.1);
    assert!((error.vectors()[0] - Vec3::z() * 0.01).norm() < 1e-16);
}

#[test]
fn the_mesh_width_is_the_mean_rest_length_of_the_tension_springs() {
    let text = r#"{ "format": "drape-system/1", "particles": { "mass_kg": [1, 1, 1],
        "position_m": [[0, 0, 0], [1, 0, 0], [2, 0, 0]] }, "springs": [
        { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 0.5, "stiffness_n_per_m": 1 },
        { "effect": "tension", "i": 1, "j": 2, "rest_length_m": 1.5, "stiffness_n_per_m": 1 },
        { "effect": "bending", "i": 0, "j": 2, "rest_length_m": 9, "stiffness_n_per_m": 1 }] }"#;
    let (system, _) = parse("test", text).expect("valid").spec().build().expect("valid");
    assert_eq!(mesh_width(&system), 1.0);
}

/// A contact bends the way of a particle at once: no line through older places foretells it.
#[test]
fn a_particle_that_met_an_obstacle_has_no_past() {
    let text = r#"{ "format": "drape-system/1", "particles": { "mass_kg": [1],
        "position_m": [[0, 0, -0.001]], "velocity_m_s": [[0, 0, -1]] },
        "obstacles": [{ "plane": { "point_m": [0, 0, 0], "normal": [0, 0, 1] } }] }"#;
    let (system, mut from) = parse("test", text).expect("valid").spec().build().expect("valid");
    let h = 0.01;
    for is_met in [false, true] {
        let mut contacts = ContactSet::new(&system);
        if is_met {
            let mut constraints = ContactSet::constraints(&system);
            contacts.detect(&system, &from.x, &from.v, (h, h), &mut constraints);
            contacts.settle(&mut from.v, |_| ());
        }
        let mut error = LocalError::new(1);
        error.accept(&from, h, Some(&contacts));
        let at = State { t: h, x: vec![Vec3::x()], v: vec![Vec3::y()] };
        error.measure(Order::One, |_| 0.0, &at, &[Vec3::x() + Vec3::y() * h], h);
        assert_eq!(error.vectors()[0].norm() < 1e-15, is_met);
    }
}
