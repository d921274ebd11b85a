//! Scenes: what a person writes, format "drape-scene/1".

use crate::build::{number, positive, vector, within};
use crate::error::Violation;
use crate::fabric::Fabric;
use crate::mesh::MeshCloth;
use crate::schema::{LAST_PARTICLE, Length};
use crate::select::{Pin, Selectable};
use crate::spec::{
    DampingLaw, MAX_COEFFICIENT, MAX_COORDINATE, MAX_OBSTACLES, MAX_PARTICLES, ObstacleSpec,
    ParticlesSpec, PinSpec, SYSTEM_FORMAT, SpringEffect, SpringSpec, SystemSpec,
};
use crate::stencils;
use crate::stretch::{MAX_PIECES, PieceSpec, StretchLaw, Stretches};
use crate::{Effects, EffectsSpec, Vec3};
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
    /// What the scene shows and where it comes from.
    #[serde(default)]
    pub description: String,
    /// Paths of keys whose values the source does not state and drape assumed.
    #[serde(default)]
    pub assumed: Vec<String>,
    /// The cloth.
    pub cloth: Cloth,
    /// The effects; one that is not named does not exist.
    #[serde(default)]
    pub effects: Effects,
    /// How the springs' damping acts.
    #[serde(default)]
    pub damping: DampingLaw,
    /// Selections of particles that do not move, or only on paths.
    #[serde(default)]
    pub pins: Vec<Pin>,
    /// Rigid obstacles; with 16 million pairs of a particle and an obstacle at most.
    #[serde(default)]
    #[schemars(length(max = MAX_OBSTACLES))]
    pub obstacles: Vec<ObstacleSpec>,
    /// Usual time step and duration.
    pub time: TimeSpan,
}

/// Where the particles come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Cloth {
    /// A regular rectangular sheet.
    Grid(Grid),
    /// The triangles and quads of an OBJ file.
    Mesh(MeshCloth),
    /// Explicit particles, springs and triangles.
    Particles(Particles),
}

/// A horizontal rectangular sheet: rows along y, columns along x; particle `row · columns + column`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Number of rows.
    #[schemars(range(min = 1, max = MAX_PARTICLES))]
    pub rows: u32,
    /// Number of particles in a row.
    #[schemars(range(min = 1, max = MAX_PARTICLES))]
    pub columns: u32,
    /// Edge lengths along x and y, m.
    #[schemars(with = "[Length; 2]")]
    pub size_m: [f64; 2],
    /// Centre of the sheet, m.
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub center_m: [f64; 3],
    /// Mass of the whole sheet, kg, spread evenly over the particles.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub mass_kg: f64,
    /// Start velocity of all particles, m/s.
    #[serde(default)]
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub velocity_m_s: [f64; 3],
}

/// Explicit particles and springs, as in a frozen system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Particles {
    /// The particles.
    pub particles: ParticlesSpec,
    /// The springs.
    #[serde(default)]
    pub springs: Vec<SpringSpec>,
    /// Triangles for display, as particle indices.
    #[serde(default)]
    #[schemars(inner(inner(range(max = LAST_PARTICLE))))]
    pub triangles: Vec<[u32; 3]>,
}

/// Stiffness and damping of one kind of spring, each either absolute or over the mass of a particle; or, instead of one
/// stiffness, piecewise-linear tension, for all springs alike, for warp and weft apart, or of a fabric.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringLaw {
    /// Stiffness `k`, N/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_per_m: Option<f64>,
    /// Stiffness over particle mass `k/m`, 1/s² (the paper's quotient).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_over_mass_per_s2: Option<f64>,
    /// Damping coefficient, N s/m; none if both keys are absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub damping_n_s_per_m: Option<f64>,
    /// Damping over particle mass, 1/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub damping_over_mass_per_s: Option<f64>,
    /// Piecewise-linear tension, instead of a stiffness.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = MAX_PIECES))]
    pub pieces: Vec<PieceSpec>,
    /// Stiffness in compression, N/m. If absent: the stiffness, or a tenth of that of the first piece.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub compression_stiffness_n_per_m: Option<f64>,
    /// A fabric whose tension was measured, instead of a stiffness; tension of a grid only. Warp is x. Every spring carries the
    /// tension per width of a strip as wide as the mesh.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fabric: Option<Fabric>,
    /// Springs along the warp, which is x on a grid, instead of a stiffness; together with `weft`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warp: Option<StretchLaw>,
    /// Springs along the weft, which is y on a grid; together with `warp`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weft: Option<StretchLaw>,
    /// Flexural rigidity, N m², of the strips of cloth that bending springs stand for: they buckle when compressed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub buckling_rigidity_n_m2: Option<f64>,
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

