//! What holds beside the mathematics: settings, set-ups, history, pins, tolerance.

use super::*;
use drape_integrator::{Setups, SolveStatus, StepError};
use drape_oracle::laws::hanging_chain;

const STEP: f64 = 0.004;

fn scene() -> (System, State) {
    stir(&sheet(4, 2e3, 3.0, DampingLaw::Full))
}

#[test]
fn every_scheme_has_its_own_id_and_refuses_what_it_does_not_know() {
    let ids = ["imex-sbdf2", "imex-cnab2", "imex-mcnab2", "imex-cnlf"];
    for (scheme, id) in SCHEMES.into_iter().zip(ids) {
        assert_eq!(method(scheme, "").method().id, id);
        for pair in
            [("start", "best"), ("implicit", "all"), ("forcing_term", "0.6"), ("order", "2")]
        {
            let error = ImexTwoStepSettings::from_pairs(scheme, [pair]).unwrap_err().to_string();
            assert!(error.contains(id) && error.contains(pair.0), "{error}");
        }
    }
}

/// A new system, step size, stiffness, damping, mass or pin rebuilds the matrix in the step that needs
/// it. A step between two sizes has a `τ` of its own, but for CNAB2, and CNLF starts anew.
#[test]
fn set_ups_are_charged_to_their_cause() {
    let none = Setups::default();
    let (step_size, stiffness) = (Setups { step_size: 1, ..none }, Setups { stiffness: 1, ..none });
    for scheme in SCHEMES {
        let mut run = Run::new(scheme, "", scene(), STEP);
        let setups = |run: &mut Run| [(); 3].map(|()| run.step().setups);
        assert_eq!(setups(&mut run), [Setups { first: 1, ..none }, none, none], "{scheme:?}");
        run.h = seconds(0.5 * STEP);
        let after = if VARIABLE[..1].contains(&scheme) || scheme == Scheme::Mcnab2 {
            step_size
        } else {
            none
        };
        assert_eq!(setups(&mut run), [step_size, after, none], "{scheme:?}");
        assert!(run.system.scale_stiffness("tension", 1.5));
        assert_eq!(setups(&mut run), [stiffness, none, none], "{scheme:?}");
        assert!(run.system.scale_damping("tension", 1.5));
        assert_eq!(setups(&mut run), [stiffness, none, none], "{scheme:?}");
        let heavier: Vec<f64> = run.system.mass().iter().map(|m| 2.0 * m).collect();
        assert!(run.system.set_mass(&heavier));
        assert_eq!(setups(&mut run), [stiffness, none, none], "{scheme:?}");
        assert!(run.system.set_pinned(7, true));
        assert_eq!(setups(&mut run), [Setups { constraints: 1, ..none }, none, none], "{scheme:?}");
        let mut run = Run::new(scheme, "matrix=rebuilt", scene(), STEP);
        let every = Setups { every_step: 1, ..none };
        assert_eq!(setups(&mut run), [Setups { first: 1, ..none }, every, every], "{scheme:?}");
    }
}

/// The history is dropped where it no longer fits: a restart, another system, a jump of the step size.
#[test]
fn a_new_beginning_is_that_of_a_fresh_integrator() {
    type Change = fn(&mut Run);
    let changes: [Change; 6] = [
        |run| run.method.restart(&run.state),
        |run| run.h = seconds(2.5 * STEP),
        |run| assert!(run.system.scale_stiffness("tension", 3.0)),
        |run| assert!(run.system.scale_damping("shear", 0.5)),
        |run| assert!(run.system.set_pinned(9, true) && run.system.set_pinned(0, false)),
        |run| {
            let heavier: Vec<f64> = run.system.mass().iter().map(|m| 2.0 * m).collect();
            assert!(run.system.set_mass(&heavier));
        },
    ];
    for (scheme, (number, change)) in
        SCHEMES.into_iter().flat_map(|s| changes.into_iter().enumerate().map(move |c| (s, c)))
    {
        let mut run = Run::new(scheme, "", scene(), STEP);
        run.steps(3);
        change(&mut run);
        let now = (run.system.clone(), run.state.clone());
        let mut fresh = Run::new(scheme, "", now, run.h.seconds());
        for step in 0..3 {
            let (a, b) = (run.step(), fresh.step());
            let work = |r: StepReport| StepReport { setups: Setups::default(), ..r };
            assert_eq!(work(a), work(b), "{scheme:?}, change {number}, step {step}");
            assert_eq!(
                bits(&run.state),
                bits(&fresh.state),
                "{scheme:?}, change {number}, step {step}"
            );
        }
    }
}

