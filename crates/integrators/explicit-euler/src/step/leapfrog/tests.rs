//! Tests of leapfrog: projected damping, forces kept from step to step, divided steps.

use super::*;
use drape_integrator::{
    DampingBound, Integrator, LargestEigenvalue, SolveStatus, SolverKind, StepControl, StepError,
    StiffnessBound,
};
use drape_model::{DampingLaw, EffectKind, KeyframeSpec, SpringEffect, SystemSpec, Vec3};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::laws::spin;
use drape_oracle::order::{of_method, position_error};
use drape_oracle::recurrence;
use drape_oracle::reference::reference;
use drape_oracle::scenes::{Sheet, anchored, build, floor, gravity, particles, pin, tension};
use drape_oracle::{Run, bits, seconds};
use nalgebra::Vector2;

const LAWS: [DampingLaw; 2] = [DampingLaw::Full, DampingLaw::Projected];

fn dividing(step: StepControl, safety: f64) -> Box<Leapfrog> {
    Box::new(Leapfrog::new(LeapfrogSettings { step, safety, ..LeapfrogSettings::default() }))
}

fn prepared(spec: &SystemSpec, h: f64) -> Run {
    Run::new(Box::<Leapfrog>::default(), build(spec), h)
}

/// A square net of unequal masses that hangs from two corners if `pinned`, with diagonals, out of
/// its plane and in motion; `k/m` about 400 to 800.
fn net(side: usize, damping: f64, law: DampingLaw, pinned: bool) -> SystemSpec {
    let width = 1.0 / (side - 1) as f64;
    let all = || (0..side * side).map(|i| i as f64);
    let place = |i: f64| Vec3::new(i % side as f64, (i / side as f64).floor(), 0.0) * width;
    let x: Vec<_> = all().map(|i| place(i) + Vec3::z() * (0.05 * (2.3 * i).sin())).collect();
    let v: Vec<_> =
        all().map(|i| Vec3::new((1.1 * i).sin(), (2.7 * i).cos(), (0.7 * i).sin())).collect();
    let mass: Vec<_> = all().map(|i| 0.5 + 0.25 * i.sin()).collect();
    let mut spec = particles(&mass, &x, &v);
    spec.damping = law;
    for i in 0..side * side {
        let (right, below) = (i % side + 1 < side, i + side < side * side);
        let mut join = |joins: bool, j, length: f64, share: f64| {
            if joins {
                let (k, c) = (200.0 * share, damping * share);
                spec.springs.push(tension((i, j), width * length, k, c));
            }
        };
        join(right, i + 1, 1.0, 1.0);
        join(below, i + side, 1.0, 1.0);
        join(right && below, i + side + 1, 2.0_f64.sqrt(), 0.3);
    }
    if pinned {
        spec.pins = vec![pin(0), pin(side - 1)];
        for corner in [0, side - 1] {
            spec.particles.velocity_m_s[corner] = [0.0; 3];
        }
    }
    spec
}

/// In a net many springs meet at different angles, so `L_c` and `D` have no modes in common.
#[test]
fn projected_damping_of_any_size_leaves_a_net_that_starts_at_rest_stable() {
    for damping in [0.01, 1.0, 100.0, 1e4] {
        let mut spec = net(5, damping, DampingLaw::Projected, false);
        spec.particles.velocity_m_s.clear();
        let (system, _) = spec.build().expect("valid");
        let lambda = StiffnessBound::new(&system).expect("springs only").evaluate(&system);
        let mut run = prepared(&spec, 0.95 * 2.0 / lambda.sqrt());
        let start = run.energy();
        for _ in 0..300 {
            run.steps(10);
            let energy = run.energy();
            assert!(energy < start, "{damping}: {energy} of {start}");
        }
        let energy = run.energy();
        assert!(energy < 0.5 * start, "{damping}: {energy} of {start}");
    }
}

#[test]
fn the_energy_of_an_undamped_net_does_not_drift() {
    let mut run = prepared(&net(5, 0.0, DampingLaw::Full, false), 0.01);
    let start = run.energy();
    for _ in 0..200 {
        run.steps(100);
        let error = (run.energy() - start).abs();
        assert!(error < 0.02 * start, "{error} of {start}");
    }
}

