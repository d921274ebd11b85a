//! Energies and momenta of a state.

use crate::{State, System, Vec3};

impl System {
    /// Kinetic energy `½ Σ m v²`, J.
    pub fn kinetic_energy(&self, v: &[Vec3]) -> f64 {
        0.5 * self.mass().iter().zip(v).map(|(&m, v)| m * v.norm_squared()).sum::<f64>()
    }

    /// Potential energy of all effects, J.
    pub fn potential_energy(&self, x: &[Vec3]) -> f64 {
        self.effects().map(|effect| effect.energy(self.mass(), x)).sum()
    }

    /// Kinetic plus potential energy `H`, J.
    pub fn total_energy(&self, state: &State) -> f64 {
        self.kinetic_energy(&state.v) + self.potential_energy(&state.x)
    }

    /// Energy of each effect by name, in the order of the effects, J.
    pub fn energies(&self, x: &[Vec3]) -> impl Iterator<Item = (&'static str, f64)> {
        self.effects().map(move |effect| (effect.name(), effect.energy(self.mass(), x)))
    }

    /// Linear momentum `Σ m v`, kg m/s.
    pub fn momentum(&self, state: &State) -> Vec3 {
        self.mass().iter().zip(&state.v).fold(Vec3::zeros(), |sum, (&m, v)| sum + v * m)
    }

    /// Angular momentum about the origin, `Σ m x × v`, kg m²/s.
    pub fn angular_momentum(&self, state: &State) -> Vec3 {
        let mut sum = Vec3::zeros();
        for ((&m, x), v) in self.mass().iter().zip(&state.x).zip(&state.v) {
            sum += x.cross(v) * m;
        }
        sum
    }

    /// Positions to be drawn: each particle that lies inside an obstacle is replaced by an
    /// auxiliary one on its surface (EEH section 6). Never fed back into the simulation.
    pub fn display_positions(&self, x: &[Vec3]) -> Vec<Vec3> {
        let shown = |x: &Vec3| {
            self.obstacles().iter().fold(*x, |x, obstacle| {
                let (depth, normal) = obstacle.distance(&x);
                x - normal * depth.min(0.0)
            })
        };
        x.iter().map(shown).collect()
    }
}
