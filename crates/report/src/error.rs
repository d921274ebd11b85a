//! What can go wrong.

use crate::RecordError;
use plotters::drawing::DrawingAreaErrorKind;
use std::path::PathBuf;

/// Why no report could be drawn.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A record could not be read, or a file could not be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// There is nothing to draw.
    #[error(
        "{}: no record (such as tables.json) is here; `drape reproduce` writes them",
        folder.display()
    )]
    NoRecords {
        /// The folder that was searched.
        folder: PathBuf,
    },
    /// A file is a record, but of another kind than its name says.
    #[error("{}: expected {expected}, found {found}", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
        /// Format and experiment that belong to the file's name.
        expected: String,
        /// Format and experiment that it names.
        found: String,
    },
    /// A figure could not be drawn.
    #[error("{file}: cannot draw the figure: {source}")]
    Draw {
        /// File name of the figure.
        file: &'static str,
        /// The drawing library's reason.
        source: DrawingAreaErrorKind<std::io::Error>,
    },
    /// A picture could not be drawn.
    #[error("{file}: cannot draw the picture: {source}")]
    Picture {
        /// File name of the picture.
        file: &'static str,
        /// The reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A page could not be filled.
    #[error("{file}: cannot fill the page's template: {source}")]
    Page {
        /// File name of the page.
        file: &'static str,
        /// The template engine's reason, with its line.
        source: minijinja::Error,
    },
}

impl ReportError {
    /// Whether the reader's input is at fault: no records, or files that are none.
    pub fn is_bad_input(&self) -> bool {
        matches!(
            self,
            Self::NoRecords { .. }
                | Self::Kind { .. }
                | Self::Record(RecordError::Format { .. } | RecordError::Unfit { .. })
        )
    }
}
