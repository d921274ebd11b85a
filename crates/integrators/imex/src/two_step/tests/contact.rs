//! Contacts: the constraint refers to `X*` and `τ`, and a contact rewrites the past.

use super::split_forces::SplitForces;
use super::*;
use drape_integrator::Implicit;
use drape_model::{Level, ObstacleSpec, parse};

/// One particle over the plane `z = 0`.
fn ball(z: f64, v: Vec3, restitution: f64) -> (System, State) {
    let text = format!(
        r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": [{MASS}], "position_m": [[0, 0, {z}]],
        "velocity_m_s": [[{}, {}, {}]] }}, "effects": {{ "gravity": {{ "m_s2": [0, 0, -9.81] }} }},
        "obstacles": [{{ "plane": {{ "point_m": [0, 0, 0], "normal": [0, 0, 1], "restitution": {restitution} }} }}] }}"#,
        v.x, v.y, v.z
    );
    parse("ball", &text).unwrap().spec().build().unwrap()
}

/// A particle that is found 1 mm inside is on the surface after one step, at rest, and slides on as it did.
#[test]
fn a_particle_is_led_to_the_surface_in_one_step_and_slides_on() {
    for scheme in SCHEMES {
        let sideways = Vec3::new(0.3, -0.2, 0.0);
        let mut run = Run::new(scheme, "", ball(1.0, sideways, 0.0), 0.01);
        while run.state.x[0].z >= 0.0 {
            run.step();
        }
        run.state.x[0].z = -1e-3; // the past does not know: a shallow dent
        run.step();
        for _ in 0..100 {
            assert!(run.state.x[0].z.abs() < 1e-12, "{scheme:?}: {:?}", run.state.x[0]);
            assert!((run.state.v[0] - sideways).norm() < 1e-12, "{scheme:?}: {:?}", run.state.v[0]);
            let t = run.state.t;
            run.step();
            let expected = sideways * (t + 0.01);
            assert!((run.state.x[0].xy() - expected.xy()).norm() < 1e-9, "{scheme:?}");
        }
    }
}

/// An elastic ball comes back to its height, time and again: neither the rebound nor the rewritten past
/// gives it energy.
#[test]
fn an_elastic_ball_neither_gains_nor_loses() {
    for scheme in SCHEMES {
        let mut run = Run::new(scheme, "", ball(1.0, Vec3::zeros(), 1.0), 0.01);
        let mut bounces = 0;
        let start = run.system.total_energy(&run.state);
        run.steps(20);
        let energy = run.system.total_energy(&run.state);
        // Backward Euler's first step is half of h²g off the parabola.
        assert!((energy / start - 1.0).abs() < 1e-3, "{scheme:?}: {start} J, {energy} J");
        // CNLF never forgets that, and shows it in every other level.
        let tolerance = if scheme == Scheme::Cnlf { 6e-4 } else { 1e-9 };
        for step in 0..1000 {
            let before = run.state.v[0].z;
            run.step();
            bounces += u32::from(before < 0.0 && run.state.v[0].z > 0.0);
            let change = run.system.total_energy(&run.state) / energy - 1.0;
            assert!(change.abs() < tolerance, "{scheme:?}, step {step}: {change:e}");
        }
        assert!(bounces > 9, "{scheme:?}: {bounces}");
    }
}

