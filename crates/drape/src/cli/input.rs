//! Scenes and discretised systems for commands.

use crate::cli::limit::LimitArguments;
use drape_harness::methods::Choice;
use drape_harness::study_scene;
use drape_model::{Cloth, SceneError, SceneFile, Violation, bundled, nearest};
use drape_report::tell;
use std::path::{Path, PathBuf};

/// Loads a scene, a discretised system or the start of a study, and reports repairs of its mesh on
/// standard error.
pub(crate) fn load(
    scene: &str,
    limit: LimitArguments,
    choice: Option<&Choice>,
) -> anyhow::Result<SceneFile> {
    let is_file = Path::new(scene).exists();
    if let Some(input) = if is_file { None } else { study_scene(scene)? } {
        return Ok(input);
    }
    let input = limit.load(scene, choice)?;
    for repair in input.repairs() {
        tell!("drape: {scene}: mesh mended: {repair}");
    }
    Ok(input)
}

/// The files that a scene was read from.
pub(crate) fn files(scene: &str, input: &SceneFile) -> Vec<PathBuf> {
    if bundled::text(scene).is_some() || !Path::new(scene).exists() {
        return Vec::new();
    }
    let mut files = vec![PathBuf::from(scene)];
    if let Some(Cloth::Mesh(mesh)) = input.scene().map(|scene| &scene.cloth) {
        files.push(Path::new(scene).parent().unwrap_or(Path::new("")).join(&mesh.file));
    }
    files
}

/// The refusal of a value, with the file that holds it.
pub(crate) fn in_file(scene: &str, violation: Violation) -> SceneError {
    SceneError::Invalid { file: scene.to_owned(), violation }
}

/// The refusal of a name in a place of the command line that takes one of the known names.
pub(crate) fn unknown_name(place: &str, name: &str, kind: &str, known: &[&str]) -> anyhow::Error {
    let like = nearest(name, known.iter().copied());
    let expected = format!("one of the {kind}{like}: {}", known.join(", "));
    Violation { path: place.to_owned(), value: format!("{name:?}"), expected }.into()
}
