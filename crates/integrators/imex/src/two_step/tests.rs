//! Tests of the two-step methods: coefficients, contacts that rewrite the past, tolerances and
//! counts.

use super::split_forces::SplitForces;
use super::*;
use drape_integrator::{Implicit, Integrator, PhaseClock, SolveStatus};
use drape_model::{Level, ObstacleSpec, State, System, SystemSpec, Vec3};
use drape_oracle::laws::hanging_chain;
use drape_oracle::recurrence::Multistep;
use drape_oracle::scenes::{
    GRAVITY, Sheet, build, floor, gravity, particles, pin, stir, tension, uneven,
};
use drape_oracle::{Run, apart, seconds};

const SCHEMES: [TwoStep; 4] = [TwoStep::Sbdf2, TwoStep::Cnab2, TwoStep::Mcnab2, TwoStep::Cnlf];
/// The methods with coefficients for varying steps, which also take friction.
const VARIABLE: [TwoStep; 3] = [TwoStep::Sbdf2, TwoStep::Cnab2, TwoStep::Mcnab2];
const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;
const STEP: f64 = 0.004;

fn method(scheme: TwoStep, text: &str) -> ImexTwoStep {
    let pairs = text.split(',').filter_map(|pair| pair.split_once('='));
    let settings = ImexTwoStepSettings::from_pairs(scheme, pairs);
    ImexTwoStep::new(settings.unwrap_or_else(|error| panic!("{error}")))
}

fn run(scheme: TwoStep, text: &str, start: (System, State), h: f64) -> Run {
    Run::new(Box::new(method(scheme, text)), start, h)
}

fn sheet(stiffness: f64) -> Sheet {
    Sheet { side: 4, tension: stiffness, shear: 0.25 * stiffness, ..Sheet::default() }
}

fn scene() -> (System, State) {
    stir(uneven(sheet(2e3).build()), 0.02, 1.0)
}

/// The oracle derives the coefficients by interpolation.
#[test]
fn the_rows_are_those_that_the_oracle_derives() {
    let oracle = |scheme, omega| match scheme {
        TwoStep::Sbdf2 => Multistep::sbdf2(omega),
        TwoStep::Cnab2 => Multistep::cnab2(omega),
        TwoStep::Mcnab2 => Multistep::mcnab2(omega),
        TwoStep::Cnlf => Multistep::cnlf(),
    };
    for (scheme, k) in SCHEMES.into_iter().flat_map(|s| (0..=30).map(move |k| (s, k))) {
        let omega = 0.5 + 0.05 * f64::from(k);
        let Some(Coefficients { a, b, c: [c1, c2] }) = scheme.coefficients(omega) else {
            assert!(scheme == TwoStep::Cnlf && omega != 1.0, "{scheme:?} at ω = {omega}");
            continue;
        };
        let expected = oracle(scheme, omega);
        for (found, expected) in [(a, expected.a), (b, expected.b), ([0.0, c1, c2], expected.c)] {
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "{scheme:?} at ω = {omega}");
            }
        }
    }
}

#[test]
fn the_new_velocity_acts_for_the_time_of_the_table() {
    let share = |scheme: TwoStep, omega| {
        scheme.coefficients(omega).map(|coefficients| coefficients.tau(1.0)).unwrap_or(f64::NAN)
    };
    for (scheme, expected) in SCHEMES.into_iter().zip([2.0 / 3.0, 0.5, 9.0 / 16.0, 1.0]) {
        assert!((share(scheme, 1.0) - expected).abs() < 1e-15, "{scheme:?}");
    }
    assert!((share(TwoStep::Sbdf2, 0.5) - 0.75).abs() < 1e-15);
    for scheme in VARIABLE {
        let known =
            [0.499, 0.5, 2.0, 2.001, f64::NAN].map(|omega| scheme.coefficients(omega).is_some());
        assert_eq!(known, [false, true, true, false, false], "{scheme:?}");
    }
}

#[test]
fn every_scheme_has_its_own_id_and_refuses_what_it_does_not_know() {
    let ids = ["imex-sbdf2", "imex-cnab2", "imex-mcnab2", "imex-cnlf"];
    for (scheme, id) in SCHEMES.into_iter().zip(ids) {
        assert_eq!(method(scheme, "").method().id, id);
        for pair in
            [("start", "best"), ("implicit", "all"), ("forcing_term", "0.6"), ("order", "2")]
        {
            let outcome = ImexTwoStepSettings::from_pairs(scheme, [pair]);
            let error = outcome.expect_err("refused").to_string();
            assert!(error.contains(id) && error.contains(pair.0), "{error}");
        }
    }
}

/// One particle over the floor.
fn ball(z: f64, v: Vec3, restitution: f64) -> (System, State) {
    let mut spec = particles(&[MASS], &[Vec3::z() * z], &[v]);
    spec.effects.gravity = gravity();
    spec.obstacles = vec![floor(restitution)];
    build(&spec)
}

