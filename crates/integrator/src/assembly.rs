//! The matrix of an implicit step whose forces are linearised, in 3×3 blocks.

use crate::Implicit;
use drape_model::{
    BlockPlanes, BlockSink, Effect, Level, Linearised, Mat3, PairBlocks, System, Tangent, Vec3,
};
use drape_solvers::{BandPlanes, BandedMatrix, BlockMatrix, PairLines, PairMatrix};

/// Where the implicit forces are linearised, and for a step of which length.
///
/// `K = −∂f/∂x` and `D = −∂f/∂v` of the implicit effects give the matrix of EEH section 2.3, multiplied by the
/// masses so that it is symmetric:
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
    /// Where damping takes its directions and coefficients. Velocities are asked for only where an effect
    /// [drags](Effect::is_drag).
    pub lagged: Level<'a>,
    /// Which `K`.
    pub tangent: Tangent,
}

impl Linearisation<'_> {
    /// `matrix ← M + τ² K + τ D`, kg. The matrix must have the pattern of [`Implicit::block_matrix`].
    #[doc(alias = "EEH section 2.3")]
    pub fn assemble(&self, system: &System, matrix: &mut BlockMatrix) {
        matrix.clear();
        for (i, &m) in system.mass().iter().enumerate() {
            matrix.add_diagonal(i, &Mat3::from_diagonal_element(m));
        }
        let mut sink = Sum(matrix);
        for effect in self.implicit.effects(system) {
            effect.add_stiffness(self.x, self.tau * self.tau, self.tangent, &mut sink);
            effect.add_damping(self.lagged, self.tau, &mut sink);
        }
    }

    /// `matrix ← M + τ² K + τ D`, kg, and `out ← K w`, N for `w` in m: the same bits as
    /// [`assemble`](Self::assemble) and [`Implicit::multiply_stiffness`] give, in one sweep where the springs allow it. The
    /// matrix must be that of [`Implicit::banded_matrix`].
    pub fn assemble_bands(
        &self,
        system: &System,
        matrix: &mut BandedMatrix,
        w: &[Vec3],
        out: &mut [Vec3],
    ) {
        let Self { implicit, tau, x, tangent, .. } = *self;
        let at = self.scaled(w);
        out.fill(Vec3::zeros());
        let BandPlanes { planes, stride, lead, offsets } = matrix.planes_mut();
        let planes = BlockPlanes { planes, stride, lead, offsets };
        if system.linearise(implicit.effects(system), &at, planes, out) {
            return;
        }
        matrix.clear();
        for (i, &m) in system.mass().iter().enumerate() {
            matrix.add_diagonal(i, &Mat3::from_diagonal_element(m));
        }
        let mut sink = Bands(matrix);
        for effect in implicit.effects(system) {
            effect.add_stiffness(x, tau * tau, tangent, &mut sink);
            effect.add_damping(self.lagged, tau, &mut sink);
        }
        implicit.multiply_stiffness(system, x, tangent, w, out);
    }

    /// As [`assemble_bands`](Self::assemble_bands) for springs in any order. The matrix must be that of
    /// [`Implicit::pair_matrix`].
    pub fn assemble_pairs(
        &self,
        system: &System,
        matrix: &mut PairMatrix,
        w: &[Vec3],
        out: &mut [Vec3],
    ) {
        let Self { implicit, tau, x, tangent, .. } = *self;
        out.fill(Vec3::zeros());
        let PairLines { diagonal, pairs, ends, slots } = matrix.lines_mut();
        let lines = PairBlocks { diagonal, pairs, ends, slots };
        if system.linearise_listed(implicit.effects(system), &self.scaled(w), lines, out) {
            return;
        }
        matrix.clear();
        for (i, &m) in system.mass().iter().enumerate() {
            matrix.add_diagonal(i, &Mat3::from_diagonal_element(m));
        }
        let mut sink = Pairs(matrix);
        for effect in implicit.effects(system) {
            effect.add_stiffness(x, tau * tau, tangent, &mut sink);
            effect.add_damping(self.lagged, tau, &mut sink);
        }
        implicit.multiply_stiffness(system, x, tangent, w, out);
    }

    fn scaled<'a>(&'a self, w: &'a [Vec3]) -> Linearised<'a> {
        let Self { tau, x, tangent, .. } = *self;
        Linearised { x, tangent, stiffness_scale: tau * tau, damping_scale: tau, w }
    }
}

