//! Scenes for experiments that need no bundled one: a square sheet, and two particles.

use crate::HarnessError;
use drape_model::{
    DampingLaw, EffectsSpec, ParticlesSpec, Scene, SpringEffect, SpringSpec, SystemSpec, Vec3,
};
use drape_oracle::{Random, scenes};

/// The acceleration of gravity, m/s².
pub(crate) const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];
/// Mass of a particle, kg.
pub(crate) const MASS: f64 = 1e-3;

/// A horizontal sheet, 1 m × 1 m, around the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sheet {
    /// Particles along each edge.
    pub(crate) side: u32,
    /// Stiffness over mass of the tension springs, 1/s².
    pub(crate) tension: f64,
    /// Stiffness over mass of the shear springs, 1/s²; 0 for none.
    pub(crate) shear: f64,
    /// Damping over mass of the tension springs, 1/s; the shear springs have a tenth.
    pub(crate) damping: f64,
    /// How the damping acts.
    pub(crate) law: DampingLaw,
    /// Acceleration of gravity, m/s².
    pub(crate) gravity: [f64; 3],
    /// Whether two corners of the first row are pinned.
    pub(crate) is_pinned: bool,
}

impl Sheet {
    /// The system at rest.
    pub(crate) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        Ok(self.scene().discretise()?)
    }

    /// The sheet as a scene.
    pub(crate) fn scene(&self) -> Scene {
        let Self { side, tension, shear, damping, law, gravity, is_pinned } = *self;
        let (gravity, pinned) = (gravity.into(), is_pinned);
        scenes::Sheet { side, tension, shear, damping, law, gravity, pinned }.scene()
    }

    /// The same sheet as a triangle mesh at rest. It has as many particles, with the same mass and
    /// the same border. Each inner particle lies anywhere within `jitter` mesh widths of its place
    /// in the grid, along x and along y. Each cell is cut along its shorter diagonal. Every edge of
    /// a triangle is a tension spring with the sheet's stiffness and damping. Triangles resist
    /// shear by themselves, so `shear` is not used.
    ///
    /// A jitter below a quarter leaves every cell convex.
    pub(super) fn triangulated(&self, jitter: f64, seed: u64) -> Result<SystemSpec, HarnessError> {
        let mut spec = Self { shear: 0.0, ..*self }.spec()?;
        let side = self.side as usize;
        let mut random = Random::new(seed);
        let mesh_width = 1.0 / f64::from(self.side - 1);
        let inside = 1..side - 1;
        for row in inside.clone() {
            for column in inside.clone() {
                let position = &mut spec.particles.position_m[row * side + column];
                for coordinate in &mut position[..2] {
                    *coordinate += mesh_width * random.between(-jitter, jitter);
                }
            }
        }
        let place = |row: usize, column: usize| (row * side + column) as u32;
        let positions = &spec.particles.position_m;
        let at = |particle: u32| Vec3::from(positions[particle as usize]);
        let distance = |i: u32, j: u32| (at(i) - at(j)).norm();
        let mut edges = Vec::new();
        let mut triangles = Vec::new();
        for row in 0..side {
            for column in 0..side {
                let here = place(row, column);
                let (is_last_row, is_last_column) = (row + 1 == side, column + 1 == side);
                if !is_last_column {
                    edges.push((here, place(row, column + 1)));
                }
                if !is_last_row {
                    edges.push((here, place(row + 1, column)));
                }
                if is_last_row || is_last_column {
                    continue;
                }
                let (right, below) = (place(row, column + 1), place(row + 1, column));
                let across = place(row + 1, column + 1);
                if distance(here, across) <= distance(right, below) {
                    edges.push((here, across));
                    triangles.extend([[here, right, across], [here, across, below]]);
                } else {
                    edges.push((right, below));
                    triangles.extend([[here, right, below], [right, across, below]]);
                }
            }
        }
        let spring = |(i, j): (u32, u32)| SpringSpec {
            effect: SpringEffect::Tension,
            i,
            j,
            rest_length_m: distance(i, j),
            stiffness_n_per_m: self.tension * MASS,
            damping_n_s_per_m: self.damping * MASS,
            ..SpringSpec::default()
        };
        let springs = edges.into_iter().map(spring).collect();
        Ok(SystemSpec { name: "triangulated sheet".to_owned(), springs, triangles, ..spec })
    }

    /// Bound on the largest angular frequency, `√(8 (k + k_s)/m)`, 1/s. `lightest` is the mass of
    /// the lightest particle over the usual mass.
    pub(crate) fn greatest_frequency(&self, lightest: f64) -> f64 {
        (8.0 * (self.tension + self.shear) / lightest).sqrt()
    }
}

