//! Reading scenes and frozen systems from files, with errors that name the place.

use crate::error::{SceneError, Violation, shorten};
use crate::scene::SCENE_FORMAT;
use crate::spec::SYSTEM_FORMAT;
use crate::strict::Strict;
use crate::{Cloth, Scene, Size, SystemSpec, bundled};
use serde::de::DeserializeOwned;
use serde_json::value::RawValue;
use serde_path_to_error::{Path as Keys, Segment};
use std::collections::BTreeMap;
use std::io::{ErrorKind, Read as _};
use std::path::Path;

/// A file that describes a cloth. Either kind may be given where a scene is expected.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneFile {
    /// A scene, with its discretisation.
    Scene(Box<Scene>, SystemSpec),
    /// A frozen system.
    System(SystemSpec),
}

impl SceneFile {
    /// The discretised system.
    pub fn spec(&self) -> &SystemSpec {
        match self {
            Self::Scene(_, spec) | Self::System(spec) => spec,
        }
    }

    /// Descriptions of the repairs to the scene's mesh; see
    /// [`MeshCloth::repair`](crate::MeshCloth::repair). Empty for a frozen system.
    pub fn repairs(&self) -> &[String] {
        match self.scene().map(|scene| &scene.cloth) {
            Some(Cloth::Mesh(mesh)) => mesh.repairs(),
            _ => &[],
        }
    }

    /// The scene, if the file holds one; `None` for a frozen system.
    pub fn scene(&self) -> Option<&Scene> {
        match self {
            Self::Scene(scene, _) => Some(scene),
            Self::System(_) => None,
        }
    }
}

/// Loads a bundled scene by name, or a scene or frozen system from a file.
///
/// # Errors
/// A [`SceneError`] if the name is unknown, the file cannot be read, the JSON is broken, a key is
/// unknown or missing, or a value is out of range.
///
/// ```
/// let input = drape_model::load("hanging-textile-1e4").expect("bundled");
/// assert_eq!(input.spec().particles.mass_kg.len(), 400);
/// ```
pub fn load(scene: &str) -> Result<SceneFile, SceneError> {
    load_within(scene, |_| Ok(()))
}

/// Largest size of a file with a scene or a frozen system, bytes.
pub const MAX_FILE_BYTES: u64 = 4 << 30;

/// As [`load`], if `allow` permits the size. `allow` is called twice, each time before memory is
/// allocated: first with the size of the file alone, then with all sizes once the text is read.
///
/// # Errors
/// As [`load`], and the [`Violation`] that `allow` returns.
pub fn load_within(
    scene: &str,
    allow: impl Fn(&Size) -> Result<(), Violation>,
) -> Result<SceneFile, SceneError> {
    if let Some(text) = bundled::text(scene) {
        return parse_within(scene, text, allow);
    }
    let fail = |source: std::io::Error| match source.kind() {
        ErrorKind::NotFound => {
            SceneError::Unknown { name: scene.to_owned(), known: bundled::names().collect() }
        }
        _ => SceneError::Io { path: scene.into(), source },
    };
    let invalid = |violation| SceneError::Invalid { file: scene.to_owned(), violation };
    let refuse = |found: String| {
        let most = MAX_FILE_BYTES >> 30;
        let expected = format!(
            "a regular file of at most {most} GiB; save what a pipe or a device gives to a file"
        );
        invalid(Violation::new(".", found, expected))
    };
    // Opening a pipe would wait for a writer, and some devices have no end.
    let metadata = std::fs::metadata(scene).map_err(fail)?;
    if !metadata.is_file() {
        return Err(refuse("no regular file".to_owned()));
    }
    let size = Size { file: metadata.len(), ..Size::default() };
    if size.file > MAX_FILE_BYTES {
        return Err(refuse(format!("{} bytes long", size.file)));
    }
    allow(&size).map_err(invalid)?;
    let mut bytes = Vec::new();
    let file = std::fs::File::open(scene).map_err(fail)?;
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(refuse("longer than it said".to_owned()));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let last = valid.rsplit(|&byte| byte == b'\n').next().unwrap_or_default();
        SceneError::Syntax {
            file: scene.to_owned(),
            line: 1 + valid.iter().filter(|&&byte| byte == b'\n').count(),
            column: 1 + last.len(),
            path: ".".to_owned(),
            reason: "not UTF-8".to_owned(),
            found: format!("byte 0x{:02x}", error.as_bytes()[valid.len()]),
        }
    })?;
    parse_within(scene, &text, allow)
}

