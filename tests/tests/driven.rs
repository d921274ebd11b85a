//! Work that pins, obstacles and wind do is told from a gain of energy.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_harness::methods::Choice;
use drape_harness::studies;
use drape_harness::{Moment, Runner, Simulation, WorkBalance};
use drape_model::{KeyframeSpec, ObstacleSpec, State, System, SystemSpec, TimeSpan};
use drape_oracle::scenes::bundled;
use drape_tests::{METHODS, Sheet, assert_covers, build, takes};

fn frame(time_s: f64, offset_m: [f64; 3]) -> KeyframeSpec {
    KeyframeSpec { time_s, offset_m }
}

/// A sheet on two pins of which one is led up and about.
fn led() -> SystemSpec {
    let mut spec = Sheet { side: 6, ..Sheet::default() }.spec();
    spec.pins[0].path =
        vec![frame(0.1, [0.0, 0.0, 0.3]), frame(0.3, [0.3, 0.1, 0.3]), frame(0.5, [0.0, 0.0, 0.0])];
    spec
}

/// A sheet on two pins in a gusty wind.
fn blown() -> SystemSpec {
    let mut spec = Sheet { side: 6, ..Sheet::default() }.spec();
    spec.effects.air = bundled("flag").effects.air;
    spec
}

/// A sheet that a ball throws up.
fn thrown() -> SystemSpec {
    let mut spec = Sheet { side: 6, pinned: false, ..Sheet::default() }.spec();
    let path = vec![frame(0.4, [0.0, 0.0, 1.2])];
    let (center_m, radius_m) = ([0.07, 0.03, -0.35], 0.3);
    spec.obstacles =
        vec![ObstacleSpec::Sphere { center_m, radius_m, restitution: 0.0, friction: 0.0, path }];
    spec
}

/// Excess of the energy beside the work, and the greatest kinetic energy, J.
fn excess(id: &str, spec: &SystemSpec, time: TimeSpan) -> (Option<f64>, f64) {
    let (balance, kinetic) = watched(id, spec, time);
    (balance.excess(), kinetic)
}

/// A run beside the work on it, and its greatest kinetic energy, J.
fn watched(id: &str, spec: &SystemSpec, time: TimeSpan) -> (WorkBalance, f64) {
    let choice = Choice::parse(id, &[]).unwrap();
    let (system, state) = build(spec);
    let mut simulation = Simulation { system, state };
    let mut balance = WorkBalance::new(&simulation.system, &simulation.state);
    let mut kinetic = 0.0_f64;
    let look = |moment: &Moment<'_>| {
        balance.look(moment);
        kinetic = kinetic.max(moment.system.kinetic_energy(&moment.state.v));
    };
    let outcome = Runner::new(&choice, time).ledger().observe(look).go(&mut simulation).unwrap();
    assert_eq!(outcome.divergence, None, "{id}");
    (balance, kinetic)
}

/// The command warns above this share of the kinetic energy.
const SHARE: f64 = 0.02;

/// Methods that move particles by a correction after the step: nothing is said about their energy.
const CORRECTED: [&str; 4] = [
    "provot",
    "provot:limit=1e-3,sweeps=4,order=alternating,velocity=positions-only",
    "baraff-witkin:solver=cholesky,contact=position,implicit=tension",
    "desbrun:torque=none,inverse_dynamics=true,limit=1e-3",
];

/// It leaves out the force of compressed springs, whose energy counts.
const GAINS: [&str; 1] = ["terzopoulos-fleischer:clamp=true"];

#[test]
fn every_method_is_driven() {
    assert_covers("driven", METHODS, &[]);
    assert!(CORRECTED.iter().chain(&GAINS).all(|id| METHODS.contains(id)));
}

/// Where the step resolves the springs no method gains energy beside the work that comes in.
#[test]
fn work_from_outside_is_no_gain_of_energy() {
    let time = TimeSpan { step_s: 0.002, duration_s: 0.6 };
    for (scene, spec) in [("led", led()), ("blown", blown()), ("thrown", thrown())] {
        let (rise, _) = rise(&spec, time);
        assert!(rise > 0.01, "{scene}: nothing comes in: {rise} J");
        let (system, _) = build(&spec);
        let taken = METHODS.into_iter().filter(|id| takes(id, &system));
        for id in taken.filter(|id| !GAINS.contains(id)) {
            let (excess, kinetic) = excess(id, &spec, time);
            match excess {
                None => assert!(CORRECTED.contains(&id), "{id}, {scene}"),
                Some(excess) => {
                    let allowed = SHARE * kinetic;
                    assert!(excess < allowed, "{id}, {scene}: {excess:e} J of {kinetic:e} J");
                }
            }
        }
    }
}

