//! Cloth from an OBJ file: particles at the vertices, springs from the edges, masses from the
//! areas.
//!
//! | springs | between |
//! |---|---|
//! | tension | the ends of each edge |
//! | shear | the ends of both diagonals of each quad |
//! | bending | across each inner edge: the next but one along a strip of quads, the opposite corners of two triangles |
//!
//! Texture coordinates, if the file has any, define the warp: it runs along the first coordinate.
//! Each edge counts as warp or weft, whichever direction is nearer.
//!
//! On a grid of quads this table gives the springs of [`Grid`](crate::Grid). Rest lengths are the
//! scaled distances in the file. A stiffness or damping over mass is multiplied by the mean mass of
//! the particles, so that all springs of one kind have the same stiffness.

mod edges;
mod obj;
mod surface;
mod warp;

pub(crate) use warp::Patch;

use crate::bounds::{
    MAX_COEFFICIENT, MAX_COORDINATE, MIN_MASS, direction, number, positive, vector, within,
};
use crate::effects::Strand;
use crate::error::Violation;
use crate::{Mat3, ParticlesSpec, SpringEffect, Vec3, bundled};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::sync::Arc;
use surface::Surface;

/// Start of `file` for a mesh that comes with drape.
const BUNDLED: &str = "bundled:";

/// The triangles and quads of an OBJ file. Particle `i` is the file's vertex `i + 1`, unless a
/// repair dropped vertices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshCloth {
    /// The OBJ file: a path relative to the folder of the scene file, or `bundled:NAME` for a mesh
    /// that comes with drape.
    pub file: String,
    /// Mass over area, kg/m²; a face gives each of its corners an equal share. If absent, it is
    /// that of the scene's material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub areal_density_kg_m2: Option<f64>,
    /// Length of one unit of the file, m.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COORDINATE))]
    pub scale: f64,
    /// Rotation about the file's origin, after the scaling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
    /// Translation after the rotation, m.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub translation_m: [f64; 3],
    /// Start velocity of all particles, m/s.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub velocity_m_s: [f64; 3],
    /// Angular velocity about the centre of mass at the start, rad/s.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub spin_rad_s: [f64; 3],
    /// Whether to repair the surface instead of refusing it. A repair drops degenerate and doubled
    /// faces and vertices without a face. It turns faces over where neighbours have opposite
    /// orientations.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub repair: bool,
    /// Content of the file, once it is read.
    #[serde(skip)]
    surface: Option<Arc<Surface>>,
}

/// A rotation about an axis through the origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Axis; any vector but 0.
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub axis: [f64; 3],
    /// Angle, degrees. Positive angles turn counterclockwise as seen from the tip of the axis.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub angle_deg: f64,
}

fn one() -> f64 {
    1.0
}

fn is_one(value: &f64) -> bool {
    *value == 1.0
}

fn is_zero(value: &[f64; 3]) -> bool {
    *value == [0.0; 3]
}

/// The value for a pair of particles in a sorted list.
pub(crate) fn cosine(list: &[([u32; 2], f64)], [i, j]: [u32; 2]) -> Option<f64> {
    let place = list.binary_search_by_key(&[i.min(j), i.max(j)], |(ends, _)| *ends).ok()?;
    Some(list[place].1)
}

impl Rotation {
    /// Rodrigues' formula. Messages call the rotation `path`.
    pub(crate) fn matrix(&self, path: &str) -> Result<Mat3, Violation> {
        let axis = direction(format_args!("{path}.axis"), self.axis)?;
        let degrees = format_args!("{path}.angle_deg");
        let angle = within(degrees, self.angle_deg, -360.0, 360.0)?.to_radians();
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let cross = axis.cross_matrix();
        Ok(Mat3::identity() + cross * sine + cross * cross * (1.0 - cosine))
    }
}