/// Reads a scene or a frozen system from text. Errors name the text `file`. Paths of meshes are
/// relative to the folder of `file`.
///
/// # Errors
/// As [`load`], except errors of the file system.
pub fn parse(file: &str, text: &str) -> Result<SceneFile, SceneError> {
    parse_within(file, text, |_| Ok(()))
}

fn parse_within(
    file: &str,
    text: &str,
    allow: impl Fn(&Size) -> Result<(), Violation>,
) -> Result<SceneFile, SceneError> {
    let length = text.len() as u64;
    let invalid = |violation| SceneError::Invalid { file: file.to_owned(), violation };
    // Checks the syntax of the whole text and finds the key that names the format.
    let keys: BTreeMap<String, &RawValue> =
        serde_json::from_str(text).map_err(|error| refuse(file, text, &error))?;
    let expected = format!("{SCENE_FORMAT:?} or {SYSTEM_FORMAT:?}");
    let Some(format) = keys.get("format").map(|raw| raw.get()) else {
        return Err(invalid(Violation::new("format", "missing", expected)));
    };
    match serde_json::from_str(format).unwrap_or_default() {
        Format::Scene => {
            let mut scene: Scene = read(file, text)?;
            let folder = Path::new(file).parent();
            if let Cloth::Mesh(mesh) = &mut scene.cloth {
                mesh.load(folder).map_err(invalid)?;
            }
            if let Some(material) = &mut scene.material {
                material.load(folder).map_err(invalid)?;
            }
            let size = Size::of_scene(&scene).map_err(invalid)?;
            allow(&Size { file: length, ..size }).map_err(invalid)?;
            let spec = scene.discretise().map_err(invalid)?;
            Ok(SceneFile::Scene(Box::new(scene), spec))
        }
        Format::System => {
            let spec: SystemSpec = read(file, text)?;
            allow(&Size { file: length, ..Size::of_system(&spec) }).map_err(invalid)?;
            spec.check().map_err(invalid)?;
            Ok(SceneFile::System(spec))
        }
        Format::Unknown => Err(invalid(Violation::new("format", format, expected))),
    }
}

#[derive(Default, serde::Deserialize)]
enum Format {
    #[serde(rename = "drape-scene/1")]
    Scene,
    #[serde(rename = "drape-system/1")]
    System,
    #[default]
    #[serde(other)]
    Unknown,
}

/// Reads text whose syntax was checked.
fn read<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, SceneError> {
    let mut json = serde_json::Deserializer::from_str(text);
    serde_path_to_error::deserialize(Strict(&mut json)).map_err(|error| {
        let (path, error) = (error.path(), error.inner());
        let violation = explain(path, raw_value(text, path), &reason(error));
        let (line, column) = (error.line(), error.column());
        SceneError::Shape { file: file.to_owned(), line, column, violation }
    })
}

/// The error for a text that is not a JSON object.
fn refuse(file: &str, text: &str, error: &serde_json::Error) -> SceneError {
    let (file, line, column) = (file.to_owned(), error.line(), error.column());
    if error.is_data() {
        let violation = Violation::new(".", text.trim(), "an object");
        return SceneError::Shape { file, line, column, violation };
    }
    // The same error once more, this time with the path of the key at which it occurs.
    let mut json = serde_json::Deserializer::from_str(text);
    let path = match serde_path_to_error::deserialize::<_, serde_json::Value>(&mut json) {
        Err(again) if (again.inner().line(), again.inner().column()) == (line, column) => {
            shorten(&again.path().to_string().replace('?', "."))
        }
        _ => ".".to_owned(),
    };
    let found = excerpt(text, line, column);
    SceneError::Syntax { file, line, column, path, reason: reason(error), found }
}

