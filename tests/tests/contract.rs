//! What every integrator promises beside its mathematics: refusals leave the state alone, rebuilds
//! are charged to their cause, history follows the step size, units do not matter.

use drape_integrator::{PhaseClock, Setups, StepError, StepReport};
use drape_model::{DampingLaw, ObstacleSpec, State, System, Vec3};
use drape_tests::{METHODS, Run, Sheet, build, method, seconds};

const H: f64 = 0.004;

const SHEET: Sheet = Sheet {
    side: 6,
    tension: 2e3,
    shear: 500.0,
    damping: 3.0,
    law: DampingLaw::Full,
    pinned: true,
};

/// A sheet in motion.
fn sheet() -> (System, State) {
    let (system, mut state) = SHEET.build();
    for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
        let i = i as f64;
        state.v[i as usize] = Vec3::new(i.sin(), (2.0 * i).cos(), (3.0 * i).sin());
    }
    (system, state)
}

fn bits(state: &State) -> Vec<u64> {
    let vectors = state.x.iter().chain(&state.v);
    let numbers = vectors.flat_map(|a| a.iter().copied()).chain([state.t]);
    numbers.map(f64::to_bits).collect()
}

#[test]
fn a_system_that_was_not_prepared_is_refused_and_the_state_kept() {
    for id in METHODS {
        let (system, mut state) = sheet();
        let before = bits(&state);
        let mut integrator = method(id);
        let (h, mut clock) = (seconds(H), PhaseClock::off());
        let error = integrator.step(&system, &mut state, h, &mut clock).expect_err("not prepared");
        assert!(matches!(error, StepError::NeedsPrepare), "{id}: {error}");
        // Another system of the same size has another topology.
        integrator.prepare(&sheet().0, h).unwrap_or_else(|error| panic!("{id}: {error}"));
        let error = integrator.step(&system, &mut state, h, &mut clock).expect_err("another one");
        assert!(matches!(error, StepError::NeedsPrepare), "{id}: {error}");
        assert_eq!(bits(&state), before, "{id}");
    }
}

#[test]
fn a_state_of_another_size_is_refused_and_kept() {
    for id in METHODS {
        let mut run = Run::new(id, sheet(), H);
        let n = run.system.len();
        for shorter in ["x", "v", "both"] {
            let mut state = run.state.clone();
            if shorter != "v" {
                state.x.pop();
            }
            if shorter != "x" {
                state.v.pop();
            }
            let before = bits(&state);
            let mut clock = PhaseClock::off();
            let outcome = run.integrator.step(&run.system, &mut state, run.h, &mut clock);
            let error = outcome.expect_err("a particle is missing");
            let fits = matches!(error, StepError::SizeMismatch { expected, .. } if expected == n);
            assert!(fits, "{id}: {error}");
            assert_eq!(bits(&state), before, "{id}");
        }
    }
}

/// Each rebuild is counted once, under its cause, in the step that needed it.
#[test]
fn set_ups_are_charged_to_their_cause() {
    let matrix = [
        "symplectic-euler:damping=implicit",
        "imex-euler",
        "imex-euler:solver=cholesky,implicit=springs",
        "imex-updated",
        "imex-updated:safeguard=paper",
        "desbrun",
        "desbrun:inverse=dense",
        "kang",
        "leapfrog:solver=cholesky",
    ];
    let none = Setups::default();
    let first = Setups { first: 1, ..none };
    let (step_size, stiffness) = (Setups { step_size: 1, ..none }, Setups { stiffness: 1, ..none });
    let constraints = Setups { constraints: 1, ..none };
    for id in matrix {
        let mut run = Run::new(id, sheet(), H);
        let setups = |run: &mut Run| run.step().setups;
        assert_eq!([(); 3].map(|()| setups(&mut run)), [first, none, none], "{id}");
        run.h = seconds(0.5 * H);
        assert_eq!([setups(&mut run), setups(&mut run)], [step_size, none], "{id}");
        assert!(run.system.scale_stiffness("tension", 1.5));
        assert_eq!([setups(&mut run), setups(&mut run)], [stiffness, none], "{id}");
        assert!(run.system.scale_damping("tension", 1.5));
        assert_eq!([setups(&mut run), setups(&mut run)], [stiffness, none], "{id}");
        let heavier: Vec<f64> = run.system.mass().iter().map(|m| 2.0 * m).collect();
        assert!(run.system.set_mass(&heavier));
        assert_eq!([setups(&mut run), setups(&mut run)], [stiffness, none], "{id}");
        assert!(run.system.set_pinned(20, true));
        assert_eq!([setups(&mut run), setups(&mut run)], [constraints, none], "{id}");
        run.h = seconds(H);
        assert_eq!([setups(&mut run), setups(&mut run)], [step_size, none], "{id}");
    }
    let every_step = Setups { every_step: 1, ..none };
    for id in [
        "imex-euler:matrix=rebuilt",
        "imex-updated:matrix=rebuilt",
        "terzopoulos-fleischer",
        "baraff-witkin",
    ] {
        let mut run = Run::new(id, sheet(), H);
        let found = [(); 3].map(|()| run.step().setups);
        assert_eq!(found, [first, every_step, every_step], "{id}");
    }
    for id in [
        "explicit-euler",
        "symplectic-euler",
        "provot",
        "adams-bashforth2",
        "backward-euler",
        "bdf2",
    ] {
        let mut run = Run::new(id, sheet(), H);
        assert_eq!([run.step().setups, run.step().setups], [none, none], "{id}");
    }
}

