//! Scenes as a person writes them, format "drape-scene/1".

use crate::bounds::{number, positive};
use crate::effects::Weave;
use crate::error::Violation;
use crate::fabric::{self, MaterialChoice, MaterialKey};
use crate::select::{Pin, Selectable};
use crate::spec::MAX_OBSTACLES;
use crate::{Cloth, DampingLaw, Effects, EffectsSpec, ObstacleSpec, SystemSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The value of `format`.
pub(crate) const SCENE_FORMAT: &str = "drape-scene/1";

/// A scene: a cloth, the effects that act on it, pins, obstacles and the usual time step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Always "drape-scene/1".
    #[schemars(extend("const" = SCENE_FORMAT))]
    pub format: String,
    /// Short name.
    pub name: String,
    /// Subject and source of the scene.
    #[serde(default)]
    pub description: String,
    /// Keys whose values drape assumed because the source does not state them.
    #[serde(default)]
    pub assumed: Vec<String>,
    /// The cloth.
    pub cloth: Cloth,
    /// Material of the cloth, in place of masses and stiffnesses: the name of a bundled material,
    /// or an object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<MaterialKey>")]
    pub material: Option<MaterialChoice>,
    /// The effects. An effect that is not named does not act.
    #[serde(default)]
    pub effects: Effects,
    /// How the springs' damping acts.
    #[serde(default)]
    pub damping: DampingLaw,
    /// Selections of particles that stand still or follow a path.
    #[serde(default)]
    pub pins: Vec<Pin>,
    /// Rigid obstacles; at most 16 million pairs of a particle and an obstacle.
    #[serde(default)]
    #[schemars(length(max = MAX_OBSTACLES))]
    pub obstacles: Vec<ObstacleSpec>,
    /// Usual time step and duration.
    pub time: TimeSpan,
}

/// The usual time step and duration of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeSpan {
    /// Time step, s.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = Self::MAX_STEP_S))]
    pub step_s: f64,
    /// Simulated time, s.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = Self::MAX_DURATION_S))]
    pub duration_s: f64,
}

impl Scene {
    /// Checks the scene and discretises it.
    ///
    /// # Errors
    /// The first [`Violation`]: the path of the key, its value, and the expected values.
    pub fn discretise(&self) -> Result<SystemSpec, Violation> {
        if self.format != SCENE_FORMAT {
            let found = format!("{:?}", self.format);
            return Err(Violation::new("format", found, format!("{SCENE_FORMAT:?}")));
        }
        self.time.check("time.step_s", "time.duration_s")?;
        let mut spec = SystemSpec {
            name: self.name.clone(),
            damping: self.damping,
            effects: EffectsSpec { contact: self.effects.contact, ..EffectsSpec::default() },
            obstacles: self.obstacles.clone(),
            ..SystemSpec::default()
        };
        let material = self.material.as_ref().map(MaterialChoice::resolve).transpose()?;
        let density = material.as_ref().map(|material| material.areal_density_kg_m2);
        match &self.cloth {
            Cloth::Grid(grid) => {
                grid.check()?;
                spec.particles = grid.particles(density)?;
                spec.triangles = grid.triangles();
            }
            Cloth::Mesh(mesh) => (spec.particles, spec.triangles) = mesh.discretise(density)?,
            Cloth::Particles(cloth) => {
                spec.particles = cloth.particles.clone();
                spec.springs = cloth.springs.clone();
                spec.triangles = cloth.triangles.clone();
            }
        }
        spec.check_cloth().map_err(|violation| self.locate(violation))?;
        let cloth = &self.cloth;
        let mass = match cloth {
            Cloth::Grid(grid) => grid.particle_mass(),
            _ => None,
        };
        let mass = mass.unwrap_or_else(|| spec.particles.mean_mass());
        self.effects.freeze(Weave { cloth, mass }, &mut spec)?;
        if let (Some(choice), Some(material)) = (&self.material, &material) {
            fabric::weave(choice, material, cloth, &self.effects, &mut spec)?;
        }
        let selectable =
            Selectable { cloth, particles: &spec.particles, triangles: &spec.triangles };
        spec.pins = selectable.pins(&self.pins)?;
        self.stop_pinned(&mut spec);
        spec.check().map_err(|violation| self.locate(violation))?;
        Ok(spec)
    }

    /// The start velocity of a generated cloth is that of its free particles: a pinned one would
    /// count in the energy until the first step stops it. Explicit particles keep what they state.
    fn stop_pinned(&self, spec: &mut SystemSpec) {
        let SystemSpec { particles, pins, .. } = spec;
        if particles.velocity_m_s.is_empty() || matches!(self.cloth, Cloth::Particles(_)) {
            return;
        }
        for pin in pins {
            if let Some(velocity) = particles.velocity_m_s.get_mut(pin.particle as usize) {
                *velocity = [0.0; 3];
            }
        }
    }

    /// Translates the path of a violation in the frozen system to the path in the scene.
    fn locate(&self, mut violation: Violation) -> Violation {
        let inside_cloth =
            ["particles", "springs", "triangles"].iter().any(|key| violation.path.starts_with(key));
        if inside_cloth && matches!(self.cloth, Cloth::Particles(_)) {
            violation.path = format!("cloth.particles.{}", violation.path);
        }
        violation
    }
}

impl TimeSpan {
    /// Longest step, s.
    const MAX_STEP_S: f64 = 1e6;
    /// Longest duration, s.
    const MAX_DURATION_S: f64 = 1e9;
    /// Largest number of steps of a run.
    pub const MAX_STEPS: f64 = 1e9;

    /// Number of whole steps, and the length of a last shorter step. The last step is `None` if the
    /// duration is a multiple of the step within 1e-9.
    pub fn steps(&self) -> (u64, Option<f64>) {
        let quotient = self.duration_s / self.step_s;
        let whole = quotient.round();
        if whole >= 1.0 && (quotient - whole).abs() <= 1e-9 {
            return (whole as u64, None);
        }
        let whole = quotient.floor();
        (whole as u64, Some(self.duration_s - whole * self.step_s))
    }

    /// Checks both values; `step` and `duration` are the paths that a violation names.
    ///
    /// # Errors
    /// A [`Violation`] if the step or the duration is not positive and finite, or if there are more
    /// than 1e9 steps.
    pub fn check(&self, step: &str, duration: &str) -> Result<(), Violation> {
        positive(step, self.step_s, Self::MAX_STEP_S)?;
        positive(duration, self.duration_s, Self::MAX_DURATION_S)?;
        if self.duration_s / self.step_s > Self::MAX_STEPS {
            let expected = format!(
                "at least {}, so that `{duration}` = {} takes at most {} steps",
                number(self.duration_s / Self::MAX_STEPS),
                number(self.duration_s),
                number(Self::MAX_STEPS)
            );
            return Err(Violation::new(step, number(self.step_s), expected));
        }
        Ok(())
    }
}
