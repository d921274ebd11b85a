//! The discretised system as data: format "drape-system/1".

use crate::effects::{Gravity, LinearSprings, Spring};
use crate::error::Violation;
use crate::system::Contact;
use crate::{Detection, Effect, Obstacle, Shape, State, System, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The value of `format`.
pub(crate) const SYSTEM_FORMAT: &str = "drape-system/1";

/// Most particles that a system may have.
pub(crate) const MAX_PARTICLES: usize = 4_000_000;

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
    /// How the springs' damping acts.
    #[serde(default)]
    pub damping: DampingLaw,
    /// Triangles for display, as particle indices.
    #[serde(default)]
    pub triangles: Vec<[u32; 3]>,
    /// Particles that do not move.
    #[serde(default)]
    pub pins: Vec<PinSpec>,
    /// All effects that are not springs.
    #[serde(default)]
    pub effects: EffectsSpec,
    /// Rigid obstacles.
    #[serde(default)]
    pub obstacles: Vec<ObstacleSpec>,
}

/// Particles of a frozen system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticlesSpec {
    /// Masses, kg; positive.
    #[schemars(length(min = 1), inner(range(min = 0.0, max = MAX_COEFFICIENT)))]
    pub mass_kg: Vec<f64>,
    /// Positions, m.
    #[schemars(length(min = 1))]
    pub position_m: Vec<[f64; 3]>,
    /// Velocities, m/s; all 0 if absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity_m_s: Vec<[f64; 3]>,
}

/// The effect that a spring belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpringEffect {
    /// Along warp and weft: the stiff part.
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
        match self {
            Self::Tension => "tension",
            Self::Shear => "shear",
            Self::Bending => "bending",
        }
    }
}

/// One spring of a frozen system.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringSpec {
    /// Effect that it belongs to.
    pub effect: SpringEffect,
    /// First end.
    pub i: u32,
    /// Second end.
    pub j: u32,
    /// Rest length, m; 0 is legal.
    #[schemars(range(min = 0.0, max = MAX_COORDINATE))]
    pub rest_length_m: f64,
    /// Stiffness, N/m.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_per_m: f64,
    /// Damping coefficient, N s/m.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub damping_n_s_per_m: f64,
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PinSpec {
    /// Its index.
    pub particle: u32,
}

/// Effects that are not springs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EffectsSpec {
    /// Uniform gravity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<GravitySpec>,
    /// How contacts with the obstacles are treated; the defaults if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact: Option<ContactSpec>,
}

/// Uniform gravity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravitySpec {
    /// Acceleration, m/s².
    pub m_s2: [f64; 3],
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

/// A rigid obstacle at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ObstacleSpec {
    /// Half-space below a plane.
    Plane {
        /// A point of the plane, m.
        point_m: [f64; 3],
        /// Outward normal; any length but 0.
        normal: [f64; 3],
        /// Coefficient of restitution, 0 to 1.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 1.0))]
        restitution: f64,
    },
    /// Box with edges along the axes.
    Box {
        /// Centre, m.
        center_m: [f64; 3],
        /// Edge lengths, m.
        #[schemars(inner(range(min = 0.0, max = MAX_COORDINATE)))]
        size_m: [f64; 3],
        /// Coefficient of restitution, 0 to 1.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 1.0))]
        restitution: f64,
    },
    /// Ball.
    Sphere {
        /// Centre, m.
        center_m: [f64; 3],
        /// Radius, m.
        #[schemars(extend("exclusiveMinimum" = 0))]
        radius_m: f64,
        /// Coefficient of restitution, 0 to 1.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 1.0))]
        restitution: f64,
    },
}

/// Greatest magnitude of a coordinate, velocity or acceleration.
pub(crate) const MAX_COORDINATE: f64 = 1e9;
/// Greatest stiffness, damping coefficient or mass.
pub(crate) const MAX_COEFFICIENT: f64 = 1e30;

fn index(path: &str, value: u32, count: usize) -> Result<usize, Violation> {
    let expected = || match count {
        0 => "no index at all: there is no particle".to_owned(),
        _ => format!("a particle index from 0 to {}", count - 1),
    };
    if (value as usize) < count {
        Ok(value as usize)
    } else {
        Err(Violation::new(path, value, expected()))
    }
}

