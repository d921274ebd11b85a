//! After the first step every method moves by the recurrence of its coefficients.

use super::*;
use drape_oracle::recurrence::{Multistep, backward_euler};
use nalgebra::Vector2;

const STEPS: usize = 100;
/// What the recurrence is met to, by a direct solve and by conjugate gradients.
const SOLVERS: [(&str, f64); 2] = [("solver=cholesky", 1e-12), ("forcing_term=1e-14", 1e-9)];

fn exact(scheme: Scheme, omega: f64) -> Multistep {
    match scheme {
        Scheme::Sbdf2 => Multistep::sbdf2(omega),
        Scheme::Cnab2 => Multistep::cnab2(omega),
        Scheme::Mcnab2 => Multistep::mcnab2(omega),
        Scheme::Cnlf => Multistep::cnlf(),
    }
}

/// `(θ_I, θ_E, η)` with what each makes of the springs of the scene.
type Parameters = (f64, f64, f64);

/// Steps of length `h(step)` beside the recurrence that starts from the run's own first step; returns
/// the number of steps, ended early where the exact `x` leaves `range`, and the worst deviation of `(x, hv)` relative
/// to the last two levels of the exact solution or, where it is larger, `floor`.
fn worst_deviation(
    run: &mut Run,
    scheme: Scheme,
    (implicit, explicit, eta): Parameters,
    h: impl Fn(usize) -> f64,
    coordinate: impl Fn(&State) -> (f64, f64),
    (range, floor): (f64, f64),
) -> (usize, f64) {
    let mut levels = [coordinate(&run.state); 2];
    let mut worst: f64 = 0.0;
    for step in 0..STEPS {
        let h_new = h(step);
        run.h = seconds(h_new);
        let scaled = levels.map(|(x, v)| Vector2::new(x, h_new * v));
        run.step();
        let found = coordinate(&run.state);
        let y = if step == 0 {
            Vector2::new(found.0, h_new * found.1) // backward Euler, checked elsewhere
        } else {
            let share = (h_new / H).powi(2);
            let multistep = exact(scheme, h_new / h(step - 1));
            multistep.recurrence(implicit * share, explicit * share, eta * h_new / H).next(&scaled)
        };
        let size = y.norm().max(scaled[0].norm()).max(floor);
        if y.x.abs() > range {
            return (step, worst);
        }
        worst = worst.max((Vector2::new(found.0, h_new * found.1) - y).norm() / size);
        levels = [(y.x, y.y / h_new), levels[0]];
    }
    (STEPS, worst)
}

/// One particle on springs whose other end is pinned at the origin.
fn anchored(springs: &[(SpringEffect, f64, (f64, f64))], x: Vec3, v: Vec3) -> (System, State) {
    let mut spec = particles(&[MASS; 2], &[Vec3::zeros(), x], &[Vec3::zeros(), v]);
    spec.pins = vec![pin(0)];
    spec.springs = springs.iter().map(|&(e, rest, law)| spring(e, (0, 1), rest, law)).collect();
    spec.build().unwrap()
}

const EVERYWHERE: (f64, f64) = (f64::MAX, 0.0);
const PARAMETERS: [(f64, f64); 4] = [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0)];

