//! The discretised system as data: format "drape-system/1".

use crate::effects::EffectKind;
use crate::obstacle::MAX_TRIANGLES;
use crate::path::{MAX_KEYFRAMES, offset_of, rest_of};
use crate::schema::{LAST_PARTICLE, Length, Mass};
use crate::stretch::MAX_PIECES;
use crate::{AngleSpec, Detection, EffectsSpec, HingeSpec, KeyframeSpec, PieceSpec, State, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The value of `format`.
pub(crate) const SYSTEM_FORMAT: &str = "drape-system/1";

/// Most particles that a system may have.
pub(crate) const MAX_PARTICLES: usize = 4_000_000;
/// Most obstacles.
pub(crate) const MAX_OBSTACLES: usize = 1024;
/// Most pairs of a particle and an obstacle: integrators keep some 120 bytes for each.
pub(crate) const MAX_CONTACTS: usize = 4 * MAX_PARTICLES;

/// A frozen system: particles, springs and everything else that acts, ready to be simulated here or
/// in another program. Reading a printed system back gives the same bits.
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
    /// The angles that shear or bending changes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub angles: Vec<AngleSpec>,
    /// The edges between two triangles over which the cloth bends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hinges: Vec<HingeSpec>,
    /// How the springs' damping acts.
    #[serde(default)]
    pub damping: DampingLaw,
    /// Triangles for display and for the air, as particle indices.
    #[serde(default)]
    #[schemars(inner(inner(range(max = LAST_PARTICLE))))]
    pub triangles: Vec<[u32; 3]>,
    /// Particles that do not move, or only on paths.
    #[serde(default)]
    pub pins: Vec<PinSpec>,
    /// All effects that are not springs.
    #[serde(default)]
    pub effects: EffectsSpec,
    /// Rigid obstacles; with 16 million pairs of a particle and an obstacle at most.
    #[serde(default)]
    #[schemars(length(max = MAX_OBSTACLES))]
    pub obstacles: Vec<ObstacleSpec>,
}

/// Particles of a frozen system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticlesSpec {
    /// Masses, kg; positive.
    #[schemars(with = "Vec<Mass>", length(min = 1, max = MAX_PARTICLES))]
    pub mass_kg: Vec<f64>,
    /// Positions, m.
    #[schemars(length(min = 1, max = MAX_PARTICLES), inner(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE))))]
    pub position_m: Vec<[f64; 3]>,
    /// Velocities, m/s; all 0 if absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = MAX_PARTICLES), inner(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE))))]
    pub velocity_m_s: Vec<[f64; 3]>,
}

/// The effect that a spring belongs to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpringEffect {
    /// Along warp and weft: the stiff part.
    #[default]
    Tension,
    /// Along the diagonals of the cells.
    Shear,
    /// From each particle to the next but one.
    Bending,
}

impl SpringEffect {
    /// All of them, in the order in which a system holds them.
    pub const ALL: [SpringEffect; 3] = [Self::Tension, Self::Shear, Self::Bending];

    /// The name under which its energy is reported.
    pub fn name(self) -> &'static str {
        EffectKind::from(self).name()
    }
}

impl From<SpringEffect> for EffectKind {
    fn from(effect: SpringEffect) -> Self {
        match effect {
            SpringEffect::Tension => Self::Tension,
            SpringEffect::Shear => Self::Shear,
            SpringEffect::Bending => Self::Bending,
        }
    }
}

/// One spring of a frozen system; linear where none of the keys behind the damping is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringSpec {
    /// Effect that it belongs to.
    pub effect: SpringEffect,
    /// First end.
    #[schemars(range(max = LAST_PARTICLE))]
    pub i: u32,
    /// Second end.
    #[schemars(range(max = LAST_PARTICLE))]
    pub j: u32,
    /// Rest length, m; 0 is legal.
    #[schemars(range(min = 0.0, max = MAX_COORDINATE))]
    pub rest_length_m: f64,
    /// Stiffness, N/m; that of the first piece, if there are pieces.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_per_m: f64,
    /// Damping coefficient, N s/m.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub damping_n_s_per_m: f64,
    /// Piecewise-linear tension; springs of one law share one list.
    #[serde(default, skip_serializing_if = "<[_]>::is_empty")]
    #[schemars(length(max = MAX_PIECES))]
    pub pieces: Arc<[PieceSpec]>,
    /// Stiffness in compression, N/m. If absent: the stiffness, or a tenth of it if there are pieces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub compression_stiffness_n_per_m: Option<f64>,
    /// Flexural rigidity, N m², of the strip of cloth that a bending spring stands for: it buckles when compressed (Choi and
    /// Ko 2002). Up to then it has the stiffness in compression.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub buckling_rigidity_n_m2: Option<f64>,
}

