//! What every integrator promises beside its mathematics: refusals leave the state alone, rebuilds
//! are charged to their cause, history follows the step size and the system, pins hold, units do
//! not matter.

use drape_integrator::{Setups, SolveStatus, StepError, StepReport};
use drape_model::{DampingLaw, EffectKind, ObstacleSpec, State, System, Vec3};
use drape_oracle::scenes;
use drape_tests::{
    METHODS, Run, Sheet, apart, assert_covers, bits, build, fresh, has, is_adaptive, method, name,
    particles, prepared, stir, takes, tension, work,
};

const H: f64 = 0.004;

/// A sheet in motion.
fn sheet() -> (System, State) {
    stir(Sheet { side: 6, shear: 500.0, ..Sheet::default() }.build(), 0.0, 1.0)
}

#[test]
fn every_method_goes_through_the_contract() {
    assert_covers("contract", METHODS, &[]);
    let ids = SETUPS.iter().flat_map(|(_, ids)| ids.iter().copied());
    assert_covers("set-ups", ids, &[]);
}

#[test]
fn a_system_that_was_not_prepared_is_refused_and_the_state_kept() {
    for id in METHODS {
        let mut run = Run { integrator: method(id), ..prepared(id, sheet(), H) };
        let before = bits(&run.state);
        let error = run.try_step().expect_err("not prepared");
        assert!(matches!(error, StepError::NeedsPrepare), "{id}: {error}");
        // Another system of the same size has another topology.
        let mut run = Run { system: sheet().0, ..prepared(id, sheet(), H) };
        let error = run.try_step().expect_err("another one");
        assert!(matches!(error, StepError::NeedsPrepare), "{id}: {error}");
        assert_eq!(bits(&run.state), before, "{id}");
    }
}

#[test]
fn a_state_of_another_size_is_refused_and_kept() {
    for id in METHODS {
        let mut run = prepared(id, sheet(), H);
        let (n, state) = (run.system.len(), run.state.clone());
        for shorter in ["x", "v", "both"] {
            run.state.clone_from(&state);
            if shorter != "v" {
                run.state.x.pop();
            }
            if shorter != "x" {
                run.state.v.pop();
            }
            let before = bits(&run.state);
            let error = run.try_step().expect_err("a particle is missing");
            let fits = matches!(error, StepError::SizeMismatch { expected, .. } if expected == n);
            assert!(fits, "{id}: {error}");
            assert_eq!(bits(&run.state), before, "{id}");
        }
    }
}

/// When a method sets up a matrix.
#[derive(Clone, Copy, PartialEq)]
enum When {
    /// It has none, or charges its Newton iterations to no cause.
    Never,
    /// In every step, for no other cause.
    EveryStep,
    /// In every step; where something changed, that is the cause.
    Rebuilt,
    /// Likewise, and see [`When::ChangedTwice`].
    RebuiltTwice,
    /// Where something changed.
    Changed,
    /// Likewise; a step between two step sizes has a `τ` of its own.
    ChangedTwice,
}

const SETUPS: [(When, &[&str]); 6] = [
    (
        When::Never,
        &[
            "explicit-euler",
            "symplectic-euler",
            "provot",
            "adams-bashforth2",
            "adams-bashforth2:steps=3",
            "backward-euler",
            "bdf2",
            "bdf2:steps=3",
            "midpoint",
            "dirk",
            "dirk:tableau=esdirk3",
            "generalized-alpha",
            "vbd",
            "vbd:augmented=true",
            "leapfrog:damping=explicit",
            "rkc",
            "srkn4",
            "multirate",
            "xpbd",
            "xpbd:substeps=8,order=2",
            "xpbd-lines",
            "exponential",
            "energy-momentum",
        ],
    ),
    (
        When::Rebuilt,
        &[
            "imex-euler:matrix=rebuilt",
            "imex-updated:matrix=rebuilt",
            "imex-cnab2:matrix=rebuilt",
            "imex-rk:matrix=rebuilt",
            "imex-cnlf:matrix=rebuilt",
        ],
    ),
    (When::RebuiltTwice, &["imex-sbdf2:matrix=rebuilt", "imex-mcnab2:matrix=rebuilt"]),
    (When::EveryStep, &["terzopoulos-fleischer", "baraff-witkin", "rosenbrock"]),
    (
        When::Changed,
        &[
            "symplectic-euler:damping=implicit",
            "imex-euler",
            "imex-euler:solver=cholesky,implicit=springs",
            "imex-updated",
            "imex-updated:safeguard=paper",
            "desbrun",
            "desbrun:inverse=dense",
            "kang",
            "leapfrog",
            "leapfrog:solver=cholesky",
            "imex-cnab2",
            "imex-cnlf",
            "imex-rk",
            "imex-rk:tableau=ark4",
            "projective",
            "projective:solver=cg",
        ],
    ),
    (When::ChangedTwice, &["imex-sbdf2", "imex-mcnab2"]),
];

