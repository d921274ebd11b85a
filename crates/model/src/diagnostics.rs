//! Energies and momenta of a state.

use crate::effects::Effect;
use crate::{State, System, Vec3};
use drape_kernels::bands::bands;
use rayon::prelude::*;

/// Depth inside an obstacle at which a particle may still be drawn, m.
const DISPLAY_TOLERANCE: f64 = 1e-12;

impl System {
    /// Kinetic energy `½ Σ m v²`, J.
    pub fn kinetic_energy(&self, v: &[Vec3]) -> f64 {
        0.5 * self.mass().iter().zip(v).map(|(&m, v)| m * v.norm_squared()).sum::<f64>()
    }

    /// Potential energy of all effects, J. The [threads](System::threads) of the system share the
    /// effects, without any change of its bits.
    pub fn potential_energy(&self, x: &[Vec3]) -> f64 {
        if self.has_helpers() {
            self.energies(x).map(|(_, energy)| energy).sum()
        } else {
            self.effects().map(|effect| effect.energy(self.mass(), x)).sum()
        }
    }

    /// Whether several threads share the sweeps over the particles: the caller is one of a pool, and
    /// there are enough particles.
    pub fn has_helpers(&self) -> bool {
        rayon::current_thread_index().is_some() && bands(self.threads(), self.len()) > 1
    }

    /// Kinetic plus potential energy `H`, J.
    pub fn total_energy(&self, state: &State) -> f64 {
        self.kinetic_energy(&state.v) + self.potential_energy(&state.x)
    }

    /// Energy of each effect by name, in the order of the effects, J. The
    /// [threads](System::threads) of the system share the effects, without any change of the bits.
    pub fn energies(&self, x: &[Vec3]) -> impl Iterator<Item = (&'static str, f64)> {
        let effects: Vec<&dyn Effect> = self.effects().collect();
        let energy = |effect: &&dyn Effect| (effect.name(), effect.energy(self.mass(), x));
        let energies: Vec<_> = if self.has_helpers() {
            effects.par_iter().with_max_len(1).map(energy).collect()
        } else {
            effects.iter().map(energy).collect()
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
