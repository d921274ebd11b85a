//! Obstacles: what falls comes to rest, bounces without gaining energy, slides and leaves as if the past knew.

use super::{Run, STEPS, adams, all, bdf, build, gravity, particles, pin, spring};
use crate::Steps;
use drape_model::{ObstacleSpec, State, System, SystemSpec, Vec3};

const H: f64 = 0.01;
const G: f64 = 9.81;

/// A particle under gravity above a plane through the origin.
fn above(normal: [f64; 3], restitution: f64, x: Vec3, v: Vec3) -> SystemSpec {
    let mut spec = particles(&[0.5], &[x], &[v]);
    spec.effects.gravity = gravity();
    spec.obstacles = vec![ObstacleSpec::plane([0.0; 3], normal, restitution)];
    spec
}

const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn name(run: &Run, steps: Steps) -> String {
    format!("{}, {steps:?}", run.integrator.method().id)
}

#[test]
fn what_falls_comes_to_rest_and_stays_so_after_restarts_too() {
    for (family, steps) in all() {
        for e in [0.0, 0.5] {
            let system = build(&above(UP, e, Vec3::new(0.1, 0.0, 0.3), Vec3::zeros()));
            let mut run = Run::new(family(steps), system, H);
            (0..400).for_each(|_| {
                run.step();
            });
            let case = format!("{}, e = {e}", name(&run, steps));
            for n in 0..100 {
                if n % 10 == 9 {
                    run.integrator.restart(&run.state);
                }
                run.step();
                let State { x, v, .. } = &run.state;
                assert!((x[0] - Vec3::x() * 0.1).norm() < 1e-9, "{case}, step {n}: {:?}", x[0]);
                assert_eq!(v[0], Vec3::zeros(), "{case}, step {n}");
            }
        }
    }
}

/// Levels that a bounce separates from the present are replaced by those of a free flight: the particle
/// is on the parabola at once, and an elastic bounce keeps the energy.
#[test]
fn the_flight_after_a_bounce_is_a_parabola_from_its_first_step() {
    for (family, steps) in all().filter(|(_, steps)| *steps != Steps::One) {
        for e in [0.5, 1.0] {
            let start = above(UP, e, Vec3::z() * 0.5, Vec3::new(0.3, 0.0, -1.0));
            let mut run = Run::new(family(steps), build(&start), H);
            let case = format!("{}, e = {e}", name(&run, steps));
            run.step(); // backward Euler, if that is how the method starts
            let energy = run.system.total_energy(&run.state);
            let mut bounces = 0;
            for n in 0..150 {
                let (x, v) = (run.state.x[0], run.state.v[0]);
                run.step();
                if run.state.v[0].z > v.z {
                    bounces += 1;
                } else if x.z > 1e-3 {
                    let expected = x + v * H - Vec3::z() * (0.5 * G * H * H);
                    // Two steps of BDF forget their start by 1/3 a step.
                    let start = 0.6 * G * H * H * 3.0_f64.powi(-n);
                    let close = 1e-12 + if case.starts_with("bdf2, Two") { start } else { 0.0 };
                    let error = (run.state.x[0] - expected).norm();
                    assert!(error < close, "{case}, step {n}: {error:e}");
                    assert!((run.state.v[0] - v + Vec3::z() * (G * H)).norm() < 1e-12, "{case}");
                }
            }
            assert!(bounces > 1, "{case}: {bounces} bounces");
            let change = run.system.total_energy(&run.state) - energy;
            let kept = change.abs() < 2e-3 * energy;
            assert!(change < 1e-12 && kept == (e == 1.0), "{case}: {change:e} of {energy}");
        }
    }
}

#[test]
fn what_starts_deep_inside_is_led_out_slowly_and_without_speed() {
    for (family, steps) in all() {
        let system = build(&above(UP, 0.5, Vec3::z() * -0.1, Vec3::zeros()));
        let mut run = Run::new(family(steps), system, H);
        let limit = run.system.contact().recovery_speed_limit;
        let case = name(&run, steps);
        for _ in 0..60 {
            let before = run.state.x[0].z;
            run.step();
            let way = run.state.x[0].z - before;
            assert!(way > -1e-15 && way < limit * H * (1.0 + 1e-9), "{case}: {way}");
            assert!(run.state.v[0].norm() < 1e-12, "{case}: {:?}", run.state.v[0]);
        }
        assert!(run.state.x[0].z.abs() < 1e-9, "{case}: {:?}", run.state.x[0]);
    }
}

