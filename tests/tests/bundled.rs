//! The bundled scenes, run as they come.

use drape_model::{Input, State, System, Vec3, bundled, drape_coefficient, load, projected_area};
use drape_tests::{Run, build};
use std::f64::consts::PI;

/// Acceleration of gravity, m/s².
const G: f64 = 9.81;

fn scene(name: &str) -> Input {
    load(name).unwrap_or_else(|error| panic!("{error}"))
}

fn reach(x: &[Vec3]) -> f64 {
    x.iter().map(|x| x.norm()).fold(0.0, f64::max)
}

#[test]
fn every_bundled_scene_runs_for_a_second_without_gaining_energy() {
    for name in bundled::names() {
        let input = scene(name);
        let h = input.scene().map_or(0.01, |scene| scene.time.step_s);
        let (system, start) = build(input.spec());
        let weight = G * system.mass().iter().sum::<f64>();
        let before = system.total_energy(&start);
        let mut run = Run::new("imex-euler", (system, start.clone()), h);
        for step in 0..(1.0 / h).ceil() as u32 {
            run.step();
            // Half a per cent of what a fall by the cloth's own size sets free.
            let most = before + 0.005 * (weight + before.abs());
            assert!(
                run.energy() <= most,
                "{name}: {} J after {before} J, step {step}",
                run.energy()
            );
        }
        let far = reach(&start.x) + reach(&start.v) + 0.5 * G;
        assert!(reach(&run.state.x) <= far, "{name} is {} m off", reach(&run.state.x));
    }
}

/// The drape coefficient after `seconds`, with bending springs stiffer by a factor.
fn draped(seconds: f64, factor: f64) -> f64 {
    let Input::Scene(mut scene, _) = scene("drape-test") else { panic!("a scene") };
    let bending = scene.effects.bending.as_mut();
    let stiffness = bending.and_then(|law| law.stiffness_n_per_m.as_mut());
    *stiffness.unwrap_or_else(|| panic!("bending springs")) *= factor;
    let spec = scene.discretise().unwrap_or_else(|violation| panic!("{violation}"));
    let (system, start): (System, State) = build(&spec);
    let specimen = projected_area(&start.x, &spec.triangles);
    let h = scene.time.step_s;
    let mut run = Run::new("imex-euler", (system, start), h);
    for _ in 0..(seconds / h) as u32 {
        run.step();
    }
    drape_coefficient(projected_area(&run.state.x, &spec.triangles), PI * 0.09 * 0.09, specimen)
}

#[test]
fn a_stiffer_cloth_has_a_greater_drape_coefficient() {
    let [limp, plain, stiff] = [0.0, 1.0, 20.0].map(|factor| draped(1.0, factor));
    assert!(
        0.1 < limp && limp + 0.005 < plain && plain + 0.05 < stiff && stiff < 0.9,
        "{limp} {plain} {stiff}"
    );
}

#[test]
fn a_free_sheet_spins_on_where_the_method_lets_it() {
    let input = scene("spinning-sheet");
    let (system, start) = build(input.spec());
    let spin = system.angular_momentum(&start).norm();
    let left = |method: &str, h: f64| {
        let mut run = Run::new(method, (system.clone(), start.clone()), h);
        for _ in 0..(1.0 / h) as u32 {
            run.step();
        }
        system.angular_momentum(&run.state).norm() / spin
    };
    assert!((left("symplectic-euler", 2e-4) - 1.0).abs() < 1e-12, "momenta are conserved");
    let updated = left("imex-updated", 0.01);
    assert!((0.8..0.95).contains(&updated), "{updated}");
    assert!(
        left("imex-euler", 0.01) < 1e-3,
        "without updates the directions of the springs lag behind"
    );
}
