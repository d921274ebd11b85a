//! Tests of the step against exact solutions.

use super::*;
use drape_integrator::Integrator;
use drape_model::{DampingLaw, SpringEffect};
use drape_oracle::laws::{Drift, free_fall};
use drape_oracle::order::{of_method, position_error};
use drape_oracle::recurrence::exact_oscillator;
use drape_oracle::reference::{Reference, ReferenceSettings, reference};
use drape_oracle::scenes::{GRAVITY, Sheet, anchored, build, particles, stir, tension, uneven};
use drape_oracle::{Run, bits};

fn with(krylov_tol: f64, max_dim: usize) -> Box<dyn Integrator> {
    Box::new(Exponential::new(ExponentialSettings { krylov_tol, max_dim }))
}

fn tight() -> Box<dyn Integrator> {
    with(1e-10, 150)
}

fn exact(system: &System, start: &State, t: f64) -> Reference {
    reference(system, start, &[t], ReferenceSettings::default()).expect("a reference")
}

/// Along an anchored spring the motion is linear, and a step is exact whatever its size.
#[test]
fn an_oscillator_moves_exactly_at_any_step_sizes() {
    let (unit, mass) = (1.0 / 64.0, 0.25);
    for (theta, eta) in
        [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0), (2.0, 30.0), (1e4, 200.0)]
    {
        for rest in [0.0, 4.0] {
            let direction = Vec3::new(0.0, 0.6, -0.8);
            let law =
                (SpringEffect::Tension, rest, theta * mass / (unit * unit), eta * mass / unit);
            let spec = anchored(mass, &[law], direction * (rest + 0.25), Vec3::zeros());
            let mut run = Run::new(tight(), build(&spec), unit);
            let (mut x, mut v) = (0.25, 0.0);
            for step in 0..50 {
                let ratio = [1.0, 2.0, 0.75][step % 3];
                let h = unit * ratio;
                let size = libm::hypot(x, h * v).max(0.25);
                run.step_by(h);
                let a = exact_oscillator(theta * ratio * ratio, eta * ratio);
                let next = a * nalgebra::Vector2::new(x, h * v);
                (x, v) = (next.x, next.y / h);
                let found = (direction.dot(&run.state.x[1]) - rest, direction.dot(&run.state.v[1]));
                let error = libm::hypot(found.0 - x, h * (found.1 - v));
                assert!(error < 1e-9 * size, "θ={theta} η={eta} ℓ={rest}, {step}: {error:e}");
            }
        }
    }
}

/// Two particles in rotation at 2 rad/s lose spin, for the tangent stretches their spring.
#[test]
fn two_particles_in_rotation_lose_spin_as_computed_elsewhere() {
    for (theta, spin, angle) in [(1.0, 0.9950452512, 1.99484204), (100.0, 0.7044603362, 1.65825735)]
    {
        let h = 0.01;
        let stiffness = theta / (h * h);
        let length = stiffness / (stiffness - 4.0);
        let (x, v) = (Vec3::x() * (0.5 * length), Vec3::y() * length);
        let mut spec = particles(&[1.0; 2], &[-x, x], &[-v, v]);
        spec.springs = vec![tension((0, 1), 1.0, 0.5 * stiffness, 0.0)];
        let mut run = Run::new(tight(), build(&spec), h);
        let start = run.system.angular_momentum(&run.state).z;
        run.steps(100);
        let kept = run.system.angular_momentum(&run.state).z / start;
        let turned = libm::atan2(run.state.x[1].y, run.state.x[1].x);
        assert!((kept - spin).abs() < 1e-7, "θ={theta}: {kept}");
        assert!((turned - angle).abs() < 1e-7, "θ={theta}: {turned}");
        assert!(run.system.momentum(&run.state).norm() < 1e-12);
    }
}

