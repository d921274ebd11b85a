//! How large a scene is, before it is discretised.

use crate::effects::Effects;
use crate::error::Violation;
use crate::{Cloth, Scene, SystemSpec};

/// What a scene or a frozen system holds once it is discretised: a few hundred bytes of a scene may
/// describe millions of particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Bytes of the file.
    pub file: u64,
    /// Particles.
    pub particles: u64,
    /// Springs, angles and hinges.
    pub springs: u64,
}

impl Size {
    /// Bytes that loading takes at most, by measurement: the text, and the frozen system.
    pub fn bytes_to_load(&self) -> u64 {
        let system = self.particles.saturating_mul(250);
        self.file.saturating_mul(2).saturating_add(system).saturating_add(self.bytes_of_springs())
    }

    /// Bytes of springs, in a frozen system and in the one that is made from it.
    pub fn bytes_of_springs(&self) -> u64 {
        self.springs.saturating_mul(115)
    }

    /// Of a scene whose mesh was read.
    pub(crate) fn of_scene(scene: &Scene) -> Result<Self, Violation> {
        let count = |length: usize| length as u64;
        let size = |particles, springs| Self { particles, springs, file: 0 };
        Ok(match &scene.cloth {
            Cloth::Grid(grid) => {
                grid.check()?;
                let n = u64::from(grid.rows) * u64::from(grid.columns);
                size(n, n * kinds(&scene.effects, [2, 2, 2, 1, 2, 3]))
            }
            Cloth::Mesh(mesh) => {
                let (vertices, faces, edges) = mesh.counts()?;
                // Two diagonals in each face, and everything else over an edge.
                let on_faces = 2 * count(faces) * kinds(&scene.effects, [0, 1, 0, 0, 0, 0]);
                let on_edges = count(edges) * kinds(&scene.effects, [1, 0, 1, 1, 1, 1]);
                size(count(vertices), on_faces + on_edges)
            }
            Cloth::Particles(cloth) => {
                let hinges = kinds(&scene.effects, [0, 0, 0, 0, 0, 2]);
                let springs = count(cloth.springs.len()) + hinges * count(cloth.triangles.len());
                size(count(cloth.particles.mass_kg.len()), springs)
            }
        })
    }

    /// Of a frozen system.
    pub(crate) fn of_system(spec: &SystemSpec) -> Self {
        let springs = spec.springs.len() + spec.angles.len() + spec.hinges.len();
        Self { file: 0, particles: spec.particles.mass_kg.len() as u64, springs: springs as u64 }
    }
}

/// The sum of these numbers over the effects that exist: tension, shear, bending, angles of shear
/// and of bending, hinges.
fn kinds(effects: &Effects, each: [u64; 6]) -> u64 {
    let exists = [
        effects.tension.is_some(),
        effects.shear.is_some(),
        effects.bending.is_some(),
        effects.shear_angle.is_some(),
        effects.bending_angle.is_some(),
        effects.bending_hinge.is_some(),
    ];
    each.iter().zip(exists).filter(|(_, exists)| *exists).map(|(n, _)| n).sum()
}
