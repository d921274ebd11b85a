//! What is run for claim C29.

use super::scenes::{build, hanging, run};
use super::{Number, Timed, Trial};
use crate::HarnessError;
use crate::scenes::bundled;
use crate::studies::claims::facts::TimedCase;
use crate::studies::tables::run::PRINTED;

pub(super) const TRIAL: Trial = Trial {
    id: "C29",
    scenes: || {
        "tables 2 and 3 of the paper; here the hanging sheet, n = 400 to 78400, h = 0.01 s, ε = \
         0.05, plain IMEX Euler, IC(0), matrix kept, 1 s"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: Some(seconds),
};

/// Particles that count as several hundred.
const SEVERAL_HUNDRED: usize = 400;
/// Wall time of a visit of a spring on a present machine, s: the model of the run's effort.
const VISIT: f64 = 5e-9;
const STEP: f64 = 0.01;
/// Simulated time of a run, s.
const SPAN: f64 = 1.0;
const METHOD: &str = "imex-euler:norm=euclid,forcing_term=0.05";
const SIDES: [u32; 6] = [20, 52, 100, 140, 200, 280];

/// Stiffness over mass at fixed k/m, and at fixed material, whose particles get lighter.
fn stiffness(side: u32, is_material: bool) -> f64 {
    let finer = f64::from(side * side) / 400.0;
    if is_material { 1e4 * finer } else { 1e4 }
}

/// Counted work of a simulated second, as seconds of a machine that visits a spring in 5 ns.
fn modelled(side: u32, is_material: bool) -> Result<f64, HarnessError> {
    let start = build(&hanging(side, stiffness(side, is_material), 40.0).spec()?)?;
    let effort = run(&start, METHOD, STEP, SPAN, None)?.outcome.effort;
    Ok(effort * VISIT / SPAN)
}

/// Particles, solver time of a simulated second, the same without the set-up of the matrix, s: by
/// the paper's tables.
fn paper() -> Result<Vec<(usize, f64, f64)>, HarnessError> {
    let mut paper = Vec::new();
    for row in &PRINTED {
        let particles = crate::scenes::build(&bundled(row.scene)?)?.1.system.len();
        let kept = row.paper.solver_s - row.paper.matrix_setup_s;
        paper.push((particles, row.paper.solver_s, kept));
    }
    Ok(paper)
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut here = Vec::new();
    for is_material in [false, true] {
        let name = if is_material { "fixed material" } else { "fixed k/m = 1e4" };
        let mut largest = 0.0;
        for side in SIDES {
            let seconds = modelled(side, is_material)?;
            if seconds > 1.0 {
                break;
            }
            largest = f64::from(side * side);
        }
        here.push((name, largest));
    }
    Ok(numbers(&paper()?, &here))
}

/// `paper` as [`paper`] gives it; `here`: a series and its largest n in real time.
fn numbers(paper: &[(usize, f64, f64)], here: &[(&str, f64)]) -> Vec<Number> {
    let rows = || paper.iter().filter(|row| row.0 <= SEVERAL_HUNDRED);
    let fastest = rows().fold(f64::INFINITY, |least, row| least.min(row.1));
    let slowest = rows().fold(0.0_f64, |most, row| most.max(row.1));
    let kept = rows().fold(f64::INFINITY, |least, row| least.min(row.2));
    let mut numbers = vec![
        Number::new("paper's fastest run of 400 particles, a simulated second", fastest, "s")
            .against(1.0),
        Number::new("paper's slowest run of 400 particles", slowest, "s").against(1.0),
        Number::new("paper's fastest without the set-up of the matrix", kept, "s").against(1.0),
    ];
    for (name, largest) in here {
        numbers.push(Number::new(
            format!("largest n in real time by counted work, {name}"),
            *largest,
            "particles",
        ));
    }
    numbers
}

/// Measures the largest sheet that the model holds to be in real time.
fn seconds() -> Result<Timed, HarnessError> {
    let mut cases = Vec::new();
    let mut largest = 0.0;
    for side in SIDES {
        let start = build(&hanging(side, stiffness(side, false), 40.0).spec()?)?;
        let mut samples_ns = Vec::new();
        for _ in 0..3 {
            let wall = run(&start, METHOD, STEP, SPAN, None)?.outcome.wall;
            samples_ns.push((wall.as_nanos() as f64 / SPAN) as u64);
        }
        let what = format!("a simulated second, n = {}, k/m = 1e4", side * side);
        let case = TimedCase { what, samples_ns };
        let is_slow = case.median_s() > 1.0;
        cases.push(case);
        if is_slow {
            break;
        }
        largest = f64::from(side * side);
    }
    let number =
        Number::new("largest n in real time on this machine", largest, "particles").of_machine();
    Ok((cases, number))
}
