//! The step against its recurrences and laws, alone and in contact.

use crate::{Dirk, DirkSettings, Tableau};
use drape_integrator::{Integrator, SolveStatus};
use drape_model::{DampingLaw, KeyframeSpec, ObstacleSpec, SpringEffect, State, System, Vec3};
use drape_oracle::Run;
use drape_oracle::laws::{Drift, free_fall};
use drape_oracle::order::of_method;
use drape_oracle::recurrence::RungeKutta;
use drape_oracle::reference::{ReferenceSettings, reference};
use drape_oracle::scenes::{GRAVITY, Sheet, anchored, build, gravity, particles, stir, tension};
use nalgebra::Vector2;

const ALL: [&str; 5] = ["tr-bdf2", "sdirk2", "sdirk3", "esdirk3", "sdirk4"];

fn exact_of(tableau: &str) -> (RungeKutta, f64) {
    match tableau {
        "tr-bdf2" => (RungeKutta::tr_bdf2(), 2.0),
        "sdirk2" => (RungeKutta::sdirk2(), 2.0),
        "sdirk3" => (RungeKutta::sdirk3(), 3.0),
        "esdirk3" => (RungeKutta::esdirk3(), 3.0),
        _ => (RungeKutta::sdirk4(), 4.0),
    }
}

fn with(tableau: &str, more: &[(&str, &str)]) -> Box<dyn Integrator> {
    let pairs = more.iter().copied().chain([("tableau", tableau)]);
    Dirk::controlled(DirkSettings::from_pairs(pairs).expect("in range"))
}

fn tight(tableau: &str) -> Box<dyn Integrator> {
    with(tableau, &[("residual", "1e-16")])
}

