//! Contacts: velocities against positions as the way out, effect on neighbours, release.

use super::{H, MASS, prepared};
use drape_integrator::{SolveStatus, StepReport};
use drape_model::{GravitySpec, State, System, SystemSpec, Vec3};
use drape_oracle::scenes::{build, floor, particles, pin, tension};

const SOLVERS: [&str; 2] = ["forcing_term=1e-14", "solver=cholesky"];

fn one_particle(z: f64, v: Vec3, acceleration: f64) -> SystemSpec {
    let mut spec = particles(&[MASS], &[Vec3::new(0.3, 0.0, z)], &[v]);
    spec.effects.gravity = Some(GravitySpec { m_s2: [0.0, 0.0, acceleration] });
    spec
}

/// Settings for a solver and a way out.
fn text(solver: &str, contact: &str) -> String {
    format!("{solver},contact={contact}")
}

fn build_on_floor(spec: &SystemSpec, restitution: f64) -> (System, State) {
    build(&SystemSpec { obstacles: vec![floor(restitution)], ..spec.clone() })
}

#[test]
fn a_position_is_altered_to_the_surface_in_one_step_and_a_velocity_leads_there_slowly() {
    const DEPTH: f64 = 0.3;
    let limit = 1.0;
    for solver in SOLVERS {
        for (fall, g) in [(0.0, 0.0), (0.0, -9.81), (-5.0, -9.81), (2.0, -9.81)] {
            let spec = one_particle(-DEPTH, Vec3::new(0.5, 0.0, fall), g);
            let mut altered = prepared(&text(solver, "position"), build_on_floor(&spec, 0.0), H);
            let report = altered.step();
            assert_eq!(report.correction, DEPTH, "{solver}");
            // A particle on its way out keeps its way.
            let left = f64::max(0.0, fall + if fall > 0.0 { g * H } else { 0.0 });
            let (x, v) = (altered.state.x[0], altered.state.v[0]);
            assert!(
                (x - Vec3::new(0.3 + 0.5 * H, 0.0, left * H)).norm() < 1e-16,
                "{solver}: {x:?}"
            );
            assert!((v - Vec3::new(0.5, 0.0, left)).norm() < 1e-15, "{solver}: {v:?}");

            let mut led = prepared(&text(solver, "velocity"), build_on_floor(&spec, 0.0), H);
            let mut steps = 0;
            while led.state.x[0].z < -1e-12 {
                let before = led.state.x[0].z;
                let report = led.step();
                let moved = led.state.x[0].z - before;
                assert_eq!(report.correction, 0.0, "{solver}");
                let fastest = f64::max(limit, fall);
                assert!(moved > 0.0 && moved <= H * fastest + 1e-15, "{solver}: {moved}");
                steps += 1;
            }
            let least = DEPTH / (H * f64::max(limit, fall));
            assert!(f64::from(steps) >= least - 1e-9, "{solver}: {steps} steps");
            if fall <= 0.0 {
                // Only the energy of the motion along the floor is left.
                for run in [&altered, &led] {
                    assert!((run.energy() - 0.5 * MASS * 0.25).abs() < 1e-13, "{solver}");
                }
            }
        }
    }
}

#[test]
fn a_rebound_is_altered_by_what_it_leaves_of_the_way_out() {
    for solver in SOLVERS {
        for (depth, altered) in [(0.02, 0.005), (0.01, 0.0)] {
            let spec = one_particle(-depth, Vec3::new(0.5, 0.0, -3.0), 0.0);
            let mut run = prepared(&text(solver, "position"), build_on_floor(&spec, 0.5), H);
            let report = run.step();
            assert!((report.correction - altered).abs() < 1e-16, "{solver}: {report:?}");
            assert!((run.state.v[0] - Vec3::new(0.5, 0.0, 1.5)).norm() < 1e-15, "{solver}");
            let x = run.state.x[0].z;
            assert!((x - (altered + 1.5 * H - depth)).abs() < 1e-16, "{solver}: {x}");
        }
    }
}

