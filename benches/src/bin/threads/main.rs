//! The speed-up of a step by more threads, beside the limits of the machine.
//!
//! ```text
//! cargo run --release -p drape-benches --bin threads
//! ```
//!
//! The program times a step of IMEX Euler with Jacobi's preconditioner on the hanging sheet of
//! [`HangingSheet`](drape_benches::HangingSheet), row by row. One thread and several threads take
//! turns from the same state; after each turn both states must have the same bits.
//!
//! In each round, as many [smaller sheets](apart) as threads also take their steps, one on each
//! thread, at the same time. They share no data and never wait for each other. So if they are
//! slower than one sheet alone, the cores slow each other down. A [separate measurement](memory)
//! shows this effect in shared caches and in memory. Other methods that sweep are timed in the same
//! way on the first sheet.

mod apart;
mod memory;
mod table;

use clap::Parser;
use drape_benches::{Mesh, Prepared, provenance};
use drape_harness::Team;
use drape_integrator::{Phase, PhaseClock};
use drape_model::State;
use drape_report::file::write_atomically;
use drape_report::tell;
use std::error::Error;
use std::io::Write as _;
use std::num::NonZero;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Times steps on one thread and on several in turns.
#[derive(Debug, Parser)]
struct Cli {
    /// File for the table
    #[arg(long, default_value = "results/threads.md")]
    out: PathBuf,
    /// Particles along an edge
    #[arg(long, value_delimiter = ',', default_value = "316,1000", value_parser = clap::value_parser!(u32).range(128..=2000))]
    sides: Vec<u32>,
    /// Threads, beside one
    #[arg(long, value_delimiter = ',', default_value = "2", value_parser = clap::value_parser!(u16).range(2..=64))]
    threads: Vec<u16>,
    /// Turns of each
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Least time of a turn on one thread, ms
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    milliseconds: u32,
}

const METHOD: &str = "imex-euler:preconditioner=jacobi";
/// Other methods that sweep, on the first of the sheets.
const OTHERS: [&str; 9] = [
    "leapfrog:step=bound,damping=explicit",
    "baraff-witkin",
    "backward-euler",
    "backward-euler:solver=cg,forcing=eisenstat-walker",
    "bdf2",
    "vbd",
    "xpbd",
    "xpbd:sweep=coloured",
    "xpbd-lines",
];
/// Steps before any is timed.
const WARM_UP: usize = 5;
/// The phases that take time.
const PHASES: [Phase; 3] = [Phase::Forces, Phase::Solve, Phase::Update];

/// Milliseconds of a step and of its phases.
#[derive(Clone, Copy, Debug)]
struct Times {
    step: f64,
    phases: [f64; 3],
}

/// What the rounds gave on one sheet.
#[derive(Clone, Debug)]
struct Comparison {
    method: &'static str,
    side: u32,
    threads: usize,
    /// Each round: on one thread, and on all.
    pairs: Vec<[Times; 2]>,
    /// Each round: how many times as many particles a second the sheets that share nothing move.
    apart: Vec<f64>,
}

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell!("threads: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(cli: &Cli) -> Result<(), Box<dyn Error>> {
    let provenance = provenance();
    let (mut comparisons, mut others) = (Vec::new(), Vec::new());
    let mut speeds = Vec::new();
    for &threads in &cli.threads {
        let threads = NonZero::<u16>::try_from(threads)?.into();
        speeds.push((threads, memory::speeds(threads)));
        for &side in &cli.sides {
            comparisons.push(compare(cli, METHOD, side, threads)?);
        }
        for (method, &side) in OTHERS.into_iter().flat_map(|m| cli.sides.first().map(|s| (m, s))) {
            others.push(compare(cli, method, side, threads)?);
        }
    }
    let text = table::text(&provenance, &speeds, &comparisons, &others);
    write_atomically(&cli.out, text.as_bytes())?;
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// A sheet that takes its steps on a team of its own.
struct Run {
    team: Team,
    prepared: Prepared,
}

impl Run {
    fn new(method: &str, side: u32, threads: NonZero<usize>) -> Result<Self, Box<dyn Error>> {
        let mut prepared = Prepared::with_threads(side, Mesh::Grid, method, 0, threads);
        let mut team = Team::new(threads, prepared.system.len())?;
        team.run(|| (0..WARM_UP).for_each(|_| prepared.step()));
        Ok(Self { team, prepared })
    }

    fn turn(&mut self, steps: u32) -> Times {
        let Self { team, prepared } = self;
        team.run(|| turn(prepared, steps))
    }
}

/// Means over so many steps.
fn turn(prepared: &mut Prepared, steps: u32) -> Times {
    let mut clock = PhaseClock::on();
    let begin = Instant::now();
    (0..steps).for_each(|_| prepared.step_by(&mut clock));
    let each = |seconds: f64| 1e3 * seconds / f64::from(steps);
    Times {
        step: each(begin.elapsed().as_secs_f64()),
        phases: PHASES.map(|phase| each(clock.seconds(phase))),
    }
}

fn compare(
    cli: &Cli,
    method: &'static str,
    side: u32,
    threads: NonZero<usize>,
) -> Result<Comparison, Box<dyn Error>> {
    let mut one = Run::new(method, side, NonZero::<usize>::MIN)?;
    let mut all = Run::new(method, side, threads)?;
    let mut small = (method == METHOD).then(|| apart::sheets(side, threads));
    let rate = 1e3 / one.turn(1).step;
    all.turn(1);
    let steps = (1e-3 * rate * f64::from(cli.milliseconds)).ceil().clamp(1.0, 1e4) as u32;
    let (mut pairs, mut parts) = (Vec::new(), Vec::new());
    for round in 0..cli.rounds {
        // Every other round goes backwards, so that a drift of the machine affects both.
        let pair = if round % 2 == 0 {
            let first = one.turn(steps);
            [first, all.turn(steps)]
        } else {
            let first = all.turn(steps);
            [one.turn(steps), first]
        };
        if bits(&one.prepared.state) != bits(&all.prepared.state) {
            return Err(format!(
                "{method}: {threads} threads end elsewhere than one on {side} × {side} particles"
            )
            .into());
        }
        if let Some(small) = &mut small {
            let particles_per_ms = apart::particles_per_ms(small, steps);
            parts.push(particles_per_ms * pair[0].step / one.prepared.system.len() as f64);
        }
        pairs.push(pair);
    }
    Ok(Comparison { method, side, threads: threads.get(), pairs, apart: parts })
}

fn bits(state: &State) -> Vec<u64> {
    let numbers = state.x.iter().chain(&state.v);
    numbers.flat_map(|vector| vector.iter().map(|number| number.to_bits())).collect()
}
