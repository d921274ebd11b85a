//! Errors of scenes and frozen systems.

use std::path::PathBuf;

/// A value that is out of range or contradicts another.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{path}` is {value}; expected {expected}")]
pub struct Violation {
    /// Path of the key from the root of the file, e.g. `particles.mass_kg[3]`.
    pub path: String,
    /// The value found there.
    pub value: String,
    /// The allowed values.
    pub expected: String,
}

impl Violation {
    pub(crate) fn new(
        path: impl Into<String>,
        value: impl ToString,
        expected: impl Into<String>,
    ) -> Self {
        Self { path: path.into(), value: shorten(&value.to_string()), expected: expected.into() }
    }
}

/// Shortens a quotation to one line of at most 80 characters by cutting its middle.
pub(crate) fn shorten(text: &str) -> String {
    const MOST: usize = 80;
    let mut line = String::new();
    for c in text.chars() {
        match c {
            ' ' | '\n' | '\t' | '\r' if line.ends_with(' ') => {}
            '\n' | '\t' | '\r' => line.push(' '),
            c if c.is_control() || c == '\u{feff}' => line.extend(c.escape_unicode()),
            c => line.push(c),
        }
    }
    let length = line.chars().count();
    if length <= MOST {
        return line;
    }
    let head: String = line.chars().take(MOST / 2).collect();
    let tail: String = line.chars().skip(length - MOST / 4).collect();
    format!("{head}…{tail}")
}

/// Least likeness of two names, by Jaro and Winkler, where one may be meant for the other.
const LIKE: f64 = 0.85;

/// The known name that is most like an unknown one, as a part of a sentence: `` (nearest: `NAME`)``
/// after a space. It is empty where none is like it.
pub fn nearest<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> String {
    let likeness = known.into_iter().map(|other| (strsim::jaro_winkler(name, other), other));
    let like = likeness.filter(|(share, _)| *share >= LIKE).max_by(|a, b| a.0.total_cmp(&b.0));
    like.map_or_else(String::new, |(_, other)| format!(" (nearest: `{other}`)"))
}

/// Why a scene or a frozen system was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The name is neither a bundled scene nor a file.
    #[error(
        "no scene `{name}`{}: there is no such file; expected one, or one of the bundled scenes {}",
        nearest(name, known.iter().copied()),
        known.join(", ")
    )]
    Unknown {
        /// The requested name.
        name: String,
        /// Names of the bundled scenes.
        known: Vec<&'static str>,
    },
    /// The file could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The text is not JSON.
    #[error(
        "{file}: no valid JSON at line {line}, column {column} (in `{path}`): {reason}; \
         found {found}; expected a scene (\"drape-scene/1\") or \
         a frozen system (\"drape-system/1\")"
    )]
    Syntax {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Path of the key that was being read.
        path: String,
        /// The parser's reason.
        reason: String,
        /// The text at that place.
        found: String,
    },
    /// A key is unknown or missing, or a value has the wrong type.
    #[error("{file}: {violation} (line {line}, column {column})")]
    Shape {
        /// The file.
        file: String,
        /// Line at which the parser noticed the error, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Key, value and what was expected.
        violation: Violation,
    },
    /// A value is out of range.
    #[error("{file}: {violation}")]
    Invalid {
        /// The file.
        file: String,
        /// Key, value and what was expected.
        violation: Violation,
    },
}
