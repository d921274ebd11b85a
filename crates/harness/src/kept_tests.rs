//! Cloths that lock, cloths that do not, and cloths that need not move.

use super::*;
use crate::OrderedSimulation;
use crate::methods;
use drape_integrator::Supports;
use drape_model::{PinSpec, SpringEffect, SystemSpec};
use drape_oracle::scenes::{gravity, particles, pin, spring};

fn kept_of(spec: &SystemSpec, method: &str, step_s: f64, duration_s: f64) -> Kept {
    let choice = Choice::parse(method, &[]).unwrap();
    let mut simulation = OrderedSimulation::new(spec, &choice).unwrap();
    let time = TimeSpan { step_s, duration_s };
    let mut check = simulation.motion_check((duration_s / step_s).round() as u64);
    let run = simulation.simulate(time, |runner| runner.observe(|moment| check.look(moment)));
    let outcome = run.unwrap();
    assert!(outcome.divergence.is_none(), "{method}");
    simulation.kept(&check, outcome.effort)
}

fn share(scene: &str, method: &str, step_s: f64, duration_s: f64) -> f64 {
    let input = drape_model::load(scene).unwrap();
    match kept_of(input.spec(), method, step_s, duration_s) {
        Kept::Share { share, .. } => share,
        other => panic!("{scene} {method}: {other:?}"),
    }
}

/// On such a sheet the study `locking` measures 0.67 of the path at a step of 0.2 ms.
#[test]
fn a_stiff_sheet_locks_under_imex_euler_at_long_steps_alone() {
    for scene in ["hanging-textile-1e6", "hanging-wool"] {
        let locked = share(scene, "imex-euler", 0.01, 1.0);
        assert!(locked < 0.35, "{scene}: {locked}");
        let kept = share(scene, "imex-updated", 0.01, 1.0);
        assert!((0.75..1.5).contains(&kept), "{scene}: {kept}");
    }
    let kept = share("hanging-textile-1e6", "imex-euler", 2e-4, 0.2);
    assert!((0.6..0.8).contains(&kept), "{kept}");
}

/// On a soft sheet every method moves, and none may be called locked.
#[test]
fn no_method_is_called_locked_where_it_is_not() {
    let mut said = String::new();
    for method in methods::all().filter(|method| method.supports != Supports::Explicit) {
        let kept = share("hanging-textile-1e4", method.id, 0.005, 0.6);
        said += &format!("{} {kept:.3}\n", method.id);
    }
    let least = said.lines().filter_map(|line| line.split(' ').nth(1)?.parse::<f64>().ok());
    assert!(least.fold(f64::INFINITY, f64::min) > 0.6, "{said}");
}

fn pair(stretch: f64, gravity_on: bool) -> SystemSpec {
    let places = [Vec3::zeros(), Vec3::new(0.0, 0.0, -1.0 - stretch)];
    let mut spec = particles(&[1e-3; 2], &places, &[Vec3::zeros(); 2]);
    spec.springs = vec![spring(SpringEffect::Tension, (0, 1), 1.0, 1e3, 0.0)];
    spec.pins = vec![pin(0)];
    spec.effects.gravity = if gravity_on { gravity() } else { None };
    spec
}

#[test]
fn a_cloth_in_balance_moves_in_no_window() {
    assert_eq!(kept_of(&pair(0.0, false), "imex-euler", 0.01, 1.0), Kept::Still);
    let weight = 9.81 * 1e-3 / 1e3;
    assert_eq!(kept_of(&pair(weight, true), "imex-euler", 0.01, 1.0), Kept::Still);
    // The jerk at the start is a vibration of 10 µm, which does not count as a motion.
    assert_eq!(kept_of(&pair(0.0, true), "imex-euler", 0.01, 1.0), Kept::Still);
}

#[test]
fn particles_without_springs_fall_freely() {
    let mut spec = pair(0.0, true);
    spec.springs.clear();
    spec.pins = Vec::<PinSpec>::new();
    let Kept::Share { share, windows, steps } = kept_of(&spec, "imex-euler", 0.01, 1.0) else {
        panic!("they fall")
    };
    assert!((share - 1.0).abs() < 0.15, "{share}");
    assert_eq!((windows, steps), (3, LONG));
}

#[test]
fn what_cannot_be_checked_is_told() {
    let short = kept_of(&pair(0.0, true), "imex-euler", 0.01, 0.01);
    assert_eq!(short, Kept::Unknown(Silent::Short));
    let mut stiff = pair(0.0, true);
    stiff.springs[0].stiffness_n_per_m = 1e20;
    let costly = kept_of(&stiff, "imex-euler", 0.01, 0.5);
    assert_eq!(costly, Kept::Unknown(Silent::Costly));
}
