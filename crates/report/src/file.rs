//! Reading and writing records: whole files or none.

use serde::{Serialize, de::DeserializeOwned};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// What can go wrong with a record's file.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file could not be read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// `read` or `write`.
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is no record of the expected kind.
    #[error("{}: not a record that this version reads: {source}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        source: serde_json::Error,
    },
}

/// Writes `bytes` to a temporary name beside `path` and renames it, so that a reader sees the old
/// file or the whole new one. Missing folders are made.
///
/// # Errors
/// [`RecordError::Io`] with the path when a folder, the temporary file or the rename fails; the
/// temporary file is removed then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), RecordError> {
    let fail = |source| RecordError::Io { path: path.to_owned(), action: "write", source };
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(fail)?;
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    let written = std::fs::File::create(&temporary)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| std::fs::rename(&temporary, path));
    written.map_err(|source| {
        // The first failure is the one to report; a left-over temporary file is only litter.
        let _ = std::fs::remove_file(&temporary);
        fail(source)
    })
}

/// Writes a value as indented JSON with a final newline, atomically.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), RecordError> {
    let mut bytes = serde_json::to_vec_pretty(value)
        .map_err(|source| RecordError::Format { path: path.to_owned(), source })?;
    bytes.push(b'\n');
    write_atomically(path, &bytes)
}

/// Reads a record.
///
/// # Errors
/// [`RecordError::Io`] when the file cannot be read, [`RecordError::Format`] with line and column
/// when it is not of type `T`.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, RecordError> {
    let text = std::fs::read_to_string(path).map_err(|source| RecordError::Io {
        path: path.to_owned(),
        action: "read",
        source,
    })?;
    serde_json::from_str(&text)
        .map_err(|source| RecordError::Format { path: path.to_owned(), source })
}
