//! From a frozen system to one that runs: every value is checked on the way.

use crate::effects::{Gravity, LinearSprings, PiecewiseSprings, Spring};
use crate::error::Violation;
use crate::numbering::Numbering;
use crate::path::Extent;
use crate::spec::{
    MAX_COEFFICIENT, MAX_CONTACTS, MAX_COORDINATE, MAX_FRICTION, MAX_OBSTACLES, MAX_PARTICLES,
    SYSTEM_FORMAT,
};
use crate::stencils::Stencils;
use crate::stretch::Laws;
use crate::system::Contact;
use crate::{
    ClosedMesh, Effect, MovingPin, Obstacle, ObstacleSpec, ParticlesSpec, Path, Shape,
    SpringEffect, SpringSpec, State, System, SystemSpec, Vec3,
};
use std::fmt::Display;
use std::sync::Arc;

pub(crate) fn index(path: impl Display, value: u32, count: usize) -> Result<usize, Violation> {
    let expected = || match count {
        0 => "no index at all: there is no particle".to_owned(),
        _ => format!("a particle index from 0 to {}", count - 1),
    };
    if (value as usize) < count {
        Ok(value as usize)
    } else {
        Err(Violation::new(path.to_string(), value, expected()))
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

pub(crate) fn within(
    path: impl Display,
    value: f64,
    low: f64,
    high: f64,
) -> Result<f64, Violation> {
    if value >= low && value <= high {
        Ok(value)
    } else {
        let expected = format!("a number from {} to {}", number(low), number(high));
        Err(Violation::new(path.to_string(), number(value), expected))
    }
}

pub(crate) fn positive(path: impl Display, value: f64, high: f64) -> Result<f64, Violation> {
    if value > 0.0 && value <= high {
        Ok(value)
    } else {
        let expected = format!("a number above 0, at most {}", number(high));
        Err(Violation::new(path.to_string(), number(value), expected))
    }
}

pub(crate) fn vector(path: impl Display, value: [f64; 3]) -> Result<Vec3, Violation> {
    for (axis, component) in value.into_iter().enumerate() {
        within(format_args!("{path}[{axis}]"), component, -MAX_COORDINATE, MAX_COORDINATE)?;
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
        let vectors = list.iter().enumerate();
        vectors.map(|(i, &value)| vector(format_args!("particles.{name}[{i}]"), value)).collect()
    }
}

impl SpringSpec {
    fn check(&self, position: usize, particles: usize) -> Result<Spring, Violation> {
        // Paths are written out only where something is wrong: there may be millions of springs.
        let end = |key: &str, end| index(format_args!("springs[{position}].{key}"), end, particles);
        let value = |key: &str, value, high| {
            within(format_args!("springs[{position}].{key}"), value, 0.0, high)
        };
        end("i", self.i)?;
        end("j", self.j)?;
        if self.i == self.j {
            let expected = format!("another particle than `i`, which is {}", self.i);
            return Err(Violation::new(format!("springs[{position}].j"), self.j, expected));
        }
        Ok(Spring {
            i: self.i,
            j: self.j,
            rest_length: value("rest_length_m", self.rest_length_m, MAX_COORDINATE)?,
            stiffness: value("stiffness_n_per_m", self.stiffness_n_per_m, MAX_COEFFICIENT)?,
            damping: value("damping_n_s_per_m", self.damping_n_s_per_m, MAX_COEFFICIENT)?,
        })
    }
}

impl ObstacleSpec {
    fn check(&self, position: usize) -> Result<Obstacle, Violation> {
        let path = |key: &str| format!("obstacles[{position}].{key}");
        let kind = self.kind();
        let (shape, restitution, friction, frames) = match self {
            Self::Plane { point_m, normal, restitution, friction, path: frames } => {
                let direction = vector(path("plane.normal"), *normal)?;
                let normal = direction.try_normalize(1e-12).ok_or_else(|| {
                    let found = format!("{normal:?}");
                    Violation::new(path("plane.normal"), found, "a vector longer than 1e-12")
                })?;
                let point = vector(path("plane.point_m"), *point_m)?;
                (Shape::Plane { point, normal }, restitution, friction, frames)
            }
            Self::Box { center_m, size_m, restitution, friction, path: frames } => {
                for (axis, &edge) in size_m.iter().enumerate() {
                    positive(path(&format!("box.size_m[{axis}]")), edge, MAX_COORDINATE)?;
                }
                let center = vector(path("box.center_m"), *center_m)?;
                let half_extents = Vec3::from(*size_m) * 0.5;
                (Shape::Box { center, half_extents }, restitution, friction, frames)
            }
            Self::Sphere { center_m, radius_m, restitution, friction, path: frames } => {
                let radius = positive(path("sphere.radius_m"), *radius_m, MAX_COORDINATE)?;
                let center = vector(path("sphere.center_m"), *center_m)?;
                (Shape::Sphere { center, radius }, restitution, friction, frames)
            }
            Self::Mesh { vertices_m, triangles, restitution, friction, path: frames } => {
                let vertices = vertices_m.iter().enumerate();
                let vertices = vertices
                    .map(|(k, &at)| vector(path(&format!("mesh.vertices_m[{k}]")), at))
                    .collect::<Result<Vec<_>, _>>()?;
                let mesh = ClosedMesh::check(&path("mesh"), vertices, triangles)?;
                (Shape::Mesh(Arc::new(mesh)), restitution, friction, frames)
            }
        };
        let restitution = within(path(&format!("{kind}.restitution")), *restitution, 0.0, 1.0)?;
        let friction = within(path(&format!("{kind}.friction")), *friction, 0.0, MAX_FRICTION)?;
        let led = Extent::of(self.places().iter().map(|&place| Vec3::from(place)));
        let motion = Path::check(&path(&format!("{kind}.path")), frames, led)?;
        Ok(Obstacle { shape, restitution, friction, path: motion })
    }
}

/// The parts of a system, checked.
struct Parts {
    mass: Vec<f64>,
    state: State,
    /// Springs of each of [`SpringEffect::ALL`].
    springs: [Vec<Spring>; 3],
    stencils: Stencils,
    /// Their laws, where one of the effect's springs is not linear.
    laws: [Option<Laws>; 3],
    gravity: Option<Gravity>,
    pinned: Vec<bool>,
    moving_pins: Vec<MovingPin>,
    obstacles: Vec<Obstacle>,
    contact: Contact,
}

impl SystemSpec {
    /// Checks every value and builds the system with its start state at `t = 0`, in the order of the specification.
    ///
    /// # Errors
    /// The first [`Violation`]: path of the key, value, what was expected.
    pub fn build(&self) -> Result<(System, State), Violation> {
        Ok(self.assemble(self.parts()?))
    }

    /// As [`build`](Self::build), in an order of particles and springs that suits the cache where that of the
    /// specification does not; see [`Numbering`] for the rule.
    ///
    /// Forces are then summed in another order: results differ from those of [`build`](Self::build) by round-off, and
    /// by more for a method that goes through the springs one after the other.
    ///
    /// # Errors
    /// As [`build`](Self::build), with the same paths.
    ///
    /// ```
    /// let input = drape_model::load("hanging-textile-1e4")?;
    /// let (_, state, numbering) = input.spec().build_ordered().expect("bundled scenes are valid");
    /// assert!(numbering.is_identity(), "a grid row by row stays as it is");
    /// assert_eq!(numbering.restore(&state).x, state.x);
    /// # Ok::<(), drape_model::SceneError>(())
    /// ```
    pub fn build_ordered(&self) -> Result<(System, State, Numbering), Violation> {
        let mut parts = self.parts()?;
        let numbering = {
            let [a, b, c] = &mut parts.laws;
            let mut law_of = [a, b, c].map(|laws| laws.as_mut().map(|laws| &mut laws.of));
            Numbering::choose(parts.mass.len(), &mut parts.springs, &mut law_of)
        };
        if !numbering.is_identity() {
            parts.mass = numbering.apply(&parts.mass);
            parts.pinned = numbering.apply(&parts.pinned);
            parts.stencils.renumber(&numbering);
            parts.state.x = numbering.apply(&parts.state.x);
            parts.state.v = numbering.apply(&parts.state.v);
            for pin in &mut parts.moving_pins {
                pin.particle = numbering.internal(pin.particle);
            }
        }
        let (system, state) = self.assemble(parts);
        Ok((system, state, numbering))
    }

    /// Checks every value.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub(crate) fn check(&self) -> Result<(), Violation> {
        self.parts().map(drop)
    }

    fn parts(&self) -> Result<Parts, Violation> {
        if self.format != SYSTEM_FORMAT {
            let found = format!("{:?}", self.format);
            return Err(Violation::new("format", found, format!("{SYSTEM_FORMAT:?}")));
        }
        let n = self.particles.check_lengths()?;
        for (i, &mass) in self.particles.mass_kg.iter().enumerate() {
            positive(format_args!("particles.mass_kg[{i}]"), mass, MAX_COEFFICIENT)?;
        }
        let x = ParticlesSpec::vectors(&self.particles.position_m, "position_m")?;
        let v = match self.particles.velocity_m_s.as_slice() {
            [] => vec![Vec3::zeros(); n],
            list => ParticlesSpec::vectors(list, "velocity_m_s")?,
        };
        let mut springs: [Vec<Spring>; 3] = Default::default();
        let mut laws: [Option<Laws>; 3] = Default::default();
        for spec in self.springs.iter().filter(|spec| spec.is_piecewise()) {
            laws[spec.effect as usize].get_or_insert_default();
        }
        for (position, spec) in self.springs.iter().enumerate() {
            springs[spec.effect as usize].push(spec.check(position, n)?);
            if let Some(laws) = &mut laws[spec.effect as usize] {
                laws.push(spec, position)?;
            }
        }
        let gravity = self.effects.gravity.map(|gravity| {
            let acceleration = vector("effects.gravity.m_s2", gravity.m_s2)?;
            Ok(Gravity { acceleration })
        });
        let gravity = gravity.transpose()?;
        let (pinned, moving_pins) = self.pinned(&x)?;
        for (position, triangle) in self.triangles.iter().enumerate() {
            for (corner, &particle) in triangle.iter().enumerate() {
                index(format_args!("triangles[{position}][{corner}]"), particle, n)?;
            }
        }
        let stencils = Stencils::check(self, n)?;
        self.check_contacts(n)?;
        let obstacles = self.obstacles.iter().enumerate().map(|(i, spec)| spec.check(i));
        let obstacles = obstacles.collect::<Result<Vec<_>, _>>()?;
        let contact = self.effects.contact.unwrap_or_default();
        let limit = contact.recovery_speed_limit_m_s;
        within("effects.contact.recovery_speed_limit_m_s", limit, 0.0, MAX_COORDINATE)?;
        let contact = Contact { detection: contact.detection, recovery_speed_limit: limit };
        let (mass, state) = (self.particles.mass_kg.clone(), State { t: 0.0, x, v });
        Ok(Parts {
            mass,
            state,
            springs,
            laws,
            stencils,
            gravity,
            pinned,
            moving_pins,
            obstacles,
            contact,
        })
    }

    /// Contacts of all particles with all obstacles must fit into memory.
    fn check_contacts(&self, particles: usize) -> Result<(), Violation> {
        let obstacles = self.obstacles.len();
        let most = MAX_OBSTACLES.min(MAX_CONTACTS / particles);
        if obstacles <= most {
            return Ok(());
        }
        let found = format!("of length {obstacles}, for {particles} particles");
        let expected = format!(
            "at most {most}: {MAX_OBSTACLES} obstacles, and {MAX_CONTACTS} pairs of a particle and an obstacle"
        );
        Err(Violation::new("obstacles", found, expected))
    }

    /// Which of the particles at `x` are pinned, and those of them that are led on paths.
    fn pinned(&self, x: &[Vec3]) -> Result<(Vec<bool>, Vec<MovingPin>), Violation> {
        let (mut pinned, mut moving) = (vec![false; x.len()], Vec::<MovingPin>::new());
        for (position, pin) in self.pins.iter().enumerate() {
            let at = format!("pins[{position}]");
            let particle = index(format_args!("{at}.particle"), pin.particle, x.len())?;
            let led = Extent::of([x[particle]]);
            let path = Path::check(&format!("{at}.path"), &pin.path, led)?;
            let was_pinned = std::mem::replace(&mut pinned[particle], true);
            let has_path = |other: &MovingPin| other.particle == particle;
            if was_pinned && (path.is_some() || moving.iter().any(has_path)) {
                let expected = "each particle once where a pin has a path";
                return Err(Violation::new(format!("{at}.particle"), pin.particle, expected));
            }
            moving.extend(path.map(|path| MovingPin { particle, start: x[particle], path }));
        }
        Ok((pinned, moving))
    }

    /// One effect object for each kind of force that is there: springs, angles and hinges, gravity, air.
    fn assemble(&self, parts: Parts) -> (System, State) {
        let Parts { mass, state, springs, laws, stencils, gravity, pinned, .. } = parts;
        let (moving_pins, obstacles, contact) = (parts.moving_pins, parts.obstacles, parts.contact);
        let mut effects: Vec<Box<dyn Effect>> = Vec::new();
        for ((effect, springs), laws) in SpringEffect::ALL.into_iter().zip(springs).zip(laws) {
            let (kind, damping) = (effect.into(), self.damping);
            match laws {
                Some(Laws { list, of, .. }) => {
                    effects.push(Box::new(PiecewiseSprings::new(kind, springs, of, list, damping)))
                }
                None if springs.is_empty() => {}
                None => effects.push(Box::new(LinearSprings::new(kind, springs, damping))),
            }
        }
        let (elastic, air) = stencils.into_effects();
        effects.extend(elastic);
        if let Some(gravity) = gravity {
            effects.push(Box::new(gravity));
        }
        effects.extend(air);
        let system = System::new(
            self.name.clone(),
            mass,
            effects,
            (pinned, moving_pins),
            obstacles,
            contact,
        );
        (system, state)
    }
}