/// The step solves nothing and sets nothing up.
#[test]
fn without_damping_there_is_no_matrix_and_one_force_a_step() {
    let spec = net(4, 0.0, DampingLaw::Full, true);
    let (system, _) = spec.build().expect("valid");
    let workspace = LeapfrogWorkspace::new(&system, &LeapfrogSettings::default(), 0.01);
    assert!(workspace.expect("supported").damping.is_none());
    let mut run = prepared(&spec, 0.01);
    let one = StepReport { force_evaluations: 1, ..StepReport::default() };
    assert_eq!(run.step(), StepReport { force_evaluations: 2, ..one });
    assert_eq!([run.step(), run.step()], [one; 2]);
}

#[test]
fn the_force_is_evaluated_again_after_whatever_may_have_changed_it() {
    type Change = (&'static str, u32, fn(&mut Run));
    let changes: [Change; 7] = [
        ("nothing", 1, |_| ()),
        ("velocity", 1, |run| run.state.v[5].x += 1.0),
        ("step size", 1, |run| run.h *= 0.5),
        ("restart", 2, |run| run.restart()),
        ("stiffness", 2, |run| assert!(run.system.scale_stiffness(EffectKind::Tension, 1.5))),
        ("mass", 2, |run| {
            let heavier: Vec<f64> = run.system.mass().iter().map(|m| 2.0 * m).collect();
            assert!(run.system.set_mass(&heavier));
        }),
        ("position", 2, |run| run.state.x[7].z += 1e-15),
    ];
    let mut run = prepared(&net(4, 1.0, DampingLaw::Full, true), 0.01);
    run.steps(3);
    for (what, evaluations, change) in changes {
        change(&mut run);
        let (system, state) = (run.system.clone(), run.state.clone());
        let mut fresh = Run::new(Box::<Leapfrog>::default(), (system, state), run.h);
        assert_eq!(run.step().force_evaluations, evaluations, "{what}");
        fresh.step();
        assert_eq!(bits(&run.state), bits(&fresh.state), "{what}");
    }
}

#[test]
fn the_second_solve_of_projected_damping_is_counted() {
    for (law, evaluations, matvecs) in [(LAWS[0], 1, 1), (LAWS[1], 2, 2)] {
        let reports = prepared(&net(4, 1.0, law, true), 0.01).steps(3);
        let StepReport { force_evaluations, matvecs: found, solve, .. } = reports[2];
        assert_eq!((force_evaluations, found), (evaluations, matvecs), "{law:?}");
        assert_eq!(solve, SolveStatus::Converged);
    }
}

#[test]
fn a_divided_step_is_its_substeps_taken_one_by_one() {
    for damping in [0.0, 1.0] {
        for step in [StepControl::Auto, StepControl::Bound] {
            let spec = net(4, damping, DampingLaw::Full, true);
            let mut divided = Run::new(dividing(step, 0.5), build(&spec), 0.125);
            let count = divided.step().substeps;
            let mut whole = prepared(&spec, 0.125 / f64::from(count));
            let last = whole.steps(count as usize).pop().expect("some");
            assert_eq!((divided.state.x, divided.state.v), (whole.state.x, whole.state.v));
            assert_eq!(divided.state.t, 0.125);
            assert!(last.substeps == 1 && count > 4, "{count}");
        }
    }
}

#[test]
fn substeps_are_as_long_as_the_limit_allows_and_follow_the_stiffness() {
    let spec = net(4, 0.0, DampingLaw::Full, true);
    let h = 1.0;
    let count = |safety: f64, lambda: f64| (h * lambda.sqrt() / (2.0 * safety)).ceil() as u32;
    for safety in [0.05, 0.7, 1.0] {
        let mut auto = Run::new(dividing(StepControl::Auto, safety), build(&spec), h);
        let mut bound = Run::new(dividing(StepControl::Bound, safety), build(&spec), h);
        for factor in [1.0, 100.0] {
            assert!(factor == 1.0 || auto.system.scale_stiffness(EffectKind::Tension, factor));
            assert!(factor == 1.0 || bound.system.scale_stiffness(EffectKind::Tension, factor));
            let largest =
                LargestEigenvalue::new(&auto.system).estimate(&auto.system, &auto.state.x, 2000);
            let found = auto.step().substeps;
            let least = count(safety, 0.97 * 1.05 * largest);
            assert!((least..=count(safety, 1.05 * largest)).contains(&found), "{found}");
            let lambda =
                StiffnessBound::new(&bound.system).expect("springs only").evaluate(&bound.system);
            assert_eq!(bound.step().substeps, count(safety, lambda));
            // Less than the limit: no division.
            (auto.h, bound.h) = (1e-6, 1e-6);
            assert_eq!((auto.step().substeps, bound.step().substeps), (1, 1));
            (auto.h, bound.h) = (h, h);
        }
    }
    // No reasonable number of substeps meets this limit.
    let x = [Vec3::zeros(), Vec3::x()];
    let mut light = particles(&[1e-30; 2], &x, &[Vec3::y(); 2]);
    light.springs = vec![tension((0, 1), 0.5, 1e30, 0.0)];
    for step in [StepControl::Auto, StepControl::Bound] {
        let refused = Run::new(dividing(step, 0.7), build(&light), 1.0).try_step();
        assert!(matches!(refused, Err(StepError::TooManySubsteps { .. })), "{refused:?}");
    }
    let free = particles(&[1.0; 2], &[Vec3::zeros(), Vec3::x()], &[Vec3::y(); 2]);
    for step in [StepControl::Auto, StepControl::Bound] {
        assert_eq!(Run::new(dividing(step, 0.7), build(&free), 1e9).step().substeps, 1);
    }
}

/// The first estimate takes tens of products; later ones take two for every thirty substeps.
#[test]
fn products_are_counted_as_three_force_evaluations() {
    let spec = net(4, 0.0, DampingLaw::Full, true);
    let mut run = Run::new(dividing(StepControl::Auto, 0.7), build(&spec), 1e-3);
    let first = run.step().force_evaluations - 2;
    assert!((60..=600).contains(&first) && first.is_multiple_of(30), "{first}");
    let later: Vec<u32> = (0..60).map(|_| run.step().force_evaluations).collect();
    let extra = [29, 59];
    for (step, &found) in later.iter().enumerate() {
        assert_eq!(found, if extra.contains(&step) { 7 } else { 1 }, "step {step}");
    }
    let mut bound = Run::new(dividing(StepControl::Bound, 0.7), build(&spec), 1e-3);
    bound.steps(2);
    assert!((0..60).all(|_| bound.step().force_evaluations == 1));
}

#[test]
fn after_a_restart_every_kind_of_step_is_that_of_a_fresh_integrator() {
    for step in [StepControl::Fixed, StepControl::Auto, StepControl::Bound] {
        for law in LAWS {
            let mut spec = net(5, 1.0, law, true);
            spec.obstacles = vec![floor(0.5)];
            let mut run = Run::new(dividing(step, 0.7), build(&spec), 0.02);
            run.steps(40);
            run.restart();
            let (system, state) = (run.system.clone(), run.state.clone());
            let mut fresh = Run::new(dividing(step, 0.7), (system, state), 0.02);
            for _ in 0..3 {
                let (a, b) = (run.step(), fresh.step());
                assert_eq!(bits(&run.state), bits(&fresh.state), "{step:?} {law:?}");
                assert_eq!((a.substeps, a.force_evaluations), (b.substeps, b.force_evaluations));
            }
        }
    }
}

#[test]
fn a_net_that_falls_on_a_floor_comes_to_rest_on_it() {
    for damping in [5.0, 15.0] {
        let mut spec = net(4, damping, DampingLaw::Full, false);
        for (i, position) in spec.particles.position_m.iter_mut().enumerate() {
            position[2] = 0.05 + 0.01 * (i % 3) as f64;
        }
        spec.particles.velocity_m_s.fill([0.0, 0.0, -1.0]);
        spec.effects.gravity = gravity();
        spec.obstacles = vec![floor(0.0)];
        let mut run = prepared(&spec, 0.005);
        run.steps(4000);
        for (x, v) in run.state.x.iter().zip(&run.state.v) {
            assert!(x.z.abs() < 1e-9 && v.norm() < 1e-3, "{damping}: {x:?} {v:?}");
        }
    }
}

#[test]
fn settings_are_read_and_wrong_ones_refused() {
    let default = LeapfrogSettings::from_pairs([]).expect("defaults");
    assert_eq!(default, LeapfrogSettings::default());
    let all = [("solver", "cg"), ("step", "bound"), ("safety", "0.95")];
    let expected = LeapfrogSettings {
        solver: SolverKind::Cg,
        step: StepControl::Bound,
        safety: 0.95,
        ..LeapfrogSettings::default()
    };
    let explicit = LeapfrogSettings::from_pairs([("damping", "explicit")]).expect("valid");
    assert_eq!(explicit.damping, LeapfrogDamping::Explicit);
    assert_eq!(LeapfrogSettings::from_pairs(all).expect("valid"), expected);
    let auto = LeapfrogSettings::from_pairs([("step", "auto")]).expect("valid");
    assert_eq!(auto.step, StepControl::Auto);
    for pair in
        [("safety", "0.04"), ("safety", "1.1"), ("step", "1"), ("solver", "ic0"), ("c", "1")]
    {
        assert!(LeapfrogSettings::from_pairs([pair]).is_err(), "{pair:?}");
    }
}

fn explicit() -> Box<dyn Integrator> {
    let damping = LeapfrogDamping::Explicit;
    Box::new(Leapfrog::new(LeapfrogSettings { damping, ..LeapfrogSettings::default() }))
}

#[test]
fn with_explicit_damping_a_step_is_that_of_its_recurrence() {
    const H: f64 = 1.0 / 64.0;
    const MASS: f64 = 0.25;
    for (theta, eta) in [(0.36, 0.06), (1.0, 1.0), (3.9, 0.5), (0.5, 3.9), (12.0, 3.0)] {
        let (k, c) = (theta * MASS / (H * H), eta * MASS / H);
        let springs = [(SpringEffect::Tension, 0.0, k, c)];
        let spec = anchored(MASS, &springs, Vec3::x(), Vec3::new(0.0, 20.0, 0.0));
        let mut run = Run::new(explicit(), build(&spec), H);
        let step = recurrence::leapfrog_explicit_damping(theta, eta);
        let mut exact = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 20.0 * H)];
        for n in 0..50 {
            run.step();
            for (axis, exact) in exact.iter_mut().enumerate() {
                *exact = step * *exact;
                let found = Vector2::new(run.state.x[1][axis], H * run.state.v[1][axis]);
                let off = (found - *exact).norm() / exact.norm().max(1e-3);
                assert!(off < 1e-12, "θ={theta} η={eta}, step {n}: {off:e}");
            }
        }
    }
}