/// A sheet that is stretched, waves and moves.
fn smooth(damping: f64, law: DampingLaw) -> (System, State) {
    let sheet = Sheet { side: 6, tension: 1e3, shear: 100.0, damping, law, ..Sheet::default() };
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

/// With either law of damping: the Jacobian holds the turn of its directions, too.
#[test]
fn the_error_on_a_smooth_scene_is_of_order_two() {
    for (damping, law) in
        [(5.0, DampingLaw::Full), (0.0, DampingLaw::Full), (5.0, DampingLaw::Projected)]
    {
        let (system, start) = smooth(damping, law);
        let exact = exact(&system, &start, 0.2);
        let found = of_method(tight, &system, &start, &exact, &[20, 40, 80]).expect("an order");
        assert!((found.order - 2.0).abs() < 0.15, "{law:?}: {found:?}");
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola_and_feels_no_spring() {
    let sheet = Sheet { side: 9, tension: 1e6, shear: 1e5, pinned: false, ..Sheet::default() };
    let (system, mut state) = sheet.build();
    state.v.fill(Vec3::new(1.0, -2.0, 3.0));
    let start = state.clone();
    let h = 1.0 / 64.0;
    let mut run = Run::new(with(1e-5, 150), (system, state), h);
    for step in 1..=20 {
        let report = run.step();
        assert!(report.matvecs < 10, "{report:?}");
        let (x, v) = free_fall(Drift::MeanVelocity, start.x[3], start.v[3], GRAVITY, h, step);
        let error = (run.state.x[3] - x).norm() + (run.state.v[3] - v).norm();
        assert!(error < 1e-11, "{step}: {error:e}");
    }
}

#[test]
fn momentum_stays_with_unequal_masses_and_either_law_of_damping() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let free = Sheet { pinned: false, gravity: Vec3::zeros(), law, ..Sheet::default() };
        let mut run = Run::new(with(1e-5, 150), uneven(stir(free.build(), 0.05, 1.0)), 0.01);
        let start = run.system.momentum(&run.state);
        run.steps(50);
        let drift = (run.system.momentum(&run.state) - start).norm();
        assert!(drift < 1e-14, "{law:?}: {drift:e}");
    }
}

/// A subspace that is too small divides the step; the result is that of shorter steps, not another.
#[test]
fn a_step_that_needs_more_dimensions_is_divided() {
    let start = stir(Sheet { tension: 1e6, shear: 1e5, ..Sheet::default() }.build(), 0.01, 0.1);
    let mut small = Run::new(with(1e-6, 20), start.clone(), 0.01);
    let mut large = Run::new(with(1e-6, 150), start, 0.01);
    let (a, b) = (small.steps(5), large.steps(5));
    assert!(a.iter().all(|report| report.substeps > 1), "{a:?}");
    assert!(b.iter().all(|report| report.substeps == 1), "{b:?}");
    assert_eq!(small.state.t, large.state.t);
    let apart = drape_oracle::apart(&small.state.x, &large.state.x);
    assert!(apart < 1e-3, "{apart:e}");
}

#[test]
fn a_step_of_too_many_parts_is_refused_and_leaves_the_state() {
    let mut run = Run::new(with(1e-5, 10), Sheet::default().build(), 1e4);
    let before = bits(&run.state);
    assert!(matches!(run.try_step(), Err(StepError::TooManySubsteps { .. })));
    assert_eq!(bits(&run.state), before);
}

#[test]
fn numbers_that_overflow_are_a_result() {
    for bad in [f64::NAN, 1e200] {
        let mut run = Run::new(with(1e-5, 20), Sheet::default().build(), 0.01);
        run.state.x[7].y = bad;
        let report = run.step();
        assert!(report.solve != SolveStatus::Converged || run.state.is_finite(), "{report:?}");
        assert_eq!(run.state.t, 0.01);
    }
}

/// The numbers that the documentation of the crate quotes; `--ignored --nocapture`.
#[test]
#[ignore = "prints measurements; takes minutes"]
#[allow(clippy::print_stdout, reason = "its purpose")]
fn measure() {
    for damping in [5.0, 0.0] {
        let (system, start) = smooth(damping, DampingLaw::Full);
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
    for damping in [40.0, 0.0] {
        let mut run = Run::new(with(1e-5, 150), sheet(1e6, damping).build(), 0.01);
        let start = run.energy();
        let (mut rise, mut parts) = (0.0_f64, 0);
        for step in 0..200 {
            match run.try_step() {
                Ok(report) => parts += report.substeps,
                Err(error) => {
                    println!("step {step}: {error}");
                    break;
                }
            }
            rise = rise.max(run.energy() - start);
            if rise > 1e6 {
                println!("blown up at step {step}");
                break;
            }
        }
        let end = run.energy() - start;
        println!("2 s, d/m={damping}: rise {rise:e}, end {end:e}, {parts} substeps");
    }
    for (k, counts) in [(1e4, &[30_u32, 60, 120][..]), (1e6, &[30, 60, 120]), (1e8, &[150, 300])] {
        let (system, start) = sheet(k, 40.0).build();
        let settings = ReferenceSettings { tolerance: 1e-8, ..ReferenceSettings::default() };
        let exact = reference(&system, &start, &[0.3], settings).expect("a reference");
        for (&steps, tolerance) in counts.iter().flat_map(|s| [1e-2, 1e-3, 1e-5].map(|t| (s, t))) {
            let h = 0.3 / f64::from(steps);
            let mut run = Run::new(with(tolerance, 150), (system.clone(), start.clone()), h);
            let time = std::time::Instant::now();
            let reports = run.steps(steps as usize);
            let error = position_error(&system, &start.x, &exact.states[0].x, &run.state.x);
            let products: u32 = reports.iter().map(|r| r.matvecs).sum();
            let parts: u32 = reports.iter().map(|r| r.substeps).sum();
            let mean = f64::from(products) / f64::from(steps);
            println!(
                "hanging {k:e}, {steps}, tol {tolerance:e}: e {error:.4e}, {mean:.1} products a \
                 step, {parts} substeps, {:?}",
                time.elapsed() / steps
            );
        }
    }
}
