//! The matrix of an implicit step with linearised forces, in 3×3 blocks.

use crate::Implicit;
use drape_model::{
    BlockSink, Effect, Level, Linearised, Mat3, StiffnessProduct, System, Tangent, Vec3,
};
use drape_solvers::{BlockMatrix, Coupling};

/// The point at which the implicit forces are linearised, and the length of the step.
///
/// `K = −∂f/∂x` and `D = −∂f/∂v` of the implicit effects give the matrix of EEH section 2.3,
/// multiplied by the masses so that it is symmetric:
///
/// ```text
/// M + τ² K + τ D
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Linearisation<'a> {
    /// Which effects are implicit.
    pub implicit: Implicit,
    /// `τ`, s.
    pub tau: f64,
    /// Positions at which `K` is taken, m.
    pub x: &'a [Vec3],
    /// Level of the directions and coefficients of damping. Only effects that
    /// [drag](Effect::is_drag) read the velocities.
    pub lagged: Level<'a>,
    /// Which second derivative of the energy `K` is.
    pub tangent: Tangent,
}

impl Linearisation<'_> {
    /// Writes `M + τ² K + τ D`, kg, to `matrix` and, on request, the product `K w` to `out`, N for
    /// `w` in m. The matrix must be an [`Implicit::block_matrix`] or [`Implicit::block_rows`] of
    /// this system.
    ///
    /// Bands and springs in any order are filled in one sweep over the springs. The bits of bands are
    /// the same as if the blocks were added one by one.
    #[doc(alias = "EEH section 2.3")]
    pub fn assemble(
        &self,
        system: &System,
        matrix: &mut BlockMatrix,
        product: Option<StiffnessProduct<'_>>,
    ) {
        self.assemble_scaled((self.tau * self.tau, self.tau), system, matrix, product);
    }

    /// As [`assemble`](Self::assemble), with any factors `s` and `d`: `matrix ← M + s K + d D`. It
    /// ignores `τ`.
    pub fn assemble_scaled(
        &self,
        (stiffness_scale, damping_scale): (f64, f64),
        system: &System,
        matrix: &mut BlockMatrix,
        mut product: Option<StiffnessProduct<'_>>,
    ) {
        let Self { implicit, x, lagged, tangent, .. } = *self;
        matrix.set_threads(system.threads());
        if let Some(StiffnessProduct { out, .. }) = &mut product {
            out.fill(Vec3::zeros());
        }
        let effects = || implicit.effects(system);
        let at = Linearised { x, tangent, stiffness_scale, damping_scale };
        if let Some(layout) = matrix.fast_layout() {
            let product = product.as_mut();
            let product = product.map(|p| StiffnessProduct { w: p.w, out: &mut *p.out });
            if system.linearise(effects(), &at, layout, product) {
                return;
            }
        }
        matrix.clear();
        for (i, &m) in system.mass().iter().enumerate() {
            matrix.add_diagonal(i, &Mat3::from_diagonal_element(m));
        }
        for effect in effects() {
            effect.add_stiffness(x, stiffness_scale, tangent, matrix);
            effect.add_damping(lagged, damping_scale, matrix);
        }
        if let Some(StiffnessProduct { w, out }) = product {
            implicit.multiply_stiffness(system, x, tangent, w, out);
        }
    }
}

impl Implicit {
    /// A zero matrix with a block for each pair of particles that the implicit effects couple. Its
    /// layout suits the mesh.
    pub fn block_matrix(self, system: &System) -> BlockMatrix {
        self.block_matrix_in(&system.coupling(self.effects(system)), system)
    }

    /// As [`block_matrix`](Self::block_matrix), but in compressed rows, as factorisations and
    /// contacts require.
    pub fn block_rows(self, system: &System) -> BlockMatrix {
        self.block_matrix_in(&Coupling::Rows, system)
    }

    fn block_matrix_in(self, coupling: &Coupling, system: &System) -> BlockMatrix {
        let mut pairs = Vec::new();
        for effect in self.effects(system) {
            effect.visit_pairs(&mut |i, j| pairs.push((i, j)));
        }
        let mut matrix = BlockMatrix::new(system.len(), coupling, pairs);
        matrix.set_threads(system.threads());
        matrix
    }