/// `X*` of a pinned particle is its position to the last bit, whatever it did before it was pinned.
#[test]
fn pins_hold_what_moved_until_then() {
    for scheme in SCHEMES {
        let (system, mut state) = scene();
        state.v[0] = Vec3::new(1.0, 2.0, 3.0); // pinned from the start
        let mut run = Run::new(scheme, "", (system, state), STEP);
        let corner = run.state.x[0];
        run.steps(5);
        assert_eq!((run.state.x[0], run.state.v[0]), (corner, Vec3::zeros()), "{scheme:?}");
        assert!(run.state.v[9].norm() > 0.1, "{scheme:?}: moves when it is pinned");
        assert!(run.system.set_pinned(9, true) && run.system.set_pinned(0, false));
        let held = run.state.x[9];
        for h in [STEP, 0.75 * STEP, 1.5 * STEP, STEP, STEP] {
            run.h = seconds(h);
            run.step();
            assert_eq!((run.state.x[9], run.state.v[9]), (held, Vec3::zeros()), "{scheme:?}");
        }
        assert!((run.state.x[0] - corner).norm() > 1e-6, "{scheme:?}: the old pin is gone");
    }
}

/// The tolerance refers to the forces: the same motion seen from a moving frame takes about the same
/// iterations and is solved as well.
#[test]
fn a_moving_frame_is_solved_as_well_as_one_at_rest() {
    for scheme in SCHEMES {
        let mut spec = sheet(4, 1e5, 3.0, DampingLaw::Full);
        spec.pins.clear();
        let cost_and_error = |speed: f64| {
            let (system, mut state) = stir(&spec);
            state.v.iter_mut().for_each(|v| v.x += speed);
            let run = |text| {
                let mut run = Run::new(scheme, text, (system.clone(), state.clone()), 0.01);
                let iterations: u32 = (0..20).map(|_| run.step().cg_iterations).sum();
                (iterations, run.state)
            };
            let ((iterations, loose), (_, exact)) =
                (run("forcing_term=1e-2"), run("solver=cholesky"));
            let pairs = loose.x.iter().zip(&exact.x);
            (iterations, pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max))
        };
        let ((at_rest, error), (moving, error_moving)) = (cost_and_error(0.0), cost_and_error(1e3));
        assert!(at_rest > 20 && moving.abs_diff(at_rest) <= 2, "{scheme:?}: {at_rest}, {moving}");
        assert!(error_moving < 1.1 * error, "{scheme:?}: {error:e}, moving {error_moving:e}");
    }
}

/// A sheet that rests or flies without any force ends its solve at the round-off of its springs.
#[test]
fn a_sheet_without_forces_needs_no_iterations() {
    for (scheme, norm) in
        SCHEMES.into_iter().flat_map(|s| ["euclid", "preconditioned"].map(|n| (s, n)))
    {
        let mut spec = sheet(4, 1e6, 3.0, DampingLaw::Full);
        (spec.pins, spec.effects.gravity) = (Vec::new(), None);
        spec.particles.velocity_m_s.fill([1.0, 2.0, 3.0]);
        let mut run = Run::new(scheme, &format!("norm={norm}"), spec.build().unwrap(), 0.01);
        for _ in 0..50 {
            let report = run.step();
            assert!(report.cg_iterations <= 2, "{scheme:?}, {norm}: {report:?}");
            assert_eq!(report.solve, SolveStatus::Converged, "{scheme:?}, {norm}");
        }
    }
}

