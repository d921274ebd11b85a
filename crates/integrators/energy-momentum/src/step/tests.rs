//! Tests of the step against its own identities.

use super::*;
use crate::settings::EnergyMomentumSettings;
use drape_integrator::Integrator;
use drape_model::{DampingLaw, Level, SpringEffect, SystemSpec};
use drape_oracle::checks::{self, Known, contact};
use drape_oracle::laws::{Drift, spin};
use drape_oracle::recurrence::implicit_midpoint;
use drape_oracle::scenes::{
    Sheet, build, particles, spring, stiffening, stir, tension, uneven, waving,
};
use drape_oracle::{Random, Run, seconds};

fn settings(residual: f64, on_failure: OnFailure) -> EnergyMomentumSettings {
    EnergyMomentumSettings { residual, on_failure, ..EnergyMomentumSettings::default() }
}

fn tight() -> Box<dyn Integrator> {
    Box::new(EnergyMomentum::new(settings(1e-16, OnFailure::Halve)))
}

fn run(start: (System, State), h: f64) -> Run {
    Run::new(tight(), start, h)
}

/// `H₊ − H_n + h v̄ᵀ D v̄`, and the size of the terms.
fn defect(before: &State, run: &Run) -> (f64, f64) {
    let Run { system, state, h, .. } = run;
    let mean: Vec<Vec3> =
        state.v.iter().zip(&before.v).map(|(new, old)| (new + old) * 0.5).collect();
    let mut force = vec![Vec3::zeros(); mean.len()];
    for effect in system.effects().filter(|effect| effect.has_damping()) {
        effect.add_damping_force(Level { t: 0.0, x: &before.x, v: &mean }, &mut force);
    }
    let work: f64 = force.iter().zip(&mean).map(|(f, v)| h * f.dot(v)).sum();
    let change = system.total_energy(state) - system.total_energy(before);
    let kinetic = system.kinetic_energy(&state.v) + system.kinetic_energy(&before.v);
    (change - work, kinetic + work.abs() + system.potential_energy(&state.x).abs())
}

/// The identity of the method, on sheets that fold, with linear and piecewise springs, and unequal
/// masses.
#[test]
fn the_energy_changes_by_the_work_of_the_damping_alone() {
    let sheet = Sheet { side: 6, tension: 1e4, shear: 1e3, damping: 10.0, ..Sheet::default() };
    let undamped = Sheet { damping: 0.0, pinned: false, ..sheet };
    let soft = SystemSpec { damping: DampingLaw::Full, ..sheet.spec() };
    for (name, start) in [
        ("damped", stir(sheet.build(), 0.02, 1.0)),
        ("undamped", stir(undamped.build(), 0.02, 0.3)),
        ("unequal masses", uneven(stir(sheet.build(), 0.02, 1.0))),
        ("piecewise", stir(build(&stiffening(soft, 10.0)), 0.02, 1.0)),
    ] {
        let mut run = run(start, 0.004);
        let mut worst = 0.0_f64;
        for step in 0..60 {
            let before = run.state.clone();
            let report = run.step();
            assert_eq!(report.solve, SolveStatus::Converged, "{name}, step {step}: {report:?}");
            if report.substeps == 1 {
                let (defect, size) = defect(&before, &run);
                worst = worst.max(defect.abs() / size);
            }
        }
        assert!(worst < 1e-12, "{name}: {worst:e}");
    }
}

#[test]
fn on_an_anchored_spring_it_is_implicit_midpoint() {
    for (at, rest) in checks::PARAMETERS.into_iter().flat_map(|p| [0.0, 4.0].map(|rest| (p, rest)))
    {
        let matrix = implicit_midpoint(at.0, at.1);
        checks::moves_along("energy-momentum", tight(), at, rest, &[1.0], |_| matrix);
    }
}

/// The rotation is a relative equilibrium of the step, too: spin, energy and length stay, and the
/// angle is that of the trapezoidal rule.
#[test]
fn two_particles_in_rotation_keep_spin_energy_and_length_at_any_stiffness() {
    for theta in [1.0, 100.0, 1e6] {
        let found = checks::turn(tight(), theta);
        let off = [found.spin - 1.0, found.energy - 1.0, found.length - 1.0];
        assert!(off.iter().all(|off| off.abs() < 1e-9), "θ={theta}: {found:?}");
        assert!((found.angle - 1.99993334).abs() < 5e-9, "θ={theta}: {found:?}");
    }
}

