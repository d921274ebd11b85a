//! A sheet hangs by two corners and swings down for a second.
//!
//! `cargo run --release --example hang_a_sheet` prints how far it has fallen and what energy it has
//! left.

#![allow(clippy::print_stdout, reason = "an example shows its numbers")]

use drape::methods::Choice;
use drape::model::TimeSpan;
use drape::{Runner, Simulation};

/// A scene: SI units stand in the names of the keys.
const SHEET: &str = r#"{
    "format": "drape-scene/1",
    "name": "my-sheet",
    "cloth": { "grid": {
        "rows": 20, "columns": 20, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 0.4
    } },
    "effects": {
        "tension": { "stiffness_over_mass_per_s2": 1e4, "damping_over_mass_per_s": 40 },
        "gravity": { "m_s2": [0, 0, -9.81] }
    },
    "pins": [{ "row": 0, "column": 0 }, { "row": 0, "column": 19 }],
    "time": { "step_s": 0.01, "duration_s": 1 }
}"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A simulation is a system (masses, forces, pins) and its state (time, positions, velocities).
    let mut sheet = Simulation::parse("my-sheet", SHEET)?;
    println!("{} particles, {} pinned", sheet.system.len(), sheet.system.pins().len());

    // A method is chosen by its id; settings follow a colon. `drape list methods` prints them all.
    let method = Choice::parse("imex-updated:start=extrapolated", &[])?;
    let time = TimeSpan { step_s: 0.01, duration_s: 1.0 };

    println!("time (s)  lowest (m)  energy (J)");
    let runner = Runner::new(&method, time).observe(|moment| {
        if moment.step % 20 == 0 {
            let (system, state) = (moment.system, moment.state);
            let lowest = state.x.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
            println!("{:8.2}  {lowest:10.3}  {:10.3}", state.t, system.total_energy(state));
        }
    });
    let outcome = runner.go(&mut sheet)?;

    // A run that diverges is a result, not an error.
    match outcome.divergence {
        None => println!("{} steps, {} CG iterations", outcome.steps, outcome.totals.cg_iterations),
        Some(divergence) => println!("diverged in step {}", divergence.step),
    }
    Ok(())
}
