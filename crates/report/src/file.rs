//! Reading and writing records. A file is written completely or not at all.

use serde::{Serialize, de::DeserializeOwned};
use std::fs::{File, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile};

/// Errors of a record's file.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file could not be read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// `read` or `write`.
        action: &'static str,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The path is not a regular file, or the file is too long.
    #[error(
        "{}: {found}; expected a regular file of at most {} GiB", path.display(), MOST_BYTES >> 30
    )]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What was found there.
        found: String,
    },
    /// The file is not a record of the expected kind.
    #[error(
        "{}: not a record that this version reads: {source}; remove it, or write it again with \
         `drape experiment`",
        path.display()
    )]
    Format {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        source: serde_json::Error,
    },
    /// A file is a record of another kind than its name says.
    #[error("{}: expected {expected}, found {found}", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
        /// Format and experiment that the file's name requires.
        expected: String,
        /// Format and experiment that the file contains.
        found: String,
    },
}

impl RecordError {
    /// Whether the user's input is at fault: the file is no record, or one of another kind.
    pub fn is_bad_input(&self) -> bool {
        !matches!(self, Self::Io { .. })
    }
}

/// Most bytes of a record.
const MOST_BYTES: u64 = 4 << 30;

/// Most symbolic links that lead from one to the next.
const MOST_LINKS: usize = 40;

/// The file that a write to `path` replaces: `path` itself, or the target of its symbolic links. It
/// need not exist.
///
/// # Errors
/// If `path` is a folder, a device, a pipe or a socket, because a file in its place would destroy
/// it.
pub fn destination(path: &Path) -> std::io::Result<PathBuf> {
    use std::io::{Error, ErrorKind};
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let kind = match path.symlink_metadata() {
            Ok(metadata) => metadata.file_type(),
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(path),
            Err(error) => return Err(error),
        };
        if kind.is_symlink() {
            let link = std::fs::read_link(&path)?;
            path.pop();
            path.push(link);
        } else if kind.is_file() {
            return Ok(path);
        } else if kind.is_dir() {
            return Err(Error::new(ErrorKind::IsADirectory, "it is a folder"));
        } else {
            let what = "it is a device, a pipe or a socket, no regular file";
            return Err(Error::new(ErrorKind::InvalidInput, what));
        }
    }
    Err(Error::other(format!("more than {MOST_LINKS} symbolic links lead from one to the next")))
}

/// What temporary names add to the name of the file that is written: this, random letters, `.tmp`.
const MARK: &str = ".drape-";
/// What temporary names end with.
const END: &str = ".tmp";
/// Number of the random letters.
const RANDOM: usize = 8;

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Makes a new file under a temporary name beside `path`. It is removed when it is dropped.
///
/// The name is random, since processes in two containers may share both a folder and a number. The
/// writer holds a lock on the file, which tells [`remove_leftovers`] that it is still at work.
fn temporary(path: &Path) -> std::io::Result<NamedTempFile<File>> {
    let mut prefix = path.file_name().unwrap_or_default().to_owned();
    prefix.push(MARK);
    Builder::new().prefix(&prefix).suffix(END).rand_bytes(RANDOM).make_in(folder_of(path), create)
}

/// Makes a new file and locks it. It never follows a link.
///
/// # Errors
/// [`AlreadyExists`](std::io::ErrorKind::AlreadyExists) also where [`remove_leftovers`] of another
/// process came between: under another name all goes well.
fn create(path: &Path) -> std::io::Result<File> {
    let file = File::create_new(path)?;
    // Some file systems know no locks. There nothing is ever removed.
    let is_taken = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
    if is_taken || !path.exists() {
        return Err(std::io::ErrorKind::AlreadyExists.into());
    }
    Ok(file)
}

/// The name of the file that is written under a temporary name.
fn written_under(temporary: &str) -> Option<&str> {
    let (written, random) = temporary.strip_suffix(END)?.rsplit_once(MARK)?;
    let is_random = random.len() == RANDOM && random.bytes().all(|b| b.is_ascii_alphanumeric());
    is_random.then_some(written)
}

/// Removes the temporary files in `folder` that killed processes left. `is_wanted` receives the
/// name of the file that was to be written. A file that another process is writing stays, because
/// it is locked.
///
/// Files that cannot be removed stay. This is not an error.
pub fn remove_leftovers(folder: &Path, is_wanted: impl Fn(&str) -> bool) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !name.to_str().and_then(written_under).is_some_and(&is_wanted) {
            continue;
        }
        let path = entry.path();
        let Ok(file) = File::options().read(true).write(true).open(&path) else { continue };
        if file.try_lock().is_ok() {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Creates missing folders and checks whether `path` can be written. The file itself is not
/// changed. Removes the temporary files that a killed process left for the same file.
///
/// # Errors
/// As [`destination`], or the operating system's reason why the file cannot be created.
pub fn probe(path: &Path) -> std::io::Result<()> {
    let path = destination(path)?;
    std::fs::create_dir_all(folder_of(&path))?;
    let name = path.file_name().and_then(|name| name.to_str());
    remove_leftovers(folder_of(&path), |written| Some(written) == name);
    temporary(&path)?.close()
}

/// Writes `bytes` to a temporary file beside `path` and renames it, so that a reader sees either
/// the old file or the complete new one. Missing folders are created. A symbolic link stays; the
/// file that it leads to is replaced.
///
/// # Errors
/// [`RecordError::Io`] with the path if it is not a regular file, or if creating a folder, writing
/// the temporary file or renaming it fails. The temporary file is then removed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), RecordError> {
    let write = || {
        let path = destination(path)?;
        std::fs::create_dir_all(folder_of(&path))?;
        let mut temporary = temporary(&path)?;
        temporary.as_file_mut().write_all(bytes)?;
        temporary.as_file().sync_all()?;
        temporary.persist(&path)?;
        Ok(())
    };
    write().map_err(|source| RecordError::Io { path: path.to_owned(), action: "write", source })
}

/// A value as indented JSON with a final newline.
///
/// # Errors
/// [`RecordError::Format`], which names `path`, if the value has a key that is not a string.
pub fn json(path: &Path, value: &impl Serialize) -> Result<Vec<u8>, RecordError> {
    let mut bytes = serde_json::to_vec_pretty(value)
        .map_err(|source| RecordError::Format { path: path.to_owned(), source })?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Writes a value as indented JSON with a final newline, atomically.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), RecordError> {
    write_atomically(path, &json(path, value)?)
}

/// Reads a record.
///
/// # Errors
/// [`RecordError::Io`] if the file cannot be read, [`RecordError::Unfit`] if it is not a regular
/// file or is too long, [`RecordError::Format`] with line and column if it is not of type `T`.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, RecordError> {
    let fail = |source| RecordError::Io { path: path.to_owned(), action: "read", source };
    // Opening a pipe would wait for a writer, and some devices have no end.
    let metadata = path.metadata().map_err(fail)?;
    if !metadata.is_file() || metadata.len() > MOST_BYTES {
        let found = match metadata.is_file() {
            true => format!("{} bytes", metadata.len()),
            false => "no regular file".to_owned(),
        };
        return Err(RecordError::Unfit { path: path.to_owned(), found });
    }
    let text = std::fs::read(path).map_err(fail)?;
    serde_json::from_slice(&text)
        .map_err(|source| RecordError::Format { path: path.to_owned(), source })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests;
