//! The 3×3 diagonal blocks as preconditioner.
//!
//! The inverses are kept as one array for each of their six numbers, so that eight of them are computed and applied at
//! a time. Each is what [`inverse`] gives for its block, bit for bit: the loops are plain Rust, which [`pulp`] compiles for
//! the vector units of the processor.
//!
//! To invert takes 8 divisions and 24 other flops a block, to apply 15 flops and 96 bytes.

use super::{Preconditioner, jacobi::is_pivot};
use crate::banded::{join, split};
use crate::{BandedMatrix, BlockMatrix, Mat3, PairMatrix, SolverError, Vec3};

/// Blocks that are computed at a time.
const GROUP: usize = 64;

/// The inverses of the 3×3 diagonal blocks of a block matrix.
#[derive(Clone, Debug)]
pub struct BlockJacobi {
    n: usize,
    /// `xx, xy, xz, yy, yz, zz`, [`Self::stride`] numbers each.
    planes: Vec<f64>,
}

impl BlockJacobi {
    /// The identity, with room for the rows of `a`.
    pub fn new(a: &BlockMatrix) -> Self {
        Self::identity(a.n())
    }

    /// The identity, with room for `n` block rows.
    pub fn identity(n: usize) -> Self {
        let mut identity = Self { n, planes: vec![0.0; 6 * n.next_multiple_of(GROUP)] };
        identity.reset();
        identity
    }

    fn stride(&self) -> usize {
        self.planes.len() / 6
    }

    fn reset(&mut self) {
        let stride = self.stride().max(1);
        for (plane, value) in self.planes.chunks_mut(stride).zip([1.0, 0.0, 0.0, 1.0, 0.0, 1.0]) {
            plane.fill(value);
        }
    }

    /// Takes over the diagonal blocks of `a`.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] for a diagonal block that is not positive definite;
    /// [`SolverError::PatternChanged`] for another number of rows (other couplings do not matter).
    pub fn update(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        self.check(a.n(), a.nonzeros())?;
        for i in 0..a.n() {
            let block = six(&a.get(i, i));
            let (inverse, pivots) = inverse(block);
            if !pivots.into_iter().all(is_pivot) {
                return Err(self.refuse(i, pivots));
            }
            let stride = self.stride();
            (0..6).for_each(|c| self.planes[c * stride + i] = inverse[c]);
        }
        Ok(())
    }

    /// Takes over the diagonal blocks of `a`: the same numbers as [`update`](Self::update), several at a time.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    pub fn update_banded(&mut self, a: &BandedMatrix) -> Result<(), SolverError> {
        self.check(a.n(), a.n() * (1 + 2 * a.offsets().len()))?;
        let blocks = a.diagonal();
        self.invert_many(
            #[inline(always)]
            |i| blocks.map(|plane| plane[i]),
        )
    }

    /// Takes over the diagonal blocks of `a`: the same numbers as [`update`](Self::update), several at a time.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    pub fn update_pairs(&mut self, a: &PairMatrix) -> Result<(), SolverError> {
        self.check(a.n(), a.nonzeros())?;
        self.invert_many(
            #[inline(always)]
            |i| a.diagonal(i),
        )
    }

    /// Takes over blocks `xx, xy, xz, yy, yz, zz`.
    fn invert_many(&mut self, block: impl Fn(usize) -> [f64; 6]) -> Result<(), SolverError> {
        let (n, stride) = (self.n, self.stride());
        let update = Inversion { n, block: &block, planes: &mut self.planes, stride };
        if pulp::Arch::new().dispatch(update) {
            return Ok(());
        }
        let pivots = |i: usize| inverse(block(i)).1;
        let bad = (0..n).find(|&i| !pivots(i).into_iter().all(is_pivot));
        bad.map_or(Ok(()), |i| Err(self.refuse(i, pivots(i))))
    }

    fn check(&self, n: usize, nonzeros: usize) -> Result<(), SolverError> {
        if n == self.n {
            return Ok(());
        }
        let (expected_size, expected_nonzeros) = (self.n, self.n);
        Err(SolverError::PatternChanged { expected_size, expected_nonzeros, size: n, nonzeros })
    }

    /// Back to the identity, with the first pivot of block `i` that is none.
    fn refuse(&mut self, i: usize, pivots: [f64; 3]) -> SolverError {
        self.reset();
        let k = pivots.into_iter().position(|pivot| !is_pivot(pivot)).unwrap_or(0);
        SolverError::NotPositiveDefinite { row: 3 * i + k, pivot: Some(pivots[k]) }
    }
}

