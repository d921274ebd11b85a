//! Springs with piecewise-linear tension: what each split promises, and what it does not.

use crate::{ImexEuler, ImexEulerSettings, ImexUpdated, ImexUpdatedSettings};
use drape_integrator::{Integrator, PhaseClock, StepReport, TimeStep};
use drape_model::{State, System};
use drape_oracle::Random;

const H: f64 = 0.01;

/// A free sheet of 5 × 5 particles of 1 g, 0.25 m apart. Its tension springs have the stiffness `k`
/// (N/m) up to 5 % of strain and `ratio k` beyond.
fn sheet(k: f64, ratio: f64, damping: f64) -> (System, State) {
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "sheet",
            "cloth": {{ "grid": {{ "rows": 5, "columns": 5, "size_m": [1, 1],
                "center_m": [0, 0, 0], "mass_kg": 0.025 }} }},
            "effects": {{ "tension": {{ "damping_n_s_per_m": {damping}, "pieces": [
                {{ "up_to_strain": 0.05, "stiffness_n_per_m": {k} }},
                {{ "stiffness_n_per_m": {} }}] }} }},
            "time": {{ "step_s": 0.01, "duration_s": 1 }} }}"#,
        ratio * k
    );
    let input = drape_model::parse("sheet", &text).unwrap_or_else(|error| panic!("{error}"));
    input.spec().build().unwrap_or_else(|violation| panic!("{violation}"))
}

fn euler(pairs: &[(&str, &str)]) -> ImexEuler {
    let settings = ImexEulerSettings::from_pairs(pairs.iter().copied());
    ImexEuler::new(settings.unwrap_or_else(|error| panic!("{error}")))
}

fn updated(pairs: &[(&str, &str)]) -> ImexUpdated {
    let settings = ImexUpdatedSettings::from_pairs(pairs.iter().copied());
    ImexUpdated::new(settings.unwrap_or_else(|error| panic!("{error}")))
}

/// Takes steps and shows each to `look`.
fn run(
    method: &mut dyn Integrator,
    (system, state): &mut (System, State),
    steps: usize,
    mut look: impl FnMut(&System, &State, &StepReport),
) {
    let h = TimeStep::new(H).unwrap_or_else(|error| panic!("{error}"));
    method.prepare(system, h).unwrap_or_else(|error| panic!("{error}"));
    for _ in 0..steps {
        let report = method.step(system, state, h, &mut PhaseClock::off());
        look(system, state, &report.unwrap_or_else(|error| panic!("{error}")));
    }
}

fn energy(system: &System, state: &State) -> f64 {
    system.kinetic_energy(&state.v) + system.potential_energy(&state.x)
}

fn shake(state: &mut State, random: &mut Random, way: f64, speed: f64) {
    for (x, v) in state.x.iter_mut().zip(&mut state.v) {
        *x += random.vector() * way;
        *v += random.vector() * speed;
    }
}

/// Greatest energy of a run over its energy at the start, and the number of matrices rebuilt.
fn peak(split: &str, ratio: f64) -> (f64, u64) {
    let mut start = sheet(1.0, ratio, 0.0);
    shake(&mut start.1, &mut Random::new(3), 0.0, 3.0);
    let first = energy(&start.0, &start.1);
    let (mut most, mut rebuilt) = (0.0_f64, 0);
    let mut method = euler(&[("solver", "cholesky"), ("split", split)]);
    run(&mut method, &mut start, 300, |system, state, report| {
        most = most.max(energy(system, state) / first);
        rebuilt += u64::from(report.setups.stiffness);
    });
    (most, rebuilt)
}

#[test]
fn with_the_steepest_slopes_in_the_matrix_no_exact_step_gains_energy() {
    let mut random = Random::new(17);
    let mut steps = 0;
    for ratio in [0.01, 1.0, 10.0, 1e2, 1e4] {
        for theta in [1e-3, 1.0, 1e3, 1e6] {
            for damping in [0.0, 1e-3] {
                let mut start = sheet(theta * 1e-3 / (H * H), ratio, damping);
                shake(&mut start.1, &mut random, 0.1, 3.0);
                let first = energy(&start.0, &start.1);
                let mut last = first;
                let mut method = euler(&[("solver", "cholesky")]);
                run(&mut method, &mut start, 50, |system, state, report| {
                    let next = energy(system, state);
                    assert!(
                        next <= last + 1e-10 * first,
                        "θ={theta}, 1 : {ratio}: {last} → {next}"
                    );
                    assert_eq!(report.setups.stiffness, 0);
                    last = next;
                    steps += 1;
                });
            }
        }
    }
    assert_eq!(steps, 2000);
}

