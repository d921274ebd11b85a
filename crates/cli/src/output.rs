//! Standard output.

use std::io::Write as _;

/// Writes a text to standard output; a closed pipe is an error that [`crate::exit`] forgives.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}
