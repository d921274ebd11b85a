//! What tests share that need a program which a machine may lack.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::io::Write as _;

/// The Python of `DRAPE_PYTHON`, or `python3`.
pub(crate) fn python() -> String {
    std::env::var("DRAPE_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

/// Tells on the terminal, past the capture of tests, what was not tested.
pub(crate) fn skipped(why: &str) {
    writeln!(std::io::stderr().lock(), "SKIPPED: {why}").unwrap();
}
