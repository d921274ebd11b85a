//! The hanging sheet of 20 × 20 particles.

use super::{NAMES, method, run};
use drape_integrator::Integrator;
use drape_model::{State, System, Vec3};
use drape_oracle::order::{of_method, position_error};
use drape_oracle::reference::{Reference, ReferenceSettings, reference};
use drape_oracle::scenes::Sheet;

fn sheet(tension: f64, damping: f64) -> (System, State) {
    Sheet { side: 20, tension, shear: 0.1 * tension, damping, ..Sheet::default() }.build()
}

/// The motion of the midpoint of the free edge.
fn midpoint(x: &[Vec3]) -> Vec3 {
    (x[389] + x[390]) * 0.5
}

/// Error after 0.3 s, length of the path of the midpoint and its height.
fn hang(text: &str, start: &(System, State), exact: &Reference, h: f64) -> [f64; 3] {
    let mut run = run(text, start.clone(), h);
    let mut path = 0.0;
    for _ in 0..(0.3 / h).round() as usize {
        let before = midpoint(&run.state.x);
        run.step();
        path += (midpoint(&run.state.x) - before).norm();
    }
    let error = position_error(&run.system, &start.1.x, &exact.states[0].x, &run.state.x);
    [error, path, midpoint(&run.state.x).z / midpoint(&exact.states[0].x).z]
}

/// One step size of the table of the documentation.
#[test]
fn the_hanging_sheet_moves_as_the_independent_program_says() {
    let start = sheet(1e6, 40.0);
    let settings = ReferenceSettings { tolerance: 1e-10, ..ReferenceSettings::default() };
    let exact = reference(&start.0, &start.1, &[0.3], settings).expect("exact");
    assert!((midpoint(&exact.states[0].x).z + 0.441376).abs() < 1e-6);
    let golden = [(1.5747e-1, 0.960), (1.3247e-1, 1.012), (6.4759e-2, 0.993), (9.3684e-3, 1.009)];
    for ((name, _), (error, fall)) in NAMES.into_iter().zip(golden) {
        let found = hang(&format!("tableau={name}"), &start, &exact, 0.01);
        assert!((found[0] / error - 1.0).abs() < 1e-3, "{name}: {found:?}");
        assert!((found[2] - fall).abs() < 1e-3, "{name}: {found:?}");
    }
}

#[test]
#[ignore = "measures the table of the documentation"]
#[expect(clippy::print_stdout, reason = "prints the table")]
fn errors_of_the_hanging_sheet() {
    for (tension, damping) in [(1e4, 40.0), (1e6, 40.0), (1e8, 40.0), (1e6, 1e3)] {
        let start = sheet(tension, damping);
        let settings = ReferenceSettings { tolerance: 1e-10, ..ReferenceSettings::default() };
        let exact = reference(&start.0, &start.1, &[0.3], settings).expect("exact");
        println!("k/m={tension:e}, d/m={damping}: z = {}", midpoint(&exact.states[0].x).z);
        for (name, _) in NAMES {
            for h in [0.03, 0.01, 0.005, 0.0025] {
                let [error, path, fall] = hang(&format!("tableau={name}"), &start, &exact, h);
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
            let mut run = run(&format!("tableau={name}"), sheet(1e6, damping), 0.01);
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

/// A smooth scene: a stretched sheet with smooth velocities, the corner of the sheet as origin.
fn smooth() -> (System, State) {
    let sheet = Sheet { side: 6, tension: 1e3, shear: 100.0, damping: 5.0, ..Sheet::default() };
    let (system, mut state) = sheet.build();
    let corner = Vec3::new(0.5, 0.5, 0.0);
    for i in (0..36).filter(|&i| !system.pinned()[i]) {
        let at = state.x[i] + corner;
        let (x, y): (f64, f64) = (at.x, at.y);
        state.x[i] = Vec3::new(1.03 * x, 0.98 * y, 0.02 * (3.0 * y + 1.0).sin()) - corner;
        state.v[i] = Vec3::new((2.0 * y).sin(), x, (3.0 * x).cos()) * 0.3;
    }
    (system, state)
}

/// The errors at 20 and 160 steps and the order of the last halving, from an independent program.
#[test]
fn errors_on_a_smooth_scene_match_the_golden_table() {
    let (system, start) = smooth();
    let exact = reference(&system, &start, &[0.2], ReferenceSettings::default()).expect("exact");
    let golden = [
        (1.3812e-03, 2.1479e-05, 2.00),
        (4.7026e-04, 1.5766e-06, 2.94),
        (1.9448e-04, 3.1753e-07, 3.05),
        (9.7745e-06, 2.9368e-09, 3.97),
    ];
    for ((name, _), (coarse, fine, order)) in NAMES.into_iter().zip(golden) {
        let text = format!("tableau={name}");
        let new = || Box::new(method(&text)) as Box<dyn Integrator>;
        let end = of_method(new, &system, &start, &exact, &[80, 160]).expect("an order");
        assert!((end.finest.error / fine - 1.0).abs() < 1e-3, "{name}: {end:?}");
        assert!((end.order - order).abs() < 0.01, "{name}: {end:?}");
        let begin = of_method(new, &system, &start, &exact, &[10, 20]).expect("an order");
        assert!((begin.finest.error / coarse - 1.0).abs() < 1e-3, "{name}: {begin:?}");
    }
}