/// Stretched, squeezed and damped pairs obey the law of the oracle.
#[test]
fn a_damped_pair_loses_spin_by_its_law() {
    let (h, mass) = (checks::H, checks::MASS);
    let mut random = Random::new(8);
    for (theta, eta) in [(0.3, 0.125), (1.0, 0.0), (100.0, 0.125)] {
        for _ in 0..4 {
            let d = random.vector().normalize() * random.between(0.2, 1.0);
            let velocities = [random.vector() * 4.0, random.vector() * 4.0];
            let mut spec = particles(&[mass; 2], &[Vec3::zeros(), d], &velocities);
            let (k, c) = checks::coefficients(0.5 * theta, 0.5 * eta, h);
            spec.springs = vec![tension((0, 1), 0.5, k, c)];
            let mut run = run(build(&spec), h);
            let pair = |run: &Run| {
                let (d, v) = checks::pair(&run.state);
                (d.norm(), d.cross(&v))
            };
            for _ in 0..40 {
                let (length, before) = pair(&run);
                if run.step().substeps > 1 {
                    continue;
                }
                let (longer, after) = pair(&run);
                let factor = spin::energy_momentum(theta, eta, 0.5 / length, 0.5 / longer);
                let error = (after - before * factor).norm();
                let bound = 1e-12 * (1.0 + theta) * (before.norm() + 1.0);
                assert!(error < bound, "θ={theta} η={eta}: {error:e}");
            }
        }
    }
}

#[test]
fn momentum_and_angular_momentum_of_a_random_net_stay() {
    let mut random = Random::new(21);
    let n = 12;
    let masses: Vec<f64> = (0..n).map(|_| random.between(0.5, 2.0)).collect();
    let (x, v): (Vec<_>, Vec<_>) = (0..n).map(|_| (random.vector(), random.vector())).unzip();
    let mut spec = particles(&masses, &x, &v);
    for i in 1..n {
        for j in (0..i).filter(|j| j + 1 == i || (i + j) % 3 == 0) {
            let rest = (x[i] - x[j]).norm() * random.between(0.7, 1.3);
            spec.springs.push(spring(SpringEffect::Tension, (i, j), rest, 125.0, 0.0));
        }
    }
    let mut run = run(build(&spec), 0.01);
    let values = |run: &Run| {
        (run.system.momentum(&run.state), run.system.angular_momentum(&run.state), run.energy())
    };
    let (p, l, e) = values(&run);
    run.steps(50);
    let (q, m, f) = values(&run);
    let off = [(q - p).norm(), (m - l).norm(), (f - e).abs() / e];
    assert!(off.iter().all(|off| *off < 1e-10), "{off:?}");
}

fn smooth(damping: f64) -> Known {
    let sheet = Sheet { side: 6, tension: 1e3, shear: 100.0, damping, ..Sheet::default() };
    Known::new(waving(sheet.build()), 0.2)
}

#[test]
fn the_error_on_a_smooth_scene_is_of_order_two() {
    for damping in [5.0, 0.0] {
        let found = smooth(damping).order(tight, &[20, 40, 80]);
        assert!((found.order - 2.0).abs() < 0.15, "{found:?}");
    }
}

/// The velocity without springs is the solution.
#[test]
fn a_free_sheet_falls_on_the_exact_parabola_and_feels_no_spring() {
    let reports = checks::falls_freely("energy-momentum", tight(), Drift::MeanVelocity, 1e-11);
    assert!(reports.iter().all(|report| report.newton_iterations == 0), "{reports:?}");
}

/// Squeezed and fast pairs, on the way to whose solution the matrix is singular: divided steps keep
/// the energy, reported ones may break it, and no failure is silent.
#[test]
fn a_step_that_newton_cannot_solve_is_divided_or_reported() {
    let (h, mass, theta) = (1.0 / 64.0, 0.25, 10.0);
    let after = |on_failure| {
        let (mut random, mut failed, mut divided) = (Random::new(3), 0, 0);
        for _ in 0..10 {
            let d = random.vector().normalize() * random.between(0.05, 0.5);
            let velocities = [random.vector() * 8.0, random.vector() * 8.0];
            let mut spec = particles(&[mass; 2], &[Vec3::zeros(), d], &velocities);
            spec.springs = vec![tension((0, 1), 0.5, 0.5 * theta * mass / (h * h), 0.0)];
            let method = EnergyMomentum::new(settings(1e-12, on_failure));
            let mut run = Run::new(Box::new(method), build(&spec), h);
            let start = run.energy();
            for _ in 0..200 {
                let before = run.energy();
                let report = run.step();
                let is_solved = report.solve == SolveStatus::Converged;
                let off = (run.energy() - before).abs();
                assert!(off < 1e-9 * start || !is_solved, "{on_failure:?}: {off:e} of {start:e}");
                failed += u32::from(!is_solved);
                divided += u32::from(report.substeps > 1);
            }
        }
        (failed, divided)
    };
    let (halved, reported) = (after(OnFailure::Halve), after(OnFailure::Report));
    assert!(halved.1 > 0 && halved.0 < reported.0 && reported.1 == 0, "{halved:?}, {reported:?}");
}