#[test]
fn explicit_damping_solves_nothing_and_keeps_the_order_and_the_spin() {
    for law in LAWS {
        let spec = net(5, 2.0, law, true);
        let mut run = Run::new(explicit(), build(&spec), 1e-3);
        let one = StepReport { force_evaluations: 1, matvecs: 4, ..StepReport::default() };
        assert_eq!(run.steps(2)[1], one);
        let (system, start) = build(&spec);
        let exact = reference(&system, &start, &[0.25], AdaptiveSettings::default());
        let exact = exact.expect("a reference");
        let found = of_method(explicit, &system, &start, &exact, &[80, 160, 320]);
        let order = found.expect("an order").order;
        assert!((order - 2.0).abs() < 0.15, "{law:?}: {order}");
    }
    let x = [Vec3::zeros(), Vec3::new(0.3, -0.5, 0.7)];
    let mut pair = particles(&[0.25; 2], &x, &[Vec3::new(1.0, 2.0, -1.0), Vec3::zeros()]);
    pair.springs = vec![tension((0, 1), 0.5, 150.0, 1.5)];
    let mut run = Run::new(explicit(), build(&pair), 1.0 / 64.0);
    let spin_of = |state: &State| (state.x[1] - state.x[0]).cross(&(state.v[1] - state.v[0]));
    let start = spin_of(&run.state);
    let factor = spin::kicks(&[0.5, 0.5], 2.0 * 1.5 / (64.0 * 0.25), 2);
    for n in 1..=40 {
        run.step();
        assert!((spin_of(&run.state) - start * factor.powi(n)).norm() < 1e-13, "step {n}");
    }
}