impl Preconditioner for BlockJacobi {
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        assert_eq!(r.len(), self.n, "one vector a row");
        assert_eq!(z.len(), self.n, "one vector a row");
        let (r, z) = (bytemuck::cast_slice(r), bytemuck::cast_slice_mut(z));
        pulp::Arch::new().dispatch(Application { jacobi: self, r, z });
    }
}

struct Inversion<'a, B> {
    n: usize,
    block: &'a B,
    planes: &'a mut [f64],
    stride: usize,
}

impl<B: Fn(usize) -> [f64; 6]> pulp::WithSimd for Inversion<'_, B> {
    /// Whether all pivots are positive.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> bool {
        let Self { n, block, planes, stride } = self;
        let mut bad = [0_u64; GROUP];
        let (mut blocks, mut inverses) = ([[0.0; GROUP]; 6], [[0.0; GROUP]; 6]);
        for i in (0..n).step_by(GROUP) {
            let m = GROUP.min(n - i);
            for t in 0..m {
                let block = block(i + t);
                (0..6).for_each(|c| blocks[c][t] = block[c]);
            }
            for t in 0..m {
                let (inverse, pivots) = inverse(blocks.each_ref().map(|plane| plane[t]));
                let good = is_pivot(pivots[0]) & is_pivot(pivots[1]) & is_pivot(pivots[2]);
                bad[t] |= u64::from(!good);
                (0..6).for_each(|c| inverses[c][t] = inverse[c]);
            }
            for (c, inverse) in inverses.iter().enumerate() {
                planes[c * stride + i..][..m].copy_from_slice(&inverse[..m]);
            }
        }
        bad.iter().all(|bad| *bad == 0)
    }
}

struct Application<'a> {
    jacobi: &'a BlockJacobi,
    r: &'a [f64],
    z: &'a mut [f64],
}

impl pulp::WithSimd for Application<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { jacobi, r, z } = self;
        let stride = jacobi.stride();
        let (mut from, mut to) = ([[0.0; GROUP]; 3], [[0.0; GROUP]; 3]);
        for (g, (r, z)) in r.chunks(3 * GROUP).zip(z.chunks_mut(3 * GROUP)).enumerate() {
            let m = r.len() / 3;
            let [x, y, w] = &mut from;
            split(r, &mut x[..m], &mut y[..m], &mut w[..m]);
            let p: [&[f64]; 6] =
                std::array::from_fn(|c| &jacobi.planes[c * stride + g * GROUP..][..GROUP]);
            for t in 0..GROUP {
                to[0][t] = p[0][t] * from[0][t] + p[1][t] * from[1][t] + p[2][t] * from[2][t];
                to[1][t] = p[1][t] * from[0][t] + p[3][t] * from[1][t] + p[4][t] * from[2][t];
                to[2][t] = p[2][t] * from[0][t] + p[4][t] * from[1][t] + p[5][t] * from[2][t];
            }
            join(&to, z);
        }
    }
}

/// `xx, xy, xz, yy, yz, zz`, from the lower triangle.
fn six(a: &Mat3) -> [f64; 6] {
    [a[(0, 0)], a[(1, 0)], a[(2, 0)], a[(1, 1)], a[(2, 1)], a[(2, 2)]]
}