#[test]
fn a_spring_without_length_moves_by_the_recurrence_at_any_step_sizes() {
    let h = 1.0 / 64.0;
    let parameters = [(0.36, 0.06), (1.0, 0.0), (100.0, 0.4), (100.0, 0.0), (2.0, 30.0)];
    for (tableau, (theta, eta)) in ALL.into_iter().flat_map(|t| parameters.map(|p| (t, p))) {
        let (k, c) = (theta * 0.25 / (h * h), eta * 0.25 / h);
        let springs = [(SpringEffect::Tension, 0.0, k, c)];
        let spec = anchored(0.25, &springs, Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
        let mut run = Run::new(tight(tableau), build(&spec), h);
        let mut exact = [0, 1, 2].map(|k| (run.state.x[1][k], run.state.v[1][k]));
        for step in 0..100 {
            let ratio = [1.0, 2.0, 0.75, 0.5, 1.5][step % 5];
            run.step_by(ratio * h);
            for (axis, (x, v)) in exact.iter_mut().enumerate() {
                let matrix = exact_of(tableau).0.amplification(theta * ratio * ratio, eta * ratio);
                let size = x.hypot(*v * ratio * h);
                let next = matrix * Vector2::new(*x, *v * ratio * h);
                (*x, *v) = (next.x, next.y / (ratio * h));
                let found = Vector2::new(run.state.x[1][axis], run.state.v[1][axis] * ratio * h);
                let error = (found - next).norm() / next.norm().max(size);
                let case = format!("{tableau}, θ={theta} η={eta}, step {step}");
                assert!(error < 1e-9, "{case}: {error:e}");
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
    let x = [-half, half];
    let mut spec = particles(&[1.0; 2], &x, &x.map(|x| 2.0 * Vec3::z().cross(&x)));
    spec.springs = vec![tension((0, 1), 1.0, 0.5 * kappa, 0.0)];
    build(&spec)
}

/// Numbers computed elsewhere with 30 digits: spin and angle after 1 s at h = 0.01 for θ = 1 and
/// θ = 100, and energy for θ = 100. The stage order decides: sdirk2 to sdirk4 lose or gain.
#[test]
fn a_stiff_pair_turns_as_a_computation_with_thirty_digits_says() {
    #[rustfmt::skip]
    let table = [
        ("tr-bdf2", [0.999_999_880_267, 1.999_967_529_899], [0.999_999_763_394, 1.999_967_413_557], 0.999_999_526_790),
        ("sdirk2", [0.999_852_838_712, 1.999_773_137_929], [0.991_621_411_805, 1.991_555_062_250], 0.983_333_592_760),
        ("sdirk3", [0.998_604_366_256, 1.998_585_049_175], [0.989_778_179_726, 1.989_692_266_827], 0.979_670_609_662),
        ("esdirk3", [0.999_999_204_643, 1.999_999_204_305], [0.999_998_966_983, 1.999_998_971_899], 0.999_997_933_976),
        ("sdirk4", [1.000_027_323_592, 2.000_024_393_999], [1.021_000_553_539, 2.020_632_884_186], 1.042_621_117_692),
    ];
    for (tableau, soft, stiff, energy) in table {
        for (theta, [spin, angle]) in [(1.0, soft), (100.0, stiff)] {
            let mut run = Run::new(tight(tableau), rotor(theta), 0.01);
            let (before, start) = (turn(&run.state).0, run.energy());
            run.steps(100);
            let found = turn(&run.state);
            let kept = found.0 / before;
            assert!((kept - spin).abs() < 1e-10, "{tableau}, θ={theta}: spin {kept}");
            assert!((found.1 - angle).abs() < 1e-10, "{tableau}, θ={theta}: angle {}", found.1);
            let kept = run.energy() / start;
            assert!(theta < 2.0 || (kept - energy).abs() < 1e-9, "{tableau}: energy {kept}");
        }
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
    for tableau in ALL {
        let (system, mut state) = sheet.build();
        state.v.fill(Vec3::new(1.0, -2.0, 3.0));
        let start = state.clone();
        let mut run = Run::new(with(tableau, &[]), (system, state), 1.0 / 64.0);
        for n in 1..=20 {
            run.step();
            for i in 0..start.len() {
                let (x, v) =
                    free_fall(Drift::MeanVelocity, start.x[i], start.v[i], GRAVITY, 1.0 / 64.0, n);
                let error = (run.state.x[i] - x).norm() + (run.state.v[i] - v).norm();
                assert!(error < 1e-11, "{tableau}, step {n}, particle {i}: {error:e}");
            }
        }
    }
}

fn smooth(law: DampingLaw) -> Sheet {
    Sheet { side: 5, tension: 400.0, shear: 100.0, damping: 2.0, law, ..Sheet::default() }
}

/// At default settings: the residual falls with the order.
#[test]
fn every_tableau_has_its_order_with_both_laws_of_damping_at_default_settings() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let (system, start) = stir(smooth(law).build(), 0.02, 0.3);
        let exact = reference(&system, &start, &[0.25], ReferenceSettings::default())
            .unwrap_or_else(|error| panic!("{error}"));
        for tableau in ALL {
            let steps: &[u32] = if tableau == "sdirk4" { &[10, 20, 40] } else { &[20, 40, 80] };
            let found = of_method(|| with(tableau, &[]), &system, &start, &exact, steps)
                .unwrap_or_else(|error| panic!("{error}"));
            let order = exact_of(tableau).1;
            assert!((found.order - order).abs() < 0.15, "{tableau}, {law:?}: {found:?}");
        }
    }
}

/// One linear solve a stage keeps order 2: Newton starts within `O(h²)` and squares that.
#[test]
fn one_newton_iteration_a_stage_keeps_order_two() {
    let (system, start) = stir(smooth(DampingLaw::Full).build(), 0.02, 0.3);
    let exact = reference(&system, &start, &[0.25], ReferenceSettings::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let one = [("max_iterations", "1"), ("solver", "cg"), ("cg_tolerance", "0.01")];
    for (tableau, cheap) in [("tr-bdf2", &one[..1]), ("tr-bdf2", &one), ("sdirk2", &one)] {
        let found = of_method(|| with(tableau, cheap), &system, &start, &exact, &[20, 40, 80, 160])
            .unwrap_or_else(|error| panic!("{error}"));
        assert!((found.order - 2.0).abs() < 0.2, "{tableau}, {cheap:?}: {found:?}");
    }
}

#[test]
fn momentum_of_a_free_sheet_is_kept() {
    for tableau in ALL {
        let free = Sheet {
            pinned: false,
            gravity: Vec3::zeros(),
            tension: 1e6,
            shear: 1e5,
            ..Sheet::default()
        };
        let mut run = Run::new(with(tableau, &[]), stir(free.build(), 0.0, 0.3), 1e-3);
        let before = run.system.momentum(&run.state);
        run.steps(50);
        let drift = (run.system.momentum(&run.state) - before).norm();
        assert!(drift < 1e-13, "{tableau}: {drift:e}");
    }
}

fn above(restitution: f64, friction: f64, normal: [f64; 3], x: Vec3, v: Vec3) -> (System, State) {
    let mut spec = particles(&[0.5], &[x], &[v]);
    spec.effects.gravity = gravity();
    let path = Vec::new();
    spec.obstacles =
        vec![ObstacleSpec::Plane { point_m: [0.0; 3], normal, restitution, friction, path }];
    build(&spec)
}

#[test]
fn a_dropped_particle_comes_to_rest_and_an_elastic_one_returns_to_its_height() {
    for (tableau, e) in ALL.into_iter().flat_map(|t| [0.0, 0.5, 1.0].map(|e| (t, e))) {
        let start = above(e, 0.0, [0.0, 0.0, 1.0], Vec3::z(), Vec3::zeros());
        let mut run = Run::new(with(tableau, &[]), start, 0.01);
        let start = run.energy();
        let mut highest: f64 = 0.0;
        for step in 0..800 {
            run.step();
            assert!(run.energy() < start + 1e-12, "{tableau}, e = {e}, step {step}");
            if step > 60 {
                highest = highest.max(run.state.x[0].z);
            }
        }
        let (x, v) = (run.state.x[0], run.state.v[0]);
        if e < 1.0 {
            assert!(x.norm() < 1e-9 && v.norm() < 1e-12, "{tableau}, e = {e}: {x:?} {v:?}");
        } else {
            assert!(highest > 0.9 && highest <= 1.0 + 1e-9, "{tableau}: {highest}");
        }
    }
}

/// On a slope a particle slides by Coulomb's law, exactly, or sticks and does not creep.
#[test]
fn friction_is_coulombs() {
    let (sine, cosine) = (0.6, 0.8);
    let down = Vec3::new(cosine, 0.0, -sine);
    for tableau in ALL {
        for (friction, acceleration) in [(0.3, 9.81 * (sine - 0.3 * cosine)), (0.9, 0.0)] {
            let start = above(0.0, friction, [sine, 0.0, cosine], Vec3::zeros(), Vec3::zeros());
            let mut run = Run::new(with(tableau, &[]), start, 0.01);
            run.steps(100);
            let (x, v) = (run.state.x[0].dot(&down), run.state.v[0].dot(&down));
            let case = format!("{tableau}, μ = {friction}");
            assert!((x - 0.5 * acceleration).abs() < 1e-9, "{case}: {x}");
            assert!((v - acceleration).abs() < 1e-9, "{case}: {v}");
        }
        // What slides on the flat comes to rest where friction says, and never turns round. Its
        // last step is cut short, so it may go h² μ g farther.
        let start = above(0.0, 0.3, [0.0, 0.0, 1.0], Vec3::zeros(), Vec3::x());
        let mut run = Run::new(with(tableau, &[]), start, 0.01);
        for step in 0..60 {
            run.step();
            assert!(run.state.v[0].x > -1e-12, "{tableau}, {step}: {:?}", run.state.v[0]);
        }
        let way = 0.5 / (0.3 * 9.81);
        assert!((run.state.x[0].x - way).abs() < 1e-3, "{tableau}: {}", run.state.x[0].x);
        assert!(run.state.v[0].norm() < 1e-12, "{tableau}: {:?}", run.state.v[0]);
    }
}

/// An impact with friction takes Coulomb's share of the speed along the surface, once.
#[test]
fn an_impact_with_friction_takes_its_share_once() {
    for tableau in ALL {
        let start = above(0.0, 0.2, [0.0, 0.0, 1.0], Vec3::z() * 0.1, Vec3::new(3.0, 0.0, -2.0));
        let mut run = Run::new(with(tableau, &[]), start, 0.001);
        let mut before = run.state.v[0];
        while run.state.v[0].z < -1e-9 {
            before = run.state.v[0];
            run.step();
        }
        // What leads it out of the floor, at 1 m/s, rubs too.
        let lost = (3.0 - run.state.v[0].x) / 0.2;
        let least = -before.z - 0.01;
        assert!((least..least + 1.03).contains(&lost), "{tableau}: {lost}, {before:?}");
    }
}

/// A pin on a path, and a floor that rises, carry what is on them.
#[test]
fn led_pins_are_on_their_paths_and_a_rising_floor_lifts() {
    for tableau in ALL {
        let mut spec = Sheet { side: 3, ..Sheet::default() }.spec();
        let frame = |time_s, offset_m| KeyframeSpec { time_s, offset_m };
        spec.pins[0].path = vec![frame(0.1, [0.0, 0.0, 0.3]), frame(0.3, [0.3, 0.1, 0.3])];
        let mut run = Run::new(with(tableau, &[]), build(&spec), 0.01);
        let start = run.state.x[0];
        for n in 1..=30 {
            run.step();
            let on_the_path = run.system.moving_pins()[0].position(run.state.t);
            let off = (run.state.x[0] - on_the_path).norm();
            assert!(off < 1e-12, "{tableau}, step {n}: {off:e}, {start:?}");
        }
        run.steps(5);
        assert_eq!(run.state.v[0], Vec3::zeros(), "it rests after the last keyframe");
        let mut spec = particles(&[0.5], &[Vec3::zeros()], &[]);
        spec.effects.gravity = gravity();
        let path = vec![frame(1.0, [0.0, 0.0, 0.5])];
        let (normal, restitution, friction) = ([0.0, 0.0, 1.0], 0.0, 0.3);
        spec.obstacles =
            vec![ObstacleSpec::Plane { point_m: [0.0; 3], normal, restitution, friction, path }];
        let mut run = Run::new(with(tableau, &[]), build(&spec), 0.01);
        run.steps(50);
        let x = run.state.x[0];
        assert!((x - Vec3::z() * 0.25).norm() < 1e-9, "{tableau}: {x:?}");
    }
}

/// What the last step knows of its forces does not outlive a change of the system.
#[test]
fn a_change_of_the_system_is_seen_at_once() {
    for tableau in ALL {
        let mut run = Run::new(tight(tableau), stir(Sheet::default().build(), 0.0, 0.3), 0.004);
        run.steps(3);
        assert!(run.system.set_pinned(12, true) && run.system.set_pinned(0, false));
        let heavier: Vec<f64> = run.system.mass().iter().map(|m| 2.0 * m).collect();
        assert!(run.system.set_mass(&heavier));
        let start = (run.system.clone(), run.state.clone());
        let mut fresh = Run::new(tight(tableau), start, 0.004);
        run.steps(2);
        fresh.steps(2);
        let apart = drape_oracle::apart(&run.state.x, &fresh.state.x);
        assert!(apart < 1e-12, "{tableau}: {apart:e}");
    }
}

#[test]
fn settings_that_exclude_each_other_are_refused_and_unfinished_solves_reported() {
    for (tableau, fits) in ALL.into_iter().zip([true, true, false, false, false]) {
        let pairs = [("tableau", tableau), ("tolerance", "0.01")];
        assert_eq!(DirkSettings::from_pairs(pairs).is_ok(), fits, "{tableau}");
    }
    assert_eq!(DirkSettings::default().tableau, Tableau::TrBdf2);
    for tableau in ALL {
        let start = stir(Sheet { tension: 1e6, ..Sheet::default() }.build(), 0.1, 3.0);
        let mut run = Run::new(with(tableau, &[("max_iterations", "1")]), start, 0.05);
        assert_eq!(run.step().solve, SolveStatus::IterationLimit, "{tableau}");
    }
}

/// Under control of the step size a smooth fall keeps to the tolerance with few rejections.
#[test]
fn step_size_control_divides_steps() {
    let start = stir(Sheet { tension: 1e4, ..Sheet::default() }.build(), 0.02, 0.3);
    let mut run = Run::new(with("tr-bdf2", &[("tolerance", "1e-4")]), start, 0.1);
    let reports = run.steps(3);
    assert!(reports.iter().all(|r| r.substeps > 2 && r.error_estimate <= 1.0), "{reports:?}");
}
