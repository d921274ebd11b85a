//! The hanging sheet of 20 × 20 particles.

use super::{NAMES, boxed, run};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::checks::{Hung, Known};
use drape_oracle::scenes::{Sheet, waving};

/// The first 0.3 s of the sheet.
fn hanging(tension: f64, damping: f64) -> Known {
    let settings = AdaptiveSettings { tolerance: 1e-10, ..AdaptiveSettings::default() };
    Known::with(Sheet::hanging(tension, damping).build(), 0.3, settings)
}

/// One step size of the table of the documentation.
#[test]
fn the_hanging_sheet_moves_as_the_independent_program_says() {
    let known = hanging(1e6, 40.0);
    assert!((known.middle().z + 0.441376).abs() < 1e-6);
    let golden = [(1.5747e-1, 0.960), (1.3247e-1, 1.012), (6.4759e-2, 0.993), (9.3684e-3, 1.009)];
    for ((name, _), (error, fall)) in NAMES.into_iter().zip(golden) {
        let found = known.hang(boxed(&format!("tableau={name}")), 0.01);
        assert!((found.error / error - 1.0).abs() < 1e-3, "{name}: {found:?}");
        assert!((found.fall - fall).abs() < 1e-3, "{name}: {found:?}");
    }
}

#[test]
#[ignore = "measures the table of the documentation"]
#[expect(clippy::print_stdout, reason = "prints the table")]
fn errors_of_the_hanging_sheet() {
    for (tension, damping) in [(1e4, 40.0), (1e6, 40.0), (1e8, 40.0), (1e6, 1e3)] {
        let known = hanging(tension, damping);
        println!("k/m={tension:e}, d/m={damping}: z = {}", known.middle().z);
        for (name, _) in NAMES {
            for h in [0.03, 0.01, 0.005, 0.0025] {
                let Hung { error, path, fall } = known.hang(boxed(&format!("tableau={name}")), h);
                println!("  {name} h={h}: e = {error:.4e}, path {path:.6}, R_fall {fall:.4}");
            }
        }
    }
}

/// Greatest rise and last change of the energy in 2 s, J; the sheet weighs 3.92 N.
#[test]
fn the_energy_of_the_hanging_sheet_falls_with_ars222_and_explodes_with_ark4() {
    for (damping, ends) in [(40.0, [-1.928, -1.956, -0.7121]), (0.0, [-1.896, -1.954, 2.916])] {
        for (k, (name, _)) in NAMES.into_iter().enumerate() {
            let mut run =
                run(&format!("tableau={name}"), Sheet::hanging(1e6, damping).build(), 0.01);
            let start = run.energy();
            let mut rise = 0.0_f64;
            for _ in 0..200 {
                run.step();
                rise = rise.max(run.energy() - start);
            }
            let end = run.energy() - start;
            match ends.get(k) {
                Some(expected) => {
                    assert!((end - expected).abs() < 1e-2, "{name}, {damping}: {end}")
                }
                None => assert!(rise > 1e4, "{name}, {damping}: {rise}"),
            }
            assert!(name != "ars222" || rise == 0.0, "{name}, {damping}: {rise}");
        }
    }
}

/// The errors at 20 and 160 steps and the order of the last halving, from an independent program.
#[test]
fn errors_on_a_smooth_scene_match_the_golden_table() {
    let sheet = Sheet { side: 6, tension: 1e3, shear: 100.0, damping: 5.0, ..Sheet::default() };
    let known = Known::new(waving(sheet.build()), 0.2);
    let golden = [
        (1.3812e-03, 2.1479e-05, 2.00),
        (4.7026e-04, 1.5766e-06, 2.94),
        (1.9448e-04, 3.1753e-07, 3.05),
        (9.7745e-06, 2.9368e-09, 3.97),
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
