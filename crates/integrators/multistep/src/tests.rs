//! Tests of methods with several steps: their past in contact, their reports and their settings.

use crate::{AdamsBashforth, AdamsBashforthSettings, Bdf, BdfSettings};
use drape_integrator::{Integrator, Setups, SolveStatus};
use drape_model::{DampingLaw, ObstacleSpec, SystemSpec, Vec3};
use drape_oracle::Run;
use drape_oracle::scenes::{Sheet, build, floor, gravity, particles, pin, stir};

const H: f64 = 0.01;
const G: f64 = 9.81;
const STEPS: [&str; 3] = ["1", "2", "3"];

fn adams(steps: &str) -> Box<dyn Integrator> {
    let settings = AdamsBashforthSettings::from_pairs([("steps", steps)]).expect("in range");
    Box::new(AdamsBashforth::new(settings))
}

fn bdf_with(pairs: &[(&str, &str)]) -> Box<dyn Integrator> {
    Box::new(Bdf::new(BdfSettings::from_pairs(pairs.iter().copied()).expect("in range")))
}

fn bdf(steps: &str) -> Box<dyn Integrator> {
    bdf_with(&[("steps", steps), ("residual", "1e-16"), ("solver", "cholesky")])
}

/// Both families with each of these numbers of steps, and a name.
fn all(steps: &[&'static str]) -> Vec<(Box<dyn Integrator>, String)> {
    let both = |steps: &&'static str| [(adams(steps), *steps), (bdf(steps), *steps)];
    let named = |(method, steps): (Box<dyn Integrator>, &str)| {
        let name = format!("{}, {steps}", method.method().id);
        (method, name)
    };
    steps.iter().flat_map(both).map(named).collect()
}

/// A particle under gravity above a plane through the origin.
fn above(normal: [f64; 3], restitution: f64, x: Vec3, v: Vec3) -> SystemSpec {
    let mut spec = particles(&[0.5], &[x], &[v]);
    spec.effects.gravity = gravity();
    spec.obstacles = vec![ObstacleSpec::plane([0.0; 3], normal, restitution)];
    spec
}

const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// A bounce replaces the levels before it by those of a free flight: the particle is on its
/// parabola at once, and an elastic bounce keeps the energy.
#[test]
fn the_flight_after_a_bounce_is_a_parabola_from_its_first_step() {
    for e in [0.5, 1.0] {
        for (method, name) in all(&STEPS[1..]) {
            let start = above(UP, e, Vec3::z() * 0.5, Vec3::new(0.3, 0.0, -1.0));
            let mut run = Run::new(method, build(&start), H);
            let case = format!("{name}, e = {e}");
            run.step(); // backward Euler, if that is how the method starts
            let energy = run.energy();
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
                    let close = 1e-12 + if name == "bdf2, 2" { start } else { 0.0 };
                    let error = (run.state.x[0] - expected).norm();
                    assert!(error < close, "{case}, step {n}: {error:e}");
                    assert!((run.state.v[0] - v + Vec3::z() * (G * H)).norm() < 1e-12, "{case}");
                }
            }
            assert!(bounces > 1, "{case}: {bounces} bounces");
            let change = run.energy() - energy;
            let kept = change.abs() < 2e-3 * energy;
            assert!(change < 1e-12 && kept == (e == 1.0), "{case}: {change:e} of {energy}");
        }
    }
}

/// Along the surface the methods keep their order, so constant acceleration is exact.
#[test]
fn sliding_down_a_slope_is_exact_where_falling_is() {
    let normal = [0.6, 0.0, 0.8];
    let down = Vec3::new(0.8, 0.0, -0.6);
    for (method, name) in all(&STEPS[1..]) {
        let mut run = Run::new(method, build(&above(normal, 0.0, Vec3::zeros(), down)), H);
        // Backward Euler slides ½ h² a too far; then the contact is new, and so is the past.
        let start = if name == "bdf2, 2" { 0.5 * H * H } else { 0.0 };
        for n in 1..=100 {
            run.step();
            let t = H * f64::from(n);
            let expected = down * (t + 0.6 * G * (0.5 * t * t + start));
            let error = (run.state.x[0] - expected).norm();
            assert!(error < 1e-10, "{name}, step {n}: off by {error:e}");
            let error = (run.state.v[0] - down * (1.0 + 0.6 * G * t)).norm();
            assert!(error < 1e-10, "{name}, step {n}: velocity off by {error:e}");
        }
    }
}

/// The support of an obstacle ends at its edge, at once.
#[test]
fn what_slides_off_an_edge_falls_on_a_parabola_from_its_first_step() {
    for (method, name) in all(&STEPS[1..]) {
        let mut spec = above(UP, 0.0, Vec3::x() * 0.31, Vec3::x());
        spec.obstacles = vec![ObstacleSpec::cuboid([0.0, 0.0, -0.5], [1.0; 3], 0.0)];
        let mut run = Run::new(method, build(&spec), H);
        for n in 0..60 {
            let (x, v) = (run.state.x[0], run.state.v[0]);
            run.step();
            let falls = if x.x > 0.5 { Vec3::z() * -G } else { Vec3::zeros() };
            // Adams remembers forces, which an edge does not change; BDF velocities, which have a
            // kink there.
            let first = v.z == 0.0;
            let close = if first && name.starts_with("bdf2") { 0.5 * G * H } else { 1e-12 };
            let error = (run.state.v[0] - v - falls * H).norm();
            assert!(error < close, "{name}, step {n}: velocity off by {error:e}");
            let close = if first { 0.6 * G * H * H } else { 1e-12 };
            let error = (run.state.x[0] - x - v * H - falls * (0.5 * H * H)).norm();
            assert!(error < close, "{name}, step {n}: off by {error:e}");
        }
        assert!(run.state.x[0].z < -0.3, "{name}: {:?}", run.state.x[0]);
    }
}