/// The inverse of a symmetric positive definite 3×3 block, `A⁻¹ = Mᵀ D⁻¹ M` with `M = L⁻¹` from
/// `A = L D Lᵀ`, and the pivots `D`. Unless all of them are positive the inverse is of no use.
#[inline(always)]
fn inverse([a00, a10, a20, a11, a21, a22]: [f64; 6]) -> ([f64; 6], [f64; 3]) {
    let d0 = a00;
    let (l10, l20) = (a10 / d0, a20 / d0);
    let d1 = a11 - l10 * a10;
    let l21 = (a21 - l20 * a10) / d1;
    let d2 = a22 - l20 * a20 - l21 * l21 * d1;
    let (m10, m21, m20) = (-l10, -l21, l10 * l21 - l20);

    let i22 = 1.0 / d2;
    let i21 = m21 * i22;
    let i20 = m20 * i22;
    let i11 = 1.0 / d1 + m21 * i21;
    let i10 = m10 / d1 + m21 * i20;
    let i00 = 1.0 / d0 + m10 * m10 / d1 + m20 * i20;
    ([i00, i10, i20, i11, i21, i22], [d0, d1, d2])
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::{Random, graph, random_blocks};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn block_jacobi_inverts_the_diagonal_blocks((n, edges) in graph(8)) {
            let mut random = Random::new(9);
            let a = random_blocks(n, &edges, &mut random);
            let mut p = BlockJacobi::new(&a);
            p.update(&a).unwrap();
            let r = random.vectors(n);
            let mut z = random.vectors(n);
            p.apply(&r, &mut z);
            for i in 0..n {
                prop_assert!((a.get(i, i) * z[i] - r[i]).norm() < 1e-12);
            }
        }

        /// Many at a time as one by one, and applied as the formula says, bit for bit.
        #[test]
        fn banded_blocks_and_pairs_give_the_same_bits(n in 1_usize..300, seed in any::<u64>()) {
            let mut random = Random::new(seed);
            let mut rows = BlockMatrix::with_pattern(n, []);
            let mut banded = BandedMatrix::new(n, [1]);
            let mut pairs = PairMatrix::new(n, []);
            for i in 0..n {
                let (u, v) = (random.vector(), random.vector());
                let block = Mat3::identity() + u * u.transpose() + v * v.transpose();
                rows.add_diagonal(i, &block);
                banded.add_diagonal(i, &block);
                pairs.add_diagonal(i, &block);
            }
            let [mut fast, mut other, mut readable] =
                [(); 3].map(|()| BlockJacobi::identity(n));
            fast.update_banded(&banded).unwrap();
            other.update_pairs(&pairs).unwrap();
            readable.update(&rows).unwrap();
            let bits = |p: &BlockJacobi| -> Vec<u64> {
                let planes = p.planes.chunks(p.stride());
                planes.flat_map(|plane| plane[..n].iter().map(|x| x.to_bits())).collect()
            };
            prop_assert_eq!(bits(&fast), bits(&readable));
            prop_assert_eq!(bits(&other), bits(&readable));
            let (r, mut z) = (random.vectors(n), random.vectors(n));
            fast.apply(&r, &mut z);
            for i in 0..n {
                let [a, b, c, d, e, f] = inverse(six(&rows.get(i, i))).0;
                let expected = [[a, b, c], [b, d, e], [c, e, f]]
                    .map(|p| (p[0] * r[i][0] + p[1] * r[i][1] + p[2] * r[i][2]).to_bits());
                prop_assert_eq!([0, 1, 2].map(|k| z[i][k].to_bits()), expected);
            }
        }
    }

    #[test]
    fn block_jacobi_names_the_scalar_row_and_is_the_identity_again() {
        let (mut rows, mut banded) = (BlockMatrix::with_pattern(2, []), BandedMatrix::new(2, [1]));
        let bad = Mat3::new(1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        for (i, block) in [2.0 * Mat3::identity(), bad].iter().enumerate() {
            rows.add_diagonal(i, block);
            banded.add_diagonal(i, block);
        }
        let mut p = BlockJacobi::new(&rows);
        let errors = [p.update(&rows).unwrap_err(), p.update_banded(&banded).unwrap_err()];
        let expected = SolverError::NotPositiveDefinite { row: 4, pivot: Some(-3.0) };
        assert_eq!(errors, [expected, expected]);
        let (r, mut z) = ([Vec3::x(), Vec3::new(1.0, 2.0, 3.0)], [Vec3::zeros(); 2]);
        p.apply(&r, &mut z);
        assert_eq!(z, r);
        let error = p.update_banded(&BandedMatrix::new(3, [1])).unwrap_err();
        assert!(matches!(error, SolverError::PatternChanged { size: 3, .. }));
    }
}