/// Along the surface the methods keep their order: constant acceleration is met exactly.
#[test]
fn sliding_down_a_slope_is_exact_where_falling_is() {
    let normal = [0.6, 0.0, 0.8];
    let down = Vec3::new(0.8, 0.0, -0.6);
    for (family, steps) in all().filter(|(_, steps)| *steps != Steps::One) {
        let mut run = Run::new(family(steps), build(&above(normal, 0.0, Vec3::zeros(), down)), H);
        let case = name(&run, steps);
        // Backward Euler slides ½ h² a too far; then the contact is new, and so is the past.
        let start = if case.starts_with("bdf2, Two") { 0.5 * H * H } else { 0.0 };
        for n in 1..=100 {
            run.step();
            let t = H * f64::from(n);
            let expected = down * (t + 0.6 * G * (0.5 * t * t + start));
            let error = (run.state.x[0] - expected).norm();
            assert!(error < 1e-10, "{case}, step {n}: off by {error:e}");
            let error = (run.state.v[0] - down * (1.0 + 0.6 * G * t)).norm();
            assert!(error < 1e-10, "{case}, step {n}: velocity off by {error:e}");
        }
    }
}

/// Where an obstacle ends, so does what it bears, at once.
#[test]
fn what_slides_off_an_edge_falls_on_a_parabola_from_its_first_step() {
    for (family, steps) in all().filter(|(_, steps)| *steps != Steps::One) {
        let mut spec = above(UP, 0.0, Vec3::x() * 0.31, Vec3::x());
        let (center_m, size_m) = ([0.0, 0.0, -0.5], [1.0; 3]);
        spec.obstacles = vec![ObstacleSpec::cuboid(center_m, size_m, 0.0)];
        let mut run = Run::new(family(steps), build(&spec), H);
        let case = name(&run, steps);
        for n in 0..60 {
            let (x, v) = (run.state.x[0], run.state.v[0]);
            run.step();
            let falls = if x.x > 0.5 { Vec3::z() * -G } else { Vec3::zeros() };
            // Adams remembers forces, which an edge does not change; BDF velocities, which have a kink there.
            let first = v.z == 0.0;
            let close = if first && case.starts_with("bdf2") { 0.5 * G * H } else { 1e-12 };
            let error = (run.state.v[0] - v - falls * H).norm();
            assert!(error < close, "{case}, step {n}: velocity off by {error:e}");
            let close = if first { 0.6 * G * H * H } else { 1e-12 };
            let error = (run.state.x[0] - x - v * H - falls * (0.5 * H * H)).norm();
            assert!(error < close, "{case}, step {n}: off by {error:e}");
        }
        assert!(run.state.x[0].z < -0.3, "{case}: {:?}", run.state.x[0]);
    }
}

fn hung_above(obstacles: bool) -> (System, State) {
    let mut spec = above(UP, 0.0, Vec3::zeros(), Vec3::zeros());
    let positions = [Vec3::zeros(), Vec3::new(0.1, 0.0, 1.0)];
    spec.particles = particles(&[1.0; 2], &positions, &[]).particles;
    spec.springs = vec![spring((0, 1), 0.5, 100.0, 0.0)];
    spec.pins = vec![pin(1)];
    if !obstacles {
        spec.obstacles.clear();
    }
    build(&spec)
}

#[test]
fn what_a_spring_pulls_off_the_surface_leaves_as_if_there_were_none() {
    for (family, steps) in all() {
        let [held, free] = [true, false].map(|obstacles| {
            let mut run = Run::new(family(steps), hung_above(obstacles), H);
            (0..20).for_each(|_| {
                run.step();
            });
            run.state.x[0]
        });
        assert!(
            free.z > 0.1 && (held - free).norm() < 1e-2 * free.z,
            "{steps:?}: {held:?}, {free:?}"
        );
    }
}

/// A pin that lets go of what it held in the air above the plane, and one that catches what has landed.
#[test]
fn pins_and_obstacles_go_together() {
    for integrator in STEPS.map(adams).into_iter().chain(STEPS.map(bdf)) {
        let mut spec = above(UP, 0.0, Vec3::z() * 0.2, Vec3::zeros());
        spec.pins = vec![pin(0)];
        let mut run = Run::new(integrator, build(&spec), H);
        let go = |run: &mut Run| {
            for _ in 0..60 {
                run.step();
            }
        };
        go(&mut run);
        assert_eq!(run.state.x[0], Vec3::z() * 0.2);
        assert!(run.system.set_pinned(0, false));
        go(&mut run);
        assert!(run.state.x[0].norm() < 1e-9 && run.state.v[0] == Vec3::zeros());
        assert!(run.system.set_pinned(0, true));
        let landed = run.state.x[0];
        go(&mut run);
        assert_eq!(run.state.x[0], landed, "{:?}", run.integrator);
    }
}
