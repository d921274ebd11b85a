//! Pins and obstacles on paths, and friction, with every method.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{
    DampingLaw, GravitySpec, KeyframeSpec, ObstacleSpec, State, System, SystemSpec, Vec3,
};
use drape_oracle::scenes;
use drape_tests::{
    METHODS, Sheet, apart, assert_covers, build, has, is_adaptive, largest, particles, prepared,
    takes, takes_friction,
};

const G: f64 = 9.81;
const H: f64 = 0.01;

fn frame(time_s: f64, offset_m: [f64; 3]) -> KeyframeSpec {
    KeyframeSpec { time_s, offset_m }
}

/// A sheet on two pins of which the first is led round a corner and stops.
fn led_sheet(law: DampingLaw) -> SystemSpec {
    let mut spec = Sheet { law, ..Sheet::default() }.spec();
    spec.pins[0].path = vec![frame(0.05, [0.1, -0.05, 0.0]), frame(0.1, [0.1, 0.0, 0.2])];
    spec
}

#[test]
fn every_method_takes_part_in_what_moves() {
    assert_covers("motion", METHODS, &[]);
    assert_covers("motion in steps of one size", methods(), &[]);
}

#[test]
fn pins_are_on_their_paths_at_the_end_of_every_step_of_every_method() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let (system, _) = build(&led_sheet(law));
        for id in METHODS.into_iter().filter(|id| takes(id, &system)) {
            let mut run = prepared(id, build(&led_sheet(law)), 0.004);
            let other = run.state.x[4];
            for n in 0..40 {
                run.step();
                assert!(run.state.is_finite(), "{id}, step {n}");
                let pin = &run.system.moving_pins()[0];
                let off = (run.state.x[pin.particle] - pin.position(run.state.t)).norm();
                assert!(off < 1e-14, "{id}, step {n}: {off:e} m off its path");
                assert_eq!(run.state.x[4], other, "{id}: the other pin does not move");
            }
            assert_eq!(run.state.v[0], Vec3::zeros(), "{id}: it rests after the last keyframe");
        }
    }
}

/// Seen from a frame that goes along, nothing happens: the pin must pull its neighbours by the
/// right velocity as well as by the right position.
#[test]
fn what_moves_with_a_pin_moves_on_with_it() {
    let velocity = Vec3::new(1.0, -0.5, 2.0);
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let (led, _) = build(&led_sheet(law));
        for id in METHODS.into_iter().filter(|id| takes(id, &led)) {
            let mut spec = Sheet { law, gravity: Vec3::zeros(), ..Sheet::default() }.spec();
            for pin in &mut spec.pins {
                pin.path = vec![frame(1.0, velocity.into())];
            }
            let (system, mut state) = build(&spec);
            let start = state.x.clone();
            for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
                state.v[i] = velocity;
            }
            let mut run = prepared(id, (system, state), 0.004);
            for n in 0..25 {
                run.step();
                for (x, start) in run.state.x.iter().zip(&start) {
                    let off = (x - start - velocity * run.state.t).norm();
                    assert!(off < 1e-11, "{id}, step {n}: {off:e}");
                }
            }
        }
    }
}

/// With gusts, a pin and an obstacle on paths: what is frozen in mid-run goes on as if it had not
/// been.
#[test]
fn a_system_frozen_in_mid_run_moves_on_as_the_run_did() {
    let mut spec = scenes::bundled("flag");
    spec.pins[0].path = vec![frame(0.05, [0.1, 0.0, 0.1]), frame(0.15, [0.0, 0.2, 0.1])];
    let ball = ObstacleSpec::Sphere {
        center_m: [0.2, -0.3, 0.0],
        radius_m: 0.2,
        restitution: 0.0,
        friction: 0.0,
        path: vec![frame(0.2, [0.0, 0.4, 0.0])],
    };
    spec.obstacles = vec![ball];
    let run = |spec: &SystemSpec, steps: usize| {
        let mut run = prepared("symplectic-euler", build(spec), 5e-4);
        run.steps(steps);
        run.state
    };
    let far = |a: &State, b: &State| apart(&a.x, &b.x);
    let whole = run(&spec, 400);
    let frozen = spec.clone().with_state(&run(&spec, 200));
    let found = far(&run(&frozen, 200), &whole);
    assert!(found < 1e-9, "{found:e} m apart");
    let mut again = frozen;
    again.effects.air.as_mut().unwrap().wind.as_mut().unwrap().gust.as_mut().unwrap().start_s = 0.0;
    let found = far(&run(&again, 200), &whole);
    assert!(found > 1e-4, "gusts that begin anew are {found:e} m apart");
}

