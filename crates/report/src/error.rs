//! Errors of reports.

use crate::RecordError;
use plotters::drawing::DrawingAreaErrorKind;
use std::path::PathBuf;

/// Why a report could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A record could not be read, or a file could not be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// There is no record to draw.
    #[error(
        "{}: no record (such as tables.json) is here; `drape reproduce` writes them",
        folder.display()
    )]
    NoRecords {
        /// The folder that was searched.
        folder: PathBuf,
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
    /// Whether the user's input is at fault: there are no records, or files that are not records.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Self::NoRecords { .. } => true,
            Self::Record(error) => error.is_bad_input(),
            Self::Draw { .. } | Self::Picture { .. } | Self::Page { .. } => false,
        }
    }
}
