//! The step against its recurrences and laws, alone and in contact.

use crate::{GeneralizedAlpha, GeneralizedAlphaSettings};
use drape_integrator::{Integrator, SolveStatus};
use drape_model::{DampingLaw, KeyframeSpec, ObstacleSpec, SpringEffect, State, System, Vec3};
use drape_oracle::Run;
use drape_oracle::laws::{Drift, free_fall, spin};
use drape_oracle::order::of_method;
use drape_oracle::recurrence;
use drape_oracle::reference::{ReferenceSettings, reference};
use drape_oracle::scenes::{GRAVITY, Sheet, anchored, build, gravity, particles, stir, tension};
use nalgebra::Vector3;

/// Family and `rho_inf`.
const ALL: [(&str, &str); 6] = [
    ("chung-hulbert", "0.5"),
    ("chung-hulbert", "0"),
    ("chung-hulbert", "0.8"),
    ("chung-hulbert", "1"),
    ("hht", "0.8"),
    ("newmark", "1"),
];

fn exact_of((family, rho): (&str, &str)) -> recurrence::GeneralizedAlpha {
    let rho: f64 = rho.parse().expect("a number");
    match family {
        "hht" => recurrence::GeneralizedAlpha::hht((1.0 - rho) / (1.0 + rho)),
        "newmark" => recurrence::GeneralizedAlpha::newmark(rho),
        _ => recurrence::GeneralizedAlpha::chung_hulbert(rho),
    }
}

fn with((family, rho): (&str, &str), more: &[(&str, &str)]) -> Box<dyn Integrator> {
    let pairs = more.iter().copied().chain([("family", family), ("rho_inf", rho)]);
    let settings = GeneralizedAlphaSettings::from_pairs(pairs).expect("in range");
    Box::new(GeneralizedAlpha::new(settings))
}

fn tight(member: (&str, &str)) -> Box<dyn Integrator> {
    with(member, &[("residual", "1e-16")])
}