/// How the damping of the springs acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DampingLaw {
    /// `f_i = −c (v_i − v_j)`: linear, the paper's; damps rigid rotation too.
    #[default]
    Full,
    /// `f_i = −c ûûᵀ (v_i − v_j)`: along the spring only; leaves rigid rotation alone.
    Projected,
}

/// A pinned particle of a frozen system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PinSpec {
    /// Its index.
    #[schemars(range(max = LAST_PARTICLE))]
    pub particle: u32,
    /// Where it is led, from its place at the start; it does not move if there are no keyframes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = MAX_KEYFRAMES))]
    pub path: Vec<KeyframeSpec>,
}

impl PinSpec {
    /// A particle that does not move.
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
    /// Greatest speed at which a penetrating particle is led back to the surface, m/s.
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

/// A rigid obstacle, at rest or on a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ObstacleSpec {
    /// Half-space below a plane.
    Plane {
        /// A point of the plane, m.
        #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
        point_m: [f64; 3],
        /// Outward normal; any length but 0.
        #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
        normal: [f64; 3],
        /// Coefficient of restitution, 0 to 1.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 1.0))]
        restitution: f64,
        /// Coefficient of Coulomb friction; 0, none, if absent.
        #[serde(default, skip_serializing_if = "is_zero")]
        #[schemars(range(min = 0.0, max = MAX_FRICTION))]
        friction: f64,
        /// How it is moved from its place at the start; it rests if there are no keyframes.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        #[schemars(length(max = MAX_KEYFRAMES))]
        path: Vec<KeyframeSpec>,
    },
    /// Box with edges along the axes.
    Box {
        /// Centre, m.
        #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
        center_m: [f64; 3],
        /// Edge lengths, m.
        #[schemars(with = "[Length; 3]")]
        size_m: [f64; 3],
        /// Coefficient of restitution, 0 to 1.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 1.0))]
        restitution: f64,
        /// Coefficient of Coulomb friction; 0, none, if absent.
        #[serde(default, skip_serializing_if = "is_zero")]
        #[schemars(range(min = 0.0, max = MAX_FRICTION))]
        friction: f64,
        /// How it is moved from its place at the start; it rests if there are no keyframes.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        #[schemars(length(max = MAX_KEYFRAMES))]
        path: Vec<KeyframeSpec>,
    },
    /// Ball.
    Sphere {
        /// Centre, m.
        #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
        center_m: [f64; 3],
        /// Radius, m.
        #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COORDINATE))]
        radius_m: f64,
        /// Coefficient of restitution, 0 to 1.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 1.0))]
        restitution: f64,
        /// Coefficient of Coulomb friction; 0, none, if absent.
        #[serde(default, skip_serializing_if = "is_zero")]
        #[schemars(range(min = 0.0, max = MAX_FRICTION))]
        friction: f64,
        /// How it is moved from its place at the start; it rests if there are no keyframes.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        #[schemars(length(max = MAX_KEYFRAMES))]
        path: Vec<KeyframeSpec>,
    },
    /// Solid bounded by a closed triangle mesh.
    Mesh {
        /// Vertices, m.
        #[schemars(inner(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE))))]
        vertices_m: Vec<[f64; 3]>,
        /// Triangles as vertex indices, counter-clockwise seen from outside.
        #[schemars(length(min = 4, max = MAX_TRIANGLES), inner(inner(range(max = u32::MAX))))]
        triangles: Vec<[u32; 3]>,
        /// Coefficient of restitution, 0 to 1.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 1.0))]
        restitution: f64,
        /// Coefficient of Coulomb friction; 0, none, if absent.
        #[serde(default, skip_serializing_if = "is_zero")]
        #[schemars(range(min = 0.0, max = MAX_FRICTION))]
        friction: f64,
        /// How it is moved from its place at the start; it rests if there are no keyframes.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        #[schemars(length(max = MAX_KEYFRAMES))]
        path: Vec<KeyframeSpec>,
    },
}

