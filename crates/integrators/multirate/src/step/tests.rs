//! Tests of the step: its recurrence, resonance, order, laws, kept forces, contacts and pins.

use super::*;
use crate::settings::Slow;
use drape_integrator::Integrator;
use drape_model::{DampingLaw, EffectKind, KeyframeSpec, SpringEffect, SystemSpec};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::order::{of_method, position_error};
use drape_oracle::recurrence::{impulse, leapfrog_explicit_damping};
use drape_oracle::reference::reference;
use drape_oracle::scenes::{GRAVITY, Sheet, anchored, build, floor, gravity, particles, stir};
use drape_oracle::{Run, bits};
use nalgebra::Vector2;

fn with(ratio: u32) -> Box<dyn Integrator> {
    Box::new(Multirate::new(MultirateSettings { ratio, ..MultirateSettings::default() }))
}

fn prepared(spec: &SystemSpec, h: f64) -> Run {
    Run::new(with(3), build(spec), h)
}

const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;

/// An anchored particle on a fast and a slow spring without length.
fn two_springs(fast: f64, slow: f64, eta: f64) -> SystemSpec {
    let k = |theta: f64| theta * MASS / (H * H);
    let springs = [
        (SpringEffect::Tension, 0.0, k(fast), eta * MASS / H),
        (SpringEffect::Shear, 0.0, k(slow), 0.0),
    ];
    anchored(MASS, &springs, Vec3::x(), Vec3::new(0.0, 20.0, 0.0))
}

#[test]
fn a_step_is_that_of_its_recurrence() {
    for (ratio, fast, slow, eta) in
        [(1, 0.3, 0.2, 0.1), (3, 4.0, 0.5, 0.0), (3, 4.0, 0.5, 0.3), (7, 6.0, 1.5, 2.0)]
    {
        let mut run = Run::new(with(ratio), build(&two_springs(fast, slow, eta)), H);
        let step = impulse(fast, slow, eta, ratio);
        let mut exact = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 20.0 * H)];
        for n in 0..50 {
            run.step();
            for (axis, exact) in exact.iter_mut().enumerate() {
                *exact = step * *exact;
                let found = Vector2::new(run.state.x[1][axis], H * run.state.v[1][axis]);
                let off = (found - *exact).norm() / exact.norm().max(1e-3);
                assert!(off < 1e-12, "ratio {ratio}, step {n}: {off:e}");
            }
        }
    }
}

/// Far below the limits of both forces, a step of half a period of the fast one is unstable.
#[test]
fn a_step_of_half_a_period_of_the_fast_force_resonates() {
    for (phase, is_stable) in [(1.57, true), (3.06, false), (4.5, true)] {
        let mut run = Run::new(with(32), build(&two_springs(phase * phase, 0.5, 0.0)), H);
        run.steps(600);
        assert_eq!(run.state.x[1].norm() < 10.0, is_stable, "{phase}: {}", run.state.x[1]);
    }
}

#[test]
fn without_slow_forces_it_is_leapfrog_with_its_short_steps() {
    let mut run = Run::new(with(5), build(&two_springs(20.0, 0.0, 1.0)), H);
    let short = leapfrog_explicit_damping(20.0 / 25.0, 1.0 / 5.0);
    let mut exact = Vector2::new(1.0, 0.0);
    for _ in 0..20 {
        run.step();
        exact = (0..5).fold(exact, |y, _| short * y);
        assert!((run.state.x[1].x - exact.x).abs() < 1e-12);
    }
}

#[test]
fn the_order_is_two() {
    for (law, pinned) in [(DampingLaw::Full, true), (DampingLaw::Projected, false)] {
        let (tension, shear, damping) = (400.0, 100.0, 2.0);
        let sheet = Sheet { side: 6, tension, shear, damping, law, pinned, ..Sheet::default() };
        let (system, start) = stir(sheet.build(), 0.02, 0.3);
        let exact = reference(&system, &start, &[0.25], AdaptiveSettings::default());
        let exact = exact.expect("a reference");
        let found = of_method(|| with(3), &system, &start, &exact, &[40, 80, 160, 320]);
        let order = found.expect("an order").order;
        assert!((order - 2.0).abs() < 0.15, "{law:?}: {order}");
    }
}

#[test]
fn momentum_and_spin_are_kept_and_free_fall_is_exact() {
    let sheet = Sheet { side: 6, damping: 0.0, pinned: false, ..Sheet::default() };
    let start = stir(Sheet { gravity: Vec3::zeros(), ..sheet }.build(), 0.02, 1.0);
    let mut run = Run::new(with(3), start, 0.005);
    let of = |run: &Run| (run.system.momentum(&run.state), run.system.angular_momentum(&run.state));
    let (momentum, spin) = of(&run);
    run.steps(200);
    let (now, spin_now) = of(&run);
    assert!((now - momentum).norm() < 1e-14 && (spin_now - spin).norm() < 1e-14);
    let (system, state) = Sheet { damping: 4.0, ..sheet }.build();
    let start = state.x.clone();
    let mut run = Run::new(with(3), (system, state), H);
    for n in 1..=20 {
        run.step();
        let t = H * f64::from(n);
        for (x, start) in run.state.x.iter().zip(&start) {
            assert!((x - start - GRAVITY * (0.5 * t * t)).norm() < 1e-12, "step {n}");
        }
    }
}