#[test]
fn with_the_present_slopes_in_the_matrix_energy_comes_in_where_the_next_piece_is_steep() {
    let (paper, rebuilt) = peak("paper", 1e4);
    let (majorant, kept) = peak("majorant", 1e4);
    assert!(paper > 2.0 && rebuilt > 10, "{paper} in {rebuilt} matrices");
    assert!(majorant <= 1.0 + 1e-9 && kept == 0, "{majorant} in {kept} matrices");
}

/// The fixed point is backward Euler, whatever stiffness is split off.
#[test]
fn converged_updates_agree_whatever_the_split() {
    let end = |split: &str, solver: &str| {
        let mut start = sheet(10.0, 10.0, 1e-3);
        shake(&mut start.1, &mut Random::new(5), 0.05, 1.0);
        let pairs = [
            ("split", split),
            ("solver", solver),
            ("forcing_term", "1e-10"),
            ("max_outer", "100000"),
            ("newton_above", "1e9"),
        ];
        run(&mut updated(&pairs), &mut start, 5, |_, _, _| ());
        start.1.x
    };
    let reference = end("majorant", "cg");
    for (split, solver) in [("majorant", "cholesky"), ("paper", "cg"), ("paper", "cholesky")] {
        let other = end(split, solver);
        let apart = other.iter().zip(&reference).map(|(a, b)| (a - b).norm());
        let apart = apart.fold(0.0, f64::max);
        assert!(apart < 1e-7, "{split}, {solver}: {apart:e}");
    }
}

#[test]
fn for_linear_springs_the_splits_are_the_same_bits_and_nothing_is_rebuilt() {
    let run = |split: &str| {
        let text =
            drape_model::load("hanging-textile-1e4").unwrap_or_else(|error| panic!("{error}"));
        let mut start = text.spec().build().unwrap_or_else(|violation| panic!("{violation}"));
        let mut evaluations = 0;
        run(&mut euler(&[("split", split)]), &mut start, 20, |_, _, report| {
            evaluations += report.force_evaluations;
            assert_eq!(report.setups.stiffness, 0);
        });
        (start.1, evaluations)
    };
    let (a, b) = (run("majorant"), run("paper"));
    assert_eq!((a.0.x, a.0.v, a.1), (b.0.x, b.0.v, b.1));
}

/// With both splits the ledger explains the change of energy to round-off.
#[test]
fn the_ledger_explains_every_step_of_either_split() {
    for split in ["majorant", "paper"] {
        for kind in ["euler", "updated"] {
            let mut start = sheet(10.0, 100.0, 1e-3);
            shake(&mut start.1, &mut Random::new(9), 0.05, 1.0);
            let pairs = [("split", split), ("solver", "cholesky")];
            let mut method: Box<dyn Integrator> = match kind {
                "euler" => Box::new(euler(&pairs)),
                _ => Box::new(updated(&pairs)),
            };
            let h = TimeStep::new(H).unwrap_or_else(|error| panic!("{error}"));
            let (system, state) = (&start.0, &mut start.1);
            method.prepare(system, h).unwrap_or_else(|error| panic!("{error}"));
            for _ in 0..20 {
                let before = state.clone();
                let report = method.step(system, state, h, &mut PhaseClock::off());
                report.unwrap_or_else(|error| panic!("{error}"));
                let Some(ledger) = method.ledger(system, &before, state, h) else {
                    panic!("a ledger");
                };
                let change = energy(system, state) - energy(system, &before);
                let off = (ledger.sum() - change).abs();
                assert!(
                    off < 1e-9 * (1.0 + change.abs()),
                    "{split}, {kind}: {off:e} of {change:e}"
                );
            }
        }
    }
}
