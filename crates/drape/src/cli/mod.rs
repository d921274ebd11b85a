//! The `drape` command: one module per subcommand in [`cmd`].
//!
//! Answers go to standard output, messages to standard error, results to files. Exit codes: 0 done,
//! 1 unexpected failure, 2 bad usage or bad input, 3 the simulation diverged, 4 cells are missing,
//! 130 interrupted (143 by SIGTERM).

mod cmd;
mod exit;
mod input;
mod interrupt;
mod limit;
mod number;
mod output;
mod parquet;
mod progress;

use clap::{Parser, Subcommand};
use drape_harness::methods::MethodError;
use drape_harness::studies::Allocated;
use drape_harness::{HarnessError, Source};
use std::process::ExitCode;
use std::sync::OnceLock;
use std::time::Instant;

/// Tells the bytes that the process holds, where the program counts them.
static ALLOCATED: OnceLock<Allocated> = OnceLock::new();

/// Sets what tells the bytes that the process holds. The first call counts.
pub(crate) fn count_with(allocated: Allocated) {
    // A second program in one process would count the same bytes.
    let _ = ALLOCATED.set(allocated);
}

/// When the program began.
static BEGAN: OnceLock<Instant> = OnceLock::new();

/// When the program began, as far as it has seen: budgets count from there.
fn began() -> Instant {
    *BEGAN.get_or_init(Instant::now)
}

/// Tells the bytes that the process has allocated and not freed, where the program counts them.
fn allocated() -> Option<Allocated> {
    ALLOCATED.get().copied()
}

/// What this program was built from, as the build script saw it.
fn source() -> Source {
    let known = |text: &str| (!text.is_empty()).then(|| text.to_owned());
    Source {
        commit: known(env!("DRAPE_COMMIT")),
        dirty: known(env!("DRAPE_DIRTY")).map(|dirty| dirty == "true"),
    }
}

#[derive(Debug, Parser)]
#[command(
    version,
    about = "Time integrators for mass-spring cloth, compared on one and the same cloth"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the experiments and draw the results
    Reproduce(cmd::reproduce::Arguments),
    /// Run one method on one scene
    Run(cmd::run::Arguments),
    /// Find the best method for a scene within a time limit
    Compare(cmd::compare::Arguments),
    /// Move the cloth of a scene and draw it as PNG
    Picture(cmd::picture::Arguments),
    /// Print a bundled scene, as a start for one of your own (format "drape-scene/1")
    Scene(cmd::scene::Arguments),
    /// Print the discretised system of a scene as JSON (format "drape-system/1")
    System(cmd::system::Arguments),
    /// Measure a scene and predict how each method would do on it
    Inspect(cmd::inspect::Arguments),
    /// Show methods side by side, live in the browser
    Lab(cmd::lab::Arguments),
    /// List scenes, materials, methods, experiments or claims
    List(cmd::list::Arguments),
    /// Print a material with its sources, or convert a row of a table of fabrics into a material
    /// (format "drape-material/1")
    Material(cmd::material::Arguments),
    /// Run one experiment and draw its results
    Experiment(cmd::experiment::Arguments),
    /// Test one claim of the paper, or one expectation about later methods, and print its numbers
    Claim(cmd::claim::Arguments),
    /// Join the parts that runs with --shard have computed, and write the records
    Merge(cmd::merge::Arguments),
    /// Draw figures, report and index page from the records in a folder
    Report(cmd::report::Arguments),
    /// Write the facts of records as tables (CSV or Parquet) with one number in each row
    Export(cmd::export::Arguments),
    /// Print the JSON Schema of a file format
    Schema(cmd::schema::Arguments),
}

/// Reads the command line and does what it asks for.
pub(crate) fn main() -> ExitCode {
    began();
    let outcome = match Cli::parse().command {
        Command::Reproduce(arguments) => cmd::reproduce::run(&arguments),
        Command::Run(arguments) => cmd::run::run(&arguments),
        Command::Compare(arguments) => cmd::compare::run(&arguments),
        Command::Picture(arguments) => cmd::picture::run(&arguments),
        Command::Scene(arguments) => cmd::scene::run(&arguments),
        Command::System(arguments) => cmd::system::run(&arguments),
        Command::Inspect(arguments) => cmd::inspect::run(&arguments),
        Command::Lab(arguments) => cmd::lab::run(&arguments),
        Command::List(arguments) => cmd::list::run(&arguments),
        Command::Material(arguments) => cmd::material::run(&arguments),
        Command::Experiment(arguments) => cmd::experiment::run(&arguments),
        Command::Claim(arguments) => cmd::claim::run(&arguments),
        Command::Merge(arguments) => cmd::merge::run(&arguments),
        Command::Report(arguments) => cmd::report::run(&arguments),
        Command::Export(arguments) => cmd::export::run(&arguments),
        Command::Schema(arguments) => cmd::schema::run(&arguments),
    };
    exit::code(outcome)
}

/// Refuses a method that was added.
pub(crate) fn refuse(error: MethodError) -> ExitCode {
    exit::code(Err(HarnessError::from(error).into()))
}
