//! Standard output, and where results go.

use drape_harness::record::Run;
use drape_model::Violation;
use drape_report::file::{json, probe, write_atomically};
use drape_report::tell;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a text to standard output. [`crate::cli::exit`] forgives a closed pipe.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    Ok(write(&mut std::io::stdout().lock(), text.as_bytes())?)
}

fn write(out: &mut impl Write, bytes: &[u8]) -> std::io::Result<()> {
    out.write_all(bytes)?;
    out.flush()
}

/// Checks that the extension of a file fits its content.
pub(crate) fn check_extension(
    key: &str,
    file: &Path,
    extension: &str,
    content: &str,
) -> Result<(), Violation> {
    let found = file.extension().unwrap_or_default();
    if found.eq_ignore_ascii_case(extension) || is_stream(file) {
        return Ok(());
    }
    let expected = format!("a name that ends in .{extension}: the file is a {content}");
    Err(Violation { path: key.to_owned(), value: format!("`{}`", file.display()), expected })
}

/// A line of a CSV file (RFC 4180). Fields with a comma, a quote or a line break stand in quotes.
pub(crate) fn csv_line<'a>(fields: impl Iterator<Item = &'a str>) -> String {
    let quoted = fields.map(|field| {
        if field.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", field.replace('"', "\"\""))
        } else {
            field.to_owned()
        }
    });
    quoted.collect::<Vec<_>>().join(",") + "\n"
}

/// Names of the standard output.
const STANDARD_OUTPUT: [&str; 4] = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// Where a result goes: a file, or a pipe that the caller opened.
#[derive(Debug)]
pub(crate) enum Sink {
    /// Standard output.
    Standard,
    /// Another pipe of the process, such as the shell makes for `>(gzip)`.
    Pipe(PathBuf, File),
    /// A file, which is replaced as a whole.
    File(PathBuf),
}

/// Whether a name means a pipe that the caller opened.
pub(crate) fn is_stream(file: &Path) -> bool {
    let is_standard = STANDARD_OUTPUT.iter().any(|name| file == Path::new(name));
    is_standard || is_pipe_of_this_process(file)
}

fn is_pipe_of_this_process(file: &Path) -> bool {
    let opened = ["/dev/fd", "/proc/self/fd", "/dev/stderr"];
    opened.iter().any(|folder| file.starts_with(folder)) && is_pipe(file)
}

#[cfg(unix)]
fn is_pipe(file: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    file.metadata().is_ok_and(|metadata| metadata.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_file: &Path) -> bool {
    false
}

impl Sink {
    /// Checks, before the run, that a result can be written, and that this destroys neither an
    /// input nor anything but a regular file. Makes missing folders.
    pub(crate) fn check(key: &str, file: &Path, inputs: &[PathBuf]) -> Result<Self, Violation> {
        let refuse = |expected: String| Violation {
            path: key.to_owned(),
            value: format!("`{}`", file.display()),
            expected,
        };
        if STANDARD_OUTPUT.iter().any(|name| file == Path::new(name)) {
            return Ok(Self::Standard);
        }
        let unwritable = |reason: String| refuse(format!("a file that can be written ({reason})"));
        if is_pipe_of_this_process(file) {
            let pipe = File::options().write(true).open(file);
            let pipe = pipe.map_err(|error| unwritable(error.to_string()))?;
            return Ok(Self::Pipe(file.to_owned(), pipe));
        }
        if let Some(input) = inputs.iter().find(|input| is_same(input, file)) {
            let input = input.display();
            return Err(refuse(format!("another file than the input `{input}`")));
        }
        if file.file_name().is_none() {
            return Err(unwritable("it names no file".to_owned()));
        }
        probe(file).map_err(|error| unwritable(error.to_string()))?;
        Ok(Self::File(file.to_owned()))
    }

    /// Refuses an output that is also another one.
    pub(crate) fn check_apart(
        &self,
        key: &str,
        other: &Self,
        named: &str,
    ) -> Result<(), Violation> {
        let (value, is_same) = match (self, other) {
            (Self::Standard, Self::Standard) => ("standard output".to_owned(), true),
            (Self::File(a), Self::File(b)) => (format!("`{}`", a.display()), is_same(a, b)),
            _ => (String::new(), false),
        };
        if !is_same {
            return Ok(());
        }
        Err(Violation {
            path: key.to_owned(),
            value,
            expected: format!("another file than {named}"),
        })
    }

    /// Whether the result goes to standard output.
    pub(crate) fn is_standard(&self) -> bool {
        matches!(self, Self::Standard)
    }

    /// Writes the result and says so.
    pub(crate) fn write(&self, bytes: &[u8]) -> anyhow::Result<()> {
        match self {
            Self::Standard => forgive(write(&mut std::io::stdout().lock(), bytes)),
            Self::Pipe(_, pipe) => forgive(write(&mut &*pipe, bytes)),
            Self::File(path) => {
                write_atomically(path, bytes)?;
                tell!("wrote {}", path.display());
                Ok(())
            }
        }
    }

    /// Writes a run as JSON and says so.
    pub(crate) fn write_run(&self, run: &Run) -> anyhow::Result<()> {
        self.write(&json(self.path(), run)?)
    }

    fn path(&self) -> &Path {
        match self {
            Self::Standard => Path::new("standard output"),
            Self::Pipe(path, _) | Self::File(path) => path,
        }
    }
}

impl std::fmt::Display for Sink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.path().display().fmt(f)
    }
}

/// A reader that has seen enough is no failure, and what follows is done nevertheless.
fn forgive(written: std::io::Result<()>) -> anyhow::Result<()> {
    match written {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other?),
    }
}

/// Whether two names lead to the same file.
fn is_same(a: &Path, b: &Path) -> bool {
    let place = |file: &Path| {
        file.canonicalize().ok().or_else(|| {
            let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
            Some(folder.join(file.file_name()?))
        })
    };
    let is_same_place = place(a).is_some_and(|a| place(b) == Some(a));
    is_same_place || is_same_node(a, b)
}

/// Whether two names are links to the same file.
#[cfg(unix)]
fn is_same_node(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let node = |file: &Path| file.metadata().ok().map(|node| (node.dev(), node.ino()));
    node(a).is_some_and(|a| node(b) == Some(a))
}

#[cfg(not(unix))]
fn is_same_node(_a: &Path, _b: &Path) -> bool {
    false
}

/// Checks, before the work, that files can be written into a folder. Makes it if it is missing.
pub(crate) fn check_folder(key: &str, folder: &Path) -> Result<(), Violation> {
    let refuse = |reason: String| Violation {
        path: key.to_owned(),
        value: format!("`{}`", folder.display()),
        expected: format!("a folder that can be written ({reason})"),
    };
    probe(&folder.join("probe")).map_err(|error| refuse(error.to_string()))
}
