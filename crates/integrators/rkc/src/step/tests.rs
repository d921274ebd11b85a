//! Tests of the step: its recurrence, order, laws, division, contacts, refusals.

use super::*;
use crate::settings::Division;
use drape_integrator::{Integrator, StepError};
use drape_model::{DampingLaw, EffectKind, KeyframeSpec, ObstacleSpec, SpringEffect, SystemSpec};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::checks;
use drape_oracle::order::{of_method, position_error};
use drape_oracle::recurrence;
use drape_oracle::reference::reference;
use drape_oracle::scenes::{GRAVITY, Sheet, anchored, build, floor, gravity, particles, stir};
use drape_oracle::{Run, bits, seconds};
use nalgebra::Vector2;

fn fixed(stages: u32) -> Box<Rkc> {
    Box::new(Rkc::new(RkcSettings { step: Division::Fixed, stages, ..RkcSettings::default() }))
}

fn prepared(spec: &SystemSpec, h: f64) -> Run {
    Run::new(Box::<Rkc>::default(), build(spec), h)
}

#[test]
fn a_step_is_that_of_its_recurrence() {
    const H: f64 = 1.0 / 64.0;
    const MASS: f64 = 0.25;
    for (stages, theta, eta) in
        [(2, 0.36, 0.06), (3, 1.0, 4.0), (6, 9.0, 20.0), (20, 100.0, 250.0), (200, 4.0, 1e4)]
    {
        let (k, c) = (theta * MASS / (H * H), eta * MASS / H);
        let springs = [(SpringEffect::Tension, 0.0, k, c)];
        let spec = anchored(MASS, &springs, Vec3::x(), Vec3::new(0.0, 20.0, 0.0));
        let mut run = Run::new(fixed(stages), build(&spec), H);
        let step = recurrence::rkc2(stages, theta, eta);
        let mut exact = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 20.0 * H)];
        for n in 0..20 {
            assert_eq!(run.step().force_evaluations, stages);
            for (axis, exact) in exact.iter_mut().enumerate() {
                *exact = step * *exact;
                let found = Vector2::new(run.state.x[1][axis], H * run.state.v[1][axis]);
                let off = (found - *exact).norm() / exact.norm().max(1e-3);
                // Round-off grows with the square of the stages.
                let allowed = 1e-12 + 1e-14 * f64::from(stages * stages);
                assert!(off < allowed, "s={stages} θ={theta} η={eta}, step {n}: {off:e}");
            }
        }
    }
}

#[test]
fn the_last_stage_is_the_stability_polynomial_and_ends_at_the_end_of_the_step() {
    for stages in 2..=200 {
        let coefficients = Coefficients::new(stages);
        assert_eq!(coefficients.count(), stages);
        let z = nalgebra::Complex::new(-0.4, 0.3);
        let off = (coefficients.polynomial(z) - recurrence::rkc2_polynomial(stages, z)).norm();
        assert!(off < 1e-10, "{stages}: {off:e}");
        // The times rise and the last one that is used is before the end.
        let times = coefficients.stages.iter().map(|stage| stage.time);
        assert!(times.clone().zip(times.skip(1)).all(|(a, b)| 0.0 < a && a < b && b < 1.0));
    }
}

#[test]
fn the_order_is_two() {
    for (law, stages) in [(DampingLaw::Full, 6), (DampingLaw::Projected, 3)] {
        for pinned in [true, false] {
            let sheet = Sheet {
                side: 6,
                tension: 400.0,
                shear: 100.0,
                damping: 2.0,
                law,
                pinned,
                ..Sheet::default()
            };
            let (system, start) = stir(sheet.build(), 0.02, 0.3);
            let exact = reference(&system, &start, &[0.25], AdaptiveSettings::default());
            let exact = exact.expect("a reference");
            let found = of_method(|| fixed(stages), &system, &start, &exact, &[80, 160, 320]);
            let order = found.expect("an order").order;
            assert!((order - 2.0).abs() < 0.15, "{law:?}: {order}");
        }
    }
}