/// One particle of 0.5 kg, gravity along −z.
fn particle(x: Vec3, v: Vec3, gravity: f64, obstacle: ObstacleSpec) -> (System, State) {
    let mut spec = particles(&[0.5], &[x], &[v]);
    spec.effects.gravity = Some(GravitySpec { m_s2: [0.0, 0.0, -gravity] });
    spec.obstacles.push(obstacle);
    build(&spec)
}

fn plane(normal: Vec3, restitution: f64, friction: f64, velocity: Vec3) -> ObstacleSpec {
    let path = vec![frame(20.0, (velocity * 20.0).into())];
    let path = if velocity == Vec3::zeros() { Vec::new() } else { path };
    let normal = normal.into();
    ObstacleSpec::Plane { point_m: [0.0; 3], normal, restitution, friction, path }
}

/// Methods that meet obstacles and take one step of the size that is asked for.
fn touching() -> impl Iterator<Item = &'static str> {
    let (obstructed, _) =
        particle(Vec3::zeros(), Vec3::zeros(), G, plane(Vec3::z(), 0.0, 0.0, Vec3::x()));
    methods().filter(move |id| takes(id, &obstructed))
}

/// Methods that take one step of the size that is asked for.
fn methods() -> impl Iterator<Item = &'static str> {
    METHODS.into_iter().filter(|id| !is_adaptive(id) && !has(id, "step=auto"))
}

#[test]
fn what_rests_on_a_moving_plane_is_carried_and_does_not_sink_in() {
    for id in touching() {
        let up = Vec3::new(0.0, 0.0, 0.5);
        let start = particle(Vec3::zeros(), Vec3::zeros(), G, plane(Vec3::z(), 0.0, 0.0, up));
        let mut run = prepared(id, start, H);
        for n in 0..300 {
            run.step();
            let off = run.state.x[0].z - 0.5 * run.state.t;
            assert!(off >= -0.5 * H - G * H * H, "{id}, step {n}: sinks in by {off:e}");
            if n >= 50 {
                assert!(off.abs() < 1e-9, "{id}, step {n}: {off:e} m off the plane");
                assert!((run.state.v[0].z - 0.5).abs() < 1e-9, "{id}: {:?}", run.state.v[0]);
            }
        }
    }
}

#[test]
fn a_plane_that_hits_a_particle_sends_it_off_by_the_restitution() {
    for id in touching() {
        for e in [0.0, 0.5, 1.0] {
            let up = Vec3::new(0.0, 0.0, 1.0);
            let at = Vec3::new(0.0, 0.0, 0.025);
            let start = particle(at, Vec3::zeros(), 0.0, plane(Vec3::z(), e, 0.0, up));
            let mut run = prepared(id, start, H);
            run.steps(20);
            let found = run.state.v[0].z;
            assert!((found - (1.0 + e)).abs() < 1e-12, "{id}, e = {e}: {found}");
        }
    }
}

fn incline(tangent: f64) -> (Vec3, Vec3) {
    let normal = Vec3::new(tangent, 0.0, 1.0).normalize();
    (normal, Vec3::new(normal.z, 0.0, -normal.x))
}

