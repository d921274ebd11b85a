//! The two parts of the force, EEH (6).

use drape_integrator::Implicit;
use drape_model::{Level, System, Vec3};

/// The two parts of `y' = f + g`, EEH (6), as forces of one level: `g` is linear and stiff, `f` the
/// rest.
#[doc(alias = "EEH 6")]
#[derive(Clone, Debug)]
pub(crate) struct SplitForces {
    /// `F`, N: `F2` of the implicit springs, the remainder of their projected damping, and all
    /// other effects.
    pub(crate) explicit: Vec<Vec3>,
    /// `G = −L_k x − L_c v` of the implicit springs, N.
    pub(crate) linear: Vec<Vec3>,
}

impl SplitForces {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        Self { explicit: zeros(), linear: zeros() }
    }

    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.explicit.copy_from_slice(&other.explicit);
        self.linear.copy_from_slice(&other.linear);
    }

    /// Number of sweeps over the springs that [`evaluate`](Self::evaluate) takes.
    pub(crate) const SWEEPS: u32 = 2;

    /// `F` and `G` at a level. `G` is the negative of EEH (15) and (18).
    #[doc(alias = "EEH 15")]
    #[doc(alias = "EEH 18")]
    pub(crate) fn evaluate(&mut self, system: &System, implicit: Implicit, at: Level<'_>) {
        implicit.forces_but_linear(system, at, &mut self.explicit);
        implicit.linear_forces(system, at, &mut self.linear);
    }
}