/// A particle that is 1 mm inside is on the surface after one step, at rest along the normal, and
/// slides on as before.
#[test]
fn a_particle_is_led_to_the_surface_in_one_step_and_slides_on() {
    for scheme in SCHEMES {
        let sideways = Vec3::new(0.3, -0.2, 0.0);
        let mut run = run(scheme, "", ball(1.0, sideways, 0.0), 0.01);
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

/// An elastic ball returns to its height again and again: neither the rebound nor the rewritten
/// past gives it energy.
#[test]
fn an_elastic_ball_neither_gains_nor_loses() {
    for scheme in SCHEMES {
        let mut run = run(scheme, "", ball(1.0, Vec3::zeros(), 1.0), 0.01);
        let (mut bounces, start) = (0, run.energy());
        run.steps(20);
        let energy = run.energy();
        // Backward Euler's first step is half of h²g off the parabola.
        assert!((energy / start - 1.0).abs() < 1e-3, "{scheme:?}: {start} J, {energy} J");
        // CNLF never forgets that error; it shows in every other level.
        let tolerance = if scheme == TwoStep::Cnlf { 6e-4 } else { 1e-9 };
        for step in 0..1000 {
            let before = run.state.v[0].z;
            run.step();
            bounces += u32::from(before < 0.0 && run.state.v[0].z > 0.0);
            let change = run.energy() / energy - 1.0;
            assert!(change.abs() < tolerance, "{scheme:?}, step {step}: {change:e}");
        }
        assert!(bounces > 9, "{scheme:?}: {bounces}");
    }
}

/// A stiff rod lands on one end. Whatever the contact rewrites, the forces of the past belong to
/// its positions and velocities, so the force across the spring is extrapolated along the path of
/// its ends.
#[test]
fn forces_of_the_past_follow_when_a_contact_rewrites_it() {
    for scheme in SCHEMES {
        let x = [Vec3::new(0.0, 0.0, 0.05), Vec3::new(0.8, 0.0, 0.65)];
        let mut spec = particles(&[MASS; 2], &x, &[]);
        spec.springs = vec![tension((0, 1), 1.0, 1e4, 1.0)];
        spec.effects.gravity = gravity();
        spec.obstacles = vec![floor(0.0)];
        let ((system, mut state), h) = (build(&spec), seconds(0.01));
        let mut method = method(scheme, "");
        method.prepare(&system, h).expect("supported");
        let mut rewritten = 0;
        for step in 0..30 {
            let before = state.clone();
            method.step(&system, &mut state, h, &mut PhaseClock::off()).expect("a step");
            let past = &mut method.prepared().expect("prepared").past;
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

/// A particle on a plane through the origin with μ = 0.5 and a slope of this tangent; and the
/// direction down the slope.
fn on_a_rough_plane(tangent: f64, x: Vec3, v: Vec3) -> ((System, State), Vec3) {
    let normal = Vec3::new(tangent, 0.0, 1.0).normalize();
    let mut spec = particles(&[MASS], &[x], &[v]);
    spec.effects.gravity = gravity();
    let (point_m, path) = ([0.0; 3], Vec::new());
    let (normal_m, restitution, friction) = (normal.into(), 0.0, 0.5);
    let plane = ObstacleSpec::Plane { point_m, normal: normal_m, restitution, friction, path };
    spec.obstacles = vec![plane];
    (build(&spec), Vec3::new(normal.z, 0.0, -normal.x))
}

#[test]
fn what_slides_down_an_incline_from_rest_follows_coulombs_law_exactly() {
    for scheme in VARIABLE {
        let (start, down) = on_a_rough_plane(0.7, Vec3::zeros(), Vec3::zeros());
        let a = -GRAVITY.z * (0.7 - 0.5) / 1.49_f64.sqrt();
        let mut run = run(scheme, "", start, H);
        for n in 1..=400 {
            run.step();
            let (t, v) = (H * f64::from(n), run.state.v[0]);
            assert!((v - down * (a * t)).norm() < 1e-11 * a * t, "{scheme:?}, step {n}: {v}");
            // Backward Euler's first step is half of h²a off the parabola.
            let off = (run.state.x[0] - down * (0.5 * a * t * t)).norm();
            assert!(off < a * H * H, "{scheme:?}, step {n}: {off:e} m");
        }
        let (start, _) = on_a_rough_plane(0.4, Vec3::zeros(), Vec3::zeros());
        let mut run = self::run(scheme, "", start, H);
        run.steps(1000);
        assert_eq!(run.state.x[0].norm() + run.state.v[0].norm(), 0.0, "{scheme:?} creeps");
    }
}

#[test]
fn what_lands_on_a_rough_floor_slows_down_and_stays_where_it_stops() {
    for scheme in VARIABLE {
        let (x, v) = (Vec3::new(0.0, 0.0, 0.06), Vec3::new(3.0, 0.0, -2.0));
        let mut run = run(scheme, "", on_a_rough_plane(0.0, x, v).0, H);
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

/// The tolerance refers to the forces, so the same motion seen from a moving frame takes about as
/// many iterations and is solved as well.
#[test]
fn a_moving_frame_is_solved_as_well_as_one_at_rest() {
    for scheme in SCHEMES {
        let free = Sheet { pinned: false, ..sheet(1e5) };
        let cost_and_error = |speed: f64| {
            let (system, mut state) = stir(uneven(free.build()), 0.02, 1.0);
            state.v.iter_mut().for_each(|v| v.x += speed);
            let run = |text| {
                let mut run = run(scheme, text, (system.clone(), state.clone()), 0.01);
                let iterations: u32 = run.steps(20).iter().map(|r| r.cg_iterations).sum();
                (iterations, run.state)
            };
            let ((iterations, loose), (_, exact)) =
                (run("forcing_term=1e-2"), run("solver=cholesky"));
            (iterations, apart(&loose.x, &exact.x))
        };
        let ((at_rest, error), (moving, error_moving)) = (cost_and_error(0.0), cost_and_error(1e3));
        assert!(at_rest > 20 && moving.abs_diff(at_rest) <= 2, "{scheme:?}: {at_rest}, {moving}");
        assert!(error_moving < 1.1 * error, "{scheme:?}: {error:e}, moving {error_moving:e}");
    }
}

/// Without forces the solve of a resting or flying sheet ends at the round-off of its springs.
#[test]
fn a_sheet_without_forces_needs_no_iterations() {
    let free = Sheet { pinned: false, gravity: Vec3::zeros(), ..sheet(1e6) };
    for (scheme, norm) in
        SCHEMES.into_iter().flat_map(|s| ["euclid", "preconditioned"].map(|n| (s, n)))
    {
        let (system, mut state) = free.build();
        state.v.fill(Vec3::new(1.0, 2.0, 3.0));
        let mut run = run(scheme, &format!("norm={norm}"), (system, state), 0.01);
        for report in run.steps(50) {
            assert!(report.cg_iterations <= 2, "{scheme:?}, {norm}: {report:?}");
            assert_eq!(report.solve, SolveStatus::Converged, "{scheme:?}, {norm}");
        }
    }
}

fn hanging() -> (SystemSpec, Vec<Vec3>) {
    let masses = [MASS, 2.0 * MASS, MASS];
    let stiffness = [300.0, 200.0, 100.0];
    let lengths = hanging_chain(&masses, &stiffness, &[0.2; 3], GRAVITY.norm());
    let depths: Vec<f64> = (0..=3).map(|k| lengths[..k].iter().sum()).collect();
    let positions: Vec<Vec3> = depths.iter().map(|depth| Vec3::z() * -depth).collect();
    let mut spec = particles(&[&[MASS], &masses[..]].concat(), &positions, &[]);
    spec.pins = vec![pin(0)];
    spec.effects.gravity = gravity();
    spec.springs = (0..3).map(|k| tension((k, k + 1), 0.2, stiffness[k], 0.1)).collect();
    (spec, positions)
}

/// The residual of a chain at rest refers to its weight, since the total force vanishes.
#[test]
fn a_chain_at_rest_needs_no_iterations() {
    let (spec, positions) = hanging();
    for scheme in SCHEMES {
        let (system, mut state) = build(&spec);
        state.x[2].z += 1e-8; // a pull far below the weight
        let mut run = run(scheme, "", (system, state), 0.01);
        let iterations: u32 = run.steps(50).iter().map(|report| report.cg_iterations).sum();
        assert_eq!(iterations, 0, "{scheme:?}");
        assert!(apart(&run.state.x, &positions) < 1e-6, "{scheme:?} moved: {:?}", run.state.x);
    }
}

/// A step takes three sweeps, for `F`, `G` and `L_k X*`, and two more where the past has no forces
/// yet.
#[test]
fn force_evaluations_are_counted() {
    for scheme in SCHEMES {
        let reports = run(scheme, "", scene(), STEP).steps(4);
        assert_eq!(reports[0].cg_iterations, 0, "{scheme:?}: the start is Newton's");
        assert!(reports[0].newton_iterations > 0, "{scheme:?}: the start is Newton's");
        let found: Vec<_> = reports[1..].iter().map(|report| report.force_evaluations).collect();
        assert_eq!(found, [5, 3, 3], "{scheme:?}");
    }
}

/// The extrapolated start of EEH (22) saves iterations, also where steps change, and alters the
/// result within the tolerance only.
#[test]
fn the_extrapolated_start_saves_iterations() {
    for scheme in [TwoStep::Sbdf2, TwoStep::Mcnab2] {
        let [(last, a), (extrapolated, b)] = ["last", "extrapolated"].map(|start| {
            let text = format!("start={start},forcing_term=1e-5");
            let mut run = run(scheme, &text, scene(), STEP);
            let lengths = [STEP, 1.5 * STEP, STEP, 0.5 * STEP];
            let mut iterations = 0;
            for step in 0..40 {
                iterations += run.step_by(lengths[step % lengths.len()]).cg_iterations;
            }
            (iterations, run.state)
        });
        assert!(extrapolated < last, "{scheme:?}: {extrapolated}, from v_n {last}");
        assert!(apart(&a.x, &b.x) < 1e-5, "{scheme:?}: {:e}", apart(&a.x, &b.x));
    }
}