/// A pin releases a particle above the plane, and another holds it after it has landed.
#[test]
fn pins_and_obstacles_go_together() {
    for (method, name) in all(&STEPS) {
        let mut spec = particles(&[0.5], &[Vec3::z() * 0.2], &[Vec3::zeros()]);
        spec.effects.gravity = gravity();
        spec.obstacles = vec![floor(0.0)];
        spec.pins = vec![pin(0)];
        let mut run = Run::new(method, build(&spec), H);
        run.steps(60);
        assert_eq!(run.state.x[0], Vec3::z() * 0.2, "{name}");
        assert!(run.system.set_pinned(0, false));
        run.steps(60);
        assert!(run.state.x[0].norm() < 1e-9 && run.state.v[0] == Vec3::zeros(), "{name}");
        assert!(run.system.set_pinned(0, true));
        let landed = run.state.x[0];
        run.steps(60);
        assert_eq!(run.state.x[0], landed, "{name}");
    }
}

fn sheet() -> Sheet {
    Sheet { side: 3, tension: 60.0, shear: 60.0, damping: 0.6, ..Sheet::default() }
}

#[test]
fn reports_say_what_a_step_cost() {
    let start = || stir(Sheet { law: DampingLaw::Full, ..sheet() }.build(), 0.1, 0.5);
    for steps in STEPS {
        let mut run = Run::new(adams(steps), start(), H);
        for expected in [if steps == "1" { 1 } else { 2 }, 1, 1] {
            let report = run.step();
            assert_eq!(report.force_evaluations, expected, "{steps}");
            assert_eq!((report.newton_iterations, report.setups.total()), (0, 0));
        }
        let mut run = Run::new(bdf(steps), start(), H);
        let [first, second] = [run.step(), run.step()];
        for report in [first, second] {
            let iterations = report.newton_iterations;
            assert!(iterations > 0 && report.factorisations >= iterations, "{report:?}");
            assert!(report.force_evaluations > iterations, "{report:?}");
            assert!(report.relative_residual > 0.0 && report.relative_residual < 1e-9);
            assert_eq!((report.setups, report.substeps), (Setups::default(), 1));
        }
        if steps == "3" {
            assert!(first.factorisations > second.factorisations, "two stages: {first:?}");
        }
    }
}

/// Four particles of unequal mass on six springs in space, the first one pinned, under gravity.
fn tetrahedron() -> SystemSpec {
    let position = [
        Vec3::zeros(),
        Vec3::new(0.6, 0.1, -0.1),
        Vec3::new(0.2, 0.5, 0.0),
        Vec3::new(0.3, 0.2, -0.6),
    ];
    let velocity =
        [Vec3::zeros(), Vec3::new(0.2, -0.8, 0.3), Vec3::new(-0.5, 0.1, 0.9), Vec3::x() * 0.7];
    let mut spec = particles(&[1.0, 0.7, 1.1, 0.5], &position, &velocity);
    spec.pins = vec![pin(0)];
    spec.effects.gravity = gravity();
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    spec.springs = pairs.map(|pair| drape_oracle::scenes::tension(pair, 0.55, 60.0, 0.6)).to_vec();
    spec
}

#[test]
fn an_iteration_limit_is_reported_also_where_only_the_first_stage_met_it() {
    let status = |steps, residual, h| {
        let method = bdf_with(&[
            ("steps", steps),
            ("max_iterations", "1"),
            ("residual", residual),
            ("solver", "cholesky"),
        ]);
        Run::new(method, build(&tetrahedron()), h).step().solve
    };
    for steps in STEPS {
        assert_eq!(status(steps, "1e-14", 0.1), SolveStatus::IterationLimit, "{steps}");
    }
    assert_eq!(status("3", "1e-4", 0.05), SolveStatus::IterationLimit);
    assert_eq!(status("3", "1e-3", 0.05), SolveStatus::Converged);
}

#[test]
fn settings_are_read_and_refused_by_name() {
    for (text, steps) in STEPS.into_iter().zip(1..) {
        let found = AdamsBashforthSettings::from_pairs([("steps", text)]).expect("in range");
        assert_eq!(found.steps.count(), steps);
        let found = BdfSettings::from_pairs([("steps", text)]).expect("in range");
        assert_eq!(found.steps.count(), steps);
    }
    assert_eq!(AdamsBashforthSettings::from_pairs([]), Ok(AdamsBashforthSettings::default()));
    assert_eq!(BdfSettings::from_pairs([]), Ok(BdfSettings::default()));
    let stage = BdfSettings::from_pairs([("residual", "1e-6"), ("max_iterations", "7")]);
    let stage = stage.expect("in range").stage;
    assert_eq!((stage.residual, stage.max_iterations), (1e-6, 7));
    for wrong in ["0", "4", "two"] {
        let refused = BdfSettings::from_pairs([("steps", wrong)]).expect_err("out of range");
        assert!(refused.to_string().contains("a whole number from 1 to 3"), "{refused}");
        assert!(AdamsBashforthSettings::from_pairs([("steps", wrong)]).is_err());
    }
    let refused = AdamsBashforthSettings::from_pairs([("residual", "1")]).expect_err("unknown");
    assert!(refused.to_string().contains("adams-bashforth2 has no setting `residual`"));
}