impl MeshCloth {
    /// A mesh with this name of its file. Nothing is read; [`read`](Self::read) supplies the
    /// content.
    pub fn of_file(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            areal_density_kg_m2: None,
            scale: 1.0,
            rotation: None,
            translation_m: [0.0; 3],
            velocity_m_s: [0.0; 3],
            spin_rad_s: [0.0; 3],
            repair: false,
            surface: None,
        }
    }

    /// Reads the file that the scene names; `folder` is the folder of the scene.
    pub(crate) fn load(&mut self, folder: Option<&Path>) -> Result<(), Violation> {
        let file = self.file.clone();
        if let Some(name) = file.strip_prefix(BUNDLED) {
            let Some(text) = bundled::mesh(name) else {
                let known: Vec<_> = bundled::meshes().collect();
                let expected = format!("one of the bundled meshes {}", known.join(", "));
                return Err(Violation::new("cloth.mesh.file", format!("{file:?}"), expected));
            };
            return self.read(text.as_bytes());
        }
        let path = folder.unwrap_or(Path::new("")).join(&file);
        let refuse = |reason: String| {
            let found = format!("{file:?}, {reason}");
            let expected = "an OBJ file, by its path from the scene's folder";
            Violation::new("cloth.mesh.file", found, expected)
        };
        // Opening a pipe would wait for a writer.
        let kind = path.metadata().map_err(|error| refuse(format!("unreadable: {error}")))?;
        if !kind.is_file() {
            return Err(refuse("which is no file".to_owned()));
        }
        let reader = File::open(&path).map_err(|error| refuse(format!("unreadable: {error}")))?;
        self.read(BufReader::new(reader))
    }

    /// Reads and checks the content of the mesh from `reader`, in place of the file.
    ///
    /// # Errors
    /// The first [`Violation`], with the line number and the number of the face, from 1.
    pub fn read(&mut self, reader: impl BufRead) -> Result<(), Violation> {
        let obj = obj::read(&self.file, reader)?;
        self.surface = Some(Arc::new(Surface::new(&self.file, obj, self.repair)?));
        Ok(())
    }

    /// Descriptions of the repairs that were made.
    pub fn repairs(&self) -> &[String] {
        self.surface.as_ref().map_or(&[], |surface| &surface.repairs)
    }

    /// Number of vertices.
    pub(crate) fn vertices(&self) -> Result<usize, Violation> {
        Ok(self.surface()?.vertices.len())
    }

    fn surface(&self) -> Result<&Surface, Violation> {
        self.surface.as_deref().ok_or_else(|| {
            let found = format!("{:?}, which was not read", self.file);
            Violation::new("cloth.mesh.file", found, "a scene from `load` or `parse`")
        })
    }

    /// The particles under a name of a group or object in the file.
    pub(crate) fn named(&self, path: &str, name: &str) -> Result<Vec<u32>, Violation> {
        let refuse = |expected| Violation::new(path, format!("{name:?}"), expected);
        self.surface()?.named(name).map_err(refuse)
    }

    /// Particles and triangles; `density` (kg/m²) is that of the scene's material, if it has one.
    pub(crate) fn discretise(
        &self,
        density: Option<f64>,
    ) -> Result<(ParticlesSpec, Vec<[u32; 3]>), Violation> {
        let surface = self.surface()?;
        let x = self.positions(surface)?;
        let mass_kg = self.masses(surface, &x, density)?;
        let velocity_m_s = self.velocities(&mass_kg, &x)?;
        let position_m = x.into_iter().map(Into::into).collect();
        Ok((ParticlesSpec { mass_kg, position_m, velocity_m_s }, surface.triangles()))
    }

    /// The springs of one effect between particles at these positions, m. If `is_woven`, they have the
    /// directions of warp and weft.
    pub(crate) fn strands(
        &self,
        effect: SpringEffect,
        position_m: &[[f64; 3]],
        is_woven: bool,
    ) -> Result<Vec<Strand>, Violation> {
        let surface = self.surface()?;
        let x = |i: u32| Vec3::from(position_m[i as usize]);
        let pairs = edges::springs(effect, &surface.faces, &surface.sides).into_iter();
        let cosines = if is_woven { self.cosines(false)? } else { Vec::new() };
        let strand = |ends @ [i, j]: [u32; 2]| {
            let direction = usize::from(cosine(&cosines, ends).is_some_and(|cosine| cosine < 0.5));
            Strand { direction, ends, length: (x(i) - x(j)).norm() }
        };
        Ok(pairs.map(strand).collect())
    }

    /// Whether the file says where the warp is.
    pub(crate) fn has_directions(&self) -> bool {
        self.surface.as_ref().is_some_and(|surface| !surface.warps.is_empty())
    }

    /// The faces in their planes, along warp and weft; with `mean`, along their first edges.
    pub(crate) fn patches(&self, mean: bool) -> Result<Vec<Patch>, Violation> {
        let surface = self.surface()?;
        warp::patches(surface, self.scale, mean).map_err(|place| {
            let face = &surface.faces[place];
            let at = obj::place(&self.file, face.line);
            let found = "a face whose texture coordinates (vt) say nothing about its directions";
            let expected = "texture coordinates that span an area, the first along the warp; or \
                            `material.directions` = \"mean\"";
            Violation::new(format!("{at} (face {})", face.number + 1), found, expected)
        })
    }

    /// Squared cosine of the angle between the warp and each edge or diagonal of a face, the mean
    /// of all faces that have it; sorted by its ends, the lower first.
    pub(crate) fn cosines(&self, mean: bool) -> Result<Vec<([u32; 2], f64)>, Violation> {
        let mut list = Vec::new();
        for patch in self.patches(mean)? {
            let (corners, places) = (patch.corners(), patch.places());
            for a in 0..corners.len() {
                for b in 0..a {
                    let [x, y] = [0, 1].map(|axis| places[a][axis] - places[b][axis]);
                    let ends = [corners[a].min(corners[b]), corners[a].max(corners[b])];
                    list.push((ends, x * x / (x * x + y * y)));
                }
            }
        }
        list.sort_by_key(|(ends, _)| *ends);
        let mean = |same: &[([u32; 2], f64)]| {
            (same[0].0, same.iter().map(|(_, cosine)| cosine).sum::<f64>() / same.len() as f64)
        };
        Ok(list.chunk_by(|a, b| a.0 == b.0).map(mean).collect())
    }

    fn positions(&self, surface: &Surface) -> Result<Vec<Vec3>, Violation> {
        let scale = positive("cloth.mesh.scale", self.scale, MAX_COORDINATE)?;
        let shift = vector("cloth.mesh.translation_m", self.translation_m)?;
        let rotation = self.rotation.map(|rotation| rotation.matrix("cloth.mesh.rotation"));
        let rotation = rotation.transpose()?;
        let place = |vertex: &Vec3| {
            let scaled = vertex * scale;
            rotation.map_or(scaled, |rotation| rotation * scaled) + shift
        };
        let x: Vec<_> = surface.vertices.iter().map(place).collect();
        // A quarter of the range, so that distances and velocities of a spin stay within it too.
        let far = x.iter().map(|x| x.amax()).fold(0.0, f64::max);
        if far > 0.25 * MAX_COORDINATE {
            let found = format!("{}, which puts a particle {} m off", number(scale), number(far));
            let expected = format!("a cloth within {} m", number(0.25 * MAX_COORDINATE));
            return Err(Violation::new("cloth.mesh.scale", found, expected));
        }
        Ok(x)
    }

    fn masses(
        &self,
        surface: &Surface,
        x: &[Vec3],
        density: Option<f64>,
    ) -> Result<Vec<f64>, Violation> {
        let path = "cloth.mesh.areal_density_kg_m2";
        let Some(density) = self.areal_density_kg_m2.or(density) else {
            let expected = "this key with a value, or a `material`";
            return Err(Violation::new(path, "missing", expected));
        };
        let density = positive(path, density, MAX_COEFFICIENT)?;
        let mut mass = vec![0.0; x.len()];
        for face in &surface.faces {
            let corners = face.corners();
            let share = density * surface::area(x, corners) / corners.len() as f64;
            corners.iter().for_each(|&corner| mass[corner as usize] += share);
        }
        match mass.iter().position(|&mass| !(MIN_MASS..=MAX_COEFFICIENT).contains(&mass)) {
            None => Ok(mass),
            Some(i) => {
                let found =
                    format!("{}: particle {i} gets {} kg", number(density), number(mass[i]));
                let [least, most] = [MIN_MASS, MAX_COEFFICIENT].map(number);
                Err(Violation::new(path, found, format!("masses from {least} to {most} kg")))
            }
        }
    }

    /// Velocities, m/s; empty for a cloth at rest.
    fn velocities(&self, mass: &[f64], x: &[Vec3]) -> Result<Vec<[f64; 3]>, Violation> {
        let velocity = vector("cloth.mesh.velocity_m_s", self.velocity_m_s)?;
        let spin = vector("cloth.mesh.spin_rad_s", self.spin_rad_s)?;
        if velocity == Vec3::zeros() && spin == Vec3::zeros() {
            return Ok(Vec::new());
        }
        let total: f64 = mass.iter().sum();
        let moments = mass.iter().zip(x).map(|(&m, x)| x * (m / total));
        let center = moments.fold(Vec3::zeros(), |sum, moment| sum + moment);
        let v: Vec<_> = x.iter().map(|x| velocity + spin.cross(&(x - center))).collect();
        let fastest = v.iter().map(|v| v.amax()).fold(0.0, f64::max);
        if fastest > MAX_COORDINATE {
            let found = format!("{:?}, which makes {} m/s", self.spin_rad_s, number(fastest));
            let expected = format!("velocities of at most {} m/s", number(MAX_COORDINATE));
            return Err(Violation::new("cloth.mesh.spin_rad_s", found, expected));
        }
        Ok(v.into_iter().map(Into::into).collect())
    }
}