/// The bound of the damping divides a step, too; a fixed one beyond it is unstable.
#[test]
fn explicit_damping_divides_steps_within_its_own_limit() {
    let spec = net(5, 500.0, DampingLaw::Full, false);
    let damping = LeapfrogDamping::Explicit;
    let settings = LeapfrogSettings { damping, step: StepControl::Bound, ..dividing_settings() };
    let mut run = Run::new(Box::new(Leapfrog::new(settings)), build(&spec), 0.01);
    let delta = DampingBound::new(&run.system).evaluate(&run.system);
    let start = run.energy();
    assert_eq!(run.step().substeps, (0.01 * delta / (4.0 * 0.95)).ceil() as u32);
    run.steps(50);
    assert!(run.energy() < start);
    let mut unstable = Run::new(explicit(), build(&spec), 6.0 / delta * 2.0);
    unstable.steps(200);
    assert!(unstable.energy().partial_cmp(&(1e6 * start)) != Some(std::cmp::Ordering::Less));
}

fn dividing_settings() -> LeapfrogSettings {
    LeapfrogSettings { safety: 0.95, ..LeapfrogSettings::default() }
}

/// Also in contact, on a led pin and with unequal masses.
#[test]
fn the_ledger_of_explicit_damping_closes() {
    for law in LAWS {
        let mut spec = net(5, 2.0, law, true);
        spec.pins[0].path = vec![KeyframeSpec { time_s: 0.1, offset_m: [0.1, -0.1, 0.1] }];
        spec.effects.gravity = gravity();
        spec.obstacles = vec![floor(0.5)];
        let mut run = Run::new(explicit(), build(&spec), 0.004);
        for n in 0..50 {
            let (before, energy) = (run.state.clone(), run.energy());
            run.step();
            let ledger = run.integrator.ledger(&run.system, &before, &run.state, seconds(run.h));
            let ledger = ledger.expect("a ledger");
            let defect = (ledger.sum() - (run.energy() - energy)).abs() / ledger.magnitude();
            assert!(defect < 1e-8, "{law:?}, step {n}: {defect:e}");
        }
    }
}