impl SpringLaw {
    /// Absolute stiffness and damping for particles of mass `mass`.
    pub(crate) fn resolve(&self, path: &str, mass: f64) -> Result<(f64, f64), Violation> {
        Ok((self.resolve_stiffness(path, mass)?, self.resolve_damping(path, mass)?))
    }

    fn resolve_stiffness(&self, path: &str, mass: f64) -> Result<f64, Violation> {
        let (a, b) = ("stiffness_n_per_m", "stiffness_over_mass_per_s2");
        match (self.stiffness_n_per_m, self.stiffness_over_mass_per_s2) {
            (Some(k), None) => absolute(path, a, k),
            (None, Some(q)) => times_mass(path, b, q, mass),
            (Some(_), Some(_)) => {
                let found = format!("given twice, as `{a}` and as `{b}`");
                Err(Violation::new(path, found, "exactly one of the two"))
            }
            (None, None) => {
                let found = "without a stiffness";
                let expected =
                    format!("`{a}` or `{b}`, or `pieces`, one at least, or `warp` and `weft`");
                Err(Violation::new(path, found, expected))
            }
        }
    }

    pub(crate) fn resolve_damping(&self, path: &str, mass: f64) -> Result<f64, Violation> {
        let (a, b) = ("damping_n_s_per_m", "damping_over_mass_per_s");
        match (self.damping_n_s_per_m, self.damping_over_mass_per_s) {
            (None, None) => Ok(0.0),
            (Some(c), None) => absolute(path, a, c),
            (None, Some(q)) => times_mass(path, b, q, mass),
            (Some(_), Some(_)) => {
                let found = format!("given twice, as `{a}` and as `{b}`");
                Err(Violation::new(path, found, "at most one of the two"))
            }
        }
    }
}

fn absolute(path: &str, key: &str, value: f64) -> Result<f64, Violation> {
    within(format!("{path}.{key}"), value, 0.0, MAX_COEFFICIENT)
}

/// A quotient within bounds times a mass within bounds may still be out of bounds.
fn times_mass(path: &str, key: &str, quotient: f64, mass: f64) -> Result<f64, Violation> {
    let high = MAX_COEFFICIENT.min(MAX_COEFFICIENT / mass);
    Ok(within(format!("{path}.{key}"), quotient, 0.0, high)? * mass)
}

impl Grid {
    fn check(&self) -> Result<(), Violation> {
        let path = |key: &str| format!("cloth.grid.{key}");
        for (key, count) in [("rows", self.rows), ("columns", self.columns)] {
            if count == 0 {
                return Err(Violation::new(path(key), count, "at least 1"));
            }
        }
        let particles = u64::from(self.rows) * u64::from(self.columns);
        if particles > MAX_PARTICLES as u64 {
            let found = format!("{} × {} = {particles} particles", self.rows, self.columns);
            let expected = format!("at most {MAX_PARTICLES} particles");
            return Err(Violation::new("cloth.grid", found, expected));
        }
        for (axis, &edge) in self.size_m.iter().enumerate() {
            positive(path(&format!("size_m[{axis}]")), edge, MAX_COORDINATE)?;
        }
        vector(path("center_m"), self.center_m)?;
        // The springs of the diagonals and the corners must be in range too.
        let [a, b] = self.size_m;
        let far = self.center_m.iter().fold(0.0, |far: f64, c| far.max(c.abs()));
        if far + a.hypot(b) > MAX_COORDINATE {
            let found = format!("[{}, {}]", number(a), number(b));
            let expected = format!("a sheet that ends within {} m", number(MAX_COORDINATE));
            return Err(Violation::new(path("size_m"), found, expected));
        }
        vector(path("velocity_m_s"), self.velocity_m_s)?;
        positive(path("mass_kg"), self.mass_kg, MAX_COEFFICIENT)?;
        if self.particle_mass() == 0.0 {
            let expected = "enough for every particle to have a mass above 0";
            return Err(Violation::new(path("mass_kg"), number(self.mass_kg), expected));
        }
        Ok(())
    }

