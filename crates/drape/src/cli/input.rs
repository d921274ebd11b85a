//! Scenes and discretised systems for commands.

use drape_model::{SceneError, SceneFile};
use drape_report::tell;

/// Loads a scene or a discretised system, and reports repairs of its mesh on standard error.
pub(crate) fn load(scene: &str) -> Result<SceneFile, SceneError> {
    let input = drape_model::load(scene)?;
    for repair in input.repairs() {
        tell!("drape: {scene}: mesh mended: {repair}");
    }
    Ok(input)
}