    /// Writes `K w` at `x` to `out`, N for `w` in m, in one sweep over the springs and without a
    /// matrix. It multiplies differences of `w`, so a translation gives exactly 0.
    pub fn multiply_stiffness(
        self,
        system: &System,
        x: &[Vec3],
        tangent: Tangent,
        w: &[Vec3],
        out: &mut [Vec3],
    ) {
        out.fill(Vec3::zeros());
        let mut sink = Product { w, out };
        for effect in self.effects(system) {
            effect.add_stiffness(x, 1.0, tangent, &mut sink);
        }
    }
}

/// Subtracts `K w` of one effect at `x` from `out`, N for `w` in m.
pub(crate) fn subtract_stiffness_product(
    effect: &dyn Effect,
    x: &[Vec3],
    tangent: Tangent,
    w: &[Vec3],
    out: &mut [Vec3],
) {
    effect.add_stiffness(x, -1.0, tangent, &mut Product { w, out });
}

/// Adds the product of blocks with a vector to another.
struct Product<'a> {
    w: &'a [Vec3],
    out: &'a mut [Vec3],
}

impl BlockSink for Product<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        let force = block * (self.w[i] - self.w[j]);
        self.out[i] += force;
        self.out[j] -= force;
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        let difference = self.w[i] - self.w[j];
        self.out[i] += block * difference;
        self.out[j] -= block.tr_mul(&difference);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.out[i] += block * self.w[i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::{State, parse};
    use drape_solvers::LinearOperator;

    /// Three particles with a stretched and a squeezed spring.
    fn bent_string() -> (System, State) {
        let text = r#"{ "format": "drape-system/1",
            "particles": { "mass_kg": [1, 2, 3], "position_m": [[0, 0, 0], [1, 0, 0], [1, 2, 1]] },
            "springs": [
                { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 3,
                  "stiffness_n_per_m": 7, "damping_n_s_per_m": 2 },
                { "effect": "bending", "i": 1, "j": 2, "rest_length_m": 1,
                  "stiffness_n_per_m": 5 }] }"#;
        parse("test", text).expect("valid").spec().build().expect("valid")
    }

    #[test]
    fn the_matrix_is_made_of_masses_stiffness_and_damping_with_their_powers_of_the_step() {
        let (system, state) = bent_string();
        let w = [Vec3::new(1.0, 2.0, -1.0), Vec3::new(0.5, 0.0, 3.0), Vec3::new(0.0, -2.0, 1.0)];
        let implicit = Implicit::Everything;
        let (mut matrix, mut product, mut stiffness) =
            (implicit.block_rows(&system), w, [Vec3::zeros(); 3]);
        for (tangent, tau) in [(Tangent::Exact, 0.5), (Tangent::Projected, 0.25)] {
            let (x, lagged) = (&state.x[..], state.level());
            let at = Linearisation { implicit, tau, x, lagged, tangent };
            at.assemble(&system, &mut matrix, None);
            matrix.multiply(&w, &mut product);
            implicit.multiply_stiffness(&system, x, tangent, &w, &mut stiffness);
            let mut damping = [Vec3::zeros(); 3];
            system.effects().for_each(|effect| {
                effect.add_damping_force(Level { v: &w, ..lagged }, &mut damping);
            });
            for (i, m) in system.mass().iter().enumerate() {
                let expected = w[i] * *m + stiffness[i] * (tau * tau) - damping[i] * tau;
                assert!((product[i] - expected).norm() < 1e-13, "{tangent:?}, {i}");
            }
        }
        // Across the squeezed spring, x: k (1 − ℓ/L) = −14, left out by the projection.
        let across = [Vec3::z(), Vec3::zeros(), Vec3::zeros()];
        implicit.multiply_stiffness(&system, &state.x, Tangent::Exact, &across, &mut stiffness);
        assert_eq!(stiffness[0], Vec3::z() * -14.0);
        implicit.multiply_stiffness(&system, &state.x, Tangent::Projected, &across, &mut stiffness);
        assert_eq!(stiffness, [Vec3::zeros(); 3]);
    }

    #[test]
    fn a_translation_meets_no_stiffness_to_the_last_bit() {
        let (system, state) = bent_string();
        let (w, mut out) = ([Vec3::new(0.1, 1e9, -0.7); 3], [Vec3::x(); 3]);
        Implicit::Everything.multiply_stiffness(&system, &state.x, Tangent::Exact, &w, &mut out);
        assert_eq!(out, [Vec3::zeros(); 3]);
        let tension = Implicit::Tension.block_matrix(&system);
        assert_eq!(
            (tension.nonzeros(), Implicit::Everything.block_matrix(&system).nonzeros()),
            (5, 7)
        );
    }
}