#[test]
fn a_block_on_an_incline_sticks_without_creep_or_slides_by_coulombs_law() {
    let mut wrong = Vec::new();
    for id in touching() {
        for (tangent, friction) in [(0.4, 0.5), (0.7, 0.5), (0.3, 0.0)] {
            let (normal, down) = incline(tangent);
            if friction > 0.0 && !takes_friction(id) {
                continue;
            }
            let obstacle = plane(normal, 0.0, friction, Vec3::zeros());
            let mut run = prepared(id, particle(Vec3::zeros(), Vec3::zeros(), G, obstacle), H);
            run.step();
            let first = run.state.x[0].dot(&down);
            let steps = if friction > tangent { 1000 } else { 100 };
            for _ in 1..steps {
                run.step();
            }
            let (x, v) = (run.state.x[0].dot(&down), run.state.v[0].dot(&down));
            let is_right = if friction > tangent {
                // The first stage of the first of three steps sees no obstacle.
                let slip = if id == "bdf2:steps=3" { 0.25 * G * H * H } else { 1e-12 };
                first.abs() < slip && (x - first).abs() < 1e-12 && v.abs() < 1e-12
            } else {
                let a = G * (normal.x - friction * normal.z);
                // A two-step method that meets friction makes up a past of constant velocity.
                // Of three steps the first stage sees no obstacle besides.
                let allowed = match id {
                    _ if friction == 0.0 => 1e-9,
                    "bdf2:steps=3" => 2.0 * H,
                    _ if id.contains("adams") || id.contains("bdf") || has(id, "order=2") => H,
                    _ if id.starts_with("xpbd-lines") && !has(id, "order=1") => H,
                    _ => 1e-9,
                };
                (v - a).abs() < allowed * a && (x - 0.5 * a).abs() < 0.02 * a
            };
            if !is_right {
                wrong.push(format!(
                    "{id}, tan = {tangent}, μ = {friction}: {first}, {x} m, {v} m/s"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_moving_table_takes_along_what_lies_on_it() {
    let (friction, speed) = (0.3, 0.5);
    for id in methods().filter(|id| takes_friction(id)) {
        let along = Vec3::new(speed, 0.0, 0.0);
        let obstacle = plane(Vec3::z(), 0.0, friction, along);
        let mut run = prepared(id, particle(Vec3::zeros(), Vec3::zeros(), G, obstacle), H);
        for n in 0..100 {
            run.step();
            let (v, t) = (run.state.v[0].x, run.state.t);
            let law = (friction * G * t).min(speed);
            assert!((v - law).abs() < 2.0 * friction * G * H, "{id}, step {n}: {v}, not {law}");
        }
        let slip = speed * run.state.t - run.state.x[0].x;
        let law = 0.5 * speed * speed / (friction * G);
        assert!((slip - law).abs() < speed * H, "{id}: slips {slip}, not {law}");
        assert!((run.state.v[0].x - speed).abs() < 1e-12, "{id}: {}", run.state.v[0].x);
    }
}

/// A sheet that is thrown along a rough floor.
fn thrown(friction: f64) -> (System, State) {
    let mut spec = Sheet { pinned: false, ..Sheet::default() }.spec();
    let (point_m, normal) = ([0.0; 3], [0.0, 0.0, 1.0]);
    let path = Vec::new();
    spec.obstacles =
        vec![ObstacleSpec::Plane { point_m, normal, restitution: 0.0, friction, path }];
    let (system, mut state) = build(&spec);
    for (i, v) in state.v.iter_mut().enumerate() {
        let a = i as f64;
        *v = Vec3::new(1.0 + 0.5 * a.sin(), 0.5 * (2.0 * a).cos(), 0.0);
    }
    (system, state)
}

#[test]
fn friction_takes_energy_and_brings_a_sheet_to_rest() {
    for id in ["backward-euler", "imex-euler", "imex-updated", "baraff-witkin"] {
        for friction in [0.1, 0.5] {
            let mut run = prepared(id, thrown(friction), 0.004);
            let (mut energy, start) = (run.energy(), run.energy());
            for n in 0..1500 {
                run.step();
                let now = run.energy();
                assert!(now <= energy + 1e-9 * start, "{id}, step {n}: {energy} J to {now} J");
                energy = now;
            }
            let moving = largest(&run.state.v);
            assert!(moving < 1e-3, "{id}, μ = {friction}: {moving} m/s");
        }
    }
}

/// In a frame that goes along with the floor, a thrown sheet does what it does on a floor at rest.
#[test]
fn friction_depends_on_the_velocity_relative_to_the_surface() {
    let velocity = Vec3::new(-1.5, 0.25, 0.5);
    for id in ["backward-euler", "leapfrog", "kang", "adams-bashforth2", "bdf2"] {
        let (system, state) = thrown(0.3);
        let mut moving = Sheet { pinned: false, ..Sheet::default() }.spec();
        moving.obstacles = vec![plane(Vec3::z(), 0.0, 0.3, velocity)];
        let (moving, mut carried) = build(&moving);
        carried.v.iter_mut().zip(&state.v).for_each(|(v, still)| *v = still + velocity);
        let mut still = prepared(id, (system, state), 0.004);
        let mut moving = prepared(id, (moving, carried), 0.004);
        for n in 0..100 {
            still.step();
            moving.step();
            for (a, b) in still.state.x.iter().zip(&moving.state.x) {
                let off = (b - a - velocity * moving.state.t).norm();
                assert!(off < 1e-6, "{id}, step {n}: {off:e}");
            }
        }
    }
}