    pub(crate) fn index(&self, row: u32, column: u32) -> u32 {
        row * self.columns + column
    }

    /// Mass of one particle, kg.
    pub fn particle_mass(&self) -> f64 {
        self.mass_kg / (f64::from(self.rows) * f64::from(self.columns))
    }

    /// Mesh widths along x and y, m; 0 along a direction with a single particle.
    pub fn spacing_m(&self) -> [f64; 2] {
        let width =
            |size: f64, count: u32| if count > 1 { size / f64::from(count - 1) } else { 0.0 };
        [width(self.size_m[0], self.columns), width(self.size_m[1], self.rows)]
    }

    fn particles(&self) -> ParticlesSpec {
        let [dx, dy] = self.spacing_m();
        let at =
            |count: u32, width: f64, k: u32| (f64::from(k) - 0.5 * f64::from(count - 1)) * width;
        let center = Vec3::from(self.center_m);
        let mut position_m = Vec::new();
        for row in 0..self.rows {
            for column in 0..self.columns {
                let offset = Vec3::new(at(self.columns, dx, column), at(self.rows, dy, row), 0.0);
                position_m.push((center + offset).into());
            }
        }
        let n = position_m.len();
        let velocity_m_s = match self.velocity_m_s {
            [0.0, 0.0, 0.0] => Vec::new(),
            velocity => vec![velocity; n],
        };
        ParticlesSpec { mass_kg: vec![self.particle_mass(); n], position_m, velocity_m_s }
    }

    /// The particle so many columns and rows from another one, if there is one.
    pub(crate) fn neighbour(&self, row: u32, column: u32, right: i64, down: i64) -> Option<u32> {
        let inside = |k: i64, count: u32| u32::try_from(k).ok().filter(|&k| k < count);
        let row = inside(i64::from(row) + down, self.rows)?;
        Some(self.index(row, inside(i64::from(column) + right, self.columns)?))
    }

    /// Offsets (columns, rows) from a particle to the other ends of its springs of one effect.
    fn stencil(effect: SpringEffect) -> [(i64, i64); 2] {
        match effect {
            SpringEffect::Tension => [(1, 0), (0, 1)],
            SpringEffect::Shear => [(1, 1), (-1, 1)],
            SpringEffect::Bending => [(2, 0), (0, 2)],
        }
    }

