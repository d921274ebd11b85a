//! Scenes of experiments that need no bundled one: a square sheet, two particles.

use crate::HarnessError;
use drape_model::{
    Cloth, DampingLaw, Effects, EffectsSpec, GravitySpec, Grid, ParticlesSpec, Pin, Scene,
    SpringEffect, SpringLaw, SpringSpec, SystemSpec, TimeSpan,
};

/// The acceleration of gravity, m/s².
pub(super) const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];
/// Mass of a particle, kg.
pub(super) const MASS: f64 = 1e-3;

/// A horizontal sheet, 1 m × 1 m, around the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    /// Particles along each edge.
    pub(super) side: u32,
    /// Stiffness over mass of the tension springs, 1/s².
    pub(super) tension: f64,
    /// Stiffness over mass of the shear springs, 1/s²; 0 for none.
    pub(super) shear: f64,
    /// Damping over mass of the tension springs, 1/s; the shear springs have a tenth.
    pub(super) damping: f64,
    /// How the damping acts.
    pub(super) law: DampingLaw,
    /// Acceleration of gravity, m/s².
    pub(super) gravity: [f64; 3],
    /// Whether two corners of the first row are pinned.
    pub(super) is_pinned: bool,
}

impl Sheet {
    /// The system at rest.
    pub(super) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        let Self { side, tension, shear, damping, law, gravity, is_pinned } = *self;
        let springs = |stiffness, damping| {
            (stiffness > 0.0).then(|| SpringLaw {
                stiffness_over_mass_per_s2: Some(stiffness),
                damping_over_mass_per_s: Some(damping),
                ..SpringLaw::default()
            })
        };
        let corner = |column| Pin { row: Some(0), column: Some(column), ..Pin::default() };
        let scene = Scene {
            format: "drape-scene/1".to_owned(),
            name: "sheet".to_owned(),
            description: String::new(),
            assumed: Vec::new(),
            cloth: Cloth::Grid(Grid {
                rows: side,
                columns: side,
                size_m: [1.0, 1.0],
                center_m: [0.0; 3],
                mass_kg: MASS * f64::from(side * side),
                velocity_m_s: [0.0; 3],
            }),
            effects: Effects {
                tension: springs(tension, damping),
                shear: springs(shear, 0.1 * damping),
                gravity: (gravity != [0.0; 3]).then_some(GravitySpec { m_s2: gravity }),
                ..Effects::default()
            },
            damping: law,
            pins: if is_pinned { vec![corner(0), corner(side - 1)] } else { Vec::new() },
            obstacles: Vec::new(),
            time: TimeSpan { step_s: 0.01, duration_s: 1.0 },
        };
        Ok(scene.discretise()?)
    }

    /// Bound on the largest angular frequency, `√(8 (k + k_s)/m)`, 1/s, where the lightest particle has `lightest`
    /// times the usual mass.
    pub(super) fn greatest_frequency(&self, lightest: f64) -> f64 {
        (8.0 * (self.tension + self.shear) / lightest).sqrt()
    }
}

/// Two particles at rest on an undamped spring of 1 m along x, around the origin.
pub(super) fn pair(stiffness_over_mass: f64) -> SystemSpec {
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
        }],
        damping: DampingLaw::default(),
        triangles: Vec::new(),
        pins: Vec::new(),
        effects: EffectsSpec::default(),
        obstacles: Vec::new(),
    }
}
