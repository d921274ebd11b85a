//! The `drape` command: one module a subcommand in [`cmd`].
//!
//! Answers go to standard output, messages to standard error, results to files. Exit codes: 0 done,
//! 1 unexpected failure, 2 bad usage or bad input, 3 the simulation diverged.

mod cmd;
mod exit;
mod input;
mod limit;
mod output;
mod progress;

use cap::Cap;
use clap::{Parser, Subcommand};
use drape_harness::Source;
use std::alloc::System;
use std::process::ExitCode;

/// Counts the bytes that the process holds, and sets no limit.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Bytes that the process has allocated and not freed.
fn allocated() -> usize {
    ALLOCATOR.allocated()
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
    /// Run all experiments and draw the results
    Reproduce(cmd::reproduce::Arguments),
    /// Run one method on one scene
    Run(cmd::run::Arguments),
    /// Move the cloth of a scene and draw it as PNG
    Picture(cmd::picture::Arguments),
    /// Print the discretised system of a scene as JSON (format "drape-system/1")
    System(cmd::system::Arguments),
    /// List scenes, methods, experiments or claims
    List(cmd::list::Arguments),
    /// Run one experiment and draw its results
    Experiment(cmd::experiment::Arguments),
    /// Test one claim of the paper and print its numbers
    Claim(cmd::claim::Arguments),
    /// Draw figures, report and index page from the records in a folder
    Report(cmd::report::Arguments),
    /// Print the JSON Schema of a file format
    Schema(cmd::schema::Arguments),
}

pub(crate) fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Reproduce(arguments) => cmd::reproduce::run(&arguments),
        Command::Run(arguments) => cmd::run::run(&arguments),
        Command::Picture(arguments) => cmd::picture::run(&arguments),
        Command::System(arguments) => cmd::system::run(&arguments),
        Command::List(arguments) => cmd::list::run(&arguments),
        Command::Experiment(arguments) => cmd::experiment::run(&arguments),
        Command::Claim(arguments) => cmd::claim::run(&arguments),
        Command::Report(arguments) => cmd::report::run(&arguments),
        Command::Schema(arguments) => cmd::schema::run(&arguments),
    };
    exit::code(outcome)
}