    fn springs(&self, effect: SpringEffect, law: &Stretches) -> Vec<SpringSpec> {
        let [dx, dy] = self.spacing_m();
        let mut springs = Vec::new();
        for row in 0..self.rows {
            for column in 0..self.columns {
                for (direction, (right, down)) in Self::stencil(effect).into_iter().enumerate() {
                    let Some(j) = self.neighbour(row, column, right, down) else { continue };
                    let span = Vec3::new(right as f64 * dx, down as f64 * dy, 0.0);
                    let ends = (self.index(row, column), j);
                    springs.push(law.spring(effect, direction, ends, span.norm()));
                }
            }
        }
        springs
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for row in 1..self.rows {
            for column in 1..self.columns {
                let [a, b] = [self.index(row - 1, column - 1), self.index(row - 1, column)];
                let [c, d] = [self.index(row, column - 1), self.index(row, column)];
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        triangles
    }
}

impl Scene {
    /// Checks the scene and discretises it.
    ///
    /// # Errors
    /// The first [`Violation`]: path of the key, value, what was expected.
    pub fn discretise(&self) -> Result<SystemSpec, Violation> {
        if self.format != SCENE_FORMAT {
            let found = format!("{:?}", self.format);
            return Err(Violation::new("format", found, format!("{SCENE_FORMAT:?}")));
        }
        self.time.check("time.step_s", "time.duration_s")?;
        let (particles, springs, triangles) = match &self.cloth {
            Cloth::Grid(grid) => {
                grid.check()?;
                (grid.particles(), self.grid_springs(grid)?, grid.triangles())
            }
            Cloth::Mesh(mesh) => {
                let cloth = mesh.discretise(&self.spring_laws())?;
                (cloth.particles, cloth.springs, cloth.triangles)
            }
            Cloth::Particles(cloth) => {
                self.refuse_spring_laws()?;
                (cloth.particles.clone(), cloth.springs.clone(), cloth.triangles.clone())
            }
        };
        let pins = self.resolve_pins(&particles, &triangles)?;
        let Effects { gravity, air, contact, .. } = self.effects;
        let mut spec = SystemSpec {
            format: SYSTEM_FORMAT.to_owned(),
            name: self.name.clone(),
            particles,
            springs,
            angles: Vec::new(),
            hinges: Vec::new(),
            damping: self.damping,
            triangles,
            pins,
            effects: EffectsSpec { gravity, air, contact },
            obstacles: self.obstacles.clone(),
        };
        spec.check().map_err(|violation| self.locate(violation))?;
        stencils::add(self, &mut spec)?;
        if !(spec.angles.is_empty() && spec.hinges.is_empty()) {
            spec.check()?; // stiffnesses that the mesh has scaled
        }
        Ok(spec)
    }

    /// Paths of a violation in the frozen system, as the scene's author sees them.
    fn locate(&self, mut violation: Violation) -> Violation {
        let inside_cloth =
            ["particles", "springs", "triangles"].iter().any(|key| violation.path.starts_with(key));
        if inside_cloth && matches!(self.cloth, Cloth::Particles(_)) {
            violation.path = format!("cloth.particles.{}", violation.path);
        }
        violation
    }

    fn spring_laws(&self) -> [(SpringEffect, Option<&SpringLaw>); 3] {
        let Effects { tension, shear, bending, .. } = &self.effects;
        let [a, b, c] = SpringEffect::ALL;
        [(a, tension.as_ref()), (b, shear.as_ref()), (c, bending.as_ref())]
    }

    fn grid_springs(&self, grid: &Grid) -> Result<Vec<SpringSpec>, Violation> {
        let mut springs = Vec::new();
        for (effect, law) in self.spring_laws() {
            let Some(law) = law else { continue };
            let law = law.of_fabric(effect, grid.spacing_m())?;
            let law = law.stretches(effect, grid.particle_mass())?;
            springs.extend(grid.springs(effect, &law));
        }
        Ok(springs)
    }

    /// Explicit springs carry their own stiffness, so that a law beside them would contradict it.
    fn refuse_spring_laws(&self) -> Result<(), Violation> {
        match self.spring_laws().into_iter().find(|(_, law)| law.is_some()) {
            None => Ok(()),
            Some((effect, _)) => Err(Violation::new(
                format!("effects.{}", effect.name()),
                "given beside explicit springs",
                "no such key: `cloth.particles.springs` carry their own stiffness",
            )),
        }
    }

    fn resolve_pins(
        &self,
        particles: &ParticlesSpec,
        triangles: &[[u32; 3]],
    ) -> Result<Vec<PinSpec>, Violation> {
        Selectable { cloth: &self.cloth, particles, triangles }.pins(&self.pins)
    }
}

impl TimeSpan {
    /// Longest step, s.
    const MAX_STEP_S: f64 = 1e6;
    /// Longest duration, s.
    const MAX_DURATION_S: f64 = 1e9;
    /// Most steps that a run may have.
    pub const MAX_STEPS: f64 = 1e9;

    /// Number of whole steps, and the length of a last shortened step if the duration is no
    /// multiple of the step within 1e-9.
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
    /// A step or duration that is not positive and finite, or more than 1e9 steps.
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
