//! The force at the end of a step, which the next step reuses.

use crate::{StepReport, each_particle};
use drape_model::{Effect, Level, Part, Revisions, System, Vec3};

/// The conservative force at the end of a step. It is kept for the [revisions](System::revisions)
/// of the system and for the positions, which are compared bit by bit. Any other change of the
/// positions or the system triggers a new evaluation. Changes of velocity and step size do not.
#[derive(Debug)]
pub struct KeptForce {
    selects: fn(&dyn Effect) -> bool,
    force: Vec<Vec3>,
    remembered: Option<Revisions>,
    positions: Vec<Vec3>,
}

impl KeptForce {
    /// Memory for the force of all effects.
    pub fn new(system: &System) -> Self {
        Self::of(system, |_| true)
    }

    /// Memory for the force of some effects.
    pub fn of(system: &System, selects: fn(&dyn Effect) -> bool) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Self { selects, force: zeros(), remembered: None, positions: zeros() }
    }

    /// The force, N; `n` × 3.
    pub fn force(&self) -> &[Vec3] {
        &self.force
    }

    /// Evaluates the force at `x`, unless it is already known for these positions.
    pub fn begin(&mut self, system: &System, x: &[Vec3], report: &mut StepReport) {
        if !(self.remembered == Some(system.revisions()) && same_bits(&self.positions, x)) {
            self.evaluate(system, x, report);
        }
    }

    /// Evaluates the force at `x` in any case.
    pub fn evaluate(&mut self, system: &System, x: &[Vec3], report: &mut StepReport) {
        let at = Level { t: 0.0, x, v: x }; // Part::Force reads only the positions
        let effects = system.effects().filter(|effect| (self.selects)(*effect));
        system.write_forces(effects.map(|effect| (effect, Part::Force)), at, &mut self.force);
        report.force_evaluations += 1;
    }

    /// Keeps the force for the next step, which starts at `x`.
    pub fn keep(&mut self, system: &System, x: &[Vec3]) {
        self.remembered = Some(system.revisions());
        each_particle(system, &mut self.positions, |i| x[i]);
    }

    /// Forgets the force.
    pub fn forget(&mut self) {
        self.remembered = None;
    }
}

/// Whether two block vectors are equal to the last bit. Without an early exit, the loop costs
/// little beside a sweep over the springs.
fn same_bits(a: &[Vec3], b: &[Vec3]) -> bool {
    let differing =
        |a: &Vec3, b: &Vec3| (0..3).fold(0, |bits, k| bits | (a[k].to_bits() ^ b[k].to_bits()));
    a.iter().zip(b).fold(0, |bits, (a, b)| bits | differing(a, b)) == 0
}