pub(crate) fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl ObstacleSpec {
    /// Its name in a file.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Plane { .. } => "plane",
            Self::Box { .. } => "box",
            Self::Sphere { .. } => "sphere",
            Self::Mesh { .. } => "mesh",
        }
    }

    /// A plane at rest, without friction: a point, m, its outward normal, and the coefficient of restitution.
    pub const fn plane(point_m: [f64; 3], normal: [f64; 3], restitution: f64) -> Self {
        Self::Plane { point_m, normal, restitution, friction: 0.0, path: Vec::new() }
    }

    /// A box at rest, without friction: centre and edge lengths, m, and the coefficient of restitution.
    pub const fn cuboid(center_m: [f64; 3], size_m: [f64; 3], restitution: f64) -> Self {
        Self::Box { center_m, size_m, restitution, friction: 0.0, path: Vec::new() }
    }

    /// A ball at rest, without friction: centre and radius, m, and the coefficient of restitution.
    pub const fn sphere(center_m: [f64; 3], radius_m: f64, restitution: f64) -> Self {
        Self::Sphere { center_m, radius_m, restitution, friction: 0.0, path: Vec::new() }
    }

    /// The points, m, that a displacement moves.
    pub(crate) fn places(&self) -> &[[f64; 3]] {
        match self {
            Self::Plane { point_m: place, .. }
            | Self::Box { center_m: place, .. }
            | Self::Sphere { center_m: place, .. } => std::slice::from_ref(place),
            Self::Mesh { vertices_m, .. } => vertices_m,
        }
    }

    /// Puts it where it is at `t` seconds, with what is left of its path.
    fn advance(&mut self, t: f64) {
        let (places, path) = match self {
            Self::Plane { point_m: place, path, .. }
            | Self::Box { center_m: place, path, .. }
            | Self::Sphere { center_m: place, path, .. } => (std::slice::from_mut(place), path),
            Self::Mesh { vertices_m, path, .. } => (&mut vertices_m[..], path),
        };
        if !path.is_empty() {
            let offset = offset_of(path, t);
            for place in places {
                *place = in_range(Vec3::from(*place) + offset);
            }
            *path = rest_of(path, t);
        }
    }
}

/// A place that a path leads to, which round-off may put a little out of range.
fn in_range(place: Vec3) -> [f64; 3] {
    place.map(|coordinate| coordinate.clamp(-MAX_COORDINATE, MAX_COORDINATE)).into()
}

/// Greatest coefficient of friction.
pub(crate) const MAX_FRICTION: f64 = 100.0;
/// Greatest magnitude of a coordinate, velocity or acceleration.
pub(crate) const MAX_COORDINATE: f64 = 1e9;
/// Greatest stiffness, damping coefficient or mass.
pub(crate) const MAX_COEFFICIENT: f64 = 1e30;

impl SystemSpec {
    /// The same system frozen mid-run: with the positions and velocities of `state`, what is left of the paths, and the
    /// gusts as they are then. It is valid where the system is and the state stays within its bounds.
    #[must_use]
    pub fn with_state(mut self, state: &State) -> Self {
        self.particles.position_m = state.x.iter().map(|&x| x.into()).collect();
        self.particles.velocity_m_s = state.v.iter().map(|&v| v.into()).collect();
        for pin in self.pins.iter_mut().filter(|pin| !pin.path.is_empty()) {
            pin.path = rest_of(&pin.path, state.t);
            if let Some(place) = self.particles.position_m.get_mut(pin.particle as usize) {
                *place = in_range(Vec3::from(*place));
            }
        }
        let wind = self.effects.air.as_mut().and_then(|air| air.wind.as_mut());
        if let Some(gust) = wind.and_then(|wind| wind.gust.as_mut()) {
            gust.advance(state.t);
        }
        for obstacle in &mut self.obstacles {
            obstacle.advance(state.t);
        }
        self
    }
}
