//! The law on a sheet, and findings from facts.
#![allow(clippy::unwrap_used, reason = "tests")]

use super::law::{lever, swing_lever};
use crate::methods::Choice;
use crate::run::{Runner, Simulation};
use crate::studies::sheet::Sheet;
use drape_model::{DampingLaw, PinSpec, TimeSpan};

/// A sheet without shear springs that is held along its whole first row is a bundle of strings.
/// Then `u_j = j (2N − 1 − j)/2` at row `j` of `N`, since the pull on each link is the load below
/// it.
#[test]
fn the_lever_of_strings_is_a_parabola() {
    let side = 7;
    let sheet = Sheet {
        side,
        tension: 1e8,
        shear: 0.0,
        damping: 0.0,
        law: DampingLaw::Full,
        gravity: [0.0, 0.0, -9.81],
        is_pinned: false,
    };
    let mut spec = sheet.spec().unwrap();
    spec.pins = (0..side).map(PinSpec::still).collect();
    let (system, state) = spec.build().unwrap();
    let levers = lever(&system, 1e8);
    for (i, u) in levers.iter().enumerate() {
        let (j, n) = ((i as u32 / side) as f64, f64::from(side));
        assert!((u - 0.5 * j * (2.0 * n - 1.0 - j)).abs() < 1e-9, "{i}: {u}");
    }
    // On a fine mesh the share tends to π²/8 of the lowest mode's value.
    let share = levers[(side * side - 1) as usize] / swing_lever(side - 1);
    assert!((share - 1.2337).abs() < 0.25, "{share}");
    // After many steps the sheet falls at this speed.
    let mut simulation = Simulation { system, state };
    let choice = Choice::parse("imex-euler:forcing_term=1e-12,implicit=springs", &[]).unwrap();
    let (h, steps) = (0.1, 20);
    let time = TimeSpan { step_s: h, duration_s: h * f64::from(steps) };
    Runner::new(&choice, time).go(&mut simulation).unwrap();
    let expected = -9.81 * levers[(side * side - 1) as usize] / (h * 1e8);
    let speed = simulation.state.v[(side * side - 1) as usize].z;
    assert!((speed / expected - 1.0).abs() < 0.001, "{speed} for {expected}");
}