/// The hanging sheet of the docs: 20 × 20 particles, 0.3 s.
#[test]
#[ignore = "measures: seconds"]
#[expect(clippy::print_stderr, reason = "it measures")]
fn measured_on_the_hanging_sheet() {
    for (tension, damping, steps) in
        [(1e4, 40.0, 45), (1e4, 40.0, 33), (1e6, 40.0, 330), (1e6, 40.0, 882), (1e8, 40.0, 3294)]
    {
        let sheet = Sheet { side: 20, tension, shear: 0.1 * tension, damping, ..Sheet::default() };
        let (system, start) = sheet.build();
        let settings = AdaptiveSettings { tolerance: 1e-11, ..AdaptiveSettings::default() };
        let exact = reference(&system, &start, &[0.3], settings).expect("a reference");
        let crank_nicolson: Box<dyn Integrator> = Box::<Leapfrog>::default();
        for (name, method) in [("explicit", explicit()), ("Crank-Nicolson", crank_nicolson)] {
            let mut run = Run::new(method, (system.clone(), start.clone()), 0.3 / f64::from(steps));
            let clock = std::time::Instant::now();
            run.steps(steps as usize);
            let time = clock.elapsed().as_secs_f64() / f64::from(steps);
            let error = position_error(&system, &start.x, &exact.states[0].x, &run.state.x);
            eprintln!("k/m {tension:e}, {steps} steps, {name}: {error:.2e}, {:.1} µs", 1e6 * time);
        }
    }
}
