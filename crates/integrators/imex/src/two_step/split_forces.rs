//! The two parts of the force, EEH (6).

use drape_integrator::Implicit;
use drape_model::{Level, System, Vec3};

/// `y' = f + g`, EEH (6), as forces of one level: everything that is not linear and stiff, and what is.
#[doc(alias = "EEH 6")]
#[derive(Clone, Debug)]
pub(crate) struct SplitForces {
    /// `F`: `F2` of the implicit springs, the remainder of their damping where it is projected, and every
    /// other effect, N.
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

    /// Adds `F` at a level to `out`.
    pub(crate) fn add_explicit(
        system: &System,
        implicit: Implicit,
        at: Level<'_>,
        out: &mut [Vec3],
    ) {
        implicit.add_explicit_forces(system, at, out);
        implicit.add_nonlinear_forces(system, at.x, out);
        implicit.add_damping_remainders(system, at.x, at.v, out);
    }

    /// `F` and `G` at a level. `G` is the negative of EEH (15) and (18).
    #[doc(alias = "EEH 15")]
    #[doc(alias = "EEH 18")]
    pub(crate) fn evaluate(&mut self, system: &System, implicit: Implicit, at: Level<'_>) {
        self.explicit.fill(Vec3::zeros());
        Self::add_explicit(system, implicit, at, &mut self.explicit);
        self.linear.fill(Vec3::zeros());
        implicit.add_linear_spring_forces(system, at.x, &mut self.linear);
        implicit.add_linear_damping_forces(system, at.v, &mut self.linear);
    }
}
