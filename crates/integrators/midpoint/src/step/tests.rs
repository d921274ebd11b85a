//! The step against its recurrence and its laws, alone and in contact.

use crate::{Midpoint, MidpointSettings};
use drape_integrator::{Integrator, SolveStatus, TimeStep};
use drape_model::{DampingLaw, ObstacleSpec, SpringEffect, State, System, SystemSpec, Vec3};
use drape_oracle::laws::{Drift, free_fall, spin};
use drape_oracle::order::{of_method, position_error};
use drape_oracle::recurrence::implicit_midpoint;
use drape_oracle::reference::{ReferenceSettings, reference};
use drape_oracle::scenes::{
    GRAVITY, Sheet, anchored, build, floor, gravity, particles, stir, tension,
};
use drape_oracle::{Run, order_of, seconds};
use nalgebra::Vector2;

const TIGHT: &[(&str, &str)] = &[("residual", "1e-16")];

fn midpoint(pairs: &[(&str, &str)]) -> Box<dyn Integrator> {
    let settings = MidpointSettings::from_pairs(pairs.iter().copied()).expect("in range");
    Midpoint::controlled(settings)
}

#[test]
fn a_spring_without_length_moves_by_the_recurrence_at_any_step_sizes() {
    let h = 1.0 / 64.0;
    for (theta, eta) in [(0.36, 0.06), (1.0, 0.0), (100.0, 0.4), (100.0, 0.0), (2.0, 30.0)] {
        let (k, c) = (theta * 0.25 / (h * h), eta * 0.25 / h);
        let springs = [(SpringEffect::Tension, 0.0, k, c)];
        let spec = anchored(0.25, &springs, Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
        let mut run = Run::new(midpoint(TIGHT), build(&spec), h);
        let mut exact = [0, 1, 2].map(|k| (run.state.x[1][k], run.state.v[1][k]));
        for step in 0..100 {
            let ratio = [1.0, 2.0, 0.75, 0.5, 1.5][step % 5];
            run.step_by(ratio * h);
            for (axis, (x, v)) in exact.iter_mut().enumerate() {
                let matrix = implicit_midpoint(theta * ratio * ratio, eta * ratio);
                let size = x.hypot(*v * ratio * h);
                let next = matrix * Vector2::new(*x, *v * ratio * h);
                (*x, *v) = (next.x, next.y / (ratio * h));
                let found = Vector2::new(run.state.x[1][axis], run.state.v[1][axis] * ratio * h);
                let error = (found - next).norm() / next.norm().max(size).max(1e-3);
                assert!(error < 1e-9, "θ={theta} η={eta}, step {step}: {error:e}");
            }
        }
    }
}

/// `d × v` of two particles, and the angle of `d`.
fn turn(state: &State) -> (f64, f64) {
    let (d, v) = (state.x[1] - state.x[0], state.v[1] - state.v[0]);
    (d.cross(&v).z, d.y.atan2(d.x))
}

/// Two particles of 1 kg on a spring of rest length 1 that turn by 2 rad/s at the length where the
/// spring bears the rotation.
fn rotor(theta: f64) -> (System, State) {
    let kappa: f64 = theta / 1e-4;
    let half = Vec3::x() * (0.5 * kappa / (kappa - 4.0));
    let mut spec =
        particles(&[1.0; 2], &[-half, half], &[-half, half].map(|x| 2.0 * Vec3::z().cross(&x)));
    spec.springs = vec![tension((0, 1), 1.0, 0.5 * kappa, 0.0)];
    build(&spec)
}

/// Numbers of an independent implementation: spin, angle and energy after 1 s at h = 0.01.
#[test]
fn a_stiff_pair_turns_as_an_independent_implementation_says() {
    for (theta, angle, energy) in
        [(1.0, 1.999_731_52, None), (100.0, 1.999_730_83, Some(1.001_441_72))]
    {
        let mut run = Run::new(midpoint(TIGHT), rotor(theta), 0.01);
        let (before, start) = (turn(&run.state).0, run.energy());
        run.steps(100);
        let (spin, found) = turn(&run.state);
        assert!((spin / before - 1.0).abs() < 1e-8, "θ={theta}: spin {}", spin / before);
        assert!((found - angle).abs() < 1e-6, "θ={theta}: angle {found}");
        let kept = run.energy() / start;
        assert!(energy.is_none_or(|e: f64| (kept - e).abs() < 1e-6), "θ={theta}: energy {kept}");
    }
}

/// Damping that is linear in the velocity takes spin by the law of the step.
#[test]
fn full_damping_takes_spin_by_the_law() {
    let (h, theta, eta) = (1.0 / 64.0, 10.0, 0.125);
    let (k, c) = (0.5 * theta * 0.25 / (h * h), 0.5 * eta * 0.25 / h);
    let (x, v) = ([Vec3::zeros(), Vec3::new(0.6, 0.0, 0.0)], [Vec3::y(), -Vec3::y()]);
    let mut spec = particles(&[0.25; 2], &x, &v);
    spec.springs = vec![tension((0, 1), 0.5, k, c)];
    let mut run = Run::new(midpoint(TIGHT), build(&spec), h);
    for step in 0..50 {
        let (before, x) = (turn(&run.state).0, run.state.x.clone());
        run.step();
        let middle = (run.state.x[1] - run.state.x[0] + x[1] - x[0]) * 0.5;
        let factor = spin::implicit_midpoint(theta, eta, 0.5 / middle.norm());
        let after = turn(&run.state).0;
        assert!((after - factor * before).abs() < 1e-8 * before.abs(), "step {step}");
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola() {
    let sheet = Sheet {
        side: 9,
        tension: 1e6,
        shear: 1e5,
        damping: 4.0,
        pinned: false,
        ..Sheet::default()
    };
    let (system, mut state) = sheet.build();
    state.v.fill(Vec3::new(1.0, -2.0, 3.0));
    let start = state.clone();
    let mut run = Run::new(midpoint(&[]), (system, state), 1.0 / 64.0);
    for n in 1..=20 {
        run.step();
        for i in 0..start.len() {
            let (x, v) =
                free_fall(Drift::MeanVelocity, start.x[i], start.v[i], GRAVITY, 1.0 / 64.0, n);
            let error = (run.state.x[i] - x).norm() + (run.state.v[i] - v).norm();
            assert!(error < 1e-11, "step {n}, particle {i}: {error:e}");
        }
    }
}

fn smooth(law: DampingLaw) -> Sheet {
    Sheet { side: 5, tension: 400.0, shear: 100.0, damping: 2.0, law, ..Sheet::default() }
}

#[test]
fn the_order_is_two_with_both_laws_of_damping() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let (system, start) = stir(smooth(law).build(), 0.02, 0.3);
        let exact = reference(&system, &start, &[0.25], ReferenceSettings::default())
            .unwrap_or_else(|error| panic!("{error}"));
        let found = of_method(
            || midpoint(&[("residual", "1e-13")]),
            &system,
            &start,
            &exact,
            &[20, 40, 80],
        )
        .unwrap_or_else(|error| panic!("{error}"));
        assert!((found.order - 2.0).abs() < 0.15, "{law:?}: {found:?}");
        // Uneven steps as well.
        let error = |count: u32| {
            let unit = 0.25 / (3.0 * f64::from(count));
            let mut run =
                Run::new(midpoint(&[("residual", "1e-13")]), (system.clone(), start.clone()), unit);
            for n in 0..2 * count {
                run.step_by(unit * f64::from(1 + n % 2));
            }
            position_error(&system, &start.x, &exact.states[0].x, &run.state.x)
        };
        let found = order_of(0.25, &[20, 40, 80], error).unwrap_or_else(|error| panic!("{error}"));
        assert!((found.order - 2.0).abs() < 0.15, "{law:?}, uneven: {found:?}");
    }
}

/// One linear solve a step, by CG or directly: order 2 is kept, because Newton starts within
/// `O(h²)` and squares that.
#[test]
fn one_newton_iteration_by_conjugate_gradients_keeps_order_two() {
    let (system, start) = stir(smooth(DampingLaw::Full).build(), 0.02, 0.3);
    let exact = reference(&system, &start, &[0.25], ReferenceSettings::default())
        .unwrap_or_else(|error| panic!("{error}"));
    for cheap in [
        &[("max_iterations", "1")][..],
        &[("max_iterations", "1"), ("solver", "cg"), ("cg_tolerance", "0.01")],
    ] {
        let found = of_method(|| midpoint(cheap), &system, &start, &exact, &[20, 40, 80, 160])
            .unwrap_or_else(|error| panic!("{error}"));
        assert!((found.order - 2.0).abs() < 0.2, "{cheap:?}: {found:?}");
    }
}

#[test]
fn momentum_and_spin_of_a_free_sheet_are_kept() {
    let free = Sheet {
        pinned: false,
        gravity: Vec3::zeros(),
        damping: 0.0,
        tension: 1e6,
        shear: 1e5,
        ..Sheet::default()
    };
    let mut run = Run::new(midpoint(TIGHT), stir(free.build(), 0.0, 0.3), 1e-3);
    let of = |run: &Run| (run.system.momentum(&run.state), run.system.angular_momentum(&run.state));
    let (p, l) = of(&run);
    run.steps(50);
    let (p_end, l_end) = of(&run);
    assert!(
        (p_end - p).norm() < 1e-13 && (l_end - l).norm() < 1e-11,
        "{:e} {:e}",
        (p_end - p).norm(),
        (l_end - l).norm()
    );
}

fn above(restitution: f64, friction: f64, normal: [f64; 3], x: Vec3, v: Vec3) -> SystemSpec {
    let mut spec = particles(&[0.5], &[x], &[v]);
    spec.effects.gravity = gravity();
    let path = Vec::new();
    spec.obstacles =
        vec![ObstacleSpec::Plane { point_m: [0.0; 3], normal, restitution, friction, path }];
    spec
}

#[test]
fn a_dropped_particle_comes_to_rest_and_an_elastic_one_returns_to_its_height() {
    for e in [0.0, 0.5, 1.0] {
        let spec = above(e, 0.0, [0.0, 0.0, 1.0], Vec3::z(), Vec3::zeros());
        let mut run = Run::new(midpoint(&[]), build(&spec), 0.01);
        let start = run.energy();
        let mut highest: f64 = 0.0;
        for step in 0..800 {
            run.step();
            assert!(run.energy() < start + 1e-12, "e = {e}, step {step}");
            if step > 60 {
                highest = highest.max(run.state.x[0].z);
            }
        }
        let (x, v) = (run.state.x[0], run.state.v[0]);
        if e < 1.0 {
            assert!(x.norm() < 1e-9 && v.norm() < 1e-12, "e = {e}: {x:?} {v:?}");
        } else {
            assert!(highest > 0.9 && highest <= 1.0 + 1e-9, "{highest}");
        }
    }
}

/// On a slope a particle slides by Coulomb's law, exactly, or sticks and does not creep.
#[test]
fn friction_on_a_slope_is_coulombs() {
    let (sine, cosine) = (0.6, 0.8);
    let down = Vec3::new(cosine, 0.0, -sine);
    for (friction, acceleration) in [(0.3, 9.81 * (sine - 0.3 * cosine)), (0.9, 0.0)] {
        let spec = above(0.0, friction, [sine, 0.0, cosine], Vec3::zeros(), Vec3::zeros());
        let mut run = Run::new(midpoint(&[]), build(&spec), 0.01);
        run.steps(100);
        let (x, v) = (run.state.x[0].dot(&down), run.state.v[0].dot(&down));
        assert!((x - 0.5 * acceleration).abs() < 1e-9, "μ = {friction}: {x}");
        assert!((v - acceleration).abs() < 1e-9, "μ = {friction}: {v}");
    }
    // What slides on the flat comes to rest, where friction says, and never turns round.
    let spec = above(0.0, 0.3, [0.0, 0.0, 1.0], Vec3::zeros(), Vec3::x());
    let mut run = Run::new(midpoint(&[]), build(&spec), 0.01);
    for step in 0..60 {
        run.step();
        assert!(run.state.v[0].x > -1e-12, "step {step}: {:?}", run.state.v[0]);
    }
    let way = 0.5 / (0.3 * 9.81);
    assert!((run.state.x[0].x - way).abs() < 5e-3, "{}", run.state.x[0].x);
    assert!(run.state.v[0].norm() < 1e-12, "{:?}", run.state.v[0]);
}

/// The ledger accounts for the whole change of energy, also in contact, and inertia is 0.
#[test]
fn the_ledger_accounts_for_the_change_of_energy() {
    let mut spec = Sheet { law: DampingLaw::Projected, pinned: false, ..Sheet::default() }.spec();
    spec.obstacles = vec![floor(0.0)];
    let (system, mut state) = build(&spec);
    for (i, x) in state.x.iter_mut().enumerate() {
        x.z += 0.02 + 0.001 * i as f64;
    }
    let mut run = Run::new(midpoint(&[]), (system, state), 0.01);
    let mut touched = false;
    for step in 0..40 {
        let before = run.state.clone();
        run.step();
        let Run { integrator, system, state, h } = &mut run;
        let ledger = integrator.ledger(system, &before, state, seconds(*h)).expect("a ledger");
        let change = system.total_energy(state) - system.total_energy(&before);
        let wrong = (ledger.sum() - change).abs() / ledger.magnitude().max(1e-6);
        assert!(wrong < 1e-8, "step {step}: {wrong:e}, {ledger:?}");
        touched |= ledger.impact < -1e-6;
        assert!(ledger.inertia.abs() < 1e-12, "{ledger:?}");
    }
    assert!(touched);
}

#[test]
fn an_unfinished_solve_is_reported_and_a_blow_up_is_no_panic() {
    let start = stir(Sheet { tension: 1e6, ..Sheet::default() }.build(), 0.1, 3.0);
    let mut run = Run::new(midpoint(&[("max_iterations", "1")]), start, 0.05);
    assert_eq!(run.step().solve, SolveStatus::IterationLimit);
    run.state.v[7].x = f64::NAN;
    let h = TimeStep::new(0.01).expect("positive");
    let mut clock = drape_integrator::PhaseClock::off();
    let _any = run.integrator.step(&run.system, &mut run.state, h, &mut clock);
}
