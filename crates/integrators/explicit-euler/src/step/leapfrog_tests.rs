use super::*;
use crate::settings::StepControl;
use crate::test_support::{GRAVITY, Run, floor, gravity, net, particles, pin, spring};
use drape_integrator::{
    Integrator, LargestEigenvalue, Setups, SolveStatus, SolverKind, StiffnessBound,
};
use drape_model::{DampingLaw, SystemSpec, Vec3};
use drape_oracle::order::of_method;
use drape_oracle::recurrence::{leapfrog, spectral_radius};
use drape_oracle::reference::{ReferenceSettings, reference};
use nalgebra::Vector2;

/// A power of two, so that `θ` and `η` are met exactly.
const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;
const SOLVERS: [(SolverKind, f64); 2] = [(SolverKind::Cholesky, 1e-12), (SolverKind::Cg, 1e-9)];
const LAWS: [DampingLaw; 2] = [DampingLaw::Full, DampingLaw::Projected];

fn with(solver: SolverKind) -> Leapfrog {
    Leapfrog::new(LeapfrogSettings { solver, ..LeapfrogSettings::default() })
}

fn dividing(step: StepControl, safety: f64) -> Leapfrog {
    Leapfrog::new(LeapfrogSettings { step, safety, ..LeapfrogSettings::default() })
}

/// One particle on a spring to a pinned one at the origin.
fn anchored(theta: f64, eta: f64, rest: f64, x: Vec3, v: Vec3) -> SystemSpec {
    let mut spec = particles(&[MASS; 2], &[Vec3::zeros(), x], &[Vec3::zeros(), v]);
    spec.pins = vec![pin(0)];
    spec.springs = vec![spring((0, 1), rest, theta * MASS / (H * H), eta * MASS / H)];
    spec
}

/// Two particles of 0.5 kg whose relative motion has `θ` and `η`.
fn pair(theta: f64, eta: f64, rest: f64, law: DampingLaw) -> SystemSpec {
    let x = [Vec3::new(0.3, 0.1, 0.0), Vec3::new(-0.5, 0.4, 0.2)];
    let v = [Vec3::new(1.0, 3.0, -2.0), Vec3::new(0.5, -4.0, 1.0)];
    let mut spec = particles(&[0.5; 2], &x, &v);
    spec.springs = vec![spring((0, 1), rest, 0.25 * theta / (H * H), 0.25 * eta / H)];
    spec.damping = law;
    spec
}

fn bits(state: &State) -> Vec<u64> {
    let vectors = state.x.iter().chain(&state.v);
    vectors.flat_map(|a| a.iter().copied()).chain([state.t]).map(f64::to_bits).collect()
}

#[test]
fn an_anchored_spring_of_rest_length_zero_moves_by_the_recurrence() {
    let (x, v) = (Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
    for (solver, tolerance) in SOLVERS {
        for (theta, eta) in
            [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0), (3.9, 50.0), (1.0, 1e4)]
        {
            let mut run = Run::new(with(solver), &anchored(theta, eta, 0.0, x, v), H);
            let matrix = leapfrog(theta, eta);
            let mut exact = [0, 1, 2].map(|axis| Vector2::new(x[axis], H * v[axis]));
            for step in 0..100 {
                // Beyond, squares of an unstable solution overflow.
                if exact[0].norm() > 1e100 {
                    assert!(step > 45);
                    break;
                }
                run.step();
                let size = exact.iter().map(Vector2::norm).fold(0.0, f64::max);
                for (axis, exact) in exact.iter_mut().enumerate() {
                    *exact = matrix * *exact;
                    let found = Vector2::new(run.state.x[1][axis], H * run.state.v[1][axis]);
                    let error = (found - *exact).norm() / size;
                    assert!(error < tolerance, "{solver:?} {theta} {eta} step {step}: {error:e}");
                }
            }
        }
    }
}