#[test]
fn an_anchored_spring_of_rest_length_zero_moves_by_the_recurrence() {
    let (x, v) = (Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
    for (scheme, (text, tolerance)) in SCHEMES.into_iter().flat_map(|s| SOLVERS.map(|t| (s, t))) {
        for ((theta, eta), axis) in PARAMETERS.into_iter().flat_map(|p| (0..3).map(move |a| (p, a)))
        {
            let springs = [(SpringEffect::Tension, 0.0, coefficients_of(theta, eta))];
            let mut run = Run::new(scheme, text, anchored(&springs, x, v), H);
            let at = |state: &State| (state.x[1][axis], state.v[1][axis]);
            let parameters = (theta, 0.0, eta);
            let (_, worst) = worst_deviation(&mut run, scheme, parameters, |_| H, at, EVERYWHERE);
            assert!(worst < tolerance, "{scheme:?}, {text}, θ={theta} η={eta}: {worst:e}");
        }
    }
}

/// Tension and its damping implicit, shear explicit: `x'' = −(κ_I + κ_E)x − δx'`.
#[test]
fn explicit_springs_beside_implicit_ones_move_by_the_test_equation() {
    let (x, v) = (Vec3::new(1.0, -0.5, 2.0), Vec3::new(0.0, 40.0, 7.0));
    let parameters = [
        (1.0, 0.5, 0.1),
        (100.0, 30.0, 0.0),
        (0.36, 0.1, 0.06),
        (0.0, 0.3, 0.0),
        (100.0, 2.0, 0.4),
    ];
    for (scheme, (text, tolerance)) in SCHEMES.into_iter().flat_map(|s| SOLVERS.map(|t| (s, t))) {
        for (implicit, explicit, eta) in parameters {
            let springs = [
                (SpringEffect::Tension, 0.0, coefficients_of(implicit, eta)),
                (SpringEffect::Shear, 0.0, coefficients_of(explicit, 0.0)),
            ];
            let text = format!("implicit=tension,{text}");
            let mut run = Run::new(scheme, &text, anchored(&springs, x, v), H);
            let at = |state: &State| (state.x[1].y, state.v[1].y);
            let parameters = (implicit, explicit, eta);
            let (_, worst) = worst_deviation(&mut run, scheme, parameters, |_| H, at, EVERYWHERE);
            assert!(worst < tolerance, "{scheme:?}, {text}, {parameters:?}: {worst:e}");
        }
    }
}

/// Along a spring with a rest length the motion is the same, offset by it.
#[test]
fn motion_along_a_spring_with_a_rest_length_obeys_the_same_recurrence() {
    let (rest, amplitude) = (4.0, 1.0 / 256.0);
    let direction = Vec3::new(0.0, 0.6, -0.8);
    for (scheme, (text, tolerance)) in SCHEMES.into_iter().flat_map(|s| SOLVERS.map(|t| (s, t))) {
        for (theta, eta) in PARAMETERS {
            let springs = [(SpringEffect::Tension, rest, coefficients_of(theta, eta))];
            let scene = anchored(&springs, direction * (rest + amplitude), Vec3::zeros());
            let mut run = Run::new(scheme, text, scene, H);
            let at =
                |state: &State| (direction.dot(&state.x[1]) - rest, direction.dot(&state.v[1]));
            let parameters = (theta, 0.0, eta);
            let (steps, worst) =
                worst_deviation(&mut run, scheme, parameters, |_| H, at, (0.5 * rest, rest));
            assert!(
                steps == STEPS && worst < tolerance,
                "{scheme:?}, θ={theta} η={eta}: {worst:e}"
            );
        }
    }
}

/// A particle between two pinned ones, a little aside: `θ_I = θ`, `θ_E = −σθ` with `σ = ℓ/L`.
#[test]
fn motion_across_a_spring_obeys_the_recurrence_of_its_two_parts() {
    for (scheme, (theta, ratio)) in SCHEMES.into_iter().flat_map(|s| {
        [(100.0, 0.5), (100.0, 0.99), (100.0, 1.0), (100.0, 1.1), (0.36, 0.3)].map(|p| (s, p))
    }) {
        // So small that the square of the slope is round-off, also where compression lets it grow.
        let amplitude = 1e-9;
        let middle = Vec3::new(0.0, amplitude, -0.5 * amplitude);
        let positions = [-Vec3::x(), Vec3::x(), middle];
        let velocities = [Vec3::zeros(), Vec3::zeros(), -middle];
        let mut spec = particles(&[MASS; 3], &positions, &velocities);
        spec.pins = vec![pin(0), pin(1)];
        let law = coefficients_of(0.5 * theta, 0.0);
        let half = |end| spring(SpringEffect::Tension, (end, 2), ratio, law);
        spec.springs = vec![half(0), half(1)];
        let mut run = Run::new(scheme, "solver=cholesky", spec.build().unwrap(), H);
        let at = |state: &State| (state.x[2].y, state.v[2].y);
        let parameters = (theta, -ratio * theta, 0.0);
        let (steps, worst) =
            worst_deviation(&mut run, scheme, parameters, |_| H, at, (1e3 * amplitude, 0.0));
        assert!(steps > 5 && worst < 1e-9, "{scheme:?}, θ={theta} ℓ/L={ratio}: {steps}, {worst:e}");
    }
}

/// The variable-step coefficients are exact: each step its own length.
#[test]
fn steps_of_varying_length_move_by_the_variable_recurrence() {
    let lengths = [1.0, 2.0, 1.5, 0.75, 1.25, 1.25, 0.625, 1.0];
    let h = |step: usize| H * lengths[step % lengths.len()];
    let (x, v) = (Vec3::new(1.0, -0.5, 2.0), Vec3::new(0.0, 40.0, 7.0));
    for (scheme, (text, tolerance)) in VARIABLE.into_iter().flat_map(|s| SOLVERS.map(|t| (s, t))) {
        for (implicit, explicit, eta) in [(0.36, 0.1, 0.06), (100.0, 2.0, 0.4), (1.0, 0.0, 0.0)] {
            let springs = [
                (SpringEffect::Tension, 0.0, coefficients_of(implicit, eta)),
                (SpringEffect::Shear, 0.0, coefficients_of(explicit, 0.0)),
            ];
            let text = format!("implicit=tension,{text}");
            let mut run = Run::new(scheme, &text, anchored(&springs, x, v), H);
            let at = |state: &State| (state.x[1].y, state.v[1].y);
            let parameters = (implicit, explicit, eta);
            let (_, worst) = worst_deviation(&mut run, scheme, parameters, h, at, EVERYWHERE);
            assert!(worst < tolerance, "{scheme:?}, {text}, {parameters:?}: {worst:e}");
        }
    }
}

/// The first step, and each after a jump of the step size that the coefficients do not cover, is one of
/// backward Euler.
#[test]
fn a_start_is_a_step_of_backward_euler() {
    let (theta, eta) = (30.0, 0.2);
    for (scheme, ratio) in [(Scheme::Sbdf2, 2.5), (Scheme::Mcnab2, 0.25), (Scheme::Cnlf, 1.25)] {
        let springs = [(SpringEffect::Tension, 0.0, coefficients_of(theta, eta))];
        let scene = anchored(&springs, Vec3::new(1.0, -0.5, 2.0), Vec3::new(0.0, 40.0, 7.0));
        let mut run = Run::new(scheme, "", scene, H);
        for (h, steps_before) in [(H, 0), (ratio * H, 3)] {
            run.steps(steps_before);
            run.h = seconds(h);
            let at = |state: &State| Vector2::new(state.x[1].y, h * state.v[1].y);
            let before = at(&run.state);
            let report = run.step();
            let expected = backward_euler(theta * (h / H).powi(2), eta * h / H) * before;
            let deviation = (at(&run.state) - expected).norm() / before.norm();
            assert!(deviation < 1e-8, "{scheme:?}: {deviation:e}");
            assert!(report.newton_iterations > 0 && report.cg_iterations == 0, "{scheme:?}");
        }
    }
}

/// Explicit stiffness beside a very stiff implicit spring, a little below and above what the theory
/// allows.
#[test]
fn explicit_springs_are_stable_up_to_the_limit_of_each_method() {
    let theta = 1e4;
    for (scheme, share, stable) in [
        (Scheme::Sbdf2, 0.32, true),
        (Scheme::Sbdf2, 0.35, false),
        (Scheme::Mcnab2, 0.12, true),
        (Scheme::Mcnab2, 0.13, false),
        (Scheme::Cnlf, 0.99, true),
        (Scheme::Cnlf, 1.01, false),
        (Scheme::Cnab2, 0.0, true),
        (Scheme::Cnab2, 0.01, false),
    ] {
        let mut springs = vec![(SpringEffect::Tension, 0.0, coefficients_of(theta, 0.0))];
        if share > 0.0 {
            springs.push((SpringEffect::Shear, 0.0, coefficients_of(share * theta, 0.0)));
        }
        let scene = anchored(&springs, Vec3::x(), Vec3::zeros());
        let mut run = Run::new(scheme, "implicit=tension,solver=cholesky", scene, H);
        run.steps(3000);
        let size = run.state.x[1].norm() + H * run.state.v[1].norm();
        assert_eq!(size < 1e3, stable, "{scheme:?}, θ_E = {share} θ_I: {size:e}");
    }
}
