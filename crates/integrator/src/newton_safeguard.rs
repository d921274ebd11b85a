//! When a linearised step needs another iteration.

use crate::{Declared, IncrementalPotential, Word, declare};
use drape_model::{System, Vec3};
use drape_solvers::{Constraints, Filter};

/// Whether Newton's method continues after its last iteration if the step would gain energy.
///
/// A solve that stops early leaves the residual `r = S∇Φ(v)`. The step then equals the exact step
/// under the additional impulse `r`, and `r·v` is the energy that this impulse adds to the cloth.
/// The [ledger](crate::EnergyLedger) calls this term *residual*. On a stiff sheet, one Newton
/// iteration leaves springs stretched that rotated during the iteration, and their work is positive
/// in many successive steps. Neither the size of the residual nor the decrease of the potential
/// reveals this: both look the same in steps that lose energy.
///
/// With [`Work`](Self::Work), Newton's method continues while
///
/// ```text
/// r·(v − u) > ⅒ ½ ‖S (v − v̂)‖²_M                                                            (W)
/// ```
///
/// The right-hand side is a tenth of the kinetic energy of the change of velocity that the implicit
/// forces make in the stage. `u` is the velocity of the fixed particles, or of the centre of mass
/// where none is fixed, so (W) is the same in every frame. The residual is known already, because
/// it is the next right-hand side. If (W) requires no further iteration, it therefore costs only
/// two sums over the particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Safeguard {
    /// The iteration ends after `max_iterations`.
    None,
    /// The iteration continues while the work of the residual adds energy, (W).
    Work,
}

impl Word for Safeguard {
    const WORDS: &'static [(&'static str, Self)] = &[("none", Self::None), ("work", Self::Work)];
}

impl Safeguard {
    /// The setting `safeguard`.
    pub const SETTING: Declared<Self> = declare!(
        safeguard: Safeguard [None, Work] = None,
        "work: Newton goes on after max_iterations while the work of its residual would add energy \
         (for linearised steps, max_iterations=1)"
    );

    /// Most iterations of a solve; `limit` is the one of the settings.
    pub(crate) fn most_iterations(self, limit: u32) -> u32 {
        match self {
            Self::None => limit,
            Self::Work => limit.max(MOST_ITERATIONS),
        }
    }

    /// Whether the solve has to go on from `v` with this projected residual.
    pub(crate) fn objects(
        self,
        system: &System,
        potential: &IncrementalPotential,
        constraints: &Constraints,
        residual: &[Vec3],
        v: &[Vec3],
    ) -> bool {
        if self == Self::None {
            return false;
        }
        let frame = frame(system, constraints, v);
        let (mut work, mut change) = (0.0, 0.0);
        for (i, m) in system.mass().iter().enumerate() {
            work += residual[i].dot(&(v[i] - frame));
            let turned = constraints.filter(i).apply(v[i] - potential.target()[i]);
            change += 0.5 * m * turned.norm_squared();
        }
        work > ALLOWED * change
    }
}

/// Most iterations of a solve that the safeguard prolongs.
const MOST_ITERATIONS: u32 = 100;
/// Work of the residual over the kinetic energy of the change of velocity.
const ALLOWED: f64 = 0.1;

/// The velocity of the frame in which energy is measured, m/s.
fn frame(system: &System, constraints: &Constraints, v: &[Vec3]) -> Vec3 {
    let (mut sum, mut weight) = (Vec3::zeros(), 0.0);
    for i in constraints.constrained().iter().map(|&i| i as usize) {
        if constraints.filter(i) == Filter::Fixed {
            sum += constraints.prescribed(i);
            weight += 1.0;
        }
    }
    if weight == 0.0 {
        for (m, v) in system.mass().iter().zip(v) {
            sum += v * *m;
            weight += m;
        }
    }
    sum / weight
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Implicit, Tau};
    use drape_model::{Level, parse};

    /// Two particles on a spring; the first may be pinned.
    fn pair() -> System {
        let text = r#"{ "format": "drape-system/1",
            "particles": { "mass_kg": [2, 1], "position_m": [[0, 0, 0], [1, 0, 0]] },
            "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
                "stiffness_n_per_m": 40 }] }"#;
        parse("pair", text).expect("valid").spec().build().expect("valid").0
    }

    /// Whether the safeguard objects to velocities that the forces have changed by `change`, in a
    /// frame that moves at `frame`.
    fn objects(
        residual: [Vec3; 2],
        change: [Vec3; 2],
        frame: Vec3,
        constraints: &Constraints,
    ) -> bool {
        let system = pair();
        let x = [Vec3::zeros(), Vec3::x()];
        let before = [frame; 2];
        let lagged = Level { t: 0.0, x: &x, v: &before };
        let mut potential = IncrementalPotential::new(&system, Implicit::Everything);
        potential.begin(&system, Tau::from(0.1), (&x, &before), lagged, &[Vec3::zeros(); 2]);
        let v = [frame + change[0], frame + change[1]];
        let [none, work] = [Safeguard::None, Safeguard::Work]
            .map(|guard| guard.objects(&system, &potential, constraints, &residual, &v));
        assert!(!none);
        work
    }

    #[test]
    fn it_objects_to_work_above_a_tenth_of_the_energy_of_the_change_in_any_frame() {
        let free = Constraints::free(2);
        let apart = |speed: f64| [Vec3::x() * (-0.5 * speed), Vec3::x() * speed];
        // ½ (2 · ¼ + 1) = 0.75 J, and the residual p does the work 1.5 p.
        for frame in [Vec3::zeros(), Vec3::new(30.0, -200.0, 7.0)] {
            for (impulse, expected) in [(0.04, false), (0.06, true), (-1.0, false)] {
                let residual = [Vec3::x() * -impulse, Vec3::x() * impulse];
                assert_eq!(objects(residual, apart(1.0), frame, &free), expected, "{impulse}");
            }
            // A residual that accelerates both alike does no work in the frame of their centre.
            let push = [Vec3::x() * 2.0, Vec3::x()];
            assert!(!objects(push, apart(1.0), frame, &free), "{frame:?}");
            // Beside a fixed particle the push is work.
            let mut held = Constraints::free(2);
            held.set(0, Filter::Fixed, frame);
            let change = [Vec3::zeros(), Vec3::x()];
            for (impulse, expected) in [(0.04, false), (0.06, true)] {
                let residual = [Vec3::zeros(), Vec3::x() * impulse];
                assert_eq!(objects(residual, change, frame, &held), expected, "{impulse}");
            }
        }
    }

    #[test]
    fn only_the_safeguard_goes_beyond_the_limit() {
        assert_eq!(Safeguard::None.most_iterations(1), 1);
        assert_eq!(Safeguard::Work.most_iterations(1), MOST_ITERATIONS);
        assert_eq!(Safeguard::Work.most_iterations(1000), 1000);
    }
}