/// A bound or a value as a message prints it: short whatever its size.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || (1e-4..1e7).contains(&value.abs()) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

pub(crate) fn within(path: &str, value: f64, low: f64, high: f64) -> Result<f64, Violation> {
    if value >= low && value <= high {
        Ok(value)
    } else {
        let expected = format!("a number from {} to {}", number(low), number(high));
        Err(Violation::new(path, number(value), expected))
    }
}

pub(crate) fn positive(path: &str, value: f64, high: f64) -> Result<f64, Violation> {
    if value > 0.0 && value <= high {
        Ok(value)
    } else {
        let expected = format!("a number above 0, at most {}", number(high));
        Err(Violation::new(path, number(value), expected))
    }
}

pub(crate) fn vector(path: &str, value: [f64; 3]) -> Result<Vec3, Violation> {
    for (axis, component) in value.into_iter().enumerate() {
        within(&format!("{path}[{axis}]"), component, -MAX_COORDINATE, MAX_COORDINATE)?;
    }
    Ok(Vec3::from(value))
}

impl ParticlesSpec {
    fn check_lengths(&self) -> Result<usize, Violation> {
        let n = self.mass_kg.len();
        if n == 0 || n > MAX_PARTICLES {
            let expected = format!("1 to {MAX_PARTICLES} particles");
            return Err(Violation::new("particles.mass_kg", format!("of length {n}"), expected));
        }
        let same = format!("length {n}, as `particles.mass_kg`");
        if self.position_m.len() != n {
            let found = format!("of length {}", self.position_m.len());
            return Err(Violation::new("particles.position_m", found, same));
        }
        if !self.velocity_m_s.is_empty() && self.velocity_m_s.len() != n {
            let found = format!("of length {}", self.velocity_m_s.len());
            return Err(Violation::new("particles.velocity_m_s", found, same));
        }
        Ok(n)
    }

    fn vectors(list: &[[f64; 3]], name: &str) -> Result<Vec<Vec3>, Violation> {
        let path = |i| format!("particles.{name}[{i}]");
        list.iter().enumerate().map(|(i, &value)| vector(&path(i), value)).collect()
    }
}

impl SpringSpec {
    fn check(&self, position: usize, particles: usize) -> Result<Spring, Violation> {
        let path = |key: &str| format!("springs[{position}].{key}");
        index(&path("i"), self.i, particles)?;
        index(&path("j"), self.j, particles)?;
        if self.i == self.j {
            let expected = format!("another particle than `i`, which is {}", self.i);
            return Err(Violation::new(path("j"), self.j, expected));
        }
        Ok(Spring {
            i: self.i,
            j: self.j,
            rest_length: within(&path("rest_length_m"), self.rest_length_m, 0.0, MAX_COORDINATE)?,
            stiffness: within(
                &path("stiffness_n_per_m"),
                self.stiffness_n_per_m,
                0.0,
                MAX_COEFFICIENT,
            )?,
            damping: within(
                &path("damping_n_s_per_m"),
                self.damping_n_s_per_m,
                0.0,
                MAX_COEFFICIENT,
            )?,
        })
    }
}

impl ObstacleSpec {
    fn check(&self, position: usize) -> Result<Obstacle, Violation> {
        let path = |key: &str| format!("obstacles[{position}].{key}");
        let (shape, restitution, kind) = match *self {
            Self::Plane { point_m, normal, restitution } => {
                let direction = vector(&path("plane.normal"), normal)?;
                let normal = direction.try_normalize(1e-12).ok_or_else(|| {
                    let found = format!("{normal:?}");
                    Violation::new(path("plane.normal"), found, "a vector longer than 1e-12")
                })?;
                let point = vector(&path("plane.point_m"), point_m)?;
                (Shape::Plane { point, normal }, restitution, "plane")
            }
            Self::Box { center_m, size_m, restitution } => {
                for (axis, &edge) in size_m.iter().enumerate() {
                    positive(&path(&format!("box.size_m[{axis}]")), edge, MAX_COORDINATE)?;
                }
                let center = vector(&path("box.center_m"), center_m)?;
                let half_extents = Vec3::from(size_m) * 0.5;
                (Shape::Box { center, half_extents }, restitution, "box")
            }
            Self::Sphere { center_m, radius_m, restitution } => {
                let radius = positive(&path("sphere.radius_m"), radius_m, MAX_COORDINATE)?;
                let center = vector(&path("sphere.center_m"), center_m)?;
                (Shape::Sphere { center, radius }, restitution, "sphere")
            }
        };
        let restitution = within(&path(&format!("{kind}.restitution")), restitution, 0.0, 1.0)?;
        Ok(Obstacle { shape, restitution })
    }
}

