//! `soak [STEPS]`: runs every method for its share of STEPS steps (10⁸ without an argument) and
//! watches the memory of the process.
//!
//! Each method steps a sheet of 3 × 3 particles that swings above a rough floor, in rounds that
//! begin anew. All methods get the same time, by the first round of each, and at least 100 000
//! steps. After the first round the memory must not grow. Exit code 1 if it does.

use drape_model::ObstacleSpec;
use drape_report::tell;
use drape_tests::{Sheet, prepared};
use std::process::ExitCode;
use std::time::Instant;

/// Steps of a round.
const ROUND: u64 = 20_000;
/// Least rounds of a method.
const LEAST_ROUNDS: u64 = 5;
/// Memory that may come and go, bytes: pages of the allocator.
const SLACK: u64 = 2 << 20;

/// In the way of the free edge.
const FLOOR: ObstacleSpec = ObstacleSpec::Plane {
    point_m: [0.0, 0.0, -0.3],
    normal: [0.0, 0.0, 1.0],
    restitution: 0.0,
    friction: 0.3,
    path: Vec::new(),
};

/// Memory of the process, bytes; `None` where the system does not tell.
fn memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(4096 * pages)
}

/// Runs a method for one round. Returns the steps that it took, and what failed.
fn round(id: &str) -> (u64, Option<String>) {
    let sheet = Sheet { side: 3, ..Sheet::default() };
    let mut spec = sheet.spec();
    if drape_tests::takes_friction(id) {
        spec.obstacles.push(FLOOR);
    }
    let mut run = prepared(id, drape_tests::build(&spec), 1e-4);
    for taken in 0..ROUND {
        if let Err(error) = run.try_step() {
            return (taken, Some(format!("{id}: {error}")));
        }
    }
    (ROUND, None)
}

fn main() -> ExitCode {
    let argument = std::env::args().nth(1);
    let Ok(steps) = argument.as_deref().unwrap_or("100000000").parse::<u64>() else {
        tell!("usage: soak [STEPS]");
        return ExitCode::from(2);
    };
    let ids: Vec<_> = drape_harness::methods::all().map(|method| method.id).collect();
    let (mut total, mut grown, mut failed) = (0_u64, Vec::new(), Vec::new());
    let mut rates = Vec::new();
    for id in &ids {
        let begun = Instant::now();
        let (taken, failure) = round(id);
        total += taken;
        failed.extend(failure);
        rates.push(1.0 / begun.elapsed().as_secs_f64());
    }
    let all: f64 = rates.iter().sum();
    for (id, rate) in ids.into_iter().zip(rates) {
        let share = steps as f64 / ROUND as f64 * rate / all;
        let rounds = (share.ceil() as u64).max(LEAST_ROUNDS);
        let mut first = None;
        for _ in 0..rounds {
            let (taken, failure) = round(id);
            total += taken;
            failed.extend(failure);
            first = first.or_else(memory);
        }
        let (Some(first), Some(last)) = (first, memory()) else {
            failed.push(format!("{id}: the system does not tell the memory of a process"));
            continue;
        };
        tell!("{id}: {rounds} rounds, {first} bytes after the first, {last} at the end");
        if last > first + SLACK {
            grown.push(id);
        }
    }
    tell!("{total} steps; memory grew with {} methods {grown:?}", grown.len());
    failed.iter().for_each(|failure| tell!("{failure}"));
    ExitCode::from(u8::from(!grown.is_empty() || !failed.is_empty()))
}
