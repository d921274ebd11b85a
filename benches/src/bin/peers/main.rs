//! Drape beside programs outside it, on the same steps of the same sheet.
//!
//! ```text
//! DRAPE_PEERS=<folder> cargo run --release -p drape-benches --bin peers
//! ```
//!
//! A *peer* is a program that solves the hanging sheet of
//! [`HangingSheet`](drape_benches::HangingSheet) with another library. It is called as
//!
//! ```text
//! eigen_imex N SOLVER TOLERANCE STEPS K/M     # IMEX Euler, tension springs implicit
//! eigen_bw   N SOLVER TOLERANCE STEPS K/M     # Baraff and Witkin, all springs implicit
//! ```
//!
//! takes STEPS steps of 0.01 s on N × N particles, times each of them by itself, and prints one
//! line of words and numbers: the median time of a step in µs after `total` (`eigen_bw`: after
//! `med`), the mean before `(mean)` if it tells it, the iterations a step after `iters/step/rhs`
//! (`it`), the heights of the middle and of the lowest particle at the end, in m, after `xmid` and
//! `ymin`. Solvers of `eigen_imex`: `cgicn` and `cgjac` (conjugate gradients with incomplete
//! Cholesky in natural order, or with the diagonal), `cholamd` (CHOLMOD, factor kept); of
//! `eigen_bw`: `jac`, `ic`, `llt`.
//!
//! Every program runs as a process of its own on one core and one thread, in turns, so that both
//! sides of a ratio meet the same machine. The order is turned round in every other round. A ratio
//! is that of the medians of two runs in the same round. It is recorded only where both answers
//! agree; between two direct solves to six digits.
//!
//! An optional file `about.txt` in the folder, with versions and compiler flags, is copied to the
//! record.

mod error;
mod measure;
mod plan;
mod program;
mod record;
mod steps;
mod table;

use crate::record::{Row, Setup};
use clap::{Parser, Subcommand, ValueEnum};
use drape_benches::{Mesh, provenance};
use drape_harness::sha256;
use drape_report::file::{write_atomically, write_json};
use drape_report::{TIMINGS_FORMAT, Timings, tell};
use error::PeersError;
use plan::plans;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

/// Compares drape's steps with those of the programs in the folder that DRAPE_PEERS names.
#[derive(Debug, Parser)]
struct Cli {
    /// Where the record goes
    #[arg(long, default_value = "results/timings/peers.json")]
    out: PathBuf,
    /// Where the tables go
    #[arg(long, default_value = "results/peers.md")]
    table: PathBuf,
    /// Largest number of particles along an edge
    #[arg(long, default_value_t = u32::MAX)]
    largest: u32,
    /// Most runs of each program on each case
    #[arg(long, default_value_t = usize::MAX)]
    rounds: usize,
    /// Core that every program is pinned to [default: the last]
    #[arg(long)]
    core: Option<u32>,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Take drape's steps once, as a peer would, and print their times
    Step {
        /// Method id with settings
        method: String,
        /// Particles along each edge
        side: u32,
        /// Order of particles and springs
        mesh: MeshName,
        /// Number of steps
        steps: u32,
        /// k/m of the tension springs, 1/s²
        stiffness: f64,
    },
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MeshName {
    Grid,
    General,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome = match &cli.command {
        Some(Command::Step { method, side, mesh, steps, stiffness }) => {
            let mesh = match mesh {
                MeshName::Grid => Mesh::Grid,
                MeshName::General => Mesh::General,
            };
            steps::take(method, *side, mesh, *steps, *stiffness)
                .and_then(|sample| print(&steps::line(&sample)))
        }
        None => compare(&cli),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell!("peers: {error}");
            ExitCode::FAILURE
        }
    }
}

fn print(text: &str) -> Result<(), PeersError> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

fn compare(cli: &Cli) -> Result<(), PeersError> {
    let folder = std::env::var_os("DRAPE_PEERS").filter(|name| !name.is_empty()).map(PathBuf::from);
    let peers = program::peers(folder.as_deref())?;
    if peers.is_empty() {
        tell!("peers: DRAPE_PEERS names no folder: drape is measured alone");
    }
    let core = program::core(cli.core);
    let executable = |path: &PathBuf| {
        std::fs::read(path)
            .map(|bytes| sha256(&bytes))
            .map_err(|source| PeersError::Start { program: path.display().to_string(), source })
    };
    let hashes: Result<BTreeMap<_, _>, PeersError> =
        peers.iter().map(|(peer, path)| Ok((peer.name.to_owned(), executable(path)?))).collect();
    let about = folder.and_then(|folder| std::fs::read_to_string(folder.join("about.txt")).ok());
    let provenance = provenance();
    let mut rows = vec![Row::Setup(Setup { core, peers_sha256: hashes?, about })];
    let plans = plans(&peers, cli.largest, cli.rounds);
    for plan in &plans {
        let case = &plan.case;
        tell!(
            "{} N = {} k/m = {:e}: {} programs, {} rounds",
            case.method,
            case.side,
            case.stiffness_over_mass_per_s2,
            plan.programs.len(),
            plan.rounds
        );
        rows.extend(measure::measure(plan, core)?);
    }
    let timings = Timings {
        format: TIMINGS_FORMAT.to_owned(),
        experiment: "peers".to_owned(),
        method: METHOD.to_owned(),
        rows,
        provenance,
    };
    write_json(&cli.out, &timings)?;
    let page = table::page(&timings, &plans);
    write_atomically(&cli.table, page.as_bytes())?;
    tell!("wrote {} and {}", cli.out.display(), cli.table.display());
    print(&page)
}

const METHOD: &str = "N × N particles, 1 m × 1 m, 0.4 kg in all, flat and horizontal at the start, two corners of one edge \
    pinned; tension springs with k/m as given and d/m = 40/s, shear and bending springs with a tenth of both; h = 0.01 s, \
    iterative solves to 1e-3 from 2 v_n − v_{n−1}. Every program takes the same steps from the start, times each step by \
    itself and tells the median. Runs take turns on one core and one thread; a ratio is that of two runs of the same \
    round. General mesh: the same cloth with particles and springs in random order (the peers' own is in \
    the order of the grid).";