/// Along the spring both laws of damping are the same.
#[test]
fn motion_along_a_spring_with_a_rest_length_obeys_the_same_recurrence() {
    let (rest, direction) = (4.0, Vec3::new(0.0, 0.6, -0.8));
    for law in LAWS {
        for (theta, eta) in [(0.36, 0.06), (1.0, 0.0), (100.0, 0.4), (2.0, 30.0)] {
            let x = direction * (rest + 1.0 / 256.0);
            let mut spec = anchored(theta, eta, rest, x, Vec3::zeros());
            spec.damping = law;
            let mut run = Run::new(with(SolverKind::Cholesky), &spec, H);
            let mut exact = Vector2::new(1.0 / 256.0, 0.0);
            for _ in 0..100 {
                exact = leapfrog(theta, eta) * exact;
                if exact.x.abs() > 0.5 * rest {
                    break;
                }
                run.step();
                let along = |a: &Vec3| direction.dot(a);
                let found = Vector2::new(along(&run.state.x[1]) - rest, H * along(&run.state.v[1]));
                let error = (found - exact).norm() / rest;
                assert!(error < 1e-12, "{law:?} {theta} {eta}: {error:e}");
            }
        }
    }
}

/// `θ < 4`, whatever the damping.
#[test]
fn a_spring_is_stable_up_to_theta_of_four_at_every_damping() {
    let (x, v) = (Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
    for eta in [0.0, 0.1, 2.0, 100.0] {
        for (theta, stable) in [(3.95, true), (4.05, false)] {
            let mut run = Run::new(Leapfrog::default(), &anchored(theta, eta, 0.0, x, v), H);
            run.steps(20_000);
            assert_eq!(run.state.x[1].norm() < 100.0, stable, "{theta} {eta}: {:?}", run.state.x);
            assert_eq!(spectral_radius(&leapfrog(theta, eta)) < 1.0 + 1e-12, stable);
        }
    }
}

/// In a net the directions of many springs meet, so that `L_c` and `D` have no modes in common.
#[test]
fn projected_damping_of_any_size_leaves_a_net_that_starts_at_rest_stable() {
    for damping in [0.01, 1.0, 100.0, 1e4] {
        let mut spec = net(5, damping, DampingLaw::Projected, false);
        spec.particles.velocity_m_s.clear();
        let (system, _) = spec.build().expect("valid");
        let lambda = StiffnessBound::new(&system).expect("springs only").evaluate(&system);
        let mut run = Run::new(Leapfrog::default(), &spec, 0.95 * 2.0 / lambda.sqrt());
        let start = run.system.total_energy(&run.state);
        for _ in 0..300 {
            run.steps(10);
            let energy = run.system.total_energy(&run.state);
            assert!(energy < start, "{damping}: {energy} of {start}");
        }
        let energy = run.system.total_energy(&run.state);
        assert!(energy < 0.5 * start, "{damping}: {energy} of {start}");
    }
}

#[test]
fn a_free_pair_keeps_its_angular_momentum_or_loses_what_full_damping_takes() {
    for (theta, eta, rest) in
        [(0.5, 0.0, 1.0), (3.0, 0.0, 0.5), (3.0, 0.0, 4.0), (1.0, 0.2, 1.0), (1.0, 8.0, 1.0)]
    {
        let mut run = Run::new(Leapfrog::default(), &pair(theta, eta, rest, DampingLaw::Full), H);
        for step in 0..100 {
            let spin = |state: &State| (state.x[0] - state.x[1]).cross(&(state.v[0] - state.v[1]));
            let before = spin(&run.state);
            run.step();
            let expected = before * ((1.0 - 0.5 * eta) / (1.0 + 0.5 * eta));
            let error = (spin(&run.state) - expected).norm();
            assert!(error < 1e-13 * (1.0 + before.norm()), "{theta} {eta} {step}: {error:e}");
        }
    }
}

#[test]
fn an_undamped_net_keeps_momentum_and_angular_momentum_and_a_damped_one_momentum() {
    for (damping, law) in [(0.0, LAWS[0]), (3.0, LAWS[0]), (3.0, LAWS[1])] {
        for (solver, tolerance) in SOLVERS {
            let mut run = Run::new(with(solver), &net(5, damping, law, false), 0.01);
            let momentum = run.system.momentum(&run.state);
            let angular = run.system.angular_momentum(&run.state);
            run.steps(200);
            let change = (run.system.momentum(&run.state) - momentum).norm();
            assert!(change < tolerance * 10.0, "{damping} {law:?} {solver:?}: {change:e}");
            if damping == 0.0 {
                let change = (run.system.angular_momentum(&run.state) - angular).norm();
                assert!(change < 1e-12, "{change:e}");
            }
        }
    }
}

#[test]
fn the_energy_of_an_undamped_net_does_not_drift() {
    let mut run = Run::new(Leapfrog::default(), &net(5, 0.0, DampingLaw::Full, false), 0.01);
    let start = run.system.total_energy(&run.state);
    for _ in 0..200 {
        run.steps(100);
        let error = (run.system.total_energy(&run.state) - start).abs();
        assert!(error < 0.02 * start, "{error} of {start}");
    }
}

#[test]
fn free_fall_is_the_exact_parabola() {
    for damping in [0.0, 2.0] {
        let mut spec = net(4, damping, DampingLaw::Full, false);
        for (i, position) in spec.particles.position_m.iter_mut().enumerate() {
            *position = [(i % 4) as f64 / 3.0, (i / 4) as f64 / 3.0, 0.0];
        }
        let velocity = Vec3::new(1.0, -2.0, 3.0);
        spec.particles.velocity_m_s.fill(velocity.into());
        spec.effects.gravity = gravity();
        let mut run = Run::new(Leapfrog::default(), &spec, 0.01);
        let start = run.state.x.clone();
        run.steps(50);
        let t = 0.5;
        for (x, start) in run.state.x.iter().zip(&start) {
            assert!((x - start - velocity * t - GRAVITY * (0.5 * t * t)).norm() < 1e-12);
        }
        assert!(run.state.v.iter().all(|v| (v - velocity - GRAVITY * t).norm() < 1e-12));
    }
}

#[test]
fn the_order_is_two_with_either_law_of_damping() {
    for law in LAWS {
        let mut spec = net(4, 2.0, law, true);
        spec.effects.gravity = gravity();
        let (system, start) = spec.build().expect("valid");
        let exact =
            reference(&system, &start, &[0.25], ReferenceSettings::default()).expect("a reference");
        let new = || Box::new(Leapfrog::default()) as Box<dyn Integrator>;
        let found = of_method(new, &system, &start, &exact, &[40, 80, 160, 320]).expect("an order");
        assert!((found.order - 2.0).abs() < 0.1, "{law:?}: {found:?}");
    }
}

/// Nothing is solved, nothing set up.
#[test]
fn without_damping_there_is_no_matrix_and_one_force_a_step() {
    let spec = net(4, 0.0, DampingLaw::Full, true);
    let (system, _) = spec.build().expect("valid");
    let workspace = LeapfrogWorkspace::new(&system, &LeapfrogSettings::default(), 0.01);
    assert!(workspace.expect("supported").damping.is_none());
    let mut run = Run::new(Leapfrog::default(), &spec, 0.01);
    let one = StepReport { force_evaluations: 1, ..StepReport::default() };
    assert_eq!(run.step(), StepReport { force_evaluations: 2, ..one });
    assert_eq!([run.step(), run.step()], [one; 2]);
}

#[test]
fn the_force_is_evaluated_again_after_whatever_may_have_changed_it() {
    type Change = (&'static str, u32, fn(&mut Run<Leapfrog>));
    let changes: [Change; 7] = [
        ("nothing", 1, |_| ()),
        ("velocity", 1, |run| run.state.v[5].x += 1.0),
        ("step size", 1, |run| run.h *= 0.5),
        ("restart", 2, |run| run.integrator.restart(&run.state)),
        ("stiffness", 2, |run| assert!(run.system.scale_stiffness("tension", 1.5))),
        ("mass", 2, |run| {
            let heavier: Vec<f64> = run.system.mass().iter().map(|m| 2.0 * m).collect();
            assert!(run.system.set_mass(&heavier));
        }),
        ("position", 2, |run| run.state.x[7].z += 1e-15),
    ];
    let mut run = Run::new(Leapfrog::default(), &net(4, 1.0, DampingLaw::Full, true), 0.01);
    run.steps(3);
    for (what, evaluations, change) in changes {
        change(&mut run);
        let (system, state) = (run.system.clone(), run.state.clone());
        let mut fresh = Run::of(Leapfrog::default(), system, state, run.h);
        assert_eq!(run.step().force_evaluations, evaluations, "{what}");
        fresh.step();
        assert_eq!(bits(&run.state), bits(&fresh.state), "{what}");
    }
}

#[test]
fn set_ups_are_charged_to_their_cause_and_the_second_solve_of_projected_damping_is_counted() {
    let none = Setups::default();
    for (law, evaluations, matvecs) in [(LAWS[0], 1, 1), (LAWS[1], 2, 2)] {
        let mut run = Run::new(Leapfrog::default(), &net(4, 1.0, law, true), 0.01);
        let mut setups = |change: fn(&mut Run<Leapfrog>)| {
            change(&mut run);
            [run.step(), run.step()].map(|report| report.setups)
        };
        assert_eq!(setups(|_| ()), [Setups { first: 1, ..none }, none]);
        assert_eq!(setups(|run| run.h = 0.005), [Setups { step_size: 1, ..none }, none]);
        let stiffness = [Setups { stiffness: 1, ..none }, none];
        assert_eq!(setups(|run| assert!(run.system.scale_damping("tension", 2.0))), stiffness);
        let pins = [Setups { constraints: 1, ..none }, none];
        assert_eq!(setups(|run| assert!(run.system.set_pinned(9, true))), pins);
        let report = run.step();
        assert_eq!((report.force_evaluations, report.matvecs), (evaluations, matvecs), "{law:?}");
        assert_eq!(report.solve, SolveStatus::Converged);
    }
}

#[test]
fn pins_that_come_and_go_hold_at_once_and_let_go_at_once() {
    for damping in [0.0, 1.0] {
        let mut run = Run::new(Leapfrog::default(), &net(4, damping, LAWS[1], true), 0.01);
        run.steps(3);
        assert!(run.system.set_pinned(9, true) && run.system.set_pinned(0, false));
        let held = [3, 9].map(|i| run.state.x[i]);
        for _ in 0..3 {
            run.step();
            assert_eq!([3, 9].map(|i| run.state.x[i]), held);
            assert_eq!([3, 9].map(|i| run.state.v[i]), [Vec3::zeros(); 2]);
        }
        assert_ne!(run.state.v[0], Vec3::zeros());
    }
}

#[test]
fn a_blow_up_is_a_result() {
    for (solver, _) in SOLVERS {
        for law in LAWS {
            let mut run = Run::new(with(solver), &net(4, 1.0, law, true), 10.0);
            run.steps(500);
            assert!(!run.state.is_finite() && run.state.t == 5000.0);
        }
    }
    for step in [StepControl::Auto, StepControl::Bound] {
        let mut run = Run::new(dividing(step, 0.7), &net(4, 1.0, LAWS[1], true), 0.01);
        run.state.x[7].y = f64::NAN;
        run.steps(3);
        run.state.x[7].y = f64::INFINITY;
        run.integrator.restart(&run.state);
        run.steps(3);
    }
}

#[test]
fn a_divided_step_is_its_substeps_taken_one_by_one() {
    for damping in [0.0, 1.0] {
        for step in [StepControl::Auto, StepControl::Bound] {
            let spec = net(4, damping, DampingLaw::Full, true);
            let mut divided = Run::new(dividing(step, 0.5), &spec, 0.125);
            let count = divided.step().substeps;
            let mut whole = Run::new(Leapfrog::default(), &spec, 0.125 / f64::from(count));
            let last = whole.steps(count as usize);
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
        let mut auto = Run::new(dividing(StepControl::Auto, safety), &spec, h);
        let mut bound = Run::new(dividing(StepControl::Bound, safety), &spec, h);
        for factor in [1.0, 100.0] {
            assert!(factor == 1.0 || auto.system.scale_stiffness("tension", factor));
            assert!(factor == 1.0 || bound.system.scale_stiffness("tension", factor));
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
    // A limit of 0 is none that could be kept.
    let x = [Vec3::zeros(), Vec3::x()];
    let mut light = particles(&[1e-300; 2], &x, &[Vec3::y(); 2]);
    light.springs = vec![spring((0, 1), 0.5, 1e30, 0.0)];
    for step in [StepControl::Auto, StepControl::Bound] {
        assert_eq!(Run::new(dividing(step, 0.7), &light, 1.0).step().substeps, 1);
    }
    let free = particles(&[1.0; 2], &[Vec3::zeros(), Vec3::x()], &[Vec3::y(); 2]);
    for step in [StepControl::Auto, StepControl::Bound] {
        assert_eq!(Run::new(dividing(step, 0.7), &free, 1e9).step().substeps, 1);
    }
}

/// The first estimate takes tens of products, each later one two for every thirty substeps.
#[test]
fn products_are_counted_as_three_force_evaluations() {
    let spec = net(4, 0.0, DampingLaw::Full, true);
    let mut run = Run::new(dividing(StepControl::Auto, 0.7), &spec, 1e-3);
    let first = run.step().force_evaluations - 2;
    assert!((60..=600).contains(&first) && first.is_multiple_of(30), "{first}");
    let later: Vec<u32> = (0..60).map(|_| run.step().force_evaluations).collect();
    let extra = [29, 59];
    for (step, &found) in later.iter().enumerate() {
        assert_eq!(found, if extra.contains(&step) { 7 } else { 1 }, "step {step}");
    }
    let mut bound = Run::new(dividing(StepControl::Bound, 0.7), &spec, 1e-3);
    bound.steps(2);
    assert!((0..60).all(|_| bound.step().force_evaluations == 1));
}

#[test]
fn after_a_restart_every_kind_of_step_is_that_of_a_fresh_integrator() {
    for step in [StepControl::Fixed, StepControl::Auto, StepControl::Bound] {
        for law in LAWS {
            let mut spec = net(5, 1.0, law, true);
            spec.obstacles = vec![floor(0.5)];
            let mut run = Run::new(dividing(step, 0.7), &spec, 0.02);
            run.steps(40);
            run.integrator.restart(&run.state);
            let (system, state) = (run.system.clone(), run.state.clone());
            let mut fresh = Run::of(dividing(step, 0.7), system, state, 0.02);
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
        let mut run = Run::new(Leapfrog::default(), &spec, 0.005);
        run.steps(4000);
        for (x, v) in run.state.x.iter().zip(&run.state.v) {
            assert!(x.z.abs() < 1e-9 && v.norm() < 1e-3, "{damping}: {x:?} {v:?}");
        }
    }
}

#[test]
fn a_particle_bounces_with_the_restitution_of_the_floor() {
    for restitution in [0.0, 0.5, 1.0] {
        let mut spec = particles(&[2.0], &[Vec3::z()], &[Vec3::zeros()]);
        spec.effects.gravity = gravity();
        spec.obstacles = vec![floor(restitution)];
        let h = 1e-3;
        let mut run = Run::new(Leapfrog::default(), &spec, h);
        let mut before = run.state.v[0].z;
        while run.state.v[0].z <= before {
            before = run.state.v[0].z;
            run.step();
        }
        let speed = (2.0 * 9.81_f64).sqrt();
        let slack = 2.0 * 9.81 * h;
        assert!((before + speed).abs() < slack, "{before}");
        assert!((run.state.v[0].z - restitution * speed).abs() < slack, "{:?}", run.state.v);
    }
}

/// Shortly after a contact an impact is rest, for an integrator that knows of the contact.
#[test]
fn a_restart_forgets_the_contacts() {
    let mut spec = particles(&[2.0], &[Vec3::zeros()], &[Vec3::zeros()]);
    spec.obstacles = vec![floor(1.0)];
    let mut run = Run::new(Leapfrog::default(), &spec, 1e-3);
    for (restarts, speed) in [(false, 0.0), (true, 3.0)] {
        run.steps(2);
        run.state.v[0].z = -3.0;
        if restarts {
            run.integrator.restart(&run.state);
        }
        run.step();
        assert_eq!(run.state.v[0].z, speed);
        run.state.x[0].z = 0.0;
        run.state.v[0].z = 0.0;
    }
}

#[test]
fn settings_are_read_and_wrong_ones_refused() {
    let default = LeapfrogSettings::from_pairs([]).expect("defaults");
    assert_eq!(default, LeapfrogSettings::default());
    let all = [("solver", "cg"), ("step", "bound"), ("safety", "0.95")];
    let expected =
        LeapfrogSettings { solver: SolverKind::Cg, step: StepControl::Bound, safety: 0.95 };
    assert_eq!(LeapfrogSettings::from_pairs(all).expect("valid"), expected);
    let auto = LeapfrogSettings::from_pairs([("step", "auto")]).expect("valid");
    assert_eq!(auto.step, StepControl::Auto);
    for pair in
        [("safety", "0.04"), ("safety", "1.1"), ("step", "1"), ("solver", "ic0"), ("c", "1")]
    {
        assert!(LeapfrogSettings::from_pairs([pair]).is_err(), "{pair:?}");
    }
}