/// Each rebuild is counted once, under its cause, in the step that needed it.
#[test]
fn set_ups_are_charged_to_their_cause() {
    let none = Setups::default();
    let first = Setups { first: 1, ..none };
    let (step_size, stiffness) = (Setups { step_size: 1, ..none }, Setups { stiffness: 1, ..none });
    let constraints = Setups { constraints: 1, ..none };
    let every_step = Setups { every_step: 1, ..none };
    for (when, id) in SETUPS.iter().flat_map(|(when, ids)| ids.iter().map(move |id| (*when, *id))) {
        let mut run = prepared(id, sheet(), H);
        let setups = |run: &mut Run| [(); 3].map(|()| run.step().setups);
        let usual = match when {
            When::Never | When::Changed | When::ChangedTwice => none,
            When::EveryStep | When::Rebuilt | When::RebuiltTwice => every_step,
        };
        let expected = [if when == When::Never { none } else { first }, usual, usual];
        assert_eq!(setups(&mut run), expected, "{id}");
        let changed = |cause: Setups| match when {
            When::Never | When::EveryStep => [usual; 3],
            _ => [cause, usual, usual],
        };
        let resized = match when {
            When::ChangedTwice | When::RebuiltTwice => [step_size, step_size, usual],
            _ => changed(step_size),
        };
        run.h = 0.5 * H;
        assert_eq!(setups(&mut run), resized, "{id}");
        assert!(run.system.scale_stiffness(EffectKind::Tension, 1.5));
        assert_eq!(setups(&mut run), changed(stiffness), "{id}");
        assert!(run.system.scale_damping(EffectKind::Tension, 1.5));
        assert_eq!(setups(&mut run), changed(stiffness), "{id}");
        assert!(double_masses(&mut run.system));
        assert_eq!(setups(&mut run), changed(stiffness), "{id}");
        assert!(run.system.set_pinned(20, true));
        assert_eq!(setups(&mut run), changed(constraints), "{id}");
        run.h = H;
        assert_eq!(setups(&mut run), resized, "{id}");
    }
}

fn double_masses(system: &mut System) -> bool {
    let heavier: Vec<f64> = system.mass().iter().map(|m| 2.0 * m).collect();
    system.set_mass(&heavier)
}

/// Rebuilding the matrix in each step costs time and changes nothing.
#[test]
fn a_rebuilt_matrix_is_the_kept_one() {
    for id in ["imex-euler", "imex-updated", "imex-sbdf2"] {
        let mut kept = prepared(id, sheet(), H);
        let mut rebuilt = prepared(&format!("{id}:matrix=rebuilt"), sheet(), H);
        kept.steps(5);
        rebuilt.steps(5);
        assert_eq!(bits(&kept.state), bits(&rebuilt.state), "{id}");
    }
}

/// Whether the coefficients of the method follow the step size, so that it keeps its history.
fn keeps_history(id: &str) -> bool {
    let several = ["adams-bashforth2", "bdf2", "imex-sbdf2", "imex-cnab2", "imex-mcnab2"];
    let is_second = has(id, "order=2") || name(id) == "xpbd-lines";
    several.contains(&name(id)) && !has(id, "steps=1") || is_second
}

/// Whether the method carries an acceleration, which belongs to any step size.
fn carries_acceleration(id: &str) -> bool {
    ["dirk", "generalized-alpha"].contains(&name(id))
}