fn fresh(id: &str, run: &Run) -> Run {
    Run::new(id, (run.system.clone(), run.state.clone()), run.h.seconds())
}

/// Rebuilding the matrix in each step costs time and changes nothing.
#[test]
fn a_rebuilt_matrix_is_the_kept_one() {
    let mut kept = Run::new("imex-euler", sheet(), H);
    let mut rebuilt = Run::new("imex-euler:matrix=rebuilt", sheet(), H);
    for _ in 0..5 {
        kept.step();
        rebuilt.step();
    }
    assert_eq!(bits(&kept.state), bits(&rebuilt.state));
}

/// Methods whose coefficients follow the step size and which keep their history.
const VARIABLE_STEP: [&str; 5] =
    ["adams-bashforth2", "bdf2", "imex-sbdf2", "imex-cnab2", "imex-mcnab2"];

/// Velocities of steps of another size are no basis for an extrapolation: the history is dropped, unless the
/// method knows what to do with it.
#[test]
fn after_a_change_of_step_size_a_step_is_that_of_a_fresh_integrator() {
    let keeps =
        |id: &&str| VARIABLE_STEP.iter().any(|method| id.split(':').next() == Some(*method));
    // Step size control carries its own step over from call to call, a saved factor serves while τ changes little.
    let carries = |id: &&str| id.contains("tolerance") || id.contains("saved");
    let fixed = METHODS.into_iter().filter(|id| !carries(id));
    for id in fixed.filter(|id| !keeps(id) || id.contains("steps=1")) {
        let mut run = Run::new(id, sheet(), H);
        for h in [0.5 * H, 2.0 * H] {
            (0..3).for_each(|_| {
                run.step();
            });
            run.h = seconds(h);
            let mut fresh = fresh(id, &run);
            let (a, b) = (run.step(), fresh.step());
            // Leapfrog knows the force at the end of the last step, whatever its size was.
            let count = |n: u32| if id.starts_with("leapfrog") { 0 } else { n };
            let work = |r: StepReport| StepReport {
                setups: Setups::default(),
                force_evaluations: count(r.force_evaluations),
                ..r
            };
            assert_eq!(work(a), work(b), "{id}");
            assert_eq!(bits(&run.state), bits(&fresh.state), "{id}");
        }
    }
}

/// What was rebuilt in place is what would have been built anew, and `restart` forgets all history.
#[test]
fn after_changes_and_a_restart_a_step_is_that_of_a_fresh_integrator() {
    for id in METHODS {
        let mut run = Run::new(id, sheet(), H);
        (0..3).for_each(|_| {
            run.step();
        });
        assert!(run.system.scale_stiffness("tension", 3.0));
        assert!(run.system.scale_damping("shear", 0.5));
        assert!(run.system.set_pinned(17, true) && run.system.set_pinned(0, false));
        run.integrator.restart(&run.state);
        let mut fresh = fresh(id, &run);
        run.step();
        fresh.step();
        assert_eq!(bits(&run.state), bits(&fresh.state), "{id}");
        assert_eq!(run.state.v[17], Vec3::zeros(), "{id}: the new pin holds");
        assert_ne!(run.state.v[0], Vec3::zeros(), "{id}: the old pin is gone");
    }
}

