//! Tests of the step against exact solutions.

use super::*;
use drape_integrator::Integrator;
use drape_model::DampingLaw;
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::checks::{self, Known};
use drape_oracle::laws::Drift;
use drape_oracle::recurrence::exact_oscillator;
use drape_oracle::scenes::{Sheet, in_a_gust, stir, uneven, waving};
use drape_oracle::{Run, bits};

fn with(krylov_tol: f64, max_dim: usize) -> Box<dyn Integrator> {
    Box::new(Exponential::new(ExponentialSettings { krylov_tol, max_dim }))
}

fn tight() -> Box<dyn Integrator> {
    with(1e-10, 150)
}

/// Along an anchored spring the motion is linear, and a step is exact whatever its size.
#[test]
fn an_oscillator_moves_exactly_at_any_step_sizes() {
    for at in checks::PARAMETERS.into_iter().chain([(1e4, 200.0)]) {
        for rest in [0.0, 4.0] {
            let sizes = [1.0, 2.0, 0.75];
            checks::moves_along("exponential", tight(), at, rest, &sizes, |size| {
                exact_oscillator(at.0 * size * size, at.1 * size)
            });
        }
    }
}

/// Two particles in rotation at 2 rad/s lose spin, for the tangent stretches their spring.
#[test]
fn two_particles_in_rotation_lose_spin_as_computed_elsewhere() {
    for (theta, spin, angle) in [(1.0, 0.9950452512, 1.99484204), (100.0, 0.7044603362, 1.65825735)]
    {
        let found = checks::turn(tight(), theta);
        assert!((found.spin - spin).abs() < 1e-7, "θ={theta}: {found:?}");
        assert!((found.angle - angle).abs() < 1e-7, "θ={theta}: {found:?}");
        assert!(found.momentum < 1e-12, "θ={theta}: {found:?}");
    }
}

fn smooth(damping: f64, law: DampingLaw) -> Known {
    let sheet = Sheet { side: 6, tension: 1e3, shear: 100.0, damping, law, ..Sheet::default() };
    Known::new(waving(sheet.build()), 0.2)
}

/// With either law of damping: the Jacobian holds the turn of its directions, too.
#[test]
fn the_error_on_a_smooth_scene_is_of_order_two() {
    for (damping, law) in
        [(5.0, DampingLaw::Full), (0.0, DampingLaw::Full), (5.0, DampingLaw::Projected)]
    {
        let found = smooth(damping, law).order(tight, &[20, 40, 80]);
        assert!((found.order - 2.0).abs() < 0.15, "{law:?}: {found:?}");
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola_and_feels_no_spring() {
    let new = with(1e-5, 150);
    let reports = checks::falls_freely("exponential", new, Drift::MeanVelocity, 1e-11);
    assert!(reports.iter().all(|report| report.matvecs < 10), "{reports:?}");
}

#[test]
fn momentum_stays_with_unequal_masses_and_either_law_of_damping() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let start = uneven(stir(Sheet { law, ..Sheet::free() }.build(), 0.05, 1.0));
        let drift = checks::momentum_drift(with(1e-5, 150), start, 0.01);
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

/// A step takes the wind of its start, and so does each part of a divided one: the error falls with
/// the number of parts.
#[test]
fn each_part_of_a_divided_step_takes_the_wind_of_its_time() {
    let end = |max_dim: usize, steps: u32| {
        let mut run = Run::new(with(1e-10, max_dim), in_a_gust(), 0.05 / f64::from(steps));
        let parts: u32 = run.steps(steps as usize).iter().map(|report| report.substeps).sum();
        (run.state.x, parts)
    };
    let [(exact, _), (whole, one), (divided, parts)] =
        [(150, 256), (150, 1), (5, 1)].map(|(max_dim, steps)| end(max_dim, steps));
    assert!(one == 1 && parts >= 4, "{one} and {parts} parts");
    let [whole, divided] = [whole, divided].map(|x| drape_oracle::apart(&x, &exact));
    assert!(divided < 2.0 * whole / f64::from(parts), "{divided:e} in {parts} parts, {whole:e}");
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
        let found = smooth(damping, DampingLaw::Full).order(tight, &[20, 40, 80, 160]);
        println!("smooth, d/m={damping}: {found:?}");
    }
    for damping in [40.0, 0.0] {
        let mut run = Run::new(with(1e-5, 150), Sheet::hanging(1e6, damping).build(), 0.01);
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
        let settings = AdaptiveSettings { tolerance: 1e-8, ..AdaptiveSettings::default() };
        let known = Known::with(Sheet::hanging(k, 40.0).build(), 0.3, settings);
        for (&steps, tolerance) in counts.iter().flat_map(|s| [1e-2, 1e-3, 1e-5].map(|t| (s, t))) {
            let h = 0.3 / f64::from(steps);
            let mut run = known.run(with(tolerance, 150), h);
            let time = std::time::Instant::now();
            let reports = run.steps(steps as usize);
            let error = known.error(&run);
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
