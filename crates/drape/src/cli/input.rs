//! Scenes and frozen systems as commands take them.

use drape_model::{Input, SceneError};

/// Loads a scene or a frozen system, and says on stderr what had to be mended.
pub(crate) fn load(scene: &str) -> Result<Input, SceneError> {
    let input = drape_model::load(scene)?;
    for repair in input.repairs() {
        eprintln!("drape: {scene}: mesh mended: {repair}");
    }
    Ok(input)
}