/// Each stage takes the wind of its own time.
#[test]
fn a_gust_keeps_the_order() {
    for stages in [2, 6] {
        let found = checks::order_in_a_gust(|| fixed(stages), &[40, 80, 160]);
        assert!((found.order - 2.0).abs() < 0.2, "{stages} stages: {found:?}");
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola_and_keeps_its_momentum() {
    let sheet = Sheet { side: 9, tension: 1e4, shear: 1e3, damping: 50.0, ..Sheet::default() };
    let (system, state) = Sheet { pinned: false, ..sheet }.build();
    let (start, h) = (state.x.clone(), 1.0 / 64.0);
    let mut run = Run::new(Box::<Rkc>::default(), (system, state), h);
    for n in 1..=20 {
        run.step();
        let t = h * f64::from(n);
        for (x, start) in run.state.x.iter().zip(&start) {
            assert!((x - start - GRAVITY * (0.5 * t * t)).norm() < 1e-12, "step {n}");
        }
    }
    let free = Sheet { pinned: false, gravity: Vec3::zeros(), ..sheet };
    let mut run = Run::new(Box::<Rkc>::default(), stir(free.build(), 0.02, 1.0), h);
    let momentum = run.system.momentum(&run.state);
    run.steps(50);
    let drift = (run.system.momentum(&run.state) - momentum).norm();
    assert!(drift < 1e-14, "{drift:e}");
}

/// `h ≤ 2.6 d/k`, whatever the number of stages.
#[test]
fn a_step_is_divided_until_vibrations_are_stable() {
    for (tension, damping) in [(1e4, 100.0), (1e6, 1e3), (1e8, 1e4)] {
        let spec =
            Sheet { side: 9, tension, shear: 0.1 * tension, damping, ..Sheet::default() }.spec();
        let limit = 2.6 * damping / tension;
        let h = 10.0 * limit;
        let mut run = prepared(&spec, h);
        let report = run.step();
        let part = h / f64::from(report.substeps);
        assert!((0.6..1.5).contains(&(part / limit)), "{part} of {limit}");
        let start = run.energy();
        let mut most = start;
        for _ in 0..(0.05 / h).ceil() as u32 {
            run.step();
            most = most.max(run.energy());
        }
        assert!(most <= start + 1e-9, "{most} of {start}");
    }
}

#[test]
fn a_short_step_takes_few_stages_and_a_change_of_the_system_others() {
    let spec = Sheet { damping: 3.0, ..Sheet::default() }.spec();
    let mut run = prepared(&spec, 1e-4);
    assert_eq!(run.step().force_evaluations, 2);
    assert!(run.system.scale_damping(EffectKind::Tension, 1e6));
    let (system, state) = (run.system.clone(), run.state.clone());
    let mut fresh = Run::new(Box::<Rkc>::default(), (system, state), run.h);
    let (many, expected) = (run.step(), fresh.step());
    assert!(many.force_evaluations > 20 && many == expected, "{many:?} {expected:?}");
    assert_eq!(bits(&run.state), bits(&fresh.state));
    let most = RkcSettings { stages: 5, ..RkcSettings::default() };
    let (system, state) = (run.system.clone(), run.state.clone());
    let mut few = Run::new(Box::new(Rkc::new(most)), (system, state), run.h);
    let report = few.step();
    assert!(report.substeps > 10 && report.force_evaluations <= 5 * report.substeps);
    // Vibrations that are hardly damped have no stable step of any use.
    assert!(run.system.scale_damping(EffectKind::Tension, 1e-12));
    assert!(run.system.scale_damping(EffectKind::Shear, 1e-12));
    run.h = 1e3;
    let before = run.state.clone();
    assert!(matches!(run.try_step(), Err(StepError::TooManySubsteps { .. })));
    assert_eq!(run.state, before);
}

#[test]
fn springs_without_damping_are_refused_and_particles_without_springs_are_not() {
    let (system, _) = Sheet { damping: 0.0, ..Sheet::default() }.build();
    let error = Rkc::default().prepare(&system, seconds(0.01)).expect_err("refused").to_string();
    assert!(error.contains("springs without damping"), "{error}");
    let mut falling = particles(&[1.0], &[Vec3::zeros()], &[]);
    falling.effects.gravity = gravity();
    let mut run = prepared(&falling, 0.1);
    assert_eq!(run.step().force_evaluations, 2);
    assert!((run.state.v[0].z + 0.981).abs() < 1e-15);
}

#[test]
fn led_pins_are_on_their_paths_and_what_they_lead_follows() {
    let frame = |time_s, offset_m| KeyframeSpec { time_s, offset_m };
    let mut spec = Sheet { damping: 30.0, ..Sheet::default() }.spec();
    spec.pins[0].path = vec![frame(0.05, [0.1, -0.05, 0.0]), frame(0.1, [0.1, 0.0, 0.2])];
    let mut run = prepared(&spec, 0.004);
    for n in 0..40 {
        run.step();
        let pin = &run.system.moving_pins()[0];
        assert_eq!(run.state.x[pin.particle], pin.position(run.state.t), "step {n}");
    }
    assert_eq!(run.state.v[0], Vec3::zeros());
    let velocity = Vec3::new(1.0, -0.5, 2.0);
    let mut spec = Sheet { gravity: Vec3::zeros(), ..Sheet::default() }.spec();
    for pin in &mut spec.pins {
        pin.path = vec![frame(1.0, velocity.into())];
    }
    let (system, mut state) = build(&spec);
    let start = state.x.clone();
    state.v.fill(velocity);
    let mut run = Run::new(Box::<Rkc>::default(), (system, state), 0.004);
    run.steps(25);
    for (x, start) in run.state.x.iter().zip(&start) {
        assert!((x - start - velocity * run.state.t).norm() < 1e-11);
    }
}

#[test]
fn what_falls_on_a_floor_bounces_as_it_should_and_comes_to_rest() {
    for restitution in [0.0, 0.5, 1.0] {
        let mut spec = particles(&[0.5], &[Vec3::z()], &[]);
        spec.effects.gravity = gravity();
        spec.obstacles = vec![floor(restitution)];
        let mut run = prepared(&spec, 0.01);
        let (mut highest, mut lowest) = (0.0_f64, 0.0_f64);
        for step in 0..1000 {
            run.step();
            let height = run.state.x[0].z;
            lowest = lowest.min(height);
            highest = highest.max(if step > 60 { height } else { 0.0 });
        }
        assert!(lowest > -0.05, "{lowest}");
        if restitution == 1.0 {
            assert!((0.9..=1.0 + 1e-9).contains(&highest), "{highest}");
        } else {
            assert!(run.state.x[0].z.abs() < 1e-9 && run.state.v[0].norm() < 1e-12);
        }
    }
}

#[test]
fn a_sheet_comes_to_rest_on_a_rough_slope() {
    let mut spec = Sheet { pinned: false, damping: 30.0, ..Sheet::default() }.spec();
    spec.obstacles = vec![ObstacleSpec::Plane {
        point_m: [0.0, 0.0, -0.3],
        normal: [0.2, 0.0, 1.0],
        restitution: 0.0,
        friction: 0.5,
        path: Vec::new(),
    }];
    let mut run = prepared(&spec, 0.005);
    let start = run.energy();
    for _ in 0..800 {
        run.step();
        assert!(run.energy() <= start + 1e-9);
    }
    let fastest = run.state.v.iter().map(|v| v.norm()).fold(0.0, f64::max);
    assert!(fastest < 1e-3, "{fastest}");
}

/// As given, a step is stable below the limit and unstable beyond it, whatever the stages.
#[test]
fn a_fixed_step_beyond_the_limit_of_vibrations_blows_up() {
    let sheet = Sheet { side: 9, tension: 1e6, shear: 1e5, damping: 1e3, ..Sheet::default() };
    for (h, stages, is_stable) in [(0.002, 7, true), (0.005, 12, false), (0.005, 40, false)] {
        let mut run = Run::new(fixed(stages), sheet.build(), h);
        let start = run.energy();
        run.steps((0.3 / h) as usize);
        assert_eq!(run.energy() < start, is_stable, "h = {h}, s = {stages}: {}", run.energy());
    }
}

/// The hanging sheet of the docs: 20 × 20 particles, 0.3 s.
#[test]
#[ignore = "measures: seconds"]
#[expect(clippy::print_stderr, reason = "it measures")]
fn measured_on_the_hanging_sheet() {
    for (tension, damping, h) in [
        (1e6, 1e3, 0.01),
        (1e6, 1e3, 0.002),
        (1e6, 1e3, 0.0005),
        (1e6, 40.0, 0.01),
        (1e8, 1e4, 0.01),
    ] {
        let sheet = Sheet { side: 20, tension, shear: 0.1 * tension, damping, ..Sheet::default() };
        let (system, start) = sheet.build();
        let settings = AdaptiveSettings { tolerance: 1e-10, ..AdaptiveSettings::default() };
        let exact = reference(&system, &start, &[0.3], settings);
        let exact = exact.expect("a reference");
        let mut run = Run::new(Box::<Rkc>::default(), (system.clone(), start.clone()), h);
        let before = run.energy();
        let (mut forces, mut substeps, mut most) = (0, 0, f64::NEG_INFINITY);
        for _ in 0..(0.3 / h).round() as u32 {
            let report = run.step();
            forces += report.force_evaluations;
            substeps += report.substeps;
            most = most.max(run.energy() - before);
        }
        let error = position_error(&system, &start.x, &exact.states[0].x, &run.state.x);
        eprintln!(
            "k/m {tension:e} d/m {damping:e} h {h}: {substeps} substeps, {forces} forces, \
             error {error:.2e}, rise {most:.2e} J"
        );
    }
}

#[test]
fn the_fast_root_of_a_damped_mode_limits_the_step_too() {
    // Without stiffness the slow root is 0. The real interval ends near −2/3 (s² − 1).
    let coefficients = Coefficients::new(6);
    assert!(coefficients.is_stable(1.0, 0.0, 22.0) && !coefficients.is_stable(1.0, 0.0, 24.0));
    assert!(coefficients.is_stable(1.0, 1e-3, 22.0) && !coefficients.is_stable(1.0, 1e-3, 24.0));
}
