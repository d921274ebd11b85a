//! Steps against recurrences, laws and the exact motion.

use super::tableaux::additive;
use super::{NAMES, method, run};
use drape_integrator::{Integrator, PrepareError, SolveStatus};
use drape_model::{
    AirSpec, AngularLaw, DampingLaw, DragSpec, KeyframeSpec, SpringEffect, State, System, Vec3,
    WindSpec,
};
use drape_oracle::laws::{Drift, free_fall};
use drape_oracle::order::{of_method, position_error};
use drape_oracle::recurrence::additive_runge_kutta;
use drape_oracle::reference::{ReferenceSettings, reference};
use drape_oracle::scenes::{
    GRAVITY, Sheet, anchored, build, floor, gravity, particles, pin, stir, tension, uneven,
};
use drape_oracle::{apart, bits, order_of, seconds};
use nalgebra::Vector2;

const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;

/// `k` and `c` of a spring with these `θ` and `η` at the step size [`H`].
fn coefficients(theta: f64, eta: f64) -> (f64, f64) {
    (theta * MASS / (H * H), eta * MASS / H)
}

/// A particle on an implicit and an explicit spring of rest length 0 to a pin: each coordinate is
/// the oscillator.
#[test]
fn a_step_is_its_recurrence_with_implicit_and_explicit_springs_at_any_step_sizes() {
    let (x, v) = (Vec3::new(1.0, -0.5, 2.0), Vec3::new(0.0, 40.0, 7.0));
    let parameters = [
        (0.36, 0.0, 0.06),
        (1.0, 0.1, 0.0),
        (100.0, 4.0, 0.4),
        (100.0, 0.0, 0.0),
        (2.0, 0.0, 30.0),
    ];
    let solvers = [("cholesky", 1e-12), ("cg,forcing_term=1e-15", 1e-9)];
    for ((name, pair), (theta, shear, eta)) in
        NAMES.into_iter().flat_map(|t| parameters.map(|p| (t, p)))
    {
        for ((solver, tolerance), sizes) in
            solvers.into_iter().flat_map(|s| [[1.0; 3], [1.0, 2.0, 0.75]].map(|sizes| (s, sizes)))
        {
            let ((k, c), (k_shear, _)) = (coefficients(theta, eta), coefficients(shear, 0.0));
            let springs =
                [(SpringEffect::Tension, 0.0, k, c), (SpringEffect::Shear, 0.0, k_shear, 0.0)];
            let text = format!("tableau={name},solver={solver},implicit=tension");
            let mut run = run(&text, build(&anchored(MASS, &springs, x, v)), H);
            for step in 0..60 {
                let size = sizes[step % 3];
                let h = H * size;
                let before = run.state.clone();
                let report = run.step_by(h);
                assert_eq!(report.solve, SolveStatus::Converged, "{text}");
                let (square, size) = (size * size, size);
                let r = additive_runge_kutta(
                    &additive(pair),
                    theta * square,
                    shear * square,
                    eta * size,
                );
                for axis in 0..3 {
                    let at = |s: &State| Vector2::new(s.x[1][axis], h * s.v[1][axis]);
                    let (expected, found) = (r * at(&before), at(&run.state));
                    let off = (found - expected).norm() / expected.norm().max(at(&before).norm());
                    assert!(
                        off < tolerance,
                        "{text}, θ={theta}, {shear}, η={eta}, step {step}: {off:e}"
                    );
                }
            }
        }
    }
}

/// A particle between two pinned ones: across the springs `θ` is implicit and `−σθ` explicit.
#[test]
fn motion_across_a_spring_sees_its_stiffness_split() {
    for ((name, pair), (theta, ratio)) in NAMES
        .into_iter()
        .flat_map(|t| [(100.0, 0.5), (100.0, 0.99), (100.0, 1.0), (0.36, 0.3)].map(|p| (t, p)))
    {
        let amplitude = 1e-9;
        let (k, _) = coefficients(0.5 * theta, 0.0);
        let middle = Vec3::new(0.0, amplitude, -0.5 * amplitude);
        let velocity = [Vec3::zeros(), Vec3::zeros(), -middle];
        let mut spec = particles(&[MASS; 3], &[-Vec3::x(), Vec3::x(), middle], &velocity);
        spec.pins = vec![pin(0), pin(1)];
        spec.springs = (0..2).map(|end| tension((end, 2), ratio, k, 0.0)).collect();
        let mut run = run(&format!("tableau={name}"), build(&spec), H);
        let r = additive_runge_kutta(&additive(pair), theta, -ratio * theta, 0.0);
        for step in 0..50 {
            let at = |s: &State| Vector2::new(s.x[2].y, H * s.v[2].y);
            let expected = r * at(&run.state);
            run.step();
            let off = (at(&run.state) - expected).norm() / expected.norm().max(amplitude);
            assert!(off < 1e-9, "{name}, θ={theta} ℓ/L={ratio}, step {step}: {off:e}");
        }
    }
}

