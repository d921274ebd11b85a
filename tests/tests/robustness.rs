//! Default settings in hard places: other frames, no gravity, failed rebuilds, stiffness beyond
//! what converges, damping that the energy theorem does not cover.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_integrator::SolveStatus;
use drape_model::{DampingLaw, EffectKind, System, Vec3};
use drape_tests::{
    METHODS, Random, Sheet, assert_covers, build, fresh, has, name, particles, prepared, tension,
};

const IMPLICIT: [&str; 3] = ["imex-updated", "imex-updated:start=last", "backward-euler"];

/// The shape of what moves must not depend on how fast it moves as a whole.
#[test]
fn implicit_methods_contract_a_spring_alike_in_every_frame() {
    const H: f64 = 0.01;
    for id in IMPLICIT {
        let length = |boost: f64| {
            let velocity = Vec3::new(0.0, boost, 0.0);
            let mut spec = particles(&[1e-3; 2], &[Vec3::zeros(), Vec3::x() * 1.5], &[velocity; 2]);
            spec.springs = vec![tension((0, 1), 1.0, 10.0, 0.0)];
            let mut run = prepared(id, build(&spec), H);
            run.steps(5);
            (run.state.x[0] - run.state.x[1]).norm()
        };
        let (rest, fast) = (length(0.0), length(1000.0));
        assert!((rest - 1.5).abs() > 0.1, "{id}: the spring moves: {rest}");
        assert!((rest - fast).abs() < 1e-2, "{id}: {rest} at rest, {fast} at 1000 m/s");
    }
}

/// A forcing term is a relative error of the change of velocity: free fall at default settings
/// keeps gravity to that accuracy, however fast the sheet has become.
#[test]
fn a_free_sheet_falls_at_default_settings() {
    const H: f64 = 0.01;
    let sheet =
        Sheet { tension: 1e4, shear: 0.0, damping: 40.0, pinned: false, ..Sheet::default() };
    for (id, accuracy) in IMPLICIT.into_iter().zip([1e-2, 1e-2, 1e-9]) {
        let mut run = prepared(id, sheet.build(), H);
        run.steps(500);
        let expected = -9.81 * 5.0;
        for v in &run.state.v {
            assert!((v.z / expected - 1.0).abs() <= accuracy, "{id}: {} of {expected}", v.z);
        }
    }
}

/// Without gravity and from rest there is no velocity to compare residuals with; the forces are.
#[test]
fn a_squeezed_sheet_without_gravity_takes_few_iterations() {
    let (side, tension, shear, damping) = (12, 1e6, 1e5, 40.0);
    let sheet = Sheet { side, tension, shear, damping, pinned: false, ..Sheet::default() };
    let sheet = Sheet { gravity: Vec3::zeros(), ..sheet };
    for id in ["imex-updated", "backward-euler"] {
        let (system, mut state) = sheet.build();
        for x in &mut state.x {
            x.x *= 0.5;
        }
        let mut run = prepared(id, (system, state), 0.01);
        for step in 0..5 {
            let report = run.step();
            assert!(report.newton_iterations <= 60, "{id}, step {step}: {report:?}");
            assert_eq!(report.solve, SolveStatus::Converged, "{id}, step {step}: {report:?}");
            assert!(report.relative_residual > 0.0, "{id}: {report:?}");
        }
    }
}

/// A failed rebuild leaves no operator behind that looks valid.
#[test]
fn after_a_step_size_that_overflows_the_next_step_is_as_good_as_new() {
    let sheet = Sheet { tension: 1e4, shear: 1e3, damping: 4.0, ..Sheet::default() };
    for id in ["imex-euler", "imex-euler:solver=cholesky", "imex-updated"] {
        let (system, start) = sheet.build();
        let step = |spoil: bool| {
            let mut run = prepared(id, (system.clone(), start.clone()), 0.004);
            run.step();
            if spoil {
                let before = run.state.clone();
                run.h = 1e200;
                let outcome = run.try_step();
                assert!(outcome.is_err(), "{id}: {outcome:?}");
                assert_eq!(before, run.state, "{id}: an error leaves the state as it was");
            }
            run.restart();
            let report = run.step_by(0.004);
            assert_eq!(report.solve, SolveStatus::Converged, "{id}");
            (run.state, report.setups)
        };
        let ((clean, _), (spoilt, setups)) = (step(false), step(true));
        assert_eq!(setups.step_size, 1, "{id}: the rebuild is charged");
        assert_eq!(clean, spoilt, "{id}");
    }
}

/// Whether a method, at its settings, factorises a matrix with the stiffness in each step or keeps
/// such a factor.
fn factorises_stiffness(id: &str) -> bool {
    let always = [
        "backward-euler",
        "bdf2",
        "terzopoulos-fleischer",
        "desbrun",
        "imex-euler",
        "imex-updated",
        "imex-rk",
        "rosenbrock",
        "projective",
    ];
    let iterates =
        has(id, "solver=multigrid") || has(id, "solver=cg") && !has(id, "jacobian=saved");
    always.contains(&name(id)) && !iterates
        || name(id) == "baraff-witkin" && has(id, "solver=cholesky")
        || name(id) == "imex-sbdf2"
}

