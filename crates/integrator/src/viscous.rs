//! Right-hand side of methods that solve for the *change* of velocity with the scalar matrix.

use crate::{Implicit, LaplacianSolver};
use drape_model::{State, System, Vec3};

/// The impulse of the springs with the artificial viscosity of Desbrun et al. (1999), and the
/// forces of the other effects.
///
/// With `A = M + h² L_k + h L_c` and the force `F` of the springs,
///
/// ```text
/// h F̃ = h [F(x_n) − h L_k v_n − L_c v_n] = h F(x_n) + (M − A) v_n
/// ```
///
/// so `Δv = A⁻¹ h F̃` is the change of IMEX Euler (EEH (21)) without other forces. Projected
/// damping adds its remainder at level `n`.
#[derive(Clone, Debug)]
pub struct ViscousImpulse {
    impulse: Vec<Vec3>,
    external: Vec<Vec3>,
    product: Vec<Vec3>,
}

impl ViscousImpulse {
    /// Memory for `n` particles.
    pub fn new(n: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        Self { impulse: zeros(), external: zeros(), product: zeros() }
    }

    /// Evaluates both parts at `state`, with one product of the matrix.
    pub fn assemble(
        &mut self,
        linear: &mut LaplacianSolver,
        system: &System,
        state: &State,
        h: f64,
    ) {
        let Self { impulse, external, product } = self;
        let v = &state.v;
        external.fill(Vec3::zeros());
        Implicit::Springs.add_explicit_forces(system, state.level(), external);
        impulse.fill(Vec3::zeros());
        Implicit::Springs.add_implicit_forces(system, &state.x, impulse);
        Implicit::Springs.add_damping_remainders(system, &state.x, v, impulse);
        let (matrix, fast) = linear.product();
        fast.multiply(matrix, v, product);
        for (i, (&m, pinned)) in system.mass().iter().zip(system.pinned()).enumerate() {
            let viscosity = v[i] * m - product[i];
            impulse[i] = if *pinned { Vec3::zeros() } else { impulse[i] * h + viscosity };
        }
    }

    /// `h F̃`, kg m/s; 0 for pinned particles.
    pub fn impulse(&self) -> &[Vec3] {
        &self.impulse
    }

    /// Force of all effects other than springs, N; one entry per particle.
    pub fn external(&self) -> &[Vec3] {
        &self.external
    }
}