#[test]
fn what_rests_on_the_floor_stays_and_what_is_pulled_off_it_leaves_at_once() {
    for contact in ["velocity", "position"] {
        for solver in SOLVERS {
            for depth in [0.0, 1e-6] {
                let spec = one_particle(-depth, Vec3::zeros(), -9.81);
                let mut run = prepared(&text(solver, contact), build_on_floor(&spec, 0.5), H);
                for _ in 0..50 {
                    let report = run.step();
                    assert_eq!(report.solve, SolveStatus::Converged);
                    assert!(run.state.x[0].z.abs() < 1e-12 && run.state.v[0].norm() < 1e-14);
                }
                let spec = one_particle(-depth, Vec3::zeros(), 9.81);
                let mut run = prepared(&text(solver, contact), build_on_floor(&spec, 0.5), H);
                run.step();
                let out = if contact == "position" { 0.0 } else { -depth };
                let (x, v) = (run.state.x[0].z, run.state.v[0].z);
                assert!((v - 9.81 * H).abs() < 1e-15, "{solver}, {contact}: {v}");
                assert!((x - out - 9.81 * H * H).abs() < 1e-15, "{solver}, {contact}: {x}");
            }
        }
    }
}

/// A spring between the floor and a pin above it: it pushes while it is compressed and pulls when
/// stretched.
#[test]
fn a_spring_that_pulls_releases_a_contact_and_one_that_pushes_keeps_it() {
    for contact in ["velocity", "position"] {
        for (solver, rest) in SOLVERS.into_iter().flat_map(|s| [(s, 0.5), (s, 1.5)]) {
            let mut spec = particles(&[MASS; 2], &[Vec3::zeros(), Vec3::z()], &[Vec3::zeros(); 2]);
            spec.springs = vec![tension((0, 1), rest, 100.0, 0.0)];
            spec.pins = vec![pin(1)];
            let mut run = prepared(&text(solver, contact), build_on_floor(&spec, 0.0), H);
            run.step();
            // (m + h²k) Δv = h k (1 − ℓ)
            let free = H * 100.0 * (1.0 - rest) / (MASS + H * H * 100.0);
            let expected = f64::max(free, 0.0);
            let v = run.state.v[0];
            assert!(
                (v - Vec3::z() * expected).norm() < 1e-14,
                "{solver}, {contact}, {rest}: {v:?}"
            );
        }
    }
}

/// Baraff-Witkin (18): `h (∂f/∂x y)` pushes the particle above a spring of length ℓ.
#[test]
fn neighbours_feel_the_alteration_in_the_step_in_which_it_happens() {
    let (depth, k, c) = (0.02, 300.0, 4.0);
    let x = [Vec3::new(0.0, 0.0, -depth), Vec3::new(0.0, 0.0, 0.5 - depth)];
    let mut spec = particles(&[MASS; 2], &x, &[Vec3::zeros(); 2]);
    spec.springs = vec![tension((0, 1), 0.5, k, c)];
    for solver in SOLVERS {
        let mut run = prepared(&text(solver, "position"), build_on_floor(&spec, 0.0), H);
        run.step();
        let expected = H * k * depth / (MASS + H * H * k + H * c);
        let v = run.state.v[1];
        assert!((v - Vec3::z() * expected).norm() < 1e-14, "{solver}: {v:?}, {expected}");
        assert_eq!(run.state.x[0], Vec3::zeros(), "{solver}");
        assert!((run.state.x[1].z - (0.5 - depth) - H * expected).abs() < 1e-15, "{solver}");
    }
}

/// Every release takes one more solve, which starts from the prescribed part alone, like the first.
#[test]
fn solves_after_a_release_are_counted() {
    let count = |acceleration: f64, solver: &str| -> StepReport {
        let spec = one_particle(0.0, Vec3::zeros(), acceleration);
        prepared(&text(solver, "velocity"), build_on_floor(&spec, 0.0), H).step()
    };
    let direct = "solver=cholesky";
    assert_eq!(count(-9.81, direct).factorisations, 1);
    assert_eq!(count(9.81, direct).factorisations, 2);
    // b; S (b − A z) for an empty right-hand side; the impulse: nothing is left to solve.
    let cg = "forcing_term=1e-14";
    assert_eq!((count(-9.81, cg).cg_iterations, count(-9.81, cg).matvecs), (0, 2));
    // b; the impulse; then one iteration: r, c, r again.
    assert_eq!((count(9.81, cg).cg_iterations, count(9.81, cg).matvecs), (1, 5));
}
