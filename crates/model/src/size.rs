//! How large a scene is, before it is discretised.

use crate::error::Violation;
use crate::{Cloth, Scene, SystemSpec};

/// Counts of a scene or a frozen system after discretisation. A few hundred bytes of a scene may
/// describe millions of particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Size of the file, bytes.
    pub file: u64,
    /// Number of particles.
    pub particles: u64,
    /// Number of springs and of stencils such as angles.
    pub springs: u64,
}

impl Size {
    /// Upper bound of the memory that loading takes, bytes: the text and the frozen system. The
    /// bound was measured.
    pub fn bytes_to_load(&self) -> u64 {
        let system = self.particles.saturating_mul(250);
        self.file.saturating_mul(2).saturating_add(system).saturating_add(self.bytes_of_springs())
    }

    /// Memory of the springs, bytes, in the frozen system and in the running system that is built
    /// from it.
    pub fn bytes_of_springs(&self) -> u64 {
        self.springs.saturating_mul(115)
    }

    /// Of a scene whose mesh was read.
    pub(crate) fn of_scene(scene: &Scene) -> Result<Self, Violation> {
        let [mut on_grid, mut on_mesh] = scene.effects.pieces();
        if scene.material.is_some() {
            on_grid += crate::fabric::PIECES[0];
            on_mesh += crate::fabric::PIECES[1];
        }
        let (particles, springs) = match &scene.cloth {
            Cloth::Grid(grid) => {
                grid.check()?;
                let n = u64::from(grid.rows) * u64::from(grid.columns);
                (n, n * on_grid)
            }
            Cloth::Mesh(mesh) => {
                let n = mesh.vertices()? as u64;
                (n, n * on_mesh)
            }
            Cloth::Particles(cloth) => {
                let n = cloth.particles.mass_kg.len() as u64;
                (n, cloth.springs.len() as u64 + n * on_mesh)
            }
        };
        Ok(Self { file: 0, particles, springs })
    }

    /// Of a frozen system.
    pub(crate) fn of_system(spec: &SystemSpec) -> Self {
        Self {
            file: 0,
            particles: spec.particles.mass_kg.len() as u64,
            springs: spec.pieces() as u64,
        }
    }
}