/// Likewise with a stiffness or damping that overflows in the matrix: the state is kept, and when
/// it is scaled back the step is that of a fresh integrator. Where a method does not refuse, what
/// comes out of the step may be anything, but nothing of it may stay in the integrator.
#[test]
fn after_a_failed_rebuild_the_next_step_is_that_of_a_fresh_integrator() {
    // So long a step that the products with it overflow where the coefficients do not.
    const H: f64 = 4.0;
    let sheet = Sheet { tension: 0.05, shear: 0.01, damping: 0.1, ..Sheet::default() };
    // Powers of two, which leave no rounding behind when they are taken back.
    let overflow = |system: &mut System, what: &str, back: bool| {
        let factors = [2.0_f64.powi(1020), 2.0_f64.powi(16)];
        for factor in factors.map(|factor| if back { factor.recip() } else { factor }) {
            let changed = match what {
                "stiffness" => system.scale_stiffness(EffectKind::Tension, factor),
                _ => system.scale_damping(EffectKind::Tension, factor),
            };
            assert!(changed, "{what}");
        }
    };
    assert_covers("failed rebuilds", METHODS, &[]);
    let mut refused = [Vec::new(), Vec::new()];
    for (what, refused) in ["stiffness", "damping"].into_iter().zip(&mut refused) {
        for id in METHODS {
            let mut run = prepared(id, sheet.build(), H);
            run.steps(2);
            let before = run.state.clone();
            overflow(&mut run.system, what, false);
            if run.try_step().is_err() {
                assert_eq!(before, run.state, "{id}, {what}: an error leaves the state as it was");
                refused.push(id);
            }
            run.state.clone_from(&before);
            overflow(&mut run.system, what, true);
            run.restart();
            let mut fresh = fresh(id, &run);
            for step in 0..2 {
                run.step();
                fresh.step();
                assert_eq!(run.state, fresh.state, "{id}, {what}, step {step}");
            }
        }
    }
    for id in METHODS.into_iter().filter(|id| factorises_stiffness(id)) {
        assert!(refused[0].contains(&id), "{id} factorises the stiffness: {refused:?}");
        assert!(refused[1].contains(&id), "{id} factorises the damping: {refused:?}");
    }
    for id in ["leapfrog:solver=cholesky", "symplectic-euler:damping=implicit"] {
        assert!(!refused[0].contains(&id), "{id} factorises no stiffness");
        assert!(refused[1].contains(&id), "{id} factorises the damping: {refused:?}");
    }
}

/// Beyond what Newton can do in a hundred iterations the robust form falls back to plain IMEX
/// Euler, which never gains energy.
#[test]
fn the_robust_form_gains_no_energy_where_it_cannot_converge() {
    let mut unconverged = 0;
    for damping in [0.0, 40.0] {
        let sheet = Sheet { side: 8, tension: 1e12, shear: 1e11, damping, ..Sheet::default() };
        let mut run = prepared("imex-updated", sheet.build(), 0.1);
        let mut last = run.energy();
        for step in 0..20 {
            let report = run.step();
            unconverged += u32::from(report.solve != SolveStatus::Converged);
            let energy = run.energy();
            assert!(energy <= last + 1e-6, "d/m = {damping}, step {step}: {last} to {energy}");
            last = energy;
        }
    }
    assert!(unconverged > 0, "the case is hard enough to need the fallback");
}

/// The energy theorem of IMEX Euler is for full damping: of projected damping a part is explicit.
#[test]
fn projected_damping_is_outside_the_energy_theorem_of_imex_euler() {
    let mut random = Random::new(5);
    let mut rises = [0, 0];
    for _ in 0..300 {
        for (law, rises) in [DampingLaw::Full, DampingLaw::Projected].into_iter().zip(&mut rises) {
            let n = 4;
            let vectors =
                |random: &mut Random| (0..n).map(|_| random.vector()).collect::<Vec<Vec3>>();
            let positions = vectors(&mut random);
            let mut spec = particles(&[1.0, 0.02, 30.0, 0.5], &positions, &vectors(&mut random));
            spec.damping = law;
            for (i, j) in [(0, 1), (1, 2), (2, 3), (0, 2), (1, 3)] {
                let rest = (positions[i] - positions[j]).norm();
                spec.springs.push(tension((i, j), rest, 1.0, 1e4));
            }
            let mut run =
                prepared("imex-euler:solver=cholesky,implicit=springs", build(&spec), 0.01);
            let before = run.energy();
            run.step();
            let after = run.energy();
            *rises += u32::from(after > before * (1.0 + 1e-9));
        }
    }
    assert_eq!(rises[0], 0, "full damping never gains energy");
    assert!(rises[1] > 0, "projected damping does, which the docs say");
}