/// Two particles of 1 kg on a spring of 1 m that turn by 2 rad/s at their equilibrium.
fn pair(theta: f64, h: f64) -> (System, State) {
    let kappa = theta / (h * h);
    let omega = 2.0;
    let length = kappa / (kappa - omega * omega);
    let (half, speed) = (Vec3::x() * (0.5 * length), Vec3::y() * (0.5 * omega * length));
    let mut spec = particles(&[1.0; 2], &[half, -half], &[speed, -speed]);
    spec.springs = vec![tension((0, 1), 1.0, 0.5 * kappa, 0.0)];
    build(&spec)
}

/// Angular momentum and angle after one second.
fn turn(text: &str, theta: f64) -> (f64, f64) {
    let mut run = run(text, pair(theta, 0.01), 0.01);
    let before = run.system.angular_momentum(&run.state).z;
    let mut angle = 0.0;
    for _ in 0..100 {
        let d = run.state.x[0] - run.state.x[1];
        run.step();
        let e = run.state.x[0] - run.state.x[1];
        angle += d.cross(&e).z.atan2(d.dot(&e));
    }
    assert!(run.system.momentum(&run.state).norm() < 1e-12);
    (run.system.angular_momentum(&run.state).z / before, angle)
}

/// `L/L₀` and angle at `θ = 1` and 100; exactly 1 and 2. At 100 nothing turns, and with `ark3` and
/// `ark4` the angular momentum does not tell.
#[test]
fn two_particles_turn_as_the_independent_computation_says() {
    let golden = [
        ("ars222", [(0.5343155466, 1.40496650), (0.0, 0.00328598)]),
        ("ars443", [(1.5541797764, 2.48478700), (0.0, 0.00143319)]),
        ("ark3", [(0.9971787873, 1.90031534), (0.9998003378, 0.09775669)]),
        ("ark4", [(1.0001203948, 2.01248749), (1.0008874219, 0.55157617)]),
    ];
    for (name, rows) in golden {
        for (theta, (momentum, angle)) in [1.0, 100.0].into_iter().zip(rows) {
            let found = turn(&format!("tableau={name}"), theta);
            assert!((found.0 - momentum).abs() < 1e-8, "{name}, θ={theta}: {found:?}");
            assert!((found.1 - angle).abs() < 1e-7, "{name}, θ={theta}: {found:?}");
        }
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola_and_feels_no_spring() {
    let velocity = Vec3::new(1.0, -2.0, 3.0);
    for (name, _) in NAMES {
        let sheet = Sheet { side: 9, tension: 1e6, shear: 1e5, pinned: false, ..Sheet::default() };
        let (system, mut state) = sheet.build();
        state.v.fill(velocity);
        let start = state.clone();
        // What `ark3` and `ark4` add to the last stage carries the round-off of the explicit force.
        let bound = if name.starts_with("ars") { 1e-11 } else { 1e-9 };
        let mut run = run(&format!("tableau={name}"), (system, state), H);
        for steps in 1..=20 {
            run.step();
            for i in 0..run.state.len() {
                let (x, v) =
                    free_fall(Drift::MeanVelocity, start.x[i], velocity, GRAVITY, H, steps);
                let off = (run.state.x[i] - x).norm() + (run.state.v[i] - v).norm();
                assert!(off < bound, "{name}, step {steps}: {off:e}");
            }
        }
    }
}

#[test]
fn momentum_is_kept_with_unequal_masses_and_both_laws_of_damping() {
    for ((name, _), law) in
        NAMES.into_iter().flat_map(|t| [DampingLaw::Full, DampingLaw::Projected].map(|l| (t, l)))
    {
        let sheet = Sheet { pinned: false, gravity: Vec3::zeros(), law, ..Sheet::default() };
        let mut run =
            run(&format!("tableau={name}"), uneven(stir(sheet.build(), 0.02, 1.0)), 0.004);
        let before = run.system.momentum(&run.state);
        run.steps(50);
        let drift = (run.system.momentum(&run.state) - before).norm();
        assert!(drift < 1e-14, "{name}, {law:?}: {drift:e}");
        assert!(run.state.is_finite());
    }
}

/// Observed order on a smooth scene, with all springs in the matrix and with shear springs explicit,
/// with both laws of damping.
#[test]
fn every_tableau_has_its_order() {
    for (law, implicit) in [DampingLaw::Full, DampingLaw::Projected]
        .into_iter()
        .flat_map(|law| ["springs", "tension"].map(|implicit| (law, implicit)))
    {
        let sheet =
            Sheet { side: 4, tension: 400.0, shear: 100.0, damping: 2.0, law, ..Sheet::default() };
        let (system, start) = stir(sheet.build(), 0.02, 0.5);
        let exact =
            reference(&system, &start, &[0.125], ReferenceSettings::default()).expect("exact");
        for (name, pair) in NAMES {
            let text = format!("tableau={name},implicit={implicit}");
            let new = || Box::new(method(&text)) as Box<dyn Integrator>;
            let found = of_method(new, &system, &start, &exact, &[40, 80, 160]).expect("an order");
            let order = f64::from(pair.tableau().order.number());
            let last = found.pairwise[found.pairwise.len() - 1];
            assert!((last - order).abs() < 0.15, "{text}, {law:?}: {found:?}");
        }
    }
}

/// A chain at rest is a fixed point, though its two parts of the force are large.
#[test]
fn an_equilibrium_is_a_fixed_point() {
    for (name, _) in NAMES {
        let (k, m) = (1e4, 0.5);
        let hang = |below: f64| 0.3 + below * m * -GRAVITY.z / k;
        let depth = [0.0, hang(2.0), hang(2.0) + hang(1.0)];
        let mut spec = particles(&[m; 3], &depth.map(|z| Vec3::z() * -z), &[]);
        spec.pins = vec![pin(0)];
        spec.effects.gravity = gravity();
        spec.springs = (0..2).map(|i| tension((i, i + 1), 0.3, k, 1.0)).collect();
        let start = build(&spec);
        let x = start.1.x.clone();
        let mut run = run(&format!("tableau={name}"), start, 0.05);
        run.steps(100);
        assert!(apart(&run.state.x, &x) < 1e-12, "{name}: {:e}", apart(&run.state.x, &x));
    }
}

#[test]
fn conjugate_gradients_come_as_close_as_their_tolerance() {
    for (name, _) in NAMES {
        let start = || {
            uneven(stir(
                Sheet { side: 8, tension: 1e4, shear: 1e3, ..Sheet::default() }.build(),
                0.02,
                0.5,
            ))
        };
        let end = |solver: &str| {
            let mut run = run(&format!("tableau={name},solver={solver}"), start(), 0.01);
            let reports = run.steps(20);
            assert!(reports.iter().all(|r| r.solve == SolveStatus::Converged), "{name}, {solver}");
            (run.state, reports.iter().map(|r| r.cg_iterations).sum::<u32>())
        };
        let ((exact, none), (found, iterations)) = (end("cholesky"), end("cg"));
        let off = apart(&exact.x, &found.x);
        assert!(none == 0 && iterations > 20 && off < 1e-6, "{name}: {off:e}, {iterations}");
    }
}

/// What changes between steps is followed: the next step is that of a fresh integrator.
#[test]
fn changes_of_the_system_and_the_step_size_are_followed() {
    for (name, _) in NAMES {
        let mut run =
            run(&format!("tableau={name}"), stir(Sheet::default().build(), 0.01, 0.5), 0.004);
        run.steps(2);
        let changes: [fn(&mut System) -> bool; 4] = [
            |s| s.scale_stiffness(drape_model::EffectKind::Tension, 4.0),
            |s| s.scale_damping(drape_model::EffectKind::Tension, 0.5),
            |s| s.set_pinned(7, true),
            |s| s.set_mass(&[2e-3; 25]),
        ];
        for (k, change) in changes.into_iter().enumerate() {
            assert!(change(&mut run.system), "change {k}");
            let mut fresh = self::run(
                &format!("tableau={name}"),
                (run.system.clone(), run.state.clone()),
                0.004,
            );
            run.h = [0.004, 0.003][k % 2];
            fresh.h = run.h;
            let (report, _) = (run.step(), fresh.step());
            assert_eq!(report.setups.total(), 1, "{name}, change {k}: {report:?}");
            assert_eq!(bits(&run.state), bits(&fresh.state), "{name}, change {k}");
            assert_eq!(run.step().setups.total(), 0, "{name}, change {k}");
        }
    }
}

/// Sweeps over the springs: the explicit forces of a stage, `−L_k X*` before a solve, and for `ark3`
/// and `ark4` the implicit force at the start.
#[test]
fn costs_are_counted() {
    for (name, sweeps) in [("ars222", 4), ("ars443", 8), ("ark3", 8), ("ark4", 12)] {
        let mut run = run(&format!("tableau={name}"), Sheet::default().build(), 0.004);
        let found: Vec<_> =
            run.steps(3).iter().map(|r| (r.force_evaluations, r.factorisations)).collect();
        assert_eq!(found, [(sweeps, 0); 3], "{name}");
    }
}

#[test]
fn obstacles_and_moving_pins_are_refused_by_name() {
    let mut contact = Sheet::default().spec();
    contact.obstacles = vec![floor(0.0)];
    let mut led = Sheet::default().spec();
    led.pins[0].path = vec![KeyframeSpec { time_s: 1.0, offset_m: [0.1, 0.0, 0.0] }];
    for (spec, expected) in [(contact, "contact"), (led, "moving pins")] {
        let (system, _) = build(&spec);
        let error = method("").prepare(&system, seconds(0.01)).expect_err("refused");
        assert!(
            matches!(&error, PrepareError::Unsupported { what, .. } if what == expected),
            "{error}"
        );
    }
}

/// A sheet that resists shear and bending by angles, in a steady wind with quadratic drag: all forces
/// take part with the full order.
#[test]
fn angles_and_wind_keep_the_order() {
    let sheet = Sheet { side: 4, tension: 400.0, shear: 0.0, damping: 2.0, ..Sheet::default() };
    let mut scene = sheet.scene();
    let law = |stiffness_n_m| Some(AngularLaw { stiffness_n_m });
    scene.effects.shear_angle = law(2e-3);
    scene.effects.bending_angle = law(2e-4);
    scene.effects.bending_hinge = law(2e-4);
    scene.effects.air = Some(AirSpec {
        drag: DragSpec::Quadratic { coefficient: 1.0, density_kg_m3: 0.1 },
        wind: Some(WindSpec { velocity_m_s: [1.0, 0.0, 3.0], gust: None }),
    });
    let (system, start) = stir(build(&scene.discretise().expect("valid")), 0.02, 0.2);
    let exact = reference(&system, &start, &[0.125], ReferenceSettings::default()).expect("exact");
    for (name, order) in NAMES.map(|(name, pair)| (name, pair.tableau().order.number())) {
        let text = format!("tableau={name}");
        let new = || Box::new(method(&text)) as Box<dyn Integrator>;
        let found = of_method(new, &system, &start, &exact, &[80, 160]).expect("an order");
        assert!((found.order - f64::from(order)).abs() < 0.2, "{text}: {found:?}");
    }
}

/// Steps of varying size keep the order: nothing of a step goes on in the next one.
#[test]
fn the_order_survives_changes_of_the_step_size() {
    let sheet = Sheet { side: 3, tension: 100.0, shear: 25.0, damping: 2.0, ..Sheet::default() };
    let (system, start) = stir(sheet.build(), 0.02, 1.0);
    let exact = reference(&system, &start, &[0.25], ReferenceSettings::default()).expect("exact");
    for ((name, order), pattern) in
        NAMES.map(|(name, pair)| (name, pair.tableau().order.number())).into_iter().flat_map(|t| {
            [&[1.0, 1.17, 1.34][..], &[1.0, 2.0], &[1.0, 1.5, 0.75, 1.25]].map(|p| (t, p))
        })
    {
        let error = |count: u32| {
            let unit = 0.25 / (f64::from(count) * pattern.iter().sum::<f64>());
            let text = format!("tableau={name}");
            let mut run = run(&text, (system.clone(), start.clone()), unit);
            for share in (0..count).flat_map(|_| pattern) {
                run.step_by(unit * share);
            }
            position_error(&system, &start.x, &exact.states[0].x, &run.state.x)
        };
        let found = order_of(0.25, &[20, 40, 80, 160], error).expect("an order");
        assert!((found.order - f64::from(order)).abs() < 0.15, "{name}, {pattern:?}: {found:?}");
    }
}
