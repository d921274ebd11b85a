//! Exit codes.

use crate::cli::interrupt::{Interrupted, exit_code};
use drape_harness::HarnessError;
use drape_integrator::{PrepareError, StepError};
use drape_model::{SceneError, Violation};
use drape_report::{ReportError, tell};
use std::process::ExitCode;

const UNEXPECTED: u8 = 1;
const BAD_INPUT: u8 = 2;
const DIVERGED: u8 = 3;
const INCOMPLETE: u8 = 4;

/// The simulation diverged; its record is kept.
#[derive(Debug)]
pub(crate) struct Diverged(pub(crate) String);

impl std::fmt::Display for Diverged {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Diverged {}

/// Cells are missing; what is there is kept.
#[derive(Debug)]
pub(crate) struct Incomplete(pub(crate) String);

impl std::fmt::Display for Incomplete {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Incomplete {}

/// Prints the error in one line and picks the exit code.
pub(crate) fn code(outcome: anyhow::Result<()>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        // `drape system … | head` closes the pipe early, which is no failure.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            // Each message includes its cause.
            tell!("drape: {error}");
            ExitCode::from(classify(&error))
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

fn classify(error: &anyhow::Error) -> u8 {
    let is_outside =
        |error: &HarnessError| matches!(error, HarnessError::Step(StepError::Outside(_)));
    if error.is::<Diverged>() || error.downcast_ref::<HarnessError>().is_some_and(is_outside) {
        return DIVERGED;
    }
    if error.is::<Incomplete>() {
        return INCOMPLETE;
    }
    if error.is::<Interrupted>() {
        return exit_code();
    }
    let harness = |error: &HarnessError| match error {
        HarnessError::Scene(_)
        | HarnessError::Violation(_)
        | HarnessError::Method(_)
        | HarnessError::TimeStep(_)
        | HarnessError::Prepare(
            PrepareError::Unsupported { .. }
            | PrepareError::Outside(_)
            | PrepareError::TooLarge { .. }
            | PrepareError::Solver(_),
        )
        | HarnessError::Refused { .. }
        | HarnessError::Stopped { .. }
        | HarnessError::Busy { .. }
        | HarnessError::Part { .. }
        | HarnessError::Threads(_)
        | HarnessError::UnknownExperiment { .. }
        | HarnessError::UnknownStart { .. }
        | HarnessError::UnknownClaim { .. }
        | HarnessError::NoOwnTimings { .. }
        | HarnessError::OtherScene { .. }
        | HarnessError::OtherForm { .. } => true,
        HarnessError::Record(error) => error.is_bad_input(),
        HarnessError::Step(_)
        | HarnessError::Reference(_)
        | HarnessError::Elsewhere
        | HarnessError::Late => false,
    };
    let bad_input = error.is::<SceneError>()
        || error.is::<Violation>()
        || error.downcast_ref::<HarnessError>().is_some_and(harness)
        || error.downcast_ref::<ReportError>().is_some_and(ReportError::is_bad_input);
    if bad_input { BAD_INPUT } else { UNEXPECTED }
}