/// The same where contacts hold particles: what the last steps knew of them is history too, which tells a bounce from
/// rest.
#[test]
fn after_a_restart_in_contact_a_step_is_that_of_a_fresh_integrator() {
    // Within the limits of the explicit methods.
    const SHORT: f64 = 0.001;
    let scene = drape_model::load("square-table-1e4").unwrap_or_else(|error| panic!("{error}"));
    for bounce in [0.0, 0.5] {
        let mut spec = scene.spec().clone();
        for obstacle in &mut spec.obstacles {
            if let ObstacleSpec::Box { restitution, .. } = obstacle {
                *restitution = bounce;
            }
        }
        for id in METHODS {
            let (system, mut state) = build(&spec);
            state.v.fill(Vec3::new(0.0, 0.0, -0.02));
            let mut run = Run::new(id, (system, state), SHORT);
            (0..10).for_each(|_| {
                run.step();
            });
            // In the middle the cloth lies on the table, at the rim it falls.
            let (middle, corner) = (run.state.x[10 * 20 + 10].z, run.state.x[0].z);
            let lies = middle.abs() < 0.1 * corner.abs() && corner < -1e-4;
            assert!(lies, "{id}: {middle}, {corner}");
            // A jump: what lay on the table a step ago now hits it.
            run.state.v.fill(Vec3::new(0.0, 0.0, -0.3));
            run.integrator.restart(&run.state);
            let mut fresh = fresh(id, &run);
            for step in 0..3 {
                run.step();
                fresh.step();
                assert_eq!(bits(&run.state), bits(&fresh.state), "{id}, e = {bounce}, step {step}");
            }
        }
    }
}

/// Masses, stiffnesses and damping coefficients in another unit, a power of four, give the same
/// motion to the last bit.
#[test]
fn the_unit_of_mass_does_not_matter() {
    for id in METHODS {
        for unit in [4.0, 0.0625] {
            let mut run = Run::new(id, sheet(), H);
            let (mut system, state) = sheet();
            let mass: Vec<f64> = system.mass().iter().map(|m| unit * m).collect();
            assert!(system.set_mass(&mass));
            for effect in ["tension", "shear"] {
                assert!(system.scale_stiffness(effect, unit) && system.scale_damping(effect, unit));
            }
            let mut scaled = Run::new(id, (system, state), H);
            for step in 0..10 {
                run.step();
                scaled.step();
                assert_eq!(bits(&run.state), bits(&scaled.state), "{id}, × {unit}, step {step}");
            }
        }
    }
}

/// A pinned particle does not move, whatever its velocity was.
#[test]
fn pins_hold() {
    for id in METHODS {
        let (system, mut state) = sheet();
        state.v[0] = Vec3::new(1.0, 2.0, 3.0);
        let mut run = Run::new(id, (system, state), H);
        let (start, pinned) = (run.state.x.clone(), run.system.pinned().to_vec());
        (0..5).for_each(|_| {
            run.step();
        });
        assert_eq!(pinned.iter().filter(|pinned| **pinned).count(), 2);
        for i in (0..start.len()).filter(|&i| pinned[i]) {
            assert_eq!((run.state.x[i], run.state.v[i]), (start[i], Vec3::zeros()), "{id}");
        }
    }
}

/// Nor does that velocity act on the others.
#[test]
fn the_old_velocity_of_a_pinned_particle_moves_no_other() {
    let stiff = Sheet { tension: 1e6, shear: 1e5, damping: 40.0, ..SHEET };
    let mut kicked = Vec::new();
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for id in METHODS {
            let after = |speed: f64| {
                let (system, mut state) = Sheet { law, ..stiff }.build();
                for i in (0..state.len()).filter(|&i| system.pinned()[i]) {
                    state.v[i] = Vec3::new(0.6, 0.48, -0.64) * speed;
                }
                let mut run = Run::new(id, (system, state), 0.01);
                run.step();
                run.state.v
            };
            let (moved, still) = (after(10.0), after(0.0));
            let kick = moved.iter().zip(&still).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            if kick > 1e-12 {
                kicked.push(format!("{id}, {law:?}: {kick:.3e} m/s"));
            }
        }
    }
    assert!(kicked.is_empty(), "neighbours are kicked: {kicked:#?}");
}
