//! The hanging sheet of 20 × 20 particles.

use super::{NAMES, boxed, run};
use drape_integrator::SolveStatus;
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::checks::{Hung, Known};
use drape_oracle::scenes::{Sheet, waving};

const FORMS: [&str; 7] = [
    "ros2",
    "ros3p",
    "rodas3",
    "ros34pw2",
    "rodas4",
    "ros2,jacobian=clamped",
    "ros34pw2,jacobian=clamped",
];

/// The first 0.3 s of the sheet.
fn hanging(tension: f64, damping: f64) -> Known {
    let settings = AdaptiveSettings { tolerance: 1e-10, ..AdaptiveSettings::default() };
    Known::with(Sheet::hanging(tension, damping).build(), 0.3, settings)
}

/// One step size of the table of the documentation.
#[test]
fn the_hanging_sheet_moves_as_the_independent_program_says() {
    let known = hanging(1e6, 40.0);
    let golden = [
        ("ros2", 2.5007e-3),
        ("ros3p", 2.0818e-3),
        ("rodas3", 1.2153e-3),
        ("rodas4", 3.0462e-5),
        ("ros2,jacobian=clamped", 2.5383e-3),
        ("ros34pw2,jacobian=clamped", 1.0099e-3),
    ];
    for (name, error) in golden {
        let found = known.hang(boxed(&format!("tableau={name}")), 0.01);
        assert!((found.error / error - 1.0).abs() < 1e-3, "{name}: {found:?}");
        assert!((found.fall - 1.0).abs() < 1e-3, "{name}: {found:?}");
    }
}

#[test]
#[ignore = "measures the table of the documentation"]
#[expect(clippy::print_stdout, reason = "prints the table")]
fn errors_of_the_hanging_sheet() {
    for tension in [1e4, 1e6, 1e8] {
        let known = hanging(tension, 40.0);
        println!("k/m={tension:e}: z = {}", known.middle().z);
        for name in FORMS {
            for h in [0.03, 0.01, 0.005, 0.0025] {
                let Hung { error, path, fall } = known.hang(boxed(&format!("tableau={name}")), h);
                println!("  {name} h={h}: e = {error:.4e}, path {path:.6}, R_fall {fall:.4}");
            }
        }
    }
}

/// Greatest rise and last change of the energy in 2 s, J; the sheet weighs 3.92 N.
#[test]
#[ignore = "measures the table of the documentation"]
#[expect(clippy::print_stdout, reason = "prints the table")]
fn energy_of_the_hanging_sheet() {
    for damping in [40.0, 0.0] {
        for name in FORMS {
            let mut run =
                run(&format!("tableau={name}"), Sheet::hanging(1e6, damping).build(), 0.01);
            let start = run.energy();
            let (mut rise, mut steps, mut unusual) = (0.0_f64, 0, 0);
            while steps < 200 && run.state.is_finite() {
                let Ok(report) = run.try_step() else { break };
                rise = rise.max(run.energy() - start);
                unusual += u32::from(report.solve != SolveStatus::Converged);
                steps += 1;
            }
            let end = run.energy() - start;
            println!(
                "{name} d/m={damping}: rise {rise:.4e}, end {end:.4e}, {steps} steps, {unusual}"
            );
        }
    }
}

/// The errors at 20 and 160 steps and the order of the last halving, from an independent program.
#[test]
fn errors_on_a_smooth_scene_match_the_golden_table() {
    let sheet = Sheet { side: 6, tension: 1e3, shear: 100.0, damping: 5.0, ..Sheet::default() };
    let known = Known::new(waving(sheet.build()), 0.2);
    let golden = [
        (2.9750e-04, 4.7813e-06, 1.99),
        (1.2041e-04, 3.0060e-07, 2.95),
        (3.4409e-05, 7.4106e-08, 2.98),
        (3.9129e-05, 8.8071e-08, 2.98),
        (6.9249e-07, 1.6909e-10, 4.00),
    ];
    for ((name, _), (coarse, fine, order)) in NAMES.into_iter().zip(golden) {
        let new = || boxed(&format!("tableau={name}"));
        let end = known.order(new, &[80, 160]);
        assert!((end.finest.error / fine - 1.0).abs() < 1e-3, "{name}: {end:?}");
        assert!((end.order - order).abs() < 0.01, "{name}: {end:?}");
        let begin = known.order(new, &[10, 20]);
        assert!((begin.finest.error / coarse - 1.0).abs() < 1e-3, "{name}: {begin:?}");
    }
}
