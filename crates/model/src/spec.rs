//! The discretised system as data: format "drape-system/1".

use crate::bounds::{LAST_PARTICLE, MAX_COORDINATE, MAX_PARTICLES, Mass};
use crate::path::{MAX_KEYFRAMES, in_range, rest_of};
use crate::{
    AngleSpec, DampingLaw, Detection, EffectsSpec, HingeSpec, KeyframeSpec, ObstacleSpec,
    SpringSpec, State, Vec3, effects,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The value of `format`.
pub(crate) const SYSTEM_FORMAT: &str = "drape-system/1";

/// Most obstacles.
pub(crate) const MAX_OBSTACLES: usize = 1024;
/// Most pairs of a particle and an obstacle. Integrators keep some 120 bytes for each.
pub(crate) const MAX_CONTACTS: usize = 4 * MAX_PARTICLES;

/// A frozen system: particles, springs and everything else that acts. This program or another one
/// can simulate it. Reading a printed system back gives the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SystemSpec {
    /// Always "drape-system/1".
    #[schemars(extend("const" = SYSTEM_FORMAT))]
    pub format: String,
    /// Name of the scene that was frozen.
    #[serde(default)]
    pub name: String,
    /// The particles.
    pub particles: ParticlesSpec,
    /// The springs; the order is kept.
    #[serde(default)]
    pub springs: Vec<SpringSpec>,
    /// Angles that resist shear or bending.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub angles: Vec<AngleSpec>,
    /// The edges between two triangles over which the cloth bends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hinges: Vec<HingeSpec>,
    /// How the springs' damping acts.
    #[serde(default)]
    pub damping: DampingLaw,
    /// Triangles for display and the air, as particle indices.
    #[serde(default)]
    #[schemars(inner(inner(range(max = LAST_PARTICLE))))]
    pub triangles: Vec<[u32; 3]>,
    /// Particles that stand still or follow a path.
    #[serde(default)]
    pub pins: Vec<PinSpec>,
    /// The effects that have no list above, and the treatment of contacts.
    #[serde(default)]
    pub effects: EffectsSpec,
    /// Rigid obstacles; at most 16 million pairs of a particle and an obstacle.
    #[serde(default)]
    #[schemars(length(max = MAX_OBSTACLES))]
    pub obstacles: Vec<ObstacleSpec>,
}

impl Default for SystemSpec {
    /// A system without particles, which is not valid yet.
    fn default() -> Self {
        Self {
            format: SYSTEM_FORMAT.to_owned(),
            name: String::new(),
            particles: ParticlesSpec::default(),
            springs: Vec::new(),
            angles: Vec::new(),
            hinges: Vec::new(),
            damping: DampingLaw::default(),
            triangles: Vec::new(),
            pins: Vec::new(),
            effects: EffectsSpec::default(),
            obstacles: Vec::new(),
        }
    }
}

/// Particles of a frozen system.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticlesSpec {
    /// Masses, kg; positive.
    #[schemars(with = "Vec<Mass>", length(min = 1, max = MAX_PARTICLES))]
    pub mass_kg: Vec<f64>,
    /// Positions, m.
    #[schemars(
        length(min = 1, max = MAX_PARTICLES),
        inner(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))
    )]
    pub position_m: Vec<[f64; 3]>,
    /// Velocities, m/s; all 0 if absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(
        length(max = MAX_PARTICLES),
        inner(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))
    )]
    pub velocity_m_s: Vec<[f64; 3]>,
}

/// A pinned particle of a frozen system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PinSpec {
    /// Index of the particle.
    #[schemars(range(max = LAST_PARTICLE))]
    pub particle: u32,
    /// Path, as displacements from the particle's starting place. Without keyframes the particle
    /// stands still.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = MAX_KEYFRAMES))]
    pub path: Vec<KeyframeSpec>,
}

impl PinSpec {
    /// A pin that holds a particle in place.
    pub fn still(particle: u32) -> Self {
        Self { particle, path: Vec::new() }
    }
}

/// Treatment of contacts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactSpec {
    /// When a contact becomes active.
    #[serde(default)]
    pub detection: Detection,
    /// Greatest speed at which a penetrating particle returns to the surface, m/s.
    #[serde(default = "default_recovery_speed")]
    #[schemars(range(min = 0.0, max = MAX_COORDINATE))]
    pub recovery_speed_limit_m_s: f64,
}

fn default_recovery_speed() -> f64 {
    1.0
}

impl Default for ContactSpec {
    fn default() -> Self {
        Self { detection: Detection::default(), recovery_speed_limit_m_s: default_recovery_speed() }
    }
}

impl SystemSpec {
    /// Number of springs, angles and hinges.
    pub(crate) fn pieces(&self) -> usize {
        self.springs.len() + self.angles.len() + self.hinges.len()
    }

    /// The system frozen during a run: with the positions and velocities of `state`, the rest of
    /// the paths, and the present gusts. The result is valid if this system is valid and `state`
    /// stays within the bounds of coordinates and velocities.
    #[must_use]
    pub fn with_state(mut self, state: &State) -> Self {
        self.particles.position_m = state.x.iter().map(|&x| x.into()).collect();
        self.particles.velocity_m_s = state.v.iter().map(|&v| v.into()).collect();
        for pin in self.pins.iter_mut().filter(|pin| !pin.path.is_empty()) {
            pin.path = rest_of(&pin.path, state.t);
            if let Some(place) = self.particles.position_m.get_mut(pin.particle as usize) {
                *place = in_range(Vec3::from(*place)).into();
            }
        }
        effects::advance(&mut self, state.t);
        for obstacle in &mut self.obstacles {
            obstacle.advance(state.t);
        }
        self
    }
}
