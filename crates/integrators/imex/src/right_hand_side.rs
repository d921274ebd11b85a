//! The right-hand side of EEH (21), and its update by Algorithm 1.

use drape_integrator::{Implicit, Slopes};
use drape_model::{State, System, Vec3};

/// `b`, and the part of it that Algorithm 1 does not update.
#[derive(Debug)]
pub(crate) struct RightHandSide {
    implicit: Implicit,
    /// Right-hand side, kg m/s.
    pub(crate) b: Vec<Vec3>,
    /// `M v_n + h [F_frozen − L_k x_n]`, kg m/s. This and the next three fields are empty where
    /// nothing is updated.
    frozen: Vec<Vec3>,
    /// Force of the explicit effects, N.
    pub(crate) explicit_force: Vec<Vec3>,
    x: Vec<Vec3>,
    force: Vec<Vec3>,
}

impl RightHandSide {
    /// Memory for [`assemble`](Self::assemble) alone.
    pub(crate) fn new(n: usize, implicit: Implicit) -> Self {
        Self {
            implicit,
            b: vec![Vec3::zeros(); n],
            frozen: Vec::new(),
            explicit_force: Vec::new(),
            x: Vec::new(),
            force: Vec::new(),
        }
    }

    /// Memory for [`freeze`](Self::freeze) and [`update`](Self::update) too.
    pub(crate) fn updated(n: usize, implicit: Implicit) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        Self {
            frozen: zeros(),
            explicit_force: zeros(),
            x: zeros(),
            force: zeros(),
            ..Self::new(n, implicit)
        }
    }

    /// Which effects are implicit.
    pub(crate) fn implicit(&self) -> Implicit {
        self.implicit
    }

    /// Positions of the last [update](Self::update), m.
    pub(crate) fn positions(&self) -> &[Vec3] {
        &self.x
    }

    /// `b = M v_n + h [F_explicit(x_n, v_n) − L_k x_n]`, EEH (21). Since `F2 − L_k x` is the force
    /// of the springs, the bracket is the whole force at level `n` without the damping `−L_c v`,
    /// which stands in the matrix.
    #[doc(alias = "EEH 21")]
    pub(crate) fn assemble(&mut self, system: &System, state: &State, h: f64) {
        self.implicit.write_impulse(system, state, h, &mut self.b);
    }

    /// The part of `b` that Algorithm 1 does not update. `M v_n`, `−h L_k x_n` and every force that
    /// the matrix does not dominate stay at level `n`.
    pub(crate) fn freeze(
        &mut self,
        system: &System,
        state: &State,
        h: f64,
        slopes: Option<&Slopes>,
    ) {
        self.explicit_force.fill(Vec3::zeros());
        self.implicit.add_explicit_forces(system, state.level(), &mut self.explicit_force);
        // −L_k x_n is the springs' force without F2.
        self.force.fill(Vec3::zeros());
        add_nonlinear_forces(self.implicit, slopes, system, &state.x, &mut self.force);
        self.frozen.fill(Vec3::zeros());
        self.implicit.add_implicit_forces(system, &state.x, &mut self.frozen);
        for (i, &m) in system.mass().iter().enumerate() {
            let force = self.explicit_force[i] + (self.frozen[i] - self.force[i]);
            self.frozen[i] = state.v[i] * m + force * h;
        }
    }

    /// The impulse of the forces of level `n` on a particle, `h F`, kg m/s; between
    /// [`freeze`](Self::freeze) and the first [`update`](Self::update).
    pub(crate) fn impulse(&self, system: &System, state: &State, h: f64, i: usize) -> Vec3 {
        self.frozen[i] - state.v[i] * system.mass()[i] + self.force[i] * h
    }

    /// `b(v, x_n + h v)`: only `F2` and the remainder of projected damping follow `v`.
    #[doc(alias = "EEH Algorithm 1")]
    pub(crate) fn update(
        &mut self,
        system: &System,
        state: &State,
        h: f64,
        v: &[Vec3],
        slopes: Option<&Slopes>,
    ) {
        for ((x, x_n), v) in self.x.iter_mut().zip(&state.x).zip(v) {
            *x = x_n + v * h;
        }
        self.force.fill(Vec3::zeros());
        add_nonlinear_forces(self.implicit, slopes, system, &self.x, &mut self.force);
        self.implicit.add_damping_remainders(system, &state.x, v, &mut self.force);
        for ((b, frozen), force) in self.b.iter_mut().zip(&self.frozen).zip(&self.force) {
            *b = frozen + force * h;
        }
    }
}

/// Adds `F2` of the implicit effects at `x`, N: the rest of their force beside the stiffnesses
/// in the matrix, which are `slopes` or else constant.
pub(crate) fn add_nonlinear_forces(
    implicit: Implicit,
    slopes: Option<&Slopes>,
    system: &System,
    x: &[Vec3],
    out: &mut [Vec3],
) {
    match slopes {
        None => implicit.add_nonlinear_forces(system, x, out),
        Some(slopes) => slopes.add_nonlinear_forces(system, x, out),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_oracle::scenes::Sheet;

    /// The stop test measures the residual by it: the momentum has no part in it.
    #[test]
    fn the_impulse_is_that_of_the_forces() {
        let (system, mut state) = Sheet { side: 3, damping: 0.0, ..Sheet::default() }.build();
        state.v.fill(Vec3::new(3.0, -2.0, 5.0));
        let h = 0.01;
        let mut rhs = RightHandSide::updated(system.len(), Implicit::Springs);
        rhs.freeze(&system, &state, h, None);
        rhs.update(&system, &state, h, &state.v, None);
        let mut force = vec![Vec3::zeros(); system.len()];
        system.forces(state.level(), &mut force);
        for (i, force) in force.iter().enumerate() {
            let impulse = rhs.impulse(&system, &state, h, i);
            assert!((impulse - force * h).norm() < 1e-12, "{i}: {impulse:?}");
        }
    }
}
