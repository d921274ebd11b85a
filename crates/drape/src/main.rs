//! The `drape` command; `drape --help` describes it.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
