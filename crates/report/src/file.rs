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
    /// What stands there is no file that can be read to its end.
    #[error(
        "{}: {found}; expected a regular file of at most {} GiB", path.display(), MOST_BYTES >> 30
    )]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What stands there.
        found: String,
    },
    /// The file is no record of the expected kind.
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
}

/// Most bytes of a record.
const MOST_BYTES: u64 = 4 << 30;

/// Most symbolic links that lead from one to the next.
const MOST_LINKS: usize = 40;

/// The file that a write to `path` replaces: `path` itself, or where its symbolic links lead. It
/// need not exist.
///
/// # Errors
/// When `path` is a folder, a device, a pipe or a socket: a file in its place would destroy it.
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

/// The temporary name beside `path` under which this process writes it.
fn temporary(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    path.with_file_name(name)
}

/// Makes a new file under a temporary name, and never follows a link that lies there.
fn create(temporary: &Path) -> std::io::Result<std::fs::File> {
    // A process that was killed may have had the same number.
    let _ = std::fs::remove_file(temporary);
    std::fs::File::create_new(temporary)
}

/// Removes the temporary files in `folder` that processes left which were killed, where `is_wanted`
/// of the name of the file to be written. Those of a process that still works stay.
///
/// Only Linux tells which processes work. Elsewhere nothing is removed. What cannot be removed
/// stays: it is litter, and no reason to stop.
pub fn remove_leftovers(folder: &Path, is_wanted: impl Fn(&str) -> bool) {
    let processes = Path::new("/proc");
    if !processes.join("self").exists() {
        return;
    }
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let parts = name.to_str().and_then(|name| name.strip_suffix(".tmp")?.rsplit_once('.'));
        let Some((written, process)) = parts else { continue };
        let is_number = process.parse::<u32>().is_ok_and(|n| n.to_string() == process);
        if is_number && is_wanted(written) && !processes.join(process).exists() {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Makes missing folders and finds out whether `path` can be written, which it leaves alone. Removes
/// what a killed process left of the same file.
///
/// # Errors
/// As [`destination`], and the system's reason why no file can be made there.
pub fn probe(path: &Path) -> std::io::Result<()> {
    let path = destination(path)?;
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)?;
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let name = path.file_name().and_then(|name| name.to_str());
    remove_leftovers(folder.unwrap_or(Path::new(".")), |written| Some(written) == name);
    let temporary = temporary(&path);
    create(&temporary).and_then(|_| std::fs::remove_file(&temporary))
}

/// Writes `bytes` to a temporary name beside `path` and renames it, so that a reader sees the old
/// file or the whole new one. Missing folders are made. A symbolic link stays; the file that it
/// leads to is replaced.
///
/// # Errors
/// [`RecordError::Io`] with the path when it is no regular file, or when a folder, the temporary
/// file or the rename fails; the temporary file is removed then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), RecordError> {
    let fail = |source| RecordError::Io { path: path.to_owned(), action: "write", source };
    let path = &destination(path).map_err(fail)?;
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(fail)?;
    }
    let temporary = temporary(path);
    let written = create(&temporary)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| std::fs::rename(&temporary, path));
    written.map_err(|source| {
        // The first failure is the one to report; a left-over temporary file is only litter.
        let _ = std::fs::remove_file(&temporary);
        fail(source)
    })
}

/// A value as indented JSON with a final newline.
///
/// # Errors
/// [`RecordError::Format`], which names `path`, when the value has a key that is no string.
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
/// [`RecordError::Io`] when the file cannot be read, [`RecordError::Unfit`] when it is none or too
/// long, [`RecordError::Format`] with line and column
/// when it is not of type `T`.
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