/// Step size control carries its own step over from call to call, a saved factor serves while τ
/// changes little.
fn carries_more(id: &str) -> bool {
    is_adaptive(id) || has(id, "jacobian=saved")
}

/// Velocities of steps of another size are no basis for an extrapolation: the history is dropped,
/// unless the method knows what to do with it.
#[test]
fn after_a_change_of_step_size_a_step_is_that_of_a_fresh_integrator_unless_the_history_bridges_it()
{
    for id in METHODS.into_iter().filter(|id| !carries_more(id)) {
        let keeps = keeps_history(id);
        let ratios: &[(f64, bool)] = match keeps {
            _ if carries_acceleration(id) => &[(0.5, true), (4.0, true)],
            false => &[(0.5, false), (4.0, false)],
            true if has(id, "steps=3") && name(id) == "bdf2" => {
                &[(0.6, true), (1.45, true), (1.6, false), (0.45, false), (2.1, false)]
            }
            true => &[(0.6, true), (1.45, true), (2.0, true), (0.45, false), (2.1, false)],
        };
        for &(ratio, kept) in ratios {
            let mut run = prepared(id, sheet(), H);
            run.steps(4);
            run.h = ratio * H;
            let mut fresh = fresh(id, &run);
            let (a, b) = (run.step(), fresh.step());
            let is_same = bits(&run.state) == bits(&fresh.state);
            assert_eq!(is_same, !kept, "{id}, ratio {ratio}");
            if !kept {
                // These know the force at the end of the last step, whatever its size was.
                let keeps_force = ["leapfrog", "srkn4", "multirate"].contains(&name(id));
                let count = |n: u32| if keeps_force { 0 } else { n };
                let counted = |r: StepReport| StepReport {
                    force_evaluations: count(r.force_evaluations),
                    ..work(r)
                };
                assert_eq!(counted(a), counted(b), "{id}");
            }
        }
    }
}