#[test]
fn a_spring_without_length_moves_by_the_recurrence_at_any_step_sizes() {
    let h = 1.0 / 64.0;
    let parameters = [(0.36, 0.06), (1.0, 0.0), (100.0, 0.4), (100.0, 0.0), (2.0, 30.0)];
    for (member, (theta, eta)) in ALL.into_iter().flat_map(|m| parameters.map(|p| (m, p))) {
        let (k, c) = (theta * 0.25 / (h * h), eta * 0.25 / h);
        let springs = [(SpringEffect::Tension, 0.0, k, c)];
        let spec = anchored(0.25, &springs, Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
        let mut run = Run::new(tight(member), build(&spec), h);
        let ratio = |step: usize| [1.0, 2.0, 0.75, 0.5, 1.5][step % 5];
        // (x, hv, h²a) with h of the first step, each rescaled for its own.
        let mut exact = [0, 1, 2].map(|k| {
            let (x, w) = (run.state.x[1][k], run.state.v[1][k] * h);
            recurrence::GeneralizedAlpha::start(x, w, theta, eta)
        });
        for step in 0..100 {
            let r = ratio(step);
            run.step_by(r * h);
            for (axis, y) in exact.iter_mut().enumerate() {
                let matrix = exact_of(member).matrix(theta * r * r, eta * r);
                let scaled = Vector3::new(y.x, y.y * r, y.z * r * r);
                let next = matrix * scaled;
                let found = [run.state.x[1][axis], run.state.v[1][axis] * r * h];
                let error = (found[0] - next.x).hypot(found[1] - next.y);
                let error = error / next.norm().max(scaled.norm());
                let case = format!("{member:?}, θ={theta} η={eta}, step {step}");
                assert!(error < 1e-9, "{case}: {error:e}");
                *y = Vector3::new(next.x, next.y / r, next.z / (r * r));
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

/// Numbers of an independent implementation: spin and angle after 1 s at h = 0.01 for θ = 1 and
/// θ = 100, and energy for θ = 100.
#[test]
fn a_stiff_pair_turns_as_an_independent_implementation_says() {
    #[rustfmt::skip]
    let table = [
        ("1", [1.000_000_000_2, 1.999_933_34], [1.000_000_000_0, 1.999_933_34], 1.000_000_00),
        ("0.8", [0.999_997_509_7, 1.999_925_93], [0.999_997_509_4, 1.999_925_92], 0.999_995_02),
        ("0.5", [0.999_977_200_6, 1.999_866_47], [0.999_977_199_6, 1.999_866_41], 0.999_954_40),
        ("0", [0.999_784_954_2, 1.999_327_94], [0.999_784_954_4, 1.999_327_44], 0.999_569_96),
    ];
    for (rho, soft, stiff, energy) in table {
        for (theta, [spin, angle]) in [(1.0, soft), (100.0, stiff)] {
            let mut run = Run::new(tight(("chung-hulbert", rho)), rotor(theta), 0.01);
            let (before, start) = (turn(&run.state).0, run.energy());
            run.steps(100);
            let found = turn(&run.state);
            let kept = found.0 / before;
            assert!((kept - spin).abs() < 2e-9, "{rho}, θ={theta}: spin {kept}");
            assert!((found.1 - angle).abs() < 1e-8, "{rho}, θ={theta}: angle {}", found.1);
            let kept = run.energy() / start;
            assert!(theta < 2.0 || (kept - energy).abs() < 1e-8, "{rho}: energy {kept}");
        }
    }
}

/// `(1 + ¼θ (1 − ℓ/L)) d × v` never drifts, whatever the spring does; damping takes its share.
#[test]
fn newmarks_trapezoid_obeys_its_law_of_spin() {
    let h = 1.0 / 64.0;
    for (theta, eta) in [(10.0, 0.0), (10.0, 0.125), (1e4, 0.0)] {
        let (k, c) = (0.5 * theta * 0.25 / (h * h), 0.5 * eta * 0.25 / h);
        let (x, v) = ([Vec3::zeros(), Vec3::new(0.6, 0.0, 0.0)], [Vec3::y(), -Vec3::y()]);
        let mut spec = particles(&[0.25; 2], &x, &v);
        spec.springs = vec![tension((0, 1), 0.5, k, c)];
        let mut run = Run::new(tight(("newmark", "1")), build(&spec), h);
        let ratio = |run: &Run| 0.5 / (run.state.x[1] - run.state.x[0]).norm();
        for step in 0..100 {
            let (before, old) = (turn(&run.state).0, ratio(&run));
            run.step();
            let factor = spin::trapezoid(theta, eta, old, ratio(&run));
            let wrong = (turn(&run.state).0 - factor * before).abs() / before.abs();
            assert!(wrong < 1e-8, "θ={theta} η={eta}, step {step}: {wrong:e}");
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
    for member in ALL {
        let (system, mut state) = sheet.build();
        state.v.fill(Vec3::new(1.0, -2.0, 3.0));
        let start = state.clone();
        let mut run = Run::new(with(member, &[]), (system, state), 1.0 / 64.0);
        for n in 1..=20 {
            run.step();
            for i in 0..start.len() {
                let (x, v) =
                    free_fall(Drift::MeanVelocity, start.x[i], start.v[i], GRAVITY, 1.0 / 64.0, n);
                let error = (run.state.x[i] - x).norm() + (run.state.v[i] - v).norm();
                assert!(error < 1e-11, "{member:?}, step {n}, particle {i}: {error:e}");
            }
        }
    }
}

fn smooth(law: DampingLaw) -> Sheet {
    Sheet { side: 5, tension: 400.0, shear: 100.0, damping: 2.0, law, ..Sheet::default() }
}

#[test]
fn every_member_has_its_order_with_both_laws_of_damping() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let (system, start) = stir(smooth(law).build(), 0.02, 0.3);
        let exact = reference(&system, &start, &[0.25], ReferenceSettings::default())
            .unwrap_or_else(|error| panic!("{error}"));
        for member in ALL.into_iter().chain([("newmark", "0.5")]) {
            let order = if member == ("newmark", "0.5") { 1.0 } else { 2.0 };
            let steps = [40, 80, 160];
            let found = of_method(|| with(member, &[]), &system, &start, &exact, &steps)
                .unwrap_or_else(|error| panic!("{error}"));
            assert!((found.order - order).abs() < 0.15, "{member:?}, {law:?}: {found:?}");
        }
    }
}

/// One linear solve a step keeps order 2: Newton starts within `O(h²)` and squares that.
#[test]
fn one_newton_iteration_keeps_order_two() {
    let (system, start) = stir(smooth(DampingLaw::Full).build(), 0.02, 0.3);
    let exact = reference(&system, &start, &[0.25], ReferenceSettings::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let one = [("max_iterations", "1"), ("solver", "cg"), ("cg_tolerance", "0.01")];
    for cheap in [&one[..1], &one] {
        let steps = [20, 40, 80, 160];
        let found = of_method(|| with(ALL[0], cheap), &system, &start, &exact, &steps)
            .unwrap_or_else(|error| panic!("{error}"));
        assert!((found.order - 2.0).abs() < 0.2, "{cheap:?}: {found:?}");
    }
}

#[test]
fn momentum_of_a_free_sheet_is_kept() {
    for member in ALL {
        let free = Sheet {
            pinned: false,
            gravity: Vec3::zeros(),
            tension: 1e6,
            shear: 1e5,
            ..Sheet::default()
        };
        let mut run = Run::new(with(member, &[]), stir(free.build(), 0.0, 0.3), 1e-3);
        let before = run.system.momentum(&run.state);
        run.steps(50);
        let drift = (run.system.momentum(&run.state) - before).norm();
        assert!(drift < 1e-13, "{member:?}: {drift:e}");
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
    for (member, e) in ALL.into_iter().flat_map(|t| [0.0, 0.5, 1.0].map(|e| (t, e))) {
        let start = above(e, 0.0, [0.0, 0.0, 1.0], Vec3::z(), Vec3::zeros());
        let mut run = Run::new(with(member, &[]), start, 0.01);
        let start = run.energy();
        let mut highest: f64 = 0.0;
        for step in 0..800 {
            run.step();
            assert!(run.energy() < start + 1e-12, "{member:?}, e = {e}, step {step}");
            if step > 60 {
                highest = highest.max(run.state.x[0].z);
            }
        }
        let (x, v) = (run.state.x[0], run.state.v[0]);
        if e < 1.0 {
            assert!(x.norm() < 1e-9 && v.norm() < 1e-12, "{member:?}, e = {e}: {x:?} {v:?}");
        } else {
            assert!(highest > 0.9 && highest <= 1.0 + 1e-9, "{member:?}: {highest}");
        }
    }
}

/// On a slope a particle slides by Coulomb's law, exactly, or sticks and does not creep.
#[test]
fn friction_is_coulombs() {
    let (sine, cosine) = (0.6, 0.8);
    let down = Vec3::new(cosine, 0.0, -sine);
    for member in ALL {
        for (friction, acceleration) in [(0.3, 9.81 * (sine - 0.3 * cosine)), (0.9, 0.0)] {
            let start = above(0.0, friction, [sine, 0.0, cosine], Vec3::zeros(), Vec3::zeros());
            let mut run = Run::new(with(member, &[]), start, 0.01);
            run.steps(100);
            let (x, v) = (run.state.x[0].dot(&down), run.state.v[0].dot(&down));
            let case = format!("{member:?}, μ = {friction}");
            // A rubbing particle moves with (h − τ_x) v_n + τ_x v_{n+1}, which has order 1.
            let off = (x - 0.5 * acceleration).abs();
            assert!(off < 0.51 * 0.01 * acceleration + 1e-9, "{case}: {x}");
            assert!((v - acceleration).abs() < 1e-9, "{case}: {v}");
        }
        // What slides on the flat comes to rest where friction says, and never turns round. Its
        // last step is cut short, so it may go h² μ g farther.
        let start = above(0.0, 0.3, [0.0, 0.0, 1.0], Vec3::zeros(), Vec3::x());
        let mut run = Run::new(with(member, &[]), start, 0.01);
        for step in 0..60 {
            run.step();
            assert!(run.state.v[0].x > -1e-12, "{member:?}, {step}: {:?}", run.state.v[0]);
        }
        let way = 0.5 / (0.3 * 9.81);
        assert!((run.state.x[0].x - way).abs() < 3e-3, "{member:?}: {}", run.state.x[0].x);
        assert!(run.state.v[0].norm() < 1e-12, "{member:?}: {:?}", run.state.v[0]);
    }
}

/// An impact with friction takes Coulomb's share of the speed along the surface, once.
#[test]
fn an_impact_with_friction_takes_its_share_once() {
    for member in ALL {
        let start = above(0.0, 0.2, [0.0, 0.0, 1.0], Vec3::z() * 0.1, Vec3::new(3.0, 0.0, -2.0));
        let mut run = Run::new(with(member, &[]), start, 0.001);
        let mut before = run.state.v[0];
        while run.state.v[0].z < -1e-9 {
            before = run.state.v[0];
            run.step();
        }
        // What leads it out of the floor, at 1 m/s, rubs too.
        let lost = (3.0 - run.state.v[0].x) / 0.2;
        let least = -before.z - 0.01;
        assert!((least..least + 1.03).contains(&lost), "{member:?}: {lost}, {before:?}");
    }
}

/// A pin on a path, and a floor that rises, carry what is on them.
#[test]
fn led_pins_are_on_their_paths_and_a_rising_floor_lifts() {
    for member in ALL {
        let mut spec = Sheet { side: 3, ..Sheet::default() }.spec();
        let frame = |time_s, offset_m| KeyframeSpec { time_s, offset_m };
        spec.pins[0].path = vec![frame(0.1, [0.0, 0.0, 0.3]), frame(0.3, [0.3, 0.1, 0.3])];
        let mut run = Run::new(with(member, &[]), build(&spec), 0.01);
        let start = run.state.x[0];
        for n in 1..=30 {
            run.step();
            let on_the_path = run.system.moving_pins()[0].position(run.state.t);
            let off = (run.state.x[0] - on_the_path).norm();
            assert!(off < 1e-12, "{member:?}, step {n}: {off:e}, {start:?}");
        }
        run.steps(5);
        assert_eq!(run.state.v[0], Vec3::zeros(), "it rests after the last keyframe");
        let mut spec = particles(&[0.5], &[Vec3::zeros()], &[]);
        spec.effects.gravity = gravity();
        let path = vec![frame(1.0, [0.0, 0.0, 0.5])];
        let (normal, restitution, friction) = ([0.0, 0.0, 1.0], 0.0, 0.3);
        spec.obstacles =
            vec![ObstacleSpec::Plane { point_m: [0.0; 3], normal, restitution, friction, path }];
        let mut run = Run::new(with(member, &[]), build(&spec), 0.01);
        run.steps(50);
        let x = run.state.x[0];
        assert!((x - Vec3::z() * 0.25).norm() < 1e-9, "{member:?}: {x:?}");
    }
}

/// What the last step knows of its forces does not outlive a change of the system.
#[test]
fn a_change_of_the_system_is_seen_at_once() {
    for member in ALL {
        let mut run = Run::new(tight(member), stir(Sheet::default().build(), 0.0, 0.3), 0.004);
        run.steps(3);
        assert!(run.system.set_pinned(12, true) && run.system.set_pinned(0, false));
        let heavier: Vec<f64> = run.system.mass().iter().map(|m| 2.0 * m).collect();
        assert!(run.system.set_mass(&heavier));
        let start = (run.system.clone(), run.state.clone());
        let mut fresh = Run::new(tight(member), start, 0.004);
        run.steps(2);
        fresh.steps(2);
        let apart = drape_oracle::apart(&run.state.x, &fresh.state.x);
        assert!(apart < 1e-12, "{member:?}: {apart:e}");
    }
}

#[test]
fn an_unfinished_solve_is_reported() {
    let start = stir(Sheet { tension: 1e6, ..Sheet::default() }.build(), 0.1, 3.0);
    let mut run = Run::new(with(ALL[0], &[("max_iterations", "1")]), start, 0.05);
    assert_eq!(run.step().solve, SolveStatus::IterationLimit);
}
