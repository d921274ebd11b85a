//! Energies and momenta of a state.

use crate::system::PIECE;
use crate::{Effect, State, System, Vec3};
use rayon::prelude::*;

/// Depth inside an obstacle at which a particle may still be drawn, m.
const DISPLAY_TOLERANCE: f64 = 1e-12;

impl System {
    /// Kinetic energy `½ Σ m v²`, J.
    pub fn kinetic_energy(&self, v: &[Vec3]) -> f64 {
        0.5 * self.mass().iter().zip(v).map(|(&m, v)| m * v.norm_squared()).sum::<f64>()
    }

    /// Potential energy of all effects, J.
    pub fn potential_energy(&self, x: &[Vec3]) -> f64 {
        if self.threads() == 1 || x.len() < PIECE {
            return self.effects().map(|effect| effect.energy(self.mass(), x)).sum();
        }
        self.energies(x).map(|(_, energy)| energy).sum()
    }

    /// Kinetic plus potential energy `H`, J.
    pub fn total_energy(&self, state: &State) -> f64 {
        self.kinetic_energy(&state.v) + self.potential_energy(&state.x)
    }

    /// Energy of each effect by name, in the order of the effects, J. On large cloth
    /// [threads](Self::threads) share the effects, which changes no bit.
    pub fn energies(&self, x: &[Vec3]) -> impl Iterator<Item = (&'static str, f64)> {
        let effects: Vec<&dyn Effect> = self.effects().collect();
        let energy = |effect: &&dyn Effect| (effect.name(), effect.energy(self.mass(), x));
        let energies: Vec<_> = if self.threads() == 1 || x.len() < PIECE {
            effects.iter().map(energy).collect()
        } else {
            effects.par_iter().map(energy).collect()
        };
        energies.into_iter()
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

    /// Positions for display at `t` seconds. A particle inside an obstacle is shown on its surface
    /// (EEH section 6). The simulation never uses these positions.
    ///
    /// If obstacles overlap, the way out of one may lead into the next. The search then continues
    /// from the point that it reached, for at most 100 rounds.
    pub fn display_positions(&self, x: &[Vec3], t: f64) -> Vec<Vec3> {
        let offsets: Vec<Vec3> = self.obstacles().iter().map(|o| o.offset(t)).collect();
        let shown = |x: &Vec3| {
            let mut shown = *x;
            for _ in 0..100 {
                let before = shown;
                for (obstacle, offset) in self.obstacles().iter().zip(&offsets) {
                    let (distance, normal) = obstacle.distance(&(shown - offset));
                    shown -= normal * distance.min(0.0);
                }
                if (shown - before).norm() <= DISPLAY_TOLERANCE {
                    break;
                }
            }
            shown
        };
        x.iter().map(shown).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::num::NonZero;

    /// A sheet with more particles than one thread takes.
    #[test]
    fn threads_share_the_energies_of_the_effects_without_changing_a_bit() {
        let text = r#"{ "format": "drape-scene/1", "name": "s", "cloth": { "grid": { "rows": 70,
            "columns": 70, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 0.4 } },
            "effects": { "tension": { "stiffness_n_per_m": 9 }, "shear": { "stiffness_n_per_m": 3 },
            "bending": { "stiffness_n_per_m": 1 }, "gravity": { "m_s2": [0, 0, -9.81] } },
            "time": { "step_s": 0.01, "duration_s": 1 } }"#;
        let spec = crate::parse("s.json", text).expect("valid").spec().clone();
        let (mut system, mut state) = spec.build().expect("valid");
        assert!(state.x.len() > PIECE);
        for (n, x) in state.x.iter_mut().enumerate() {
            x.z += 1e-3 * (n % 7) as f64;
        }
        let of = |system: &System| {
            let energies = system.energies(&state.x).map(|(name, energy)| (name, energy.to_bits()));
            (energies.collect::<Vec<_>>(), system.potential_energy(&state.x).to_bits())
        };
        let one = of(&system);
        let names: Vec<_> = one.0.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["tension", "shear", "bending", "gravity"]);
        assert!(one.0.iter().all(|(_, energy)| f64::from_bits(*energy) != 0.0), "{one:?}");
        system.set_threads(NonZero::new(3).expect("positive"));
        assert_eq!(of(&system), one);
    }
}