/// A stiff rod that lands on one end: whatever the contact rewrites, the forces of the past are those of the
/// past positions and velocities, so that a force across the spring is extrapolated along the path of its ends.
#[test]
fn forces_of_the_past_follow_when_a_contact_rewrites_it() {
    for scheme in SCHEMES {
        let text = format!(
            r#"{{ "format": "drape-system/1",
            "particles": {{ "mass_kg": [{MASS}, {MASS}], "position_m": [[0, 0, 0.05], [0.8, 0, 0.65]] }},
            "springs": [{{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1, "stiffness_n_per_m": 1e4,
                "damping_n_s_per_m": 1 }}],
            "effects": {{ "gravity": {{ "m_s2": [0, 0, -9.81] }} }},
            "obstacles": [{{ "plane": {{ "point_m": [0, 0, 0], "normal": [0, 0, 1] }} }}] }}"#
        );
        let scene = parse("rod", &text).unwrap().spec().build().unwrap();
        let mut run = Run::new(scheme, "", scene, 0.01);
        let mut rewritten = 0;
        for step in 0..30 {
            let (before, system) = (run.state.clone(), run.system.clone());
            run.step();
            let past = &mut run.method.prepared().expect("prepared").past;
            let at = past.level();
            let Level { x, v, .. } = at;
            rewritten += u32::from(v[0] != before.v[0]);
            assert_eq!((x[1], v[1]), (before.x[1], before.v[1]), "{scheme:?}: nothing touched it");
            let mut fresh = SplitForces::new(2);
            fresh.evaluate(&system, Implicit::Springs, at);
            past.update_forces(&system, Implicit::Springs);
            assert_eq!(past.forces.explicit, fresh.explicit, "{scheme:?}, step {step}");
            assert_eq!(past.forces.linear, fresh.linear, "{scheme:?}, step {step}");
        }
        assert!(rewritten > 0, "{scheme:?}: the rod lands");
    }
}

/// Those that take friction.
const ROUGH: [Scheme; 3] = VARIABLE;

/// A particle on a plane through the origin, μ = 0.5, whose slope has this tangent; and the direction down it.
fn on_a_rough_plane(tangent: f64, x: Vec3, v: Vec3) -> ((System, State), Vec3) {
    let normal = Vec3::new(tangent, 0.0, 1.0).normalize();
    let mut spec = particles(&[MASS], &[x], &[v]);
    spec.effects.gravity = gravity();
    spec.obstacles = vec![ObstacleSpec::Plane {
        point_m: [0.0; 3],
        normal: normal.into(),
        restitution: 0.0,
        friction: 0.5,
        path: Vec::new(),
    }];
    (spec.build().unwrap(), Vec3::new(normal.z, 0.0, -normal.x))
}

#[test]
fn what_slides_down_an_incline_from_rest_follows_coulombs_law_exactly() {
    for scheme in ROUGH {
        let (start, down) = on_a_rough_plane(0.7, Vec3::zeros(), Vec3::zeros());
        let a = -GRAVITY.z * (0.7 - 0.5) / 1.49_f64.sqrt();
        let mut run = Run::new(scheme, "", start, H);
        for n in 1..=400 {
            run.step();
            let (t, v) = (H * f64::from(n), run.state.v[0]);
            assert!((v - down * (a * t)).norm() < 1e-11 * a * t, "{scheme:?}, step {n}: {v}");
            // Backward Euler's first step is half of h²a off the parabola.
            let off = (run.state.x[0] - down * (0.5 * a * t * t)).norm();
            assert!(off < a * H * H, "{scheme:?}, step {n}: {off:e} m");
        }
    }
}

#[test]
fn what_friction_holds_on_an_incline_does_not_creep() {
    for scheme in ROUGH {
        let (start, _) = on_a_rough_plane(0.4, Vec3::zeros(), Vec3::zeros());
        let mut run = Run::new(scheme, "", start, H);
        run.steps(1000);
        assert_eq!(run.state.x[0].norm() + run.state.v[0].norm(), 0.0, "{scheme:?}");
    }
}

#[test]
fn what_lands_on_a_rough_floor_slows_down_and_stays_where_it_stops() {
    for scheme in ROUGH {
        let (x, v) = (Vec3::new(0.0, 0.0, 0.06), Vec3::new(3.0, 0.0, -2.0));
        let mut run = Run::new(scheme, "", on_a_rough_plane(0.0, x, v).0, H);
        for n in 0..100 {
            let before = run.state.v[0].x;
            run.step();
            let (v, slowest) = (run.state.v[0].x, before + 0.5 * GRAVITY.z * H);
            assert!(v >= 0.0 && v <= before, "{scheme:?}, step {n}: {v}");
            assert!(n < 5 || v >= slowest - 1e-12, "{scheme:?}, step {n}: {before}, {v}");
        }
        let stopped = run.state.x[0];
        assert!(run.state.v[0].norm() < 1e-12 && stopped.x > 0.1, "{scheme:?}: {stopped}");
        run.steps(101);
        assert!((run.state.x[0] - stopped).norm() < 1e-12, "{scheme:?}: {}", run.state.x[0]);
    }
}
