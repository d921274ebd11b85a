//! What can go wrong.

use std::path::PathBuf;

/// Why nothing was recorded.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PeersError {
    /// The folder of peers cannot be used.
    #[error("DRAPE_PEERS = {}: {reason}; give a folder that holds at least one of: {known}", folder.display())]
    Folder { folder: PathBuf, reason: String, known: String },
    /// A program did not start.
    #[error("{program}: cannot be started: {source}")]
    Start { program: String, source: std::io::Error },
    /// A program ended with a failure.
    #[error("{program}: ended with {status}: {said}")]
    Failed { program: String, status: std::process::ExitStatus, said: String },
    /// A program's answer is not understood.
    #[error(
        "{program}: expected `{expected}` followed by a number on standard output, found: {found}"
    )]
    Output { program: String, expected: &'static str, found: String },
    /// The sheet was refused.
    #[error(transparent)]
    Sheet(#[from] drape_model::Violation),
    /// The method or a run was refused.
    #[error(transparent)]
    Harness(#[from] drape_harness::HarnessError),
    /// The record could not be written.
    #[error(transparent)]
    Record(#[from] drape_report::RecordError),
    /// Standard output is closed.
    #[error("standard output: {0}")]
    Print(#[from] std::io::Error),
}
