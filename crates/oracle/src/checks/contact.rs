//! A particle on planes, pins on paths.

use crate::Run;
use crate::scenes::{Sheet, build, floor, gravity, particles};
use drape_integrator::Integrator;
use drape_model::{KeyframeSpec, ObstacleSpec, State, System, Vec3};
use std::fmt::Debug;

const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// A plane through the origin.
fn plane(
    normal: [f64; 3],
    restitution: f64,
    friction: f64,
    path: Vec<KeyframeSpec>,
) -> ObstacleSpec {
    ObstacleSpec::Plane { point_m: [0.0; 3], normal, restitution, friction, path }
}

/// A particle of 0.5 kg under gravity, and a plane.
fn above(plane: ObstacleSpec, x: Vec3, v: Vec3) -> (System, State) {
    let mut spec = particles(&[0.5], &[x], &[v]);
    spec.effects.gravity = gravity();
    spec.obstacles = vec![plane];
    build(&spec)
}

/// A dropped particle never gains energy. With a restitution below 1 it comes to rest; with
/// restitution 1 it returns to its height.
pub fn bounces_or_rests(
    case: impl Debug,
    new: impl Fn() -> Box<dyn Integrator>,
    restitutions: &[f64],
) {
    for &e in restitutions {
        let start = above(plane(UP, e, 0.0, Vec::new()), Vec3::z(), Vec3::zeros());
        let mut run = Run::new(new(), start, 0.01);
        let start = run.energy();
        let mut highest: f64 = 0.0;
        for step in 0..800 {
            run.step();
            assert!(run.energy() < start + 1e-12, "{case:?}, e = {e}, step {step}");
            if step > 60 {
                highest = highest.max(run.state.x[0].z);
            }
        }
        let (x, v) = (run.state.x[0], run.state.v[0]);
        if e < 1.0 {
            assert!(x.norm() < 1e-9 && v.norm() < 1e-12, "{case:?}, e = {e}: {x:?} {v:?}");
        } else {
            assert!(highest > 0.9 && highest <= 1.0 + 1e-9, "{case:?}: {highest}");
        }
    }
}

/// On a slope, a particle must slide by Coulomb's law, or stick without creeping. On the flat it
/// must come to rest where friction predicts, and never reverse.
///
/// On the slope it may deviate by `lag` times the displacement that one step adds to its speed. On
/// the flat the last step is shortened, so it may go `flat` metres farther.
pub fn friction_is_coulombs(
    case: impl Debug,
    new: impl Fn() -> Box<dyn Integrator>,
    lag: f64,
    flat: f64,
) {
    let (sine, cosine) = (0.6, 0.8);
    let down = Vec3::new(cosine, 0.0, -sine);
    for (friction, acceleration) in [(0.3, 9.81 * (sine - 0.3 * cosine)), (0.9, 0.0)] {
        let slope = plane([sine, 0.0, cosine], 0.0, friction, Vec::new());
        let mut run = Run::new(new(), above(slope, Vec3::zeros(), Vec3::zeros()), 0.01);
        run.steps(100);
        let (x, v) = (run.state.x[0].dot(&down), run.state.v[0].dot(&down));
        let off = (x - 0.5 * acceleration).abs();
        assert!(off < lag * 0.01 * acceleration + 1e-9, "{case:?}, μ = {friction}: {x}");
        assert!((v - acceleration).abs() < 1e-9, "{case:?}, μ = {friction}: {v}");
    }
    let start = above(plane(UP, 0.0, 0.3, Vec::new()), Vec3::zeros(), Vec3::x());
    let mut run = Run::new(new(), start, 0.01);
    for step in 0..60 {
        run.step();
        assert!(run.state.v[0].x > -1e-12, "{case:?}, step {step}: {:?}", run.state.v[0]);
    }
    let way = 0.5 / (0.3 * 9.81);
    assert!((run.state.x[0].x - way).abs() < flat, "{case:?}: {}", run.state.x[0].x);
    assert!(run.state.v[0].norm() < 1e-12, "{case:?}: {:?}", run.state.v[0]);
}

/// An impact with friction takes Coulomb's share of the tangential speed exactly once.
pub fn impact_takes_its_share_once(case: impl Debug, integrator: Box<dyn Integrator>) {
    let floor = plane(UP, 0.0, 0.2, Vec::new());
    let start = above(floor, Vec3::z() * 0.1, Vec3::new(3.0, 0.0, -2.0));
    let mut run = Run::new(integrator, start, 0.001);
    let mut before = run.state.v[0];
    for step in 0.. {
        assert!(step < 1000, "{case:?}: it never lands");
        before = run.state.v[0];
        run.step();
        if run.state.v[0].z >= -1e-9 {
            break;
        }
    }
    // What leads it out of the floor, at 1 m/s, rubs too.
    let lost = (3.0 - run.state.v[0].x) / 0.2;
    let least = -before.z - 0.01;
    assert!((least..least + 1.03).contains(&lost), "{case:?}: {lost}, {before:?}");
}

/// A pin on a path, and a rising floor, must carry the particles on them.
pub fn paths_lead(case: impl Debug, new: impl Fn() -> Box<dyn Integrator>) {
    let mut spec = Sheet { side: 3, ..Sheet::default() }.spec();
    let frame = |time_s, offset_m| KeyframeSpec { time_s, offset_m };
    spec.pins[0].path = vec![frame(0.1, [0.0, 0.0, 0.3]), frame(0.3, [0.3, 0.1, 0.3])];
    let mut run = Run::new(new(), build(&spec), 0.01);
    for n in 1..=30 {
        run.step();
        let on_the_path = run.system.moving_pins()[0].position(run.state.t);
        let off = (run.state.x[0] - on_the_path).norm();
        assert!(off < 1e-12, "{case:?}, step {n}: {off:e}");
    }
    run.steps(5);
    assert_eq!(run.state.v[0], Vec3::zeros(), "{case:?}: it rests after the last keyframe");
    let rising = plane(UP, 0.0, 0.3, vec![frame(1.0, [0.0, 0.0, 0.5])]);
    let mut run = Run::new(new(), above(rising, Vec3::zeros(), Vec3::zeros()), 0.01);
    run.steps(50);
    let x = run.state.x[0];
    assert!((x - Vec3::z() * 0.25).norm() < 1e-9, "{case:?}: {x:?}");
}

/// A sheet that falls on a floor must end outside of it. A particle that friction holds on a slope
/// must not creep.
pub fn nothing_sinks_or_creeps(case: impl Debug, new: impl Fn() -> Box<dyn Integrator>) {
    let mut spec = Sheet { side: 8, pinned: false, ..Sheet::default() }.spec();
    spec.obstacles = vec![floor(0.0)];
    spec.particles.position_m.iter_mut().for_each(|x| x[2] += 0.3);
    let mut run = Run::new(new(), build(&spec), 0.01);
    for step in 0..100 {
        run.step();
        let deepest = run.state.x.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
        assert!(deepest > -1e-9, "{case:?}, step {step}: {deepest:e} m");
    }
    let normal = Vec3::new(0.4, 0.0, 1.0).normalize().into();
    let slope = plane(normal, 0.0, 0.5, Vec::new());
    let mut run = Run::new(new(), above(slope, Vec3::zeros(), Vec3::zeros()), 0.01);
    run.steps(200);
    assert!(run.state.x[0].norm() < 1e-12, "{case:?}: creeps {:?}", run.state.x[0]);
}