/// Rise of the total energy with backward Euler, and the greatest kinetic energy, J.
fn rise(spec: &SystemSpec, time: TimeSpan) -> (f64, f64) {
    let (system, state) = build(spec);
    let energy = |system: &System, state: &State| {
        system.kinetic_energy(&state.v) + system.potential_energy(&state.x)
    };
    let (start, mut top, mut kinetic) = (energy(&system, &state), f64::NEG_INFINITY, 0.0_f64);
    let look = |moment: &Moment<'_>| {
        top = top.max(energy(moment.system, moment.state));
        kinetic = kinetic.max(moment.system.kinetic_energy(&moment.state.v));
    };
    let choice = Choice::parse("backward-euler", &[]).unwrap();
    Runner::new(&choice, time).observe(look).go(&mut Simulation { system, state }).unwrap();
    (top - start, kinetic)
}

/// At a step that does not resolve the springs a locked sheet pulls on a pin with forces that are
/// far from those of its positions. Baraff and Witkin's step does gain energy there.
#[test]
fn work_from_outside_is_no_gain_of_energy_on_a_stiff_sheet() {
    let mut spec = led();
    for spring in &mut spec.springs {
        spring.stiffness_n_per_m *= 500.0; // k/m = 1e6
    }
    let time = TimeSpan { step_s: 0.01, duration_s: 1.0 };
    for id in [
        "backward-euler",
        "bdf2",
        "desbrun",
        "imex-euler",
        "imex-updated",
        "imex-sbdf2",
        "imex-mcnab2",
    ] {
        let (excess, kinetic) = excess(id, &spec, time);
        let excess = excess.unwrap();
        assert!(excess < SHARE * kinetic, "{id}: {excess:e} J of {kinetic:e} J");
    }
}

#[test]
fn a_gain_of_energy_is_seen_beside_a_pin_on_a_path() {
    let mut spec = bundled("hanging-textile-1e6");
    spec.pins[0].path = vec![frame(1.0, [0.0; 3])];
    let time = TimeSpan { step_s: 0.01, duration_s: 1.0 };
    let (balance, kinetic) = watched("imex-updated:paper,forcing_term=0.1", &spec, time);
    let (gained, sure) = (balance.excess().unwrap(), balance.sure_excess().unwrap());
    assert!(sure > 100.0 && sure > SHARE * kinetic, "{sure} J of {kinetic} J");
    assert!(sure <= gained, "{sure} J, {gained} J");
}

/// The upper edge of a sheet goes to and fro, so that all pins move as one. They move evenly for a
/// 24th of a second, and so start anew 24 times a second.
fn edge_led() -> SystemSpec {
    let start = studies::start("animation/led, cotton-blend, light, n=400, 24 Hz, 4 s");
    let mut spec = start.unwrap().unwrap().system().unwrap();
    for pin in &mut spec.pins {
        pin.path.retain(|key| {
            (24.0 * key.time_s).fract().min(1.0 - (24.0 * key.time_s).fract()) < 1e-6
        });
        assert_eq!(pin.path.len(), 96);
    }
    spec
}

fn steps(number: u32) -> TimeSpan {
    TimeSpan { step_s: 1.0 / f64::from(number), duration_s: 1.0 }
}

/// The momentum of the cloth tells the work of pins that move as one, however much the force on
/// them changes within a step. The method divides the long step.
#[test]
fn work_of_pins_that_move_as_one_is_known_in_long_steps() {
    for (id, number) in [("xpbd-lines:substeps=20", 24), ("xpbd-lines:substeps=1", 480)] {
        let (excess, kinetic) = excess(id, &edge_led(), steps(number));
        let excess = excess.unwrap();
        assert!(excess < SHARE * kinetic, "{id}: {excess:e} J of {kinetic:e} J");
    }
}

/// With an obstacle in the scene, momentum tells nothing, and the force on the pins changes within a
/// step. What looks like a gain is not sure, and shorter steps show that it is none.
#[test]
fn work_that_is_not_known_is_no_sure_gain() {
    let mut spec = edge_led();
    let (center_m, radius_m) = ([0.0, 0.0, -9.0], 0.3);
    let path = Vec::new();
    spec.obstacles =
        vec![ObstacleSpec::Sphere { center_m, radius_m, restitution: 0.0, friction: 0.0, path }];
    let (balance, kinetic) = watched("xpbd-lines:substeps=1", &spec, steps(96));
    let (seems, sure) = (balance.excess().unwrap(), balance.sure_excess().unwrap());
    assert!(seems > SHARE * kinetic, "{seems} J of {kinetic} J");
    assert!(sure < SHARE * kinetic, "{sure} J of {kinetic} J");
    let (excess, kinetic) = excess("xpbd-lines:substeps=1", &spec, steps(960));
    let excess = excess.unwrap();
    assert!(excess < SHARE * kinetic, "{excess} J of {kinetic} J");
}
