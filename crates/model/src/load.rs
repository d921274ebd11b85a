//! Reading scenes and frozen systems from files, with errors that name the place.

use crate::error::{SceneError, Violation};
use crate::scene::SCENE_FORMAT;
use crate::spec::SYSTEM_FORMAT;
use crate::{Scene, SystemSpec, bundled};
use serde::de::{DeserializeOwned, IgnoredAny};
use std::path::Path;

/// What a file held: both kinds are interchangeable wherever a scene is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// A scene, with its discretisation.
    Scene(Box<Scene>, SystemSpec),
    /// A frozen system.
    System(SystemSpec),
}

impl Input {
    /// The discretised system.
    pub fn spec(&self) -> &SystemSpec {
        match self {
            Self::Scene(_, spec) | Self::System(spec) => spec,
        }
    }

    /// The scene, if it was one.
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
/// Every [`SceneError`]: an unknown name, an unreadable file, broken JSON, unknown or missing keys,
/// values out of range.
///
/// ```
/// let input = drape_model::load("hanging-textile-1e4").expect("bundled");
/// assert_eq!(input.spec().particles.mass_kg.len(), 400);
/// ```
pub fn load(scene: &str) -> Result<Input, SceneError> {
    if let Some(text) = bundled::text(scene) {
        return parse(scene, text);
    }
    let path = Path::new(scene);
    if !path.exists() {
        let known = bundled::names().collect();
        return Err(SceneError::Unknown { name: scene.to_owned(), known });
    }
    let io = |source| SceneError::Io { path: path.to_owned(), source };
    let bytes = std::fs::read(path).map_err(io)?;
    match String::from_utf8(bytes) {
        Ok(text) => parse(scene, &text),
        Err(error) => Err(SceneError::Syntax {
            file: scene.to_owned(),
            line: 1 + error.as_bytes()[..error.utf8_error().valid_up_to()]
                .iter()
                .filter(|&&byte| byte == b'\n')
                .count(),
            column: 1,
            path: ".".to_owned(),
            reason: "not UTF-8".to_owned(),
            found: "binary data".to_owned(),
        }),
    }
}

/// Reads a scene or a frozen system from text; `file` is what errors call it.
///
/// # Errors
/// As [`load`], less those of the file system.
pub fn parse(file: &str, text: &str) -> Result<Input, SceneError> {
    let invalid = |violation| SceneError::Invalid { file: file.to_owned(), violation };
    let header: Header = read(file, text)?;
    let format = match &header.format {
        Some(FormatOrAny::Format(format)) => format.as_str(),
        Some(FormatOrAny::Any(_)) => "",
        None => {
            let expected = format!("{SCENE_FORMAT:?} or {SYSTEM_FORMAT:?}");
            return Err(invalid(Violation::new("format", "missing", expected)));
        }
    };
    if format == SYSTEM_FORMAT {
        let spec: SystemSpec = read(file, text)?;
        spec.build().map_err(invalid)?;
        return Ok(Input::System(spec));
    }
    if format != SCENE_FORMAT {
        let found = if format.is_empty() { "no such string".to_owned() } else { format!("{format:?}") };
        let expected = format!("{SCENE_FORMAT:?} or {SYSTEM_FORMAT:?}");
        return Err(invalid(Violation::new("format", found, expected)));
    }
    let scene: Scene = read(file, text)?;
    let spec = scene.discretise().map_err(invalid)?;
    Ok(Input::Scene(Box::new(scene), spec))
}

/// The one key that tells what the rest is.
#[derive(serde::Deserialize)]
struct Header {
    format: Option<FormatOrAny>,
}

#[derive(serde::Deserialize)]
#[serde(untagged)]
enum FormatOrAny {
    Format(String),
    Any(IgnoredAny),
}

fn read<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, SceneError> {
    let mut json = serde_json::Deserializer::from_str(text);
    let value = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let path = error.path().to_string();
        describe(file, text, path, error.inner())
    })?;
    json.end().map_err(|error| describe(file, text, ".".to_owned(), &error))?;
    Ok(value)
}

fn describe(file: &str, text: &str, path: String, error: &serde_json::Error) -> SceneError {
    let file = file.to_owned();
    if error.is_data() {
        return SceneError::Shape { file, path, reason: error.to_string() };
    }
    let message = error.to_string();
    let reason = message.split(" at line ").next().unwrap_or(&message).to_owned();
    let (line, column) = (error.line(), error.column());
    SceneError::Syntax { file, line, column, path, reason, found: excerpt(text, line, column) }
}

/// The text around a place, short enough for a message. (A number out of range is reported at its end.)
fn excerpt(text: &str, line: usize, column: usize) -> String {
    let row = text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
    let row: Vec<char> = row.chars().collect();
    if row.is_empty() {
        return if text.trim().is_empty() { "an empty file" } else { "the end of the file" }.to_owned();
    }
    let end = (column + 8).min(row.len());
    let start = column.saturating_sub(24).min(end);
    format!("`{}`", row[start..end].iter().collect::<String>().trim())
}
