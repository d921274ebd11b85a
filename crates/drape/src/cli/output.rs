//! Standard output, and checks of file names.

use drape_model::Violation;
use std::io::Write as _;
use std::path::Path;

/// Writes a text to standard output. [`crate::cli::exit`] forgives a closed pipe.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Checks that the extension of a file fits its content.
pub(crate) fn check_extension(
    key: &str,
    file: &Path,
    extension: &str,
    content: &str,
) -> Result<(), Violation> {
    let found = file.extension().unwrap_or_default();
    if found.eq_ignore_ascii_case(extension) {
        return Ok(());
    }
    let expected = format!("a name that ends in .{extension}: the file is a {content}");
    Err(Violation { path: key.to_owned(), value: file.display().to_string(), expected })
}

/// Checks, before the run, that a file can be written. Makes missing folders.
pub(crate) fn check_writable(key: &str, file: &Path) -> Result<(), Violation> {
    let refuse = |reason: String| Violation {
        path: key.to_owned(),
        value: file.display().to_string(),
        expected: format!("a file that can be written ({reason})"),
    };
    let Some(name) = file.file_name().filter(|_| !file.is_dir()) else {
        return Err(refuse("it is a folder".to_owned()));
    };
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    let probe = file.with_file_name(format!("{}.{}.tmp", name.display(), std::process::id()));
    folder
        .map_or(Ok(()), std::fs::create_dir_all)
        .and_then(|()| std::fs::File::create(&probe))
        .and_then(|_| std::fs::remove_file(&probe))
        .map_err(|error| refuse(error.to_string()))
}
