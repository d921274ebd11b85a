//! The hanging sheet of the comparisons of cost, on the grid and as a general mesh.

use drape_model::{
    Cloth, DampingLaw, Effects, GravitySpec, Grid, Pin, PinSpec, Scene, SpringLaw, SystemSpec,
    TimeSpan, Violation,
};
use drape_oracle::Random;

/// Order of the particles and springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mesh {
    /// Row by row, as a grid scene has them.
    Grid,
    /// The same cloth with particles and springs in random order, so that nothing shows the grid.
    General,
}

impl Mesh {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Grid, Self::General];

    /// Its name in records and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::General => "general",
        }
    }
}

/// A frozen sheet and the index of its middle particle.
#[derive(Clone, Debug)]
pub struct HangingSheet {
    /// The system.
    pub spec: SystemSpec,
    /// Index of the particle in row and column `side / 2`.
    pub middle: usize,
}

/// Time step of all comparisons, s.
pub const STEP_S: f64 = 0.01;
/// Seed of the random orders.
const SEED: u64 = 20;
/// Damping over mass of the tension springs, 1/s.
const DAMPING: f64 = 40.0;

impl HangingSheet {
    /// `side × side` particles, 1 m × 1 m, 0.4 kg in all, flat and horizontal at the start, two
    /// corners of one edge pinned. Tension springs with `k/m = stiffness` (1/s²) and `d/m = 40/s`;
    /// shear and bending springs with a tenth of both.
    ///
    /// # Errors
    /// A [`Violation`] for fewer than two or too many particles along an edge, or a stiffness out
    /// of range.
    pub fn new(side: u32, stiffness: f64, mesh: Mesh) -> Result<Self, Violation> {
        let law = |factor: f64| {
            Some(SpringLaw {
                stiffness_over_mass_per_s2: Some(factor * stiffness),
                damping_over_mass_per_s: Some(factor * DAMPING),
                ..SpringLaw::default()
            })
        };
        let corner = |column| Pin { row: Some(0), column: Some(column), ..Pin::default() };
        let scene = Scene {
            format: "drape-scene/1".to_owned(),
            name: format!("hanging sheet {side} × {side}"),
            description: String::new(),
            assumed: Vec::new(),
            cloth: Cloth::Grid(Grid {
                rows: side,
                columns: side,
                size_m: [1.0, 1.0],
                center_m: [0.0; 3],
                mass_kg: Some(0.4),
                rotation: None,
                velocity_m_s: [0.0; 3],
            }),
            material: None,
            effects: Effects {
                tension: law(1.0),
                shear: law(0.1),
                bending: law(0.1),
                gravity: Some(GravitySpec { m_s2: [0.0, 0.0, -9.81] }),
                ..Effects::default()
            },
            damping: DampingLaw::Full,
            pins: vec![corner(0), corner(side.saturating_sub(1))],
            obstacles: Vec::new(),
            time: TimeSpan { step_s: STEP_S, duration_s: 1.0 },
        };
        let spec = scene.discretise()?;
        let middle = (side / 2 * side + side / 2) as usize;
        Ok(match mesh {
            Mesh::Grid => Self { spec, middle },
            Mesh::General => shuffled(&spec, middle),
        })
    }
}

/// The same system with particles and springs in an order that `SEED` gives.
fn shuffled(spec: &SystemSpec, middle: usize) -> HangingSheet {
    let mut random = Random::new(SEED);
    // Particle `old[new]` of the grid becomes particle `new`.
    let mut old: Vec<usize> = (0..spec.particles.mass_kg.len()).collect();
    shuffle(&mut old, &mut random);
    let mut new = vec![0_u32; old.len()];
    for (to, &from) in old.iter().enumerate() {
        new[from] = to as u32;
    }
    let mut out = spec.clone();
    out.triangles.clear();
    for (to, &from) in old.iter().enumerate() {
        out.particles.mass_kg[to] = spec.particles.mass_kg[from];
        out.particles.position_m[to] = spec.particles.position_m[from];
    }
    for spring in &mut out.springs {
        (spring.i, spring.j) = (new[spring.i as usize], new[spring.j as usize]);
    }
    shuffle(&mut out.springs, &mut random);
    let pins = spec.pins.iter().map(|pin| PinSpec::still(new[pin.particle as usize]));
    out.pins = pins.collect();
    HangingSheet { spec: out, middle: new[middle] as usize }
}

fn shuffle<T>(list: &mut [T], random: &mut Random) {
    for last in (1..list.len()).rev() {
        list.swap(last, random.below(last + 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_general_mesh_is_the_same_cloth_in_another_order() {
        let [grid, general] = Mesh::ALL.map(|m| HangingSheet::new(7, 1e4, m).expect("valid"));
        let places = |sheet: &HangingSheet| {
            let at = |i: u32| sheet.spec.particles.position_m[i as usize].map(f64::to_bits);
            let spring = |s: &drape_model::SpringSpec| {
                let ends = BTreeSet::from([at(s.i), at(s.j)]);
                (ends, s.rest_length_m.to_bits(), s.stiffness_n_per_m.to_bits())
            };
            let springs: BTreeSet<_> = sheet.spec.springs.iter().map(spring).collect();
            let pins: BTreeSet<_> = sheet.spec.pins.iter().map(|pin| at(pin.particle)).collect();
            (springs, pins, at(sheet.middle as u32))
        };
        assert_eq!(places(&grid), places(&general));
        assert_ne!(grid.spec.particles.position_m, general.spec.particles.position_m);
        assert_ne!(grid.spec.springs, general.spec.springs);
        let again = HangingSheet::new(7, 1e4, Mesh::General).expect("valid");
        assert_eq!(again.spec, general.spec);
    }
}