/// Two triangles for each cell of a square grid with so many particles a side.
pub(crate) fn cut(side: u32) -> Vec<[u32; 3]> {
    let cells = (0..(side - 1) * (side - 1)).map(|k| k / (side - 1) * side + k % (side - 1));
    cells.flat_map(|k| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]]).collect()
}

/// Two particles at rest on an undamped spring of 1 m along x, around the origin.
pub(crate) fn pair(stiffness_over_mass: f64) -> SystemSpec {
    SystemSpec {
        format: "drape-system/1".to_owned(),
        name: "pair".to_owned(),
        particles: ParticlesSpec {
            mass_kg: vec![MASS; 2],
            position_m: vec![[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]],
            velocity_m_s: vec![[0.0; 3]; 2],
        },
        springs: vec![SpringSpec {
            effect: SpringEffect::Tension,
            i: 0,
            j: 1,
            rest_length_m: 1.0,
            stiffness_n_per_m: stiffness_over_mass * MASS,
            damping_n_s_per_m: 0.0,
            ..SpringSpec::default()
        }],
        angles: Vec::new(),
        hinges: Vec::new(),
        damping: DampingLaw::default(),
        triangles: Vec::new(),
        pins: Vec::new(),
        effects: EffectsSpec::default(),
        obstacles: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    const SHEET: Sheet = Sheet {
        side: 7,
        tension: 1e4,
        shear: 1e3,
        damping: 2.0,
        law: DampingLaw::Full,
        gravity: GRAVITY,
        is_pinned: true,
    };

    #[test]
    fn a_triangulated_sheet_fills_the_square_with_triangles_whose_edges_are_springs_at_rest() {
        let spec = SHEET.triangulated(0.24, 3).expect("valid");
        let x: Vec<Vec3> = spec.particles.position_m.iter().map(|&x| Vec3::from(x)).collect();
        // Euler's formula for a disc of n² points, of which 4 (n − 1) are on the border.
        let (n, border) = (49, 24);
        assert_eq!(spec.triangles.len(), 2 * n - border - 2);
        assert_eq!(spec.springs.len(), 3 * n - border - 3);
        let mut area = 0.0;
        let mut sides: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for &[a, b, c] in &spec.triangles {
            let doubled = (x[b as usize] - x[a as usize]).cross(&(x[c as usize] - x[a as usize]));
            assert!(doubled.z.abs() > 1e-3 / 36.0, "a sliver: {doubled:?}");
            area += 0.5 * doubled.z.abs();
            for (i, j) in [(a, b), (b, c), (c, a)] {
                *sides.entry((i.min(j), i.max(j))).or_default() += 1;
            }
        }
        // There is no overlap: the triangles cover the square once.
        assert!((area - 1.0).abs() < 1e-12, "{area}");
        assert_eq!(sides.values().filter(|count| **count == 1).count(), border);
        let springs: Vec<_> = spec.springs.iter().map(|s| (s.i.min(s.j), s.i.max(s.j))).collect();
        assert!(springs.len() == sides.len() && springs.iter().all(|s| sides.contains_key(s)));
        let (system, state) = spec.build().expect("valid");
        let mut forces = vec![Vec3::zeros(); n];
        system.forces(state.level(), &mut forces);
        let weight = Vec3::from(GRAVITY) * MASS;
        assert!(forces.iter().all(|force| (force - weight).norm() < 1e-12), "at rest");
    }

    #[test]
    fn jitter_moves_what_is_inside_and_nothing_else_and_follows_the_seed() {
        let grid = SHEET.spec().expect("valid");
        let mesh = |seed| SHEET.triangulated(0.2, seed).expect("valid");
        let spec = mesh(1);
        assert_eq!(spec, mesh(1));
        assert_ne!(spec, mesh(2));
        assert_eq!((&spec.pins, &spec.particles.mass_kg), (&grid.pins, &grid.particles.mass_kg));
        let pairs = spec.particles.position_m.iter().zip(&grid.particles.position_m);
        for (place, (x, grid)) in pairs.enumerate() {
            let (row, column) = (place / 7, place % 7);
            let is_border = row % 6 == 0 || column % 6 == 0;
            let moved = (Vec3::from(*x) - Vec3::from(*grid)).abs().max();
            assert!(if is_border { moved == 0.0 } else { moved > 0.0 && moved < 0.2 / 6.0 });
        }
    }
}