type Change = (&'static str, fn(&mut System) -> bool);

const CHANGES: [Change; 6] = [
    ("nothing", |_| true),
    ("stiffness", |system| system.scale_stiffness(EffectKind::Tension, 3.0)),
    ("damping", |system| system.scale_damping(EffectKind::Shear, 0.5)),
    ("mass", double_masses),
    ("pins", |system| system.set_pinned(17, true) && system.set_pinned(0, false)),
    ("everything", |system| CHANGES[1..5].iter().all(|(_, change)| change(system))),
];

/// What is rebuilt in place is what is built anew, and `restart` forgets all history.
#[test]
fn after_changes_and_a_restart_the_steps_are_those_of_a_fresh_integrator() {
    for (id, (what, change)) in METHODS.into_iter().flat_map(|id| CHANGES.map(|c| (id, c))) {
        let mut run = prepared(id, sheet(), H);
        run.steps(3);
        assert!(change(&mut run.system));
        run.restart();
        let mut fresh = fresh(id, &run);
        for step in 0..3 {
            let (a, b) = (run.step(), fresh.step());
            assert_eq!(work(a), work(b), "{id}, {what}, step {step}");
            assert_eq!(bits(&run.state), bits(&fresh.state), "{id}, {what}, step {step}");
            if what == "pins" {
                assert_eq!(run.state.v[17], Vec3::zeros(), "{id}: the new pin holds");
                assert_ne!(run.state.v[0], Vec3::zeros(), "{id}: the old pin is gone");
            }
        }
    }
}

/// Whether the method starts its solves from the last velocities, which a change of the system does
/// not spoil.
fn starts_warm(id: &str) -> bool {
    let warm = ["backward-euler", "imex-euler", "imex-updated", "midpoint", "energy-momentum"];
    warm.contains(&name(id)) || has(id, "start=last")
}

/// A change of the system is as good as a restart: velocities have a kink there, accelerations a
/// jump.
#[test]
fn after_a_change_of_the_system_the_steps_are_those_of_a_fresh_integrator() {
    let ids = METHODS.into_iter().filter(|id| !carries_more(id) && !starts_warm(id));
    for (id, (what, change)) in ids.flat_map(|id| CHANGES[1..].iter().map(move |c| (id, *c))) {
        let mut run = prepared(id, sheet(), H);
        run.steps(3);
        assert!(change(&mut run.system));
        let mut fresh = fresh(id, &run);
        for step in 0..3 {
            let (a, b) = (run.step(), fresh.step());
            assert_eq!(work(a), work(b), "{id}, {what}, step {step}");
            assert_eq!(bits(&run.state), bits(&fresh.state), "{id}, {what}, step {step}");
        }
    }
}

/// The same where contacts hold particles: what the last steps knew of them is history too, which
/// tells a bounce from rest.
#[test]
fn after_a_restart_in_contact_the_steps_are_those_of_a_fresh_integrator() {
    // Within the limits of the explicit methods.
    const SHORT: f64 = 0.001;
    for bounce in [0.0, 0.5] {
        let mut spec = scenes::bundled("square-table-1e4");
        for obstacle in &mut spec.obstacles {
            if let ObstacleSpec::Box { restitution, .. } = obstacle {
                *restitution = bounce;
            }
        }
        for id in METHODS {
            let (system, mut state) = build(&spec);
            if !takes(id, &system) {
                continue;
            }
            state.v.fill(Vec3::new(0.0, 0.0, -0.02));
            let mut run = prepared(id, (system, state), SHORT);
            run.steps(10);
            // In the middle the cloth lies on the table, at the rim it falls.
            let (middle, corner) = (run.state.x[10 * 20 + 10].z, run.state.x[0].z);
            let lies = middle.abs() < 0.1 * corner.abs() && corner < -1e-4;
            assert!(lies, "{id}: {middle}, {corner}");
            // A jump: what lay on the table a step ago now hits it.
            run.state.v.fill(Vec3::new(0.0, 0.0, -0.3));
            run.restart();
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
            let mut run = prepared(id, sheet(), H);
            let (mut system, state) = sheet();
            let mass: Vec<f64> = system.mass().iter().map(|m| unit * m).collect();
            assert!(system.set_mass(&mass));
            for effect in [EffectKind::Tension, EffectKind::Shear] {
                assert!(system.scale_stiffness(effect, unit) && system.scale_damping(effect, unit));
            }
            let mut scaled = prepared(id, (system, state), H);
            for step in 0..10 {
                run.step();
                scaled.step();
                assert_eq!(bits(&run.state), bits(&scaled.state), "{id}, × {unit}, step {step}");
            }
        }
    }
}

/// A pinned particle does not move, whatever its velocity was, with old pins and new ones, at any
/// step sizes.
#[test]
fn pins_hold_what_moved_until_then_and_let_go() {
    for id in METHODS {
        let (system, mut state) = sheet();
        state.v[0] = Vec3::new(1.0, 2.0, 3.0);
        let mut run = prepared(id, (system, state), H);
        let hold = |run: &mut Run, pinned: [usize; 2]| {
            let places = pinned.map(|i| run.state.x[i]);
            for ratio in [1.0, 1.0, 0.75, 1.5, 1.0] {
                run.step_by(ratio * H);
                assert_eq!(pinned.map(|i| run.state.x[i]), places, "{id}");
                assert_eq!(pinned.map(|i| run.state.v[i]), [Vec3::zeros(); 2], "{id}");
            }
        };
        let corner = run.state.x[0];
        hold(&mut run, [0, 5]);
        assert!(run.state.v[17].norm() > 0.01, "{id}: moves when it is pinned");
        assert!(run.system.set_pinned(17, true) && run.system.set_pinned(0, false));
        hold(&mut run, [17, 5]);
        assert!((run.state.x[0] - corner).norm() > 1e-6, "{id}: the old pin is gone");
    }
}

/// Nor does that velocity act on the others.
#[test]
fn the_old_velocity_of_a_pinned_particle_moves_no_other() {
    let stiff = Sheet { side: 6, tension: 1e6, shear: 1e5, damping: 40.0, ..Sheet::default() };
    let mut kicked = Vec::new();
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let (damped, _) = Sheet { law, ..stiff }.build();
        for id in METHODS.into_iter().filter(|id| takes(id, &damped)) {
            let after = |speed: f64| {
                let (system, mut state) = Sheet { law, ..stiff }.build();
                for i in (0..state.len()).filter(|&i| system.pinned()[i]) {
                    state.v[i] = Vec3::new(0.6, 0.48, -0.64) * speed;
                }
                let mut run = prepared(id, (system, state), 0.01);
                run.step();
                run.state.v
            };
            let kick = apart(&after(10.0), &after(0.0));
            if kick > 1e-12 {
                kicked.push(format!("{id}, {law:?}: {kick:.3e} m/s"));
            }
        }
    }
    assert!(kicked.is_empty(), "neighbours are kicked: {kicked:#?}");
}

