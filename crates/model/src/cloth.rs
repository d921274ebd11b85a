//! The cloth of a scene: a grid, a mesh or explicit particles.

use crate::bounds::{
    LAST_PARTICLE, Length, MAX_COEFFICIENT, MAX_COORDINATE, MAX_PARTICLES, MIN_MASS, number,
    positive, vector,
};
use crate::effects::Strand;
use crate::error::Violation;
use crate::{Mat3, MeshCloth, ParticlesSpec, Rotation, SpringEffect, SpringSpec, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

/// A rectangular sheet, horizontal unless it is rotated. Rows follow each other along y, columns
/// along x. Particle `row · columns + column` stands where a row and a column cross.
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
    /// Mass of the whole sheet, kg, spread evenly over the particles. If absent, the scene's
    /// material gives the mass, by the area at each particle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub mass_kg: Option<f64>,
    /// Rotation about the centre of the sheet. Without it the sheet is horizontal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
    /// Start velocity of all particles that no pin holds, m/s.
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
    /// Triangles for display, hinges and the air, as particle indices.
    #[serde(default)]
    #[schemars(inner(inner(range(max = LAST_PARTICLE))))]
    pub triangles: Vec<[u32; 3]>,
}

impl Grid {
    pub(crate) fn check(&self) -> Result<(), Violation> {
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
        self.turn()?;
        if let Some(mass) = self.mass_kg {
            positive(path("mass_kg"), mass, MAX_COEFFICIENT)?;
            if mass / self.count() < MIN_MASS {
                let least = number(MIN_MASS);
                let expected = format!("enough for every particle to have a mass of {least} kg");
                return Err(Violation::new(path("mass_kg"), number(mass), expected));
            }
        }
        Ok(())
    }

    /// The matrix of the rotation.
    fn turn(&self) -> Result<Option<Mat3>, Violation> {
        self.rotation.map(|rotation| rotation.matrix("cloth.grid.rotation")).transpose()
    }

    fn count(&self) -> f64 {
        f64::from(self.rows) * f64::from(self.columns)
    }

    pub(crate) fn index(&self, row: u32, column: u32) -> u32 {
        row * self.columns + column
    }

    /// Mass of one particle, kg; `None` if the scene's material gives the mass.
    pub fn particle_mass(&self) -> Option<f64> {
        self.mass_kg.map(|mass| mass / self.count())
    }

    /// Number of cells that have this particle at a corner, along each direction of the grid.
    pub(crate) fn cells_beside(&self, row: u32, column: u32) -> [u32; 2] {
        let beside = |k: u32, count: u32| u32::from(k > 0) + u32::from(k + 1 < count);
        [beside(column, self.columns), beside(row, self.rows)]
    }

    /// Masses, kg; `density` (kg/m²) is that of the scene's material, if it has one.
    fn masses(&self, density: Option<f64>) -> Result<Vec<f64>, Violation> {
        let n = self.rows as usize * self.columns as usize;
        let path = "cloth.grid.mass_kg";
        match (self.particle_mass(), density) {
            (Some(mass), _) => Ok(vec![mass; n]),
            (None, None) => {
                let expected = "this key with a value, or a `material`";
                Err(Violation::new(path, "missing", expected))
            }
            (None, Some(_)) if self.rows == 1 || self.columns == 1 => {
                let expected = "this key: a single row or column has no area";
                Err(Violation::new(path, "missing", expected))
            }
            (None, Some(density)) => {
                let [dx, dy] = self.spacing_m();
                let share = 0.25 * density * dx * dy;
                let cells = |row, column| self.cells_beside(row, column).map(f64::from);
                let of = |row, column| share * cells(row, column).iter().product::<f64>();
                let all = (0..self.rows).flat_map(|row| (0..self.columns).map(move |c| (row, c)));
                let mass: Vec<f64> = all.map(|(row, column)| of(row, column)).collect();
                match mass.iter().find(|mass| !(MIN_MASS..=MAX_COEFFICIENT).contains(*mass)) {
                    None => Ok(mass),
                    Some(mass) => {
                        let [least, most] = [MIN_MASS, MAX_COEFFICIENT].map(number);
                        let found = format!("left to the material: {} kg", number(*mass));
                        let expected = format!("masses from {least} to {most} kg");
                        Err(Violation::new(path, found, expected))
                    }
                }
            }
        }
    }

    /// Distances of neighbouring particles along x and y, m; 0 along a direction with a single
    /// particle.
    pub fn spacing_m(&self) -> [f64; 2] {
        let width =
            |size: f64, count: u32| if count > 1 { size / f64::from(count - 1) } else { 0.0 };
        [width(self.size_m[0], self.columns), width(self.size_m[1], self.rows)]
    }

    pub(crate) fn particles(&self, density: Option<f64>) -> Result<ParticlesSpec, Violation> {
        let turn = self.turn()?;
        let [dx, dy] = self.spacing_m();
        let at =
            |count: u32, width: f64, k: u32| (f64::from(k) - 0.5 * f64::from(count - 1)) * width;
        let center = Vec3::from(self.center_m);
        let mut position_m = Vec::new();
        for row in 0..self.rows {
            for column in 0..self.columns {
                let offset = Vec3::new(at(self.columns, dx, column), at(self.rows, dy, row), 0.0);
                let offset = turn.map_or(offset, |turn| turn * offset);
                position_m.push((center + offset).into());
            }
        }
        let n = position_m.len();
        let velocity_m_s = match self.velocity_m_s {
            [0.0, 0.0, 0.0] => Vec::new(),
            velocity => vec![velocity; n],
        };
        Ok(ParticlesSpec { mass_kg: self.masses(density)?, position_m, velocity_m_s })
    }

    /// The particle this many columns and rows from another one, if it exists.
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

    /// The springs of one effect.
    pub(crate) fn strands(&self, effect: SpringEffect) -> Vec<Strand> {
        let [dx, dy] = self.spacing_m();
        let mut strands = Vec::new();
        for row in 0..self.rows {
            for column in 0..self.columns {
                for (direction, (right, down)) in Self::stencil(effect).into_iter().enumerate() {
                    let Some(j) = self.neighbour(row, column, right, down) else { continue };
                    let span = Vec3::new(right as f64 * dx, down as f64 * dy, 0.0);
                    let ends = [self.index(row, column), j];
                    strands.push(Strand { direction, ends, length: span.norm() });
                }
            }
        }
        strands
    }

    pub(crate) fn triangles(&self) -> Vec<[u32; 3]> {
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
