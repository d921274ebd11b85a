//! Two methods move the same stiff sheet with the same step. Which costs less, which keeps more?
//!
//! `cargo run --release --example compare_two` prints a table. IMEX Euler solves one linear system
//! per step; the cloth hardly moves. Updated CG takes more iterations and keeps the motion.

#![allow(clippy::print_stdout, reason = "an example shows its numbers")]

use drape::methods::Choice;
use drape::model::TimeSpan;
use drape::{Counts, Runner, Simulation, reference_energy};

/// A hanging textile with k/m = 10⁶ s⁻²: springs oscillate much faster than the step of 0.01 s.
const SCENE: &str = "hanging-textile-1e6";
const DURATION: f64 = 0.3;

fn run(sheet: &Simulation, method: &str, step_s: f64) -> Result<Counts, drape::Error> {
    let choice = Choice::parse(method, &[])?;
    Runner::new(&choice, TimeSpan { step_s, duration_s: DURATION }).count(sheet)
}

/// How far the particles came down on average, m.
fn fall(sheet: &Simulation, run: &Counts) -> f64 {
    let falls = sheet.state.x.iter().zip(&run.state.x).map(|(start, end)| start.z - end.z);
    falls.sum::<f64>() / sheet.system.len() as f64
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sheet = Simulation::load(SCENE)?;
    // Leapfrog with steps far below its stability limit stands for the true motion.
    let truth = fall(&sheet, &run(&sheet, "leapfrog", 1e-4)?);
    let released = reference_energy(&sheet, DURATION)?;
    println!("{SCENE}, {DURATION} s: the sheet should fall by {truth:.3} m");
    println!("method        verdict  energy gain  CG iterations  retained motion");
    for method in ["imex-euler", "imex-updated"] {
        let run = run(&sheet, method, 0.01)?;
        println!(
            "{method:13} {:7} {:11.2} % {:14} {:14.0} %",
            run.verdict(released).name(),
            100.0 * run.energy.gain / released,
            run.outcome.totals.cg_iterations,
            100.0 * fall(&sheet, &run) / truth
        );
    }
    Ok(())
}
