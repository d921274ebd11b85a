//! Tests of the step against its own identities.

use super::*;
use crate::settings::EnergyMomentumSettings;
use drape_integrator::Integrator;
use drape_model::{DampingLaw, Level, SpringEffect, SystemSpec};
use drape_oracle::laws::{Drift, free_fall, spin};
use drape_oracle::order::{of_method, position_error};
use drape_oracle::recurrence::implicit_midpoint;
use drape_oracle::reference::{Reference, ReferenceSettings, reference};
use drape_oracle::scenes::{
    GRAVITY, Sheet, anchored, build, floor, particles, spring, stiffening, stir, tension, uneven,
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

fn exact(system: &System, start: &State, t: f64) -> Reference {
    reference(system, start, &[t], ReferenceSettings::default()).expect("a reference")
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
    let (h, mass) = (1.0 / 64.0, 0.25);
    for (theta, eta) in [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0), (2.0, 30.0)] {
        for rest in [0.0, 4.0] {
            let direction = Vec3::new(0.0, 0.6, -0.8);
            let law = (SpringEffect::Tension, rest, theta * mass / (h * h), eta * mass / h);
            let spec = anchored(mass, &[law], direction * (rest + 0.25), Vec3::zeros());
            let mut run = run(build(&spec), h);
            let (mut x, mut w) = (0.25, 0.0);
            for step in 0..50 {
                let size = libm::hypot(x, w).max(rest);
                run.step();
                let next = implicit_midpoint(theta, eta) * nalgebra::Vector2::new(x, w);
                (x, w) = (next.x, next.y);
                let found = (direction.dot(&run.state.x[1]) - rest, direction.dot(&run.state.v[1]));
                let error = libm::hypot(found.0 - x, h * found.1 - w);
                assert!(error < 1e-9 * size, "θ={theta} η={eta} ℓ={rest}, {step}: {error:e}");
            }
        }
    }
}

/// Two particles in rotation at 2 rad/s, of mass 1 kg and rest length 1 m, at their equilibrium.
fn rotor(theta: f64, h: f64) -> (System, State) {
    let stiffness = theta / (h * h);
    let length = stiffness / (stiffness - 4.0);
    let (x, v) = (Vec3::x() * (0.5 * length), Vec3::y() * length);
    let mut spec = particles(&[1.0; 2], &[-x, x], &[-v, v]);
    spec.springs = vec![tension((0, 1), 1.0, 0.5 * stiffness, 0.0)];
    build(&spec)
}

/// The rotation is a relative equilibrium of the step, too: spin, energy and length stay, and the
/// angle is that of the trapezoidal rule.
#[test]
fn two_particles_in_rotation_keep_spin_energy_and_length_at_any_stiffness() {
    for theta in [1.0, 100.0, 1e6] {
        let mut run = run(rotor(theta, 0.01), 0.01);
        let spin = run.system.angular_momentum(&run.state).z;
        let (energy, length) = (run.energy(), run.state.x[1].norm());
        run.steps(100);
        let off = [
            run.system.angular_momentum(&run.state).z / spin - 1.0,
            run.energy() / energy - 1.0,
            run.state.x[1].norm() / length - 1.0,
        ];
        assert!(off.iter().all(|off| off.abs() < 1e-9), "θ={theta}: {off:?}");
        let angle = libm::atan2(run.state.x[1].y, run.state.x[1].x);
        assert!((angle - 1.99993334).abs() < 5e-9, "θ={theta}: {angle}");
    }
}

