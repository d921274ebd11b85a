//! `drape report`.

use drape_report::tell;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder with the records
    #[arg(default_value = "results")]
    folder: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    draw(&arguments.folder)
}

/// Draws figures and pages from the records in a folder.
pub(crate) fn draw(folder: &Path) -> anyhow::Result<()> {
    for file in drape_harness::studies::draw(folder)? {
        tell!("wrote {}", file.display());
    }
    Ok(())
}