#[test]
fn forces_are_kept_until_something_changes_them() {
    let mut run = prepared(&Sheet { damping: 0.0, ..Sheet::default() }.spec(), 0.005);
    let count = |run: &mut Run| run.step().force_evaluations;
    assert_eq!([count(&mut run), count(&mut run)], [3 + 1 + 2, 3 + 1]);
    assert!(run.system.scale_stiffness(EffectKind::Shear, 1.5));
    let (system, state) = (run.system.clone(), run.state.clone());
    let mut fresh = Run::new(with(3), (system, state), run.h);
    assert_eq!([count(&mut run), count(&mut fresh)], [6, 6]);
    assert_eq!(bits(&run.state), bits(&fresh.state));
}

#[test]
fn each_choice_of_slow_forces_divides_all_effects() {
    let scene = build(&Sheet::default().spec());
    for slow in [Slow::ButTension, Slow::Bending, Slow::Angles] {
        let [is_slow, is_fast] = slow.selects();
        for effect in scene.0.effects() {
            assert!(is_slow(effect) != is_fast(effect), "{slow:?}, {}", effect.name());
            assert!(effect.name() != "tension" || is_fast(effect));
        }
    }
}

#[test]
fn led_pins_are_on_their_paths_and_what_falls_comes_to_rest() {
    let frame = |time_s, offset_m| KeyframeSpec { time_s, offset_m };
    let mut spec = Sheet::default().spec();
    spec.pins[0].path = vec![frame(0.05, [0.1, -0.05, 0.0]), frame(0.1, [0.1, 0.0, 0.2])];
    let mut run = prepared(&spec, 0.004);
    for n in 0..40 {
        run.step();
        let pin = &run.system.moving_pins()[0];
        let off = (run.state.x[pin.particle] - pin.position(run.state.t)).norm();
        assert!(off < 1e-14, "step {n}: {off:e}");
    }
    assert_eq!(run.state.v[0], Vec3::zeros());
    for restitution in [0.0, 0.5, 1.0] {
        let mut spec = particles(&[0.5], &[Vec3::z()], &[]);
        spec.effects.gravity = gravity();
        spec.obstacles = vec![floor(restitution)];
        let mut run = prepared(&spec, 0.01);
        let mut highest = 0.0_f64;
        for step in 0..1000 {
            run.step();
            highest = highest.max(if step > 60 { run.state.x[0].z } else { 0.0 });
        }
        if restitution == 1.0 {
            assert!((0.9..=1.0 + 1e-9).contains(&highest), "{highest}");
        } else {
            assert!(run.state.x[0].z.abs() < 1e-9 && run.state.v[0].norm() < 1e-12);
        }
    }
    // A sheet that lies down.
    let mut spec = Sheet { pinned: false, damping: 10.0, ..Sheet::default() }.spec();
    spec.obstacles = vec![floor(0.0)];
    let mut run = prepared(&spec, 0.004);
    run.steps(2000);
    let fastest = run.state.v.iter().map(|v| v.norm()).fold(0.0, f64::max);
    assert!(fastest < 1e-6, "{fastest}");
}

/// The hanging sheet of the docs: 20 × 20 particles.
#[test]
#[ignore = "measures: seconds"]
#[expect(clippy::print_stderr, reason = "it measures")]
fn measured_on_the_hanging_sheet() {
    let omega = |tension: f64| (4.35 * tension).sqrt();
    for (tension, h) in [(1e6, 9.6e-4), (1e6, 1.92e-3), (1e4, 0.019)] {
        let (shear, damping) = (0.1 * tension, 40.0);
        let sheet = Sheet { side: 20, tension, shear, damping, ..Sheet::default() };
        let (system, start) = sheet.build();
        let exact = reference(&system, &start, &[0.3], AdaptiveSettings::default());
        let exact = exact.expect("a reference");
        let steps = (0.3_f64 / h).round();
        let mut run = Run::new(with(3), (system.clone(), start.clone()), 0.3 / steps);
        run.steps(steps as usize);
        let error = position_error(&system, &start.x, &exact.states[0].x, &run.state.x);
        eprintln!("k/m {tension:e}, H {h}, {steps} steps: {error:.2e}");
    }
    for (tension, damping, factor, ratio) in [
        (1e6, 0.0, 4.0, 3),
        (1e6, 40.0, 4.0, 3),
        (1e6, 0.0, 2.0, 3),
        (1e6, 0.0, 1.57, 2),
        (1e8, 40.0, 4.0, 3),
        (1e8, 40.0, 2.0, 3),
    ] {
        let shear = 0.1 * tension;
        let sheet = Sheet { side: 20, tension, shear, damping, ..Sheet::default() };
        let h = factor / omega(tension);
        let mut run = Run::new(with(ratio), sheet.build(), h);
        let (start, mut most) = (run.energy(), f64::NEG_INFINITY);
        let span = if tension > 1e7 { 0.5 } else { 2.0 };
        for _ in 0..(span / h) as u32 {
            run.step();
            most = most.max(run.energy() - start);
        }
        eprintln!("k/m {tension:e} d/m {damping} H = {factor}/ω, ratio {ratio}: rise {most:.2e} J");
    }
}