impl SystemSpec {
    /// Checks every value and builds the system with its start state at `t = 0`.
    ///
    /// # Errors
    /// The first [`Violation`]: path of the key, value, what was expected.
    pub fn build(&self) -> Result<(System, State), Violation> {
        if self.format != SYSTEM_FORMAT {
            let found = format!("{:?}", self.format);
            return Err(Violation::new("format", found, format!("{SYSTEM_FORMAT:?}")));
        }
        let n = self.particles.check_lengths()?;
        for (i, &mass) in self.particles.mass_kg.iter().enumerate() {
            positive(&format!("particles.mass_kg[{i}]"), mass, MAX_COEFFICIENT)?;
        }
        let x = ParticlesSpec::vectors(&self.particles.position_m, "position_m")?;
        let v = match self.particles.velocity_m_s.as_slice() {
            [] => vec![Vec3::zeros(); n],
            list => ParticlesSpec::vectors(list, "velocity_m_s")?,
        };
        let effects = self.build_effects(n)?;
        let mut pinned = vec![false; n];
        for (position, pin) in self.pins.iter().enumerate() {
            pinned[index(&format!("pins[{position}].particle"), pin.particle, n)?] = true;
        }
        for (position, triangle) in self.triangles.iter().enumerate() {
            for (corner, &particle) in triangle.iter().enumerate() {
                index(&format!("triangles[{position}][{corner}]"), particle, n)?;
            }
        }
        let obstacles = self.obstacles.iter().enumerate().map(|(i, spec)| spec.check(i));
        let obstacles = obstacles.collect::<Result<Vec<_>, _>>()?;
        let contact = self.effects.contact.unwrap_or_default();
        let limit = contact.recovery_speed_limit_m_s;
        within("effects.contact.recovery_speed_limit_m_s", limit, 0.0, MAX_COORDINATE)?;
        let contact = Contact { detection: contact.detection, recovery_speed_limit: limit };
        let mass = self.particles.mass_kg.clone();
        let system = System::new(self.name.clone(), mass, effects, pinned, obstacles, contact);
        Ok((system, State { t: 0.0, x, v }))
    }

    /// One effect object for each kind of force that is there, springs first.
    fn build_effects(&self, particles: usize) -> Result<Vec<Box<dyn Effect>>, Violation> {
        let mut groups: [Vec<Spring>; 3] = Default::default();
        for (position, spec) in self.springs.iter().enumerate() {
            groups[spec.effect as usize].push(spec.check(position, particles)?);
        }
        let mut effects: Vec<Box<dyn Effect>> = Vec::new();
        for (effect, springs) in SpringEffect::ALL.into_iter().zip(groups) {
            if !springs.is_empty() {
                effects.push(Box::new(LinearSprings::new(effect.name(), springs, self.damping)));
            }
        }
        if let Some(gravity) = self.effects.gravity {
            let acceleration = vector("effects.gravity.m_s2", gravity.m_s2)?;
            effects.push(Box::new(Gravity { acceleration }));
        }
        Ok(effects)
    }

    /// The same system with positions, velocities replaced by those of `state` (frozen mid-run).
    #[must_use]
    pub fn with_state(mut self, state: &State) -> Self {
        self.particles.position_m = state.x.iter().map(|&x| x.into()).collect();
        self.particles.velocity_m_s = state.v.iter().map(|&v| v.into()).collect();
        self
    }
}
