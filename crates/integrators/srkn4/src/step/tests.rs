//! Tests of the step: its recurrence, order, laws, forces kept from step to step, divided steps,
//! refusals.

use super::*;
use drape_integrator::StepControl;
use drape_model::{DampingLaw, EffectKind, KeyframeSpec, SpringEffect, SystemSpec};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::laws::spin;
use drape_oracle::order::{of_method, position_error};
use drape_oracle::recurrence;
use drape_oracle::reference::reference;
use drape_oracle::scenes::{
    GRAVITY, Sheet, anchored, build, floor, gravity, particles, stir, tension,
};
use drape_oracle::{Run, bits, seconds};
use nalgebra::Vector2;

fn dividing(step: StepControl, safety: f64) -> Box<Srkn4> {
    Box::new(Srkn4::new(Srkn4Settings { step, safety }))
}

fn prepared(spec: &SystemSpec, h: f64) -> Run {
    Run::new(Box::<Srkn4>::default(), build(spec), h)
}

#[test]
fn a_step_is_that_of_its_recurrence() {
    const H: f64 = 1.0 / 64.0;
    const MASS: f64 = 0.25;
    for (theta, eta) in [(0.36, 0.0), (4.0, 0.0), (0.36, 0.06), (4.0, 3.0), (12.0, 7.5)] {
        let (k, c) = (theta * MASS / (H * H), eta * MASS / H);
        let springs = [(SpringEffect::Tension, 0.0, k, c)];
        let spec = anchored(MASS, &springs, Vec3::x(), Vec3::new(0.0, 20.0, 0.0));
        let mut run = prepared(&spec, H);
        let step = recurrence::srkn4(theta, eta, TERMS);
        let mut exact = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 20.0 * H)];
        for n in 0..50 {
            run.step();
            for (axis, exact) in exact.iter_mut().enumerate() {
                *exact = step * *exact;
                let found = Vector2::new(run.state.x[1][axis], H * run.state.v[1][axis]);
                let size = exact.norm().max(1e-3);
                let off = (found - *exact).norm() / size;
                assert!(off < 1e-12, "θ={theta} η={eta}, step {n}: {off:e}");
            }
        }
    }
}

/// Two particles in random motion: kicks pull along their distance, drifts keep the momentum.
#[test]
fn the_spin_of_two_particles_obeys_its_law() {
    let (h, k, c): (f64, f64, f64) = (1.0 / 64.0, 150.0, 1.5);
    let x = [Vec3::zeros(), Vec3::new(0.3, -0.5, 0.7)];
    let mut spec = particles(&[0.25; 2], &x, &[Vec3::new(1.0, 2.0, -1.0), Vec3::zeros()]);
    for c in [0.0, c] {
        spec.springs = vec![tension((0, 1), 0.5, k, c)];
        let mut run = prepared(&spec, h);
        let (momentum, start) = (run.system.momentum(&run.state), spin_of(&run));
        let factor = spin::kicks(&KICKS, 2.0 * h * c / 0.25, TERMS);
        for n in 1..=40 {
            run.step();
            let expected = start * factor.powi(n);
            assert!((spin_of(&run) - expected).norm() < 1e-13, "step {n}");
            assert!((run.system.momentum(&run.state) - momentum).norm() < 1e-14);
        }
    }
}

fn spin_of(run: &Run) -> Vec3 {
    let (x, v) = (&run.state.x, &run.state.v);
    (x[1] - x[0]).cross(&(v[1] - v[0]))
}

/// At its equilibrium length a pair of `κ = 2k/m` turns by 2 rad in a second.
#[test]
fn a_pair_in_rigid_rotation_turns_by_its_angle() {
    let (kappa, omega) = (1e4_f64, 2.0);
    let length = kappa / (kappa - omega * omega);
    let (x, v) = (Vec3::x() * (0.5 * length), Vec3::y() * (0.5 * length * omega));
    let mut spec = particles(&[1.0; 2], &[-x, x], &[-v, v]);
    spec.springs = vec![tension((0, 1), 1.0, 0.5 * kappa, 0.0)];
    let mut run = prepared(&spec, 0.01);
    let start = spin_of(&run);
    run.steps(100);
    let d = run.state.x[1] - run.state.x[0];
    let angle = d.y.atan2(d.x);
    assert!((angle - 2.0).abs() < 1e-8, "{angle}");
    assert!((spin_of(&run) - start).norm() < 1e-12);
}

