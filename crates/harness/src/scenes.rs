//! Bundled scenes and variations of them, for experiments.

use crate::{HarnessError, Simulation};
use drape_model::{
    Cloth, Effects, Scene, SceneError, SceneFile, SpringLaw, SystemSpec, TimeSpan, Violation,
};

/// A bundled scene.
///
/// # Errors
/// [`HarnessError::Scene`] when no bundled scene has that name.
pub fn bundled(name: &str) -> Result<Scene, HarnessError> {
    match drape_model::load(name)? {
        SceneFile::Scene(scene, _) => Ok(*scene),
        SceneFile::System(_) => {
            let known = drape_model::bundled::names().collect();
            Err(SceneError::Unknown { name: name.to_owned(), known }.into())
        }
    }
}

/// The scene from which a study starts, by its name `STUDY/NAME`; `None` where no study has that
/// name.
///
/// # Errors
/// [`HarnessError::UnknownStart`] where the study has no such start; it names the starts of the
/// study.
pub fn study_scene(name: &str) -> Result<Option<SceneFile>, HarnessError> {
    let Some(start) = crate::studies::start(name)? else { return Ok(None) };
    // Numbers are written with all their digits, so reading the text gives the same bits.
    let text = serde_json::to_string(&start.system()?).map_err(|error| Violation {
        path: name.to_owned(),
        value: error.to_string(),
        expected: "a system that can be written as JSON".to_owned(),
    })?;
    Ok(Some(drape_model::parse(name, &text)?))
}

/// The step and the duration, s, from the options or else from the scene.
///
/// # Errors
/// [`Violation`] where one is missing or out of range.
pub fn time_span(
    dt: Option<f64>,
    duration: Option<f64>,
    input: &SceneFile,
) -> Result<TimeSpan, Violation> {
    let usual = input.scene().map(|scene| scene.time);
    let missing = |key: &str| Violation {
        path: key.to_owned(),
        value: "missing".to_owned(),
        expected: format!("`{key} SECONDS`, because a discretised system states no time"),
    };
    let time = TimeSpan {
        step_s: dt.or(usual.map(|t| t.step_s)).ok_or_else(|| missing("--dt"))?,
        duration_s: duration
            .or(usual.map(|t| t.duration_s))
            .ok_or_else(|| missing("--duration"))?,
    };
    time.check("--dt", "--duration")?;
    Ok(time)
}

/// The laws of the springs that the scene names.
fn spring_laws(scene: &mut Scene) -> impl Iterator<Item = &mut SpringLaw> {
    let Effects { tension, shear, bending, .. } = &mut scene.effects;
    [tension, shear, bending].into_iter().flatten()
}

/// The scene with another stiffness over mass of its tension springs, 1/s². Its shear and bending
/// springs change in the same proportion.
pub fn with_stiffness(mut scene: Scene, stiffness_over_mass: f64) -> Scene {
    let tension = scene.effects.tension.as_ref().and_then(|law| law.stiffness_over_mass_per_s2);
    let factor = stiffness_over_mass / tension.unwrap_or(stiffness_over_mass);
    for law in spring_laws(&mut scene) {
        if let Some(quotient) = &mut law.stiffness_over_mass_per_s2 {
            *quotient *= factor;
        }
    }
    if let Some(tension) = &mut scene.effects.tension {
        tension.stiffness_over_mass_per_s2 = Some(stiffness_over_mass);
    }
    scene
}

/// The scene with all its quotients of damping over mass multiplied by `factor`.
pub fn with_damping_scaled(mut scene: Scene, factor: f64) -> Scene {
    for law in spring_laws(&mut scene) {
        if let Some(quotient) = &mut law.damping_over_mass_per_s {
            *quotient *= factor;
        }
    }
    scene
}

/// The scene on a finer or coarser square grid; pins at corners stay there.
pub fn with_particles_a_side(mut scene: Scene, side: u32) -> Scene {
    if let Cloth::Grid(grid) = &mut scene.cloth {
        let last = (grid.rows - 1, grid.columns - 1);
        for pin in &mut scene.pins {
            pin.row = pin.row.map(|row| if row == last.0 { side - 1 } else { row });
            pin.column = pin.column.map(|column| if column == last.1 { side - 1 } else { column });
        }
        (grid.rows, grid.columns) = (side, side);
    }
    scene
}

/// Discretises a scene and builds it.
pub(crate) fn build(scene: &Scene) -> Result<(SystemSpec, Simulation), HarnessError> {
    let spec = scene.discretise()?;
    let (system, state) = spec.build()?;
    Ok((spec, Simulation { system, state }))
}

/// The particle in the middle of the last row of a grid: the free edge of the hanging textile.
pub fn free_edge_midpoint(scene: &Scene) -> Option<usize> {
    match scene.cloth {
        Cloth::Grid(grid) => Some(((grid.rows - 1) * grid.columns + grid.columns / 2) as usize),
        Cloth::Mesh(_) | Cloth::Particles(_) => None,
    }
}
