//! How much of its spin a free cloth keeps.
//!
//! Where no torque acts about the centre of mass, the angular momentum `L` about it is constant:
//! springs, hinges and projected damping pull in pairs along lines or turn nothing, and uniform
//! gravity has no lever arm. Any loss of `L` in a run comes from the method.
//!
//! ```text
//! L = Σ m (x − c) × (v − v_c)        share = L_end·L_start / L_start·L_start
//! ```
//!
//! The torque is computed from all forces at the start, so the rule covers every effect. Full
//! damping, which also resists a rigid rotation, has a torque.

use drape_model::{State, System, Vec3};

/// A cloth spins if `|L|` is at least this share of `Σ m |x − c| |v − v_c|`.
const LEAST: f64 = 0.1;
/// A torque up to this share of the sum of its parts is round-off.
const ROUND_OFF: f64 = 1e-9;

/// The spin of a cloth on which no torque acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spin {
    /// `L` at the start, kg m²/s.
    start: Vec3,
}

/// The mean of vectors, each with its mass.
fn mean(mass: &[f64], vectors: &[Vec3]) -> Vec3 {
    let sum: Vec3 = mass.iter().zip(vectors).map(|(m, v)| v * *m).sum();
    sum / mass.iter().sum::<f64>()
}

/// `Σ (x − c) × y` about the centre of mass `c`, and the sum of the products of the lengths.
fn moment(mass: &[f64], x: &[Vec3], y: impl Iterator<Item = Vec3>) -> (Vec3, f64) {
    let centre = mean(mass, x);
    let mut sums = (Vec3::zeros(), 0.0);
    for (x, y) in x.iter().zip(y) {
        let lever = x - centre;
        sums.0 += lever.cross(&y);
        sums.1 += lever.norm() * y.norm();
    }
    sums
}

/// The angular momentum about the centre of mass, and the greatest one that such speeds could give,
/// kg m²/s.
fn angular_momentum(system: &System, state: &State) -> (Vec3, f64) {
    let mass = system.mass();
    let drift = mean(mass, &state.v);
    moment(mass, &state.x, mass.iter().zip(&state.v).map(|(m, v)| (v - drift) * *m))
}

impl Spin {
    /// The spin of a cloth at its start; `None` where it does not spin, or where a torque may act
    /// on it.
    pub(crate) fn of(system: &System, state: &State) -> Option<Self> {
        let is_held = system.pinned().contains(&true)
            || !system.moving_pins().is_empty()
            || !system.obstacles().is_empty()
            || system.effects().any(|effect| effect.is_drag());
        let (start, most) = angular_momentum(system, state);
        let does_spin = most > 0.0 && start.norm() >= LEAST * most;
        if is_held || !does_spin {
            return None;
        }
        let mut force = vec![Vec3::zeros(); system.len()];
        system.forces(state.level(), &mut force);
        let (torque, most) = moment(system.mass(), &state.x, force.into_iter());
        (torque.norm() <= ROUND_OFF * most).then_some(Self { start })
    }

    /// The share of the spin that a state has.
    pub(crate) fn share(&self, system: &System, state: &State) -> f64 {
        angular_momentum(system, state).0.dot(&self.start) / self.start.norm_squared()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use drape_model::{AirSpec, DampingLaw, DragSpec, SystemSpec};
    use drape_oracle::scenes::pin;

    fn spinning() -> SystemSpec {
        drape_model::load("spinning-sheet").unwrap().spec().clone()
    }

    fn spin(spec: &SystemSpec) -> Option<Spin> {
        let (system, state) = spec.build().unwrap();
        Spin::of(&system, &state)
    }

    #[test]
    fn a_turned_and_a_slowed_sheet_have_their_share() {
        let (system, state) = spinning().build().unwrap();
        let spin = Spin::of(&system, &state).unwrap();
        assert!((spin.share(&system, &state) - 1.0).abs() < 1e-12);
        // A drift of the whole cloth does not count as spin.
        let mut slowed = state.clone();
        slowed.v.iter_mut().for_each(|v| *v = *v * 0.25 + Vec3::new(3.0, -2.0, 1.0));
        assert!((spin.share(&system, &slowed) - 0.25).abs() < 1e-9);
        slowed.v.iter_mut().zip(&state.v).for_each(|(slowed, v)| *slowed = -v);
        assert!((spin.share(&system, &slowed) + 1.0).abs() < 1e-9);
    }

    #[test]
    fn only_a_cloth_that_spins_and_that_no_torque_acts_on_is_watched() {
        assert!(spin(&spinning()).is_some());
        let changed = |change: fn(&mut SystemSpec)| {
            let mut spec = spinning();
            change(&mut spec);
            spin(&spec)
        };
        let falling = |spec: &mut SystemSpec| {
            spec.effects.gravity = drape_oracle::scenes::gravity();
        };
        assert!(changed(falling).is_some(), "gravity has no lever");
        assert!(changed(|spec| spec.pins.push(pin(0))).is_none(), "a pin");
        assert!(changed(|spec| spec.damping = DampingLaw::Full).is_none(), "full damping");
        let air = |spec: &mut SystemSpec| {
            let drag = DragSpec::Linear { coefficient_n_s_per_m3: 1e-9 };
            spec.effects.air = Some(AirSpec { drag, wind: None });
        };
        assert!(changed(air).is_none(), "air");
        let still = |spec: &mut SystemSpec| spec.particles.velocity_m_s.fill([1.0, 2.0, 3.0]);
        assert!(changed(still).is_none(), "it does not spin");
    }
}
