//! `drape system`.

use crate::cli::input::load;
use crate::cli::limit::LimitArguments;
use std::io::{BufWriter, Write as _};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bundled scene, or a file with a scene or a discretised system
    scene: String,
    #[command(flatten)]
    limit: LimitArguments,
}

/// Prints piece by piece, because the text of a large system takes more memory than the system.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let input = load(&arguments.scene, arguments.limit, None)?;
    let mut out = BufWriter::new(std::io::stdout().lock());
    serde_json::to_writer(&mut out, input.spec()).map_err(std::io::Error::from)?;
    out.write_all(b"\n")?;
    out.flush()?;
    Ok(())
}
