//! The command with methods of the user.

use crate::cli;
use drape_harness::{methods, studies::Allocated};
use drape_integrator::Registration;
use std::process::ExitCode;

/// The `drape` command with methods of your own: a binary of a few lines that has every subcommand
/// and every study, with your methods in them.
///
/// ```no_run
/// # use drape::integrator::Registration;
/// # fn my_method() -> Registration { unimplemented!() }
/// fn main() -> std::process::ExitCode {
///     drape::Drape::new().with(my_method()).main()
/// }
/// ```
///
/// [`examples::write_a_method`](crate::examples::write_a_method) is a whole one. A study runs an added
/// method at its defaults, after all others; `--methods MY-METHOD` runs no other. Its results go into
/// `results-own` by default. Figures show it among the "Other methods".
#[derive(Debug, Default)]
#[must_use]
pub struct Drape {
    methods: Vec<Registration>,
    allocated: Option<Allocated>,
}

impl Drape {
    /// The command as it is.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a method. Its id must be new; [`main`](Self::main) refuses any other.
    pub fn with(mut self, method: Registration) -> Self {
        self.methods.push(method);
        self
    }

    /// Lets studies of memory ask how many bytes the process holds. Only a program that counts them
    /// in its allocator can tell.
    pub fn counting(mut self, allocated: Allocated) -> Self {
        self.allocated = Some(allocated);
        self
    }

    /// Reads the command line, does what it asks for and tells the exit code.
    pub fn main(self) -> ExitCode {
        if let Some(allocated) = self.allocated {
            cli::count_with(allocated);
        }
        for method in self.methods {
            if let Err(error) = methods::add(method) {
                return cli::refuse(error);
            }
        }
        cli::main()
    }
}