/// serde_json's message without the place; errors have fields for the place.
fn reason(error: &serde_json::Error) -> String {
    let message = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    message.strip_suffix(&place).unwrap_or(&message).to_owned()
}

/// The text of the value at a path, as it stands in the file.
fn raw_value(text: &str, path: &Keys) -> Option<String> {
    let mut raw: &RawValue = serde_json::from_str(text).ok()?;
    for segment in path {
        raw = match segment {
            Segment::Seq { index } => {
                *serde_json::from_str::<Vec<&RawValue>>(raw.get()).ok()?.get(*index)?
            }
            Segment::Map { key } | Segment::Enum { variant: key } => {
                *serde_json::from_str::<BTreeMap<String, &RawValue>>(raw.get()).ok()?.get(key)?
            }
            Segment::Unknown => return None,
        };
    }
    Some(raw.get().to_owned())
}

/// Translates a message of serde to the words of a scene file.
fn explain(path: &Keys, raw: Option<String>, reason: &str) -> Violation {
    let parent = path.to_string();
    let inside = |outer: &str, name: &str| match shorten(outer).as_str() {
        "" | "." => shorten(name),
        outer => format!("{outer}.{}", shorten(name)),
    };
    // serde appends an unknown key to the path, but not a missing or doubled one.
    let outer = |name: &str| parent.strip_suffix(name).unwrap_or(&parent).trim_end_matches('.');
    let raw = raw.unwrap_or_default();
    let (what, expected) = reason.split_once(", expected ").unwrap_or((reason, ""));
    let (kind, name) = what.split_once('`').unwrap_or((what, ""));
    let name = name.trim_end_matches('`');
    match kind.trim_end() {
        "unknown field" => {
            Violation::new(inside(outer(name), name), "an unknown key", known(expected))
        }
        "unknown variant" if raw.starts_with('{') => {
            Violation::new(inside(&parent, name), "an unknown key", known(expected))
        }
        "missing field" => {
            Violation::new(inside(&parent, name), "missing", "this key with a value")
        }
        "duplicate field" => Violation::new(inside(&parent, name), "given twice", "this key once"),
        "invalid type: unit variant" => {
            // A word in place of an object; serde appends the word to the path.
            let (outer, word) = parent.rsplit_once('.').unwrap_or((".", &parent));
            Violation::new(outer, format!("{word:?}"), expected)
        }
        "number out of range" => {
            Violation::new(parent, raw, "a number of magnitude at most 1.8e308")
        }
        _ if expected.is_empty() => Violation::new(parent, raw, format!("another value: {reason}")),
        _ => Violation::new(parent, raw, known(expected)),
    }
}

/// serde's names of expected types, in plain words.
fn known(expected: &str) -> String {
    let plain = match expected {
        "f64" => "a number",
        "u32" => "a whole number from 0 to 4294967295",
        "a sequence" => "a list",
        "a string" => "a string in quotes",
        other if other.starts_with("an array of length") => {
            return other.replace("an array of length", "a list of length");
        }
        other if other.starts_with("struct ") => "an object",
        other => other,
    };
    plain.to_owned()
}

/// The text around a place, short enough for a message.
fn excerpt(text: &str, line: usize, column: usize) -> String {
    let row = text.split('\n').nth(line.saturating_sub(1)).unwrap_or_default();
    if text.trim().is_empty() {
        return "an empty file".to_owned();
    }
    // Columns count bytes.
    let mut start = column.saturating_sub(24).min(row.len());
    let mut end = (column + 8).min(row.len());
    while !row.is_char_boundary(start) {
        start -= 1;
    }
    while !row.is_char_boundary(end) {
        end += 1;
    }
    match row[start..end].trim() {
        "" => "the end of the file".to_owned(),
        around => format!("`{}`", shorten(around)),
    }
}
