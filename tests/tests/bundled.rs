//! The bundled scenes, run as they come.

use drape_harness::methods::{self, Choice};
use drape_harness::{HarnessError, Runner, Simulation};
use drape_integrator::PrepareError;
use drape_model::{SceneFile, System, SystemSpec, TimeSpan, bundled, load};
use drape_tests::drape::drape;
use drape_tests::{build, largest, prepared};

/// Acceleration of gravity, m/s².
const G: f64 = 9.81;

fn scene(name: &str) -> SceneFile {
    load(name).unwrap_or_else(|error| panic!("{error}"))
}

/// Whether energy comes in from outside, by wind or by what is led on paths.
fn is_driven(spec: &SystemSpec, system: &System) -> bool {
    spec.effects.air.is_some_and(|air| air.wind.is_some())
        || !system.moving_pins().is_empty()
        || system.obstacles().iter().any(|obstacle| obstacle.path.is_some())
}

#[test]
fn every_bundled_scene_runs_for_a_second_and_gains_no_energy_that_nobody_brings() {
    for name in bundled::names() {
        let input = scene(name);
        let h = input.scene().map_or(0.01, |scene| scene.time.step_s);
        let (system, start) = build(input.spec());
        let is_driven = is_driven(input.spec(), &system);
        let weight = G * system.mass().iter().sum::<f64>();
        let before = system.total_energy(&start);
        let mut run = prepared("imex-euler", (system, start.clone()), h);
        for step in 0..(1.0 / h).ceil() as u32 {
            run.step();
            // Half a per cent of what a fall by the cloth's own size sets free.
            let most = before + 0.005 * (weight + before.abs());
            assert!(run.energy().is_finite() && run.state.is_finite(), "{name}, step {step}");
            assert!(
                run.energy() <= most || is_driven,
                "{name}: {} J after {before} J, step {step}",
                run.energy()
            );
        }
        let far = largest(&start.x) + largest(&start.v) + 0.5 * G;
        assert!(largest(&run.state.x) <= far, "{name} is {} m off", largest(&run.state.x));
    }
}

#[test]
fn a_stiffer_cloth_has_a_greater_drape_coefficient() {
    let [limp, plain, stiff] =
        [1.5e-6, 9e-6, 6e-4].map(|rigidity| drape(rigidity, "backward-euler", 0.005, 2.0));
    for found in [limp, plain, stiff] {
        assert!(found.speed < 1e-4, "at rest: {} m/s", found.speed);
    }
    let [limp, plain, stiff] = [limp, plain, stiff].map(|found| found.coefficient);
    // The classes of BS 5058:1973: limp below 0.30, stiff above 0.85.
    assert!(0.1 < limp && limp < 0.3 && 0.85 < stiff && stiff < 1.0, "{limp} {stiff}");
    assert!((plain - 0.449).abs() < 0.005, "{plain}");
    // What is at rest does not know by which method it came there.
    let other = drape(9e-6, "baraff-witkin", 0.005, 2.0).coefficient;
    assert!((plain - other).abs() < 1e-3, "{plain} {other}");
}

/// Scenes that are stretched at their start, which their descriptions name.
const STRESSED: [&str; 0] = [];

/// Energy that springs and hinges hold at the start would drown what gravity sets free.
#[test]
fn bundled_scenes_begin_without_stress() {
    for name in bundled::names() {
        let (system, state) = build(scene(name).spec());
        let weight: f64 = system.mass().iter().sum::<f64>() * 9.81; // J for a metre
        let stores = |effect: &str| effect != "gravity";
        let energies = system.energies(&state.x).filter(|(effect, _)| stores(effect));
        let stored: f64 = energies.map(|(_, energy)| energy).sum();
        let is_stressed = stored > 1e-12 * weight;
        assert_eq!(is_stressed, STRESSED.contains(&name), "{name}: {stored:e} J");
    }
}

/// Methods that take springs at the old level: their steps must be short.
const EXPLICIT: [&str; 8] = [
    "explicit-euler",
    "symplectic-euler",
    "leapfrog",
    "provot",
    "adams-bashforth2",
    "rkc",
    "srkn4",
    "multirate",
];

#[test]
fn every_bundled_scene_runs_with_every_method_or_is_refused_by_name() {
    for name in bundled::names() {
        let input = scene(name);
        let (system, start) = build(input.spec());
        let usual = input.scene().map_or(0.01, |scene| scene.time.step_s);
        for method in methods::all() {
            let step_s = if EXPLICIT.contains(&method.id) { 5e-4 } else { usual };
            let choice = Choice::parse(method.id, &[]).unwrap_or_else(|error| panic!("{error}"));
            let mut run = Simulation { system: system.clone(), state: start.clone() };
            let time = TimeSpan { step_s, duration_s: 20.0 * step_s };
            let says = format!("{name}, {}", method.id);
            match Runner::new(&choice, time).go(&mut run) {
                Ok(outcome) => match outcome.divergence {
                    None => assert!(run.state.is_finite() && outcome.steps == 20, "{says}"),
                    Some(divergence) => {
                        let text = &divergence.criterion;
                        assert!(divergence.step >= 1 && !text.is_empty(), "{says}: {text}");
                        assert!(method.id != "backward-euler", "{says} diverged: {text}");
                    }
                },
                Err(HarnessError::Prepare(PrepareError::Unsupported {
                    method: id, what, ..
                })) => {
                    assert!(id == method.id && !what.is_empty(), "{says}: {what}");
                }
                Err(error) => panic!("{says}: {error}"),
            }
        }
    }
}

#[test]
fn a_free_sheet_spins_on_where_the_method_lets_it() {
    let input = scene("spinning-sheet");
    let (system, start) = build(input.spec());
    let spin = system.angular_momentum(&start).norm();
    let left = |method: &str, h: f64| {
        let mut run = prepared(method, (system.clone(), start.clone()), h);
        run.steps((1.0 / h) as usize);
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
