//! The hanging sheet: it locks where the iterations do not converge, and gains no energy.

use super::convergence::{H, hanging, leapfrog, middle};
use super::run;
use drape_model::{State, System};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::reference::reference;

/// Path of the middle of the free edge within 0.3 s, m, and its fall.
fn path(text: &str, start: (System, State), h: f64) -> (f64, f64, State) {
    let mut run = run(text, start, h);
    let first = middle(&run.state);
    let mut path = 0.0;
    for _ in 0..(0.3 / h).round() as u32 {
        let before = middle(&run.state);
        run.step();
        path += (middle(&run.state) - before).norm();
    }
    let fall = middle(&run.state).z - first.z;
    (path, fall, run.state)
}

/// Path of the exact motion with `d/m` = 40 1/s, m: an independent reference of order 8.
const EXACT: [(f64, f64); 4] =
    [(1e4, 0.441_455), (1e6, 0.476_456), (1e8, 0.481_941), (1e10, 0.481_961)];

/// Ten iterations hold a stiff sheet back.
#[test]
fn too_few_iterations_lock_a_stiff_sheet() {
    for (text, stiffness, expected) in [
        ("", 1e6, 1.032),
        ("acceleration=anderson", 1e6, 1.028),
        ("", 1e8, 0.183),
        ("acceleration=anderson", 1e8, 0.398),
        ("", 1e10, 0.107),
    ] {
        let exact = EXACT.iter().find(|(k, _)| *k == stiffness).map_or(f64::NAN, |(_, path)| *path);
        let (path, _, _) = path(text, hanging(stiffness, 40.0), H);
        let ratio = path / exact;
        assert!((ratio - expected).abs() < 0.01, "{text}, k/m = {stiffness:e}: {ratio}");
    }
}

/// Greatest rise of the energy over its start, and its change at the end, J.
fn energies(text: &str, damping: f64) -> (f64, f64) {
    let mut run = run(text, hanging(1e6, damping), H);
    let start = run.energy();
    let mut rise = f64::NEG_INFINITY;
    for _ in 0..200 {
        run.step();
        rise = rise.max(run.energy() - start);
    }
    (rise, run.energy() - start)
}

#[test]
fn energy_never_rises_over_its_start() {
    for damping in [0.0, 40.0] {
        for text in ["iterations=10", "acceleration=anderson", "acceleration=lbfgs"] {
            let (rise, _) = energies(text, damping);
            assert!(rise <= 1e-9, "{text}, d/m = {damping}: {rise:e} J");
        }
    }
}

#[test]
#[ignore = "prints the tables of the documentation"]
#[allow(clippy::print_stderr, reason = "a table")]
fn tables_of_the_hanging_sheet() {
    let forms = [
        "iterations=10",
        "iterations=50",
        "acceleration=chebyshev,rho=0.95,iterations=30",
        "acceleration=chebyshev,rho=0.99,iterations=30",
        "acceleration=chebyshev,rho=0.99,iterations=50",
        "acceleration=anderson",
        "acceleration=anderson,iterations=30",
        "acceleration=lbfgs",
        "acceleration=lbfgs,iterations=30",
        "acceleration=admm",
    ];
    for stiffness in [1e4, 1e6, 1e8, 1e10] {
        let start = hanging(stiffness, 40.0);
        let (exact, exact_path) = match stiffness {
            k if k < 1e7 => {
                let settings = AdaptiveSettings::default();
                let times: Vec<f64> = (1..=300).map(|n| 1e-3 * f64::from(n)).collect();
                let exact = reference(&start.0, &start.1, &times, settings)
                    .unwrap_or_else(|error| panic!("{error}"));
                let states: Vec<_> = [start.1.clone()].into_iter().chain(exact.states).collect();
                let paths = states.windows(2).map(|s| (middle(&s[1]) - middle(&s[0])).norm());
                let path = paths.sum();
                (states[states.len() - 1].clone(), path)
            }
            1e8 => {
                let mut exact = start.clone();
                let path = leapfrog(&mut exact, stiffness, 0.3);
                (exact.1, path)
            }
            _ => (start.1.clone(), 0.481_961),
        };
        let exact_fall = middle(&exact).z - middle(&start.1).z;
        eprintln!("{stiffness:e} R of the reference: {exact_path:.6} {exact_fall:.6}");
        for form in forms {
            for h in [0.01, 0.005, 0.0025] {
                if h < 0.01 && stiffness > 1e7 {
                    continue;
                }
                let (path, fall, end) = path(form, start.clone(), h);
                let square = |a: &State, b: &State| -> f64 {
                    a.x.iter().zip(&b.x).map(|(a, b)| (a - b).norm_squared()).sum()
                };
                let error = (square(&end, &exact) / square(&exact, &start.1)).sqrt();
                eprintln!(
                    "{stiffness:e} {form} h={h}: R {:.3} fall {:.3} e {error:.4e}",
                    path / exact_path,
                    fall / exact_fall
                );
            }
        }
    }
    for form in forms {
        let mut run = run(form, hanging(1e6, 40.0), H);
        run.steps(10);
        let begin = std::time::Instant::now();
        let reports = run.steps(50);
        let micros = begin.elapsed().as_micros() as f64 / 50.0;
        let mean = |of: fn(&drape_integrator::StepReport) -> u32| {
            reports.iter().map(|report| f64::from(of(report))).sum::<f64>() / 50.0
        };
        let (forces, products) = (mean(|r| r.force_evaluations), mean(|r| r.matvecs));
        let left = reports.last().map_or(f64::NAN, |report| report.relative_residual);
        eprintln!("cost {form}: {micros:.0} µs, {forces} forces, {products} products, {left:.1e}");
        for damping in [40.0, 0.0] {
            eprintln!("energy {form}, d/m={damping}: {:?}", energies(form, damping));
        }
    }
}