#[test]
fn what_is_at_rest_stays_there_to_the_last_bit() {
    let x = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.1, 0.2, 1.3)];
    let mut spec = particles(&[1.0, 2.0], &x, &[]);
    spec.springs = vec![tension((0, 1), 1.3 - 0.3, 1e4, 1.0)];
    let mut moved = Vec::new();
    // The factor of SBDF2 rounds the mean of the old levels, and stages round their sums.
    let rounds = |id: &str| id == "imex-sbdf2:solver=cholesky" || name(id) == "imex-rk";
    for id in METHODS.into_iter().filter(|id| !rounds(id)) {
        let mut run = prepared(id, build(&spec), 0.01);
        let start = bits(&run.state);
        run.steps(50);
        run.state.t = 0.0;
        if bits(&run.state) != start {
            moved.push(id);
        }
    }
    assert!(moved.is_empty(), "{moved:?}");
}

/// Whether the method solves a linear system in each step and reports how.
fn reports_its_solves(id: &str) -> bool {
    const SOLVES: [&str; 8] = [
        "backward-euler",
        "bdf2",
        "baraff-witkin",
        "midpoint",
        "dirk",
        "generalized-alpha",
        "exponential",
        "energy-momentum",
    ];
    SOLVES.contains(&name(id)) || name(id).starts_with("imex")
}

/// Blow-up is a result; what cannot be solved is an error that leaves the state as it was.
#[test]
fn numbers_that_overflow_are_a_result_or_a_refusal_that_leaves_the_state() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let sheet = Sheet { side: 4, tension: 1e6, shear: 1e5, law, ..Sheet::default() };
        let (system, _) = sheet.build();
        let ids = METHODS.into_iter().filter(|id| takes(id, &system));
        for (id, bad) in ids.flat_map(|id| BAD.map(|bad| (id, bad))) {
            let mut run = prepared(id, stir(sheet.build(), 0.0, 1.0), H);
            run.steps(2);
            run.state.x[4].y = bad;
            run.state.v[5].x = bad;
            let before = bits(&run.state);
            match run.try_step() {
                Ok(report) => {
                    let fails = bad == 1e200 || report.solve != SolveStatus::Converged;
                    assert!(fails || !reports_its_solves(id), "{id}, {bad}: {report:?}");
                    // What comes after may be anything but a panic.
                    for _ in 0..3 {
                        let _ = run.try_step();
                    }
                    run.restart();
                    let _ = run.try_step();
                }
                Err(StepError::Solver(_)) => assert_eq!(bits(&run.state), before, "{id}, {bad}"),
                Err(error) => panic!("{id}, {bad}: {error}"),
            }
        }
    }
}

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, 1e200];

/// Far beyond its limit a method blows up without a panic; a step size that overflows is an error
/// or a result.
#[test]
fn steps_that_are_far_too_long_do_not_panic() {
    // A divided step would take as many substeps as it asks for.
    let divides = |id: &str| has(id, "step=auto") || id == "rkc";
    let takes_one = |id: &&str| !reports_its_solves(id) && !divides(id);
    for id in METHODS.into_iter().filter(takes_one) {
        for h in [10.0, 1e200] {
            let mut run = prepared(id, sheet(), H);
            run.step();
            run.h = h;
            for _ in 0..60 {
                let before = bits(&run.state);
                if let Err(error) = run.try_step() {
                    assert!(matches!(error, StepError::Solver(_)), "{id}: {error}");
                    assert_eq!(bits(&run.state), before, "{id}");
                    break;
                }
            }
        }
    }
}