impl Implicit {
    /// A zero matrix with room for the blocks that the implicit effects couple.
    pub fn block_matrix(self, system: &System) -> BlockMatrix {
        let mut pairs = Vec::new();
        for effect in self.effects(system) {
            effect.visit_pairs(&mut |i, j| pairs.push((i, j)));
        }
        BlockMatrix::with_pattern(system.len(), pairs)
    }

    /// The same for a system whose implicit effects are springs of regular grids, with full damping or none.
    pub fn banded_matrix(self, system: &System) -> Option<BandedMatrix> {
        let bands = system.bands(self.effects(system))?;
        Some(BandedMatrix::new(system.len(), bands))
    }

    /// The same for a system whose implicit effects are springs in any order, with full damping or none.
    pub fn pair_matrix(self, system: &System) -> Option<PairMatrix> {
        let mut edges = Vec::new();
        for effect in self.effects(system) {
            effect.visit_pairs(&mut |i, j| edges.push((i, j)));
        }
        system.are_listed(self.effects(system)).then(|| PairMatrix::new(system.len(), edges))
    }

    /// `out ← K w` at `x` in one sweep over the springs, without a matrix; N for `w` in m. Differences of `w`
    /// are formed before they are multiplied, so that a translation gives exactly 0.
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

/// Adds blocks to a matrix.
struct Sum<'a>(&'a mut BlockMatrix);

impl BlockSink for Sum<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.0.add_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.0.add_general_pair(i, j, block);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.0.add_diagonal(i, block);
    }
}

/// Adds blocks to a banded matrix, which exists for springs alone: their blocks are symmetric.
struct Bands<'a>(&'a mut BandedMatrix);

impl BlockSink for Bands<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.0.add_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        debug_assert_eq!(*block, block.transpose(), "no spring has such a block");
        self.0.add_pair(i, j, block);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.0.add_diagonal(i, block);
    }
}

/// Adds blocks to a matrix of pairs, which exists for springs alone.
struct Pairs<'a>(&'a mut PairMatrix);

impl BlockSink for Pairs<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.0.add_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        debug_assert_eq!(*block, block.transpose(), "no spring has such a block");
        self.0.add_pair(i, j, block);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.0.add_diagonal(i, block);
    }
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
                { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 3, "stiffness_n_per_m": 7, "damping_n_s_per_m": 2 },
                { "effect": "bending", "i": 1, "j": 2, "rest_length_m": 1, "stiffness_n_per_m": 5 }] }"#;
        parse("test", text).expect("valid").spec().build().expect("valid")
    }

    #[test]
    fn the_matrix_is_made_of_masses_stiffness_and_damping_with_their_powers_of_the_step() {
        let (system, state) = bent_string();
        let w = [Vec3::new(1.0, 2.0, -1.0), Vec3::new(0.5, 0.0, 3.0), Vec3::new(0.0, -2.0, 1.0)];
        let implicit = Implicit::Everything;
        let (mut matrix, mut product, mut stiffness) =
            (implicit.block_matrix(&system), w, [Vec3::zeros(); 3]);
        for (tangent, tau) in [(Tangent::Exact, 0.5), (Tangent::Projected, 0.25)] {
            let (x, lagged) = (&state.x[..], state.level());
            Linearisation { implicit, tau, x, lagged, tangent }.assemble(&system, &mut matrix);
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