/// The same squeezed sheet with all iterations that it needs, and with fewer: the limit holds for
/// the step with all of its parts, and the step says that it is unsolved.
#[test]
fn a_step_ends_when_its_iterations_are_used_up_and_says_so() {
    let sheet = Sheet { tension: 1e8, shear: 1e7, damping: 0.0, ..Sheet::default() };
    let start = stir(sheet.build(), 0.2, 10.0);
    let take = |most: Option<u32>| {
        let (system, mut state) = start.clone();
        let settings = settings(1e-9, OnFailure::Halve);
        let mut step = Workspace::new(&system, &settings, 0.01).expect("a pattern");
        step.equation.most = most.unwrap_or(step.equation.most);
        let mut clock = PhaseClock::off();
        let report = step.step(&settings, &system, &mut state, 0.01, &mut clock).expect("finite");
        assert!(state.is_finite() && state.t == 0.01, "{report:?}");
        report
    };
    let free = take(None);
    assert_eq!(free.solve, SolveStatus::Converged, "{free:?}");
    assert!(free.rejected > 0 && free.newton_iterations > 30, "{free:?}");
    for most in [1, 5, 30] {
        let limited = take(Some(most));
        assert_eq!(limited.newton_iterations, most, "{limited:?}");
        assert_eq!(limited.solve, SolveStatus::IterationLimit, "{limited:?}");
    }
}

#[test]
fn what_cannot_be_computed_is_an_error_that_leaves_the_state() {
    let mut run = run(Sheet::default().build(), 0.01);
    run.state.x[7].y = f64::NAN;
    let before = drape_oracle::bits(&run.state);
    assert!(matches!(run.try_step(), Err(StepError::Solver(_))));
    assert_eq!(drape_oracle::bits(&run.state), before);
}

#[test]
fn a_particle_falls_on_the_floor_bounces_and_comes_to_rest() {
    contact::bounces_or_rests("energy-momentum", tight, &[0.0, 0.5]);
}

/// Every term of the ledger is there, and the springs leave no gap.
#[test]
fn the_ledger_closes_without_gaps_of_springs() {
    let mut run = run(uneven(stir(Sheet::default().build(), 0.01, 1.0)), 0.004);
    for _ in 0..20 {
        let (before, energy) = (run.state.clone(), run.energy());
        run.step();
        let h = seconds(run.h);
        let ledger = run.integrator.ledger(&run.system, &before, &run.state, h).expect("undivided");
        let change = run.energy() - energy;
        assert!((ledger.sum() - change).abs() < 1e-10 * ledger.magnitude(), "{ledger:?}");
        assert!(ledger.gap().abs() < 1e-12 * ledger.magnitude(), "{ledger:?}");
        assert!(ledger.damping < 0.0 && ledger.inertia.abs() < 1e-12 * ledger.magnitude());
    }
}

/// The numbers that the documentation of the crate quotes; `--ignored --nocapture`.
#[test]
#[ignore = "prints measurements; takes minutes"]
#[allow(clippy::print_stdout, reason = "its purpose")]
fn measure() {
    for damping in [5.0, 0.0] {
        let found = smooth(damping).order(tight, &[20, 40, 80, 160]);
        println!("smooth, d/m={damping}: {found:?}");
    }
    for k in [1e4, 1e6] {
        let known = Known::new(Sheet::hanging(k, 40.0).build(), 0.3);
        for steps in [30_u32, 60, 120] {
            let mut run = known.run(tight(), 0.3 / f64::from(steps));
            let reports = run.steps(steps as usize);
            let error = known.error(&run);
            let newton: u32 = reports.iter().map(|r| r.newton_iterations).sum();
            println!(
                "hanging {k:e}, {steps}: {error:.4e}, {newton} Newton, {:.1e}",
                known.exact.position_error
            );
        }
    }
    let cases = [1e6, 1e8].into_iter().flat_map(|k| [(k, 40.0), (k, 0.0)]);
    for ((k, damping), on_failure) in
        cases.flat_map(|case| [OnFailure::Halve, OnFailure::Report].map(|on| (case, on)))
    {
        let method = EnergyMomentum::new(settings(1e-9, on_failure));
        let mut run = Run::new(Box::new(method), Sheet::hanging(k, damping).build(), 0.01);
        let start = run.energy();
        let (mut rise, mut failed, mut total) = (0.0_f64, 0, StepReport::default());
        let time = std::time::Instant::now();
        for _ in 0..200 {
            let report = run.step();
            rise = rise.max(run.energy() - start);
            failed += usize::from(report.solve != SolveStatus::Converged);
            total.newton_iterations += report.newton_iterations;
            total.substeps += report.substeps;
            total.rejected += report.rejected;
        }
        println!(
            "2 s, {k:e}, d/m={damping}, {on_failure:?}: rise {rise:e}, end {:e}, {failed} unsolved, \
             {total:?}, {:?} a step",
            run.energy() - start,
            time.elapsed() / 200
        );
    }
}
