//! Times drape and other programs on the same steps of the same sheet.
//!
//! ```text
//! DRAPE_PEERS=<folder> cargo run --release -p drape-benches --bin peers
//! ```
//!
//! A *peer* is a program that solves the hanging sheet of
//! [`HangingSheet`](drape_benches::HangingSheet) with another library. Its command line is
//!
//! ```text
//! eigen_imex N SOLVER TOLERANCE STEPS K/M     # IMEX Euler, tension springs implicit
//! eigen_bw   N SOLVER TOLERANCE STEPS K/M     # Baraff and Witkin, all springs implicit
//! ```
//!
//! The peer takes STEPS steps of 0.01 s on N × N particles and times each step. It prints one line
//! of words and numbers:
//!
//! | number | word beside it in `eigen_imex` | in `eigen_bw` |
//! |---|---|---|
//! | median time of a step, µs | after `total` | after `med` |
//! | mean time of a step, µs (optional) | before `(mean)` | before `(mean)` |
//! | iterations a step | after `iters/step/rhs` | after `it` |
//! | final height of the middle particle, m | after `xmid` | after `xmid` |
//! | final height of the lowest particle, m | after `ymin` | after `ymin` |
//!
//! The solvers of `eigen_imex` are `cgicn` and `cgjac` (conjugate gradients with incomplete
//! Cholesky in natural order, or with the diagonal) and `cholamd` (CHOLMOD, factor kept). Those of
//! `eigen_bw` are `jac`, `ic` and `llt`.
//!
//! Every program runs as its own process on one core and one thread. The programs take turns, and
//! every other round reverses their order, so both sides of a ratio see the same machine. A ratio
//! divides the medians of two runs in the same round. The program records it only if both answers
//! agree; two direct solves must agree to six digits.
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
    /// File for the record
    #[arg(long, default_value = "results/timings/peers.json")]
    out: PathBuf,
    /// File for the tables
    #[arg(long, default_value = "results/peers.md")]
    table: PathBuf,
    /// Largest number of particles along an edge
    #[arg(long, default_value_t = u32::MAX)]
    largest: u32,
    /// Limit of the runs of each program on each case
    #[arg(long, default_value_t = usize::MAX)]
    rounds: usize,
    /// Core to which every program is pinned [default: the last]
    #[arg(long)]
    core: Option<u32>,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Take drape's steps once, as a peer does, and print their times
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