/// What hangs at rest is compared with its weight, not with the forces, of which there are none left.
#[test]
fn a_chain_at_rest_needs_no_iterations() {
    let masses = [MASS, 2.0 * MASS, MASS];
    let stiffness = [300.0, 200.0, 100.0];
    let lengths = hanging_chain(&masses, &stiffness, &[0.2; 3], GRAVITY.norm());
    let depths: Vec<f64> = (0..=3).map(|k| lengths[..k].iter().sum()).collect();
    let positions: Vec<Vec3> = depths.iter().map(|depth| Vec3::z() * -depth).collect();
    let masses = [&[MASS], &masses[..]].concat();
    let mut spec = particles(&masses, &positions, &[Vec3::zeros(); 4]);
    spec.pins = vec![pin(0)];
    spec.effects.gravity = gravity();
    let link = |k: usize| spring(SpringEffect::Tension, (k, k + 1), 0.2, (stiffness[k], 0.1));
    spec.springs = (0..3).map(link).collect();
    for scheme in SCHEMES {
        let (system, mut state) = spec.build().unwrap();
        state.x[2].z += 1e-8; // a pull far below the weight
        let mut run = Run::new(scheme, "", (system, state), 0.01);
        let iterations: u32 = (0..50).map(|_| run.step().cg_iterations).sum();
        assert_eq!(iterations, 0, "{scheme:?}");
        for (x, rest) in run.state.x.iter().zip(&positions) {
            assert!((x - rest).norm() < 1e-6, "{scheme:?}: {x:?} moved from {rest:?}");
        }
    }
}

/// Three sweeps a step: `F`, `G`, `L_k X*`; two more where the past has no forces yet.
#[test]
fn force_evaluations_are_counted() {
    for scheme in SCHEMES {
        let mut run = Run::new(scheme, "", scene(), STEP);
        run.step();
        let found = [(); 3].map(|()| run.step().force_evaluations);
        assert_eq!(found, [5, 3, 3], "{scheme:?}");
    }
}

/// Blow-up is a result; a matrix that cannot be built is an error that leaves the state as it was.
#[test]
fn numbers_that_are_not_finite_are_reported_and_a_refused_step_changes_nothing() {
    for scheme in SCHEMES {
        let mut run = Run::new(scheme, "", scene(), STEP);
        run.steps(2);
        run.state.v[5].x = f64::NAN;
        let report = run.step();
        assert_ne!(report.solve, SolveStatus::Converged, "{scheme:?}");
        let mut run = Run::new(scheme, "", scene(), STEP);
        run.steps(2);
        let before = bits(&run.state);
        assert!(run.system.scale_stiffness("tension", 1e306));
        let mut clock = PhaseClock::off();
        let outcome = run.method.step(&run.system, &mut run.state, run.h, &mut clock);
        assert!(matches!(outcome, Err(StepError::Solver(_))), "{scheme:?}: {outcome:?}");
        assert_eq!(bits(&run.state), before, "{scheme:?}");
    }
}

/// Masses, stiffnesses and damping coefficients in another unit, a power of four, give the same motion to
/// the last bit.
#[test]
fn the_unit_of_mass_does_not_matter() {
    for (scheme, text) in
        SCHEMES.into_iter().flat_map(|s| ["", "norm=preconditioned"].map(|t| (s, t)))
    {
        let mut run = Run::new(scheme, text, scene(), STEP);
        let (mut system, state) = scene();
        let mass: Vec<f64> = system.mass().iter().map(|m| 4.0 * m).collect();
        assert!(system.set_mass(&mass));
        for effect in ["tension", "shear"] {
            assert!(system.scale_stiffness(effect, 4.0) && system.scale_damping(effect, 4.0));
        }
        let mut scaled = Run::new(scheme, text, (system, state), STEP);
        for step in 0..10 {
            run.step();
            scaled.step();
            assert_eq!(bits(&run.state), bits(&scaled.state), "{scheme:?}, {text}, step {step}");
        }
    }
}

/// The extrapolated start is that of EEH (22) carried to the end of the step: it saves iterations, also where steps
/// change, and alters the result within the tolerance only.
#[test]
fn the_extrapolated_start_saves_iterations() {
    for scheme in [Scheme::Sbdf2, Scheme::Mcnab2] {
        let [(last, a), (extrapolated, b)] = ["last", "extrapolated"].map(|start| {
            let text = format!("start={start},forcing_term=1e-5");
            let mut run = Run::new(scheme, &text, scene(), STEP);
            let lengths = [STEP, 1.5 * STEP, STEP, 0.5 * STEP];
            let mut iterations = 0;
            for step in 0..40 {
                run.h = seconds(lengths[step % lengths.len()]);
                iterations += run.step().cg_iterations;
            }
            (iterations, run.state)
        });
        assert!(extrapolated < last, "{scheme:?}: {extrapolated}, from v_n {last}");
        let apart = a.x.iter().zip(&b.x).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(apart < 1e-5, "{scheme:?}: {apart:e}");
    }
}
