//! Building blocks of small scenes, for tests.

use drape_model::{
    DampingLaw, EffectsSpec, GravitySpec, ParticlesSpec, PinSpec, SpringEffect, SpringSpec,
    SystemSpec, Vec3,
};

/// The acceleration of gravity, m/s².
pub const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -9.81);

/// A frozen system of free particles on which nothing acts: masses in kg, positions in m, velocities in
/// m/s, where no velocity at all means rest.
pub fn particles(mass: &[f64], position: &[Vec3], velocity: &[Vec3]) -> SystemSpec {
    let list = |vectors: &[Vec3]| vectors.iter().map(|&a| a.into()).collect();
    SystemSpec {
        format: "drape-system/1".to_owned(),
        name: "test".to_owned(),
        particles: ParticlesSpec {
            mass_kg: mass.to_vec(),
            position_m: list(position),
            velocity_m_s: list(velocity),
        },
        springs: Vec::new(),
        angles: Vec::new(),
        hinges: Vec::new(),
        damping: DampingLaw::Full,
        triangles: Vec::new(),
        pins: Vec::new(),
        effects: EffectsSpec::default(),
        obstacles: Vec::new(),
    }
}

/// A spring between two particles: rest length in m, stiffness in N/m, damping coefficient in N s/m.
pub fn spring(
    effect: SpringEffect,
    (i, j): (usize, usize),
    rest_length: f64,
    stiffness: f64,
    damping: f64,
) -> SpringSpec {
    SpringSpec {
        effect,
        i: i as u32,
        j: j as u32,
        rest_length_m: rest_length,
        stiffness_n_per_m: stiffness,
        damping_n_s_per_m: damping,
        ..SpringSpec::default()
    }
}

/// Pins a particle.
pub fn pin(particle: usize) -> PinSpec {
    PinSpec::still(particle as u32)
}

/// [`GRAVITY`] as an effect.
pub fn gravity() -> Option<GravitySpec> {
    Some(GravitySpec { m_s2: GRAVITY.into() })
}