#[test]
fn the_order_is_four_with_and_without_damping() {
    let (full, projected) = (DampingLaw::Full, DampingLaw::Projected);
    for (damping, law, pinned) in
        [(0.0, full, true), (2.0, full, true), (2.0, full, false), (2.0, projected, false)]
    {
        let (tension, shear) = (400.0, 100.0);
        let sheet = Sheet { side: 6, tension, shear, damping, law, pinned, ..Sheet::default() };
        let (system, start) = stir(sheet.build(), 0.02, 0.3);
        let exact = reference(&system, &start, &[0.25], AdaptiveSettings::default());
        let exact = exact.expect("a reference");
        let found = of_method(|| Box::<Srkn4>::default(), &system, &start, &exact, &[20, 40, 80]);
        let order = found.expect("an order").order;
        assert!((order - 4.0).abs() < 0.15, "d/m = {damping}: {order}");
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola() {
    let sheet = Sheet { side: 9, tension: 100.0, shear: 10.0, pinned: false, ..Sheet::default() };
    let (system, state) = sheet.build();
    let (start, h) = (state.x.clone(), 1.0 / 64.0);
    let mut run = Run::new(Box::<Srkn4>::default(), (system, state), h);
    for n in 1..=20 {
        run.step();
        let t = h * f64::from(n);
        for (x, start) in run.state.x.iter().zip(&start) {
            assert!((x - start - GRAVITY * (0.5 * t * t)).norm() < 1e-13, "step {n}");
        }
    }
}

#[test]
fn a_step_takes_six_forces_and_the_last_one_begins_the_next_step() {
    for (damping, products) in [(0.0, 0), (1.0, 7 * TERMS)] {
        let mut run = prepared(&Sheet { damping, ..Sheet::default() }.spec(), 1e-3);
        let counts = |run: &mut Run| {
            let report = run.step();
            (report.force_evaluations, report.matvecs)
        };
        assert_eq!(counts(&mut run), (7, products));
        assert_eq!(counts(&mut run), (6, products));
        run.h *= 0.5;
        run.state.v[12].x += 1.0;
        assert_eq!(counts(&mut run), (6, products));
        assert!(run.system.scale_stiffness(EffectKind::Tension, 1.5));
        let (system, state) = (run.system.clone(), run.state.clone());
        let mut fresh = Run::new(Box::<Srkn4>::default(), (system, state), run.h);
        assert_eq!(counts(&mut run), (7, products));
        fresh.step();
        assert_eq!(bits(&run.state), bits(&fresh.state));
        run.state.x[7].z += 1e-15;
        assert_eq!(counts(&mut run), (7, products));
        run.restart();
        assert_eq!(counts(&mut run), (7, products));
    }
}

#[test]
fn a_divided_step_is_its_substeps_taken_one_by_one() {
    for (damping, step) in [(0.0, StepControl::Auto), (1.0, StepControl::Bound)] {
        let spec = Sheet { damping, ..Sheet::default() }.spec();
        let mut divided = Run::new(dividing(step, 0.5), build(&spec), 0.25);
        let count = divided.step().substeps;
        let mut whole = prepared(&spec, 0.25 / f64::from(count));
        whole.steps(count as usize);
        assert_eq!((&divided.state.x, &divided.state.v), (&whole.state.x, &whole.state.v));
        assert_eq!(divided.state.t, 0.25);
        assert!(count > 4, "{count}");
    }
    // Damping alone divides, too.
    let spec = Sheet { tension: 1.0, shear: 0.0, damping: 1e3, ..Sheet::default() }.spec();
    let mut run = Run::new(dividing(StepControl::Bound, 1.0), build(&spec), 0.1);
    assert_eq!(run.step().substeps, 100, "hδ = 0.1 · 8 · 1e3 over 8");
    run.steps(50);
    assert!(run.state.is_finite());
    // Whatever comes out of a division without a limit.
    let free = particles(&[1.0], &[Vec3::zeros()], &[Vec3::x()]);
    assert_eq!(Run::new(dividing(StepControl::Auto, 0.7), build(&free), 1e9).step().substeps, 1);
}

#[test]
fn what_negative_substeps_cannot_take_is_refused_by_name() {
    let refused = |spec: &SystemSpec| {
        let (system, _) = build(spec);
        let mut integrator = Srkn4::default();
        let error = drape_integrator::Integrator::prepare(&mut integrator, &system, seconds(0.01));
        error.expect_err("refused").to_string()
    };
    let sheet = Sheet::default();
    let mut contact = sheet.spec();
    contact.obstacles = vec![floor(0.0)];
    assert!(refused(&contact).contains("contact"));
    let mut led = sheet.spec();
    led.pins[0].path = vec![KeyframeSpec { time_s: 1.0, offset_m: [0.1; 3] }];
    assert!(refused(&led).contains("moving pins"));
    let mut falling = particles(&[1.0], &[Vec3::zeros()], &[]);
    falling.effects.gravity = gravity();
    assert!(prepared(&falling, 0.1).step().force_evaluations == 7);
}

/// The hanging sheet of the docs: 20 × 20 particles, 0.3 s.
#[test]
#[ignore = "measures: seconds"]
#[expect(clippy::print_stderr, reason = "it measures")]
fn measured_on_the_hanging_sheet() {
    for (tension, h, damping) in
        [(1e4, 0.03 / 1.1, 40.0), (1e4, 0.3 / 16.0, 40.0), (1e6, 0.3 / 157.0, 40.0)]
    {
        let sheet = Sheet { side: 20, tension, shear: 0.1 * tension, damping, ..Sheet::default() };
        let (system, start) = sheet.build();
        let settings = AdaptiveSettings::default();
        let exact = reference(&system, &start, &[0.3], settings).expect("a reference");
        let steps = (0.3_f64 / h).round();
        let mut run =
            Run::new(Box::<Srkn4>::default(), (system.clone(), start.clone()), 0.3 / steps);
        let forces: u32 =
            run.steps(steps as usize).iter().map(|report| report.force_evaluations).sum();
        let error = position_error(&system, &start.x, &exact.states[0].x, &run.state.x);
        eprintln!("k/m {tension:e}, {steps} steps, {forces} forces: {error:.2e}");
    }
    for (damping, c) in [(0.0, 2.0), (40.0, 2.0), (0.0, 1.75), (0.0, 3.0)] {
        let sheet = Sheet { side: 20, tension: 1e6, shear: 1e5, damping, ..Sheet::default() };
        let (system, start) = sheet.build();
        let h = c * 2.0 / 4.35e6_f64.sqrt();
        let mut run = Run::new(Box::<Srkn4>::default(), (system, start), h);
        let (before, mut most) = (run.energy(), f64::NEG_INFINITY);
        for _ in 0..(2.0 / h) as u32 {
            run.step();
            most = most.max(run.energy() - before);
        }
        eprintln!("d/m {damping}, c {c}: rise {most:.3e} J, end {:.3e} J", run.energy() - before);
    }
}