/// Stretched, squeezed and damped pairs obey the law of the oracle.
#[test]
fn a_damped_pair_loses_spin_by_its_law() {
    let (h, mass) = (1.0 / 64.0, 0.25);
    let mut random = Random::new(8);
    for (theta, eta) in [(0.3, 0.125), (1.0, 0.0), (100.0, 0.125)] {
        for _ in 0..4 {
            let d = random.vector().normalize() * random.between(0.2, 1.0);
            let velocities = [random.vector() * 4.0, random.vector() * 4.0];
            let mut spec = particles(&[mass; 2], &[Vec3::zeros(), d], &velocities);
            let (k, c) = (0.5 * theta * mass / (h * h), 0.5 * eta * mass / h);
            spec.springs = vec![tension((0, 1), 0.5, k, c)];
            let mut run = run(build(&spec), h);
            let pair = |run: &Run| {
                let State { x, v, .. } = &run.state;
                ((x[1] - x[0]).norm(), (x[1] - x[0]).cross(&(v[1] - v[0])))
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

/// A sheet that is stretched, waves and moves.
fn smooth(damping: f64) -> (System, State) {
    let sheet = Sheet { side: 6, tension: 1e3, shear: 100.0, damping, ..Sheet::default() };
    let (system, mut state) = sheet.build();
    let corner = Vec3::new(-0.5, -0.5, 0.0);
    for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
        let from_corner = state.x[i] - corner;
        let (x, y) = (from_corner.x, from_corner.y);
        let wave = 0.02 * libm::sin(3.0 * y + 1.0);
        state.x[i] = corner + Vec3::new(1.03 * x, 0.98 * y, wave);
        state.v[i] = Vec3::new(libm::sin(2.0 * y), x, libm::cos(3.0 * x)) * 0.3;
    }
    (system, state)
}

#[test]
fn the_error_on_a_smooth_scene_is_of_order_two() {
    for damping in [5.0, 0.0] {
        let (system, start) = smooth(damping);
        let exact = exact(&system, &start, 0.2);
        let found = of_method(tight, &system, &start, &exact, &[20, 40, 80]).expect("an order");
        assert!((found.order - 2.0).abs() < 0.15, "{found:?}");
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola_and_feels_no_spring() {
    let sheet = Sheet { side: 9, tension: 1e6, shear: 1e5, pinned: false, ..Sheet::default() };
    let (system, mut state) = sheet.build();
    state.v.fill(Vec3::new(1.0, -2.0, 3.0));
    let start = state.clone();
    let h = 1.0 / 64.0;
    let mut run = run((system, state), h);
    for step in 1..=20 {
        let report = run.step();
        assert_eq!(report.newton_iterations, 0, "the velocity without springs is the solution");
        let (x, v) = free_fall(Drift::MeanVelocity, start.x[3], start.v[3], GRAVITY, h, step);
        let error = (run.state.x[3] - x).norm() + (run.state.v[3] - v).norm();
        assert!(error < 1e-11, "{step}: {error:e}");
    }
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
    for restitution in [0.0, 0.5] {
        let mut spec = particles(&[0.5], &[Vec3::z()], &[]);
        spec.effects.gravity = drape_oracle::scenes::gravity();
        spec.obstacles = vec![floor(restitution)];
        let mut run = run(build(&spec), 0.01);
        let start = run.energy();
        for _ in 0..800 {
            run.step();
            assert!(run.energy() <= start + 1e-12);
        }
        assert!(run.state.x[0].z.abs() < 1e-9 && run.state.v[0].norm() < 1e-12, "{:?}", run.state);
    }
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
        let (system, start) = smooth(damping);
        let exact = exact(&system, &start, 0.2);
        let found = of_method(tight, &system, &start, &exact, &[20, 40, 80, 160]).expect("order");
        println!("smooth, d/m={damping}: {found:?}");
    }
    let sheet = |k: f64, damping| Sheet {
        side: 20,
        tension: k,
        shear: 0.1 * k,
        damping,
        ..Sheet::default()
    };
    for k in [1e4, 1e6] {
        let (system, start) = sheet(k, 40.0).build();
        let exact = exact(&system, &start, 0.3);
        for steps in [30_u32, 60, 120] {
            let mut run = run((system.clone(), start.clone()), 0.3 / f64::from(steps));
            let reports = run.steps(steps as usize);
            let error = position_error(&system, &start.x, &exact.states[0].x, &run.state.x);
            let newton: u32 = reports.iter().map(|r| r.newton_iterations).sum();
            println!(
                "hanging {k:e}, {steps}: {error:.4e}, {newton} Newton, {:.1e}",
                exact.position_error
            );
        }
    }
    let cases = [1e6, 1e8].into_iter().flat_map(|k| [(k, 40.0), (k, 0.0)]);
    for ((k, damping), on_failure) in
        cases.flat_map(|case| [OnFailure::Halve, OnFailure::Report].map(|on| (case, on)))
    {
        let method = EnergyMomentum::new(settings(1e-9, on_failure));
        let mut run = Run::new(Box::new(method), sheet(k, damping).build(), 0.01);
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
