//! The 3×3 diagonal blocks as preconditioner.
//!
//! Each of the six numbers of the inverses has an array of its own, so that eight inverses are
//! computed and applied at a time. The loops are plain Rust, which [`pulp`] compiles for the vector
//! units of the processor. The bits are those of one block after the other.
//!
//! Inversion takes 8 divisions and 24 other flops a block; application takes 15 flops and 96 bytes.

use super::{Preconditioner, jacobi::is_pivot};
use crate::bands::{Divisible, in_bands, split_each};
use crate::block::{BlockSource, VisitDiagonal};
use crate::vector::BLOCK;
use crate::{BlockMatrix, LinearOperator, SolverError, Vec3};
use drape_kernels::planes::{join, split};
use std::sync::atomic::{AtomicBool, Ordering};

/// Blocks computed at a time.
const GROUP: usize = 64;

/// The inverses of the 3×3 diagonal blocks of a block matrix.
#[derive(Clone, Debug)]
pub struct BlockJacobi {
    n: usize,
    /// `xx, xy, xz, yy, yz, zz`, [`Self::stride`] numbers each.
    planes: Vec<f64>,
}

impl BlockJacobi {
    /// The identity, with memory for the rows of `a`.
    pub fn new(a: &BlockMatrix) -> Self {
        Self::identity(a.n())
    }

    /// The identity, with memory for `n` block rows.
    pub fn identity(n: usize) -> Self {
        let mut identity = Self { n, planes: vec![0.0; 6 * n.next_multiple_of(GROUP)] };
        identity.reset();
        identity
    }

    fn stride(&self) -> usize {
        self.planes.len() / 6
    }

    /// The planes `xx, xy, xz, yy, yz, zz` of the inverses.
    pub(crate) fn planes(&self) -> [&[f64]; 6] {
        std::array::from_fn(|c| &self.planes[c * self.stride()..][..self.n])
    }

    fn reset(&mut self) {
        let stride = self.stride().max(1);
        for (plane, value) in self.planes.chunks_mut(stride).zip([1.0, 0.0, 0.0, 1.0, 0.0, 1.0]) {
            plane.fill(value);
        }
    }

    /// Inverts the diagonal blocks of `a`, on as many threads as share its products. Only their
    /// lower triangles are read.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] for a diagonal block that is not positive definite;
    /// [`SolverError::PatternChanged`] for another number of rows (other couplings do not matter).
    pub fn update(&mut self, a: &BlockMatrix) -> Result<(), SolverError> {
        self.check(a.n(), a.nonzeros())?;
        self.invert(a, a.bands())
    }

    /// Inverts the diagonal blocks of a matrix with as many rows.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] for a diagonal block that is not positive definite.
    pub(super) fn invert(&mut self, a: &impl BlockSource, bands: usize) -> Result<(), SolverError> {
        a.with_diagonal(Inversion { jacobi: self, bands })
    }

    fn check(&self, n: usize, nonzeros: usize) -> Result<(), SolverError> {
        if n == self.n {
            return Ok(());
        }
        let (expected_size, expected_nonzeros) = (self.n, self.n);
        Err(SolverError::PatternChanged { expected_size, expected_nonzeros, size: n, nonzeros })
    }

    /// Resets to the identity; the error names the first pivot of block `i` that is not positive.
    fn refuse(&mut self, i: usize, pivots: [f64; 3]) -> SolverError {
        self.reset();
        let k = pivots.into_iter().position(|pivot| !is_pivot(pivot)).unwrap_or(0);
        SolverError::NotPositiveDefinite { row: 3 * i + k, pivot: Some(pivots[k]) }
    }
}

struct Inversion<'a> {
    jacobi: &'a mut BlockJacobi,
    bands: usize,
}

impl VisitDiagonal for Inversion<'_> {
    type Output = Result<(), SolverError>;

    fn visit(self, block: impl Fn(usize) -> [f64; 6] + Sync) -> Self::Output {
        let Self { jacobi, bands } = self;
        let (n, stride) = (jacobi.n, jacobi.stride().max(1));
        let mut planes = jacobi.planes.chunks_exact_mut(stride);
        let part = Inverses(std::array::from_fn(|_| planes.next().unwrap_or_default()));
        let is_good = AtomicBool::new(true);
        in_bands(bands, n, part, &|rows, Inverses(planes)| {
            let (first, n) = (rows.start, rows.len());
            if !pulp::Arch::new().dispatch(InvertedRows { first, n, block: &block, planes }) {
                is_good.store(false, Ordering::Relaxed);
            }
        });
        if is_good.into_inner() {
            return Ok(());
        }
        let pivots = |i: usize| inverse(block(i)).1;
        let bad = (0..n).find(|&i| !pivots(i).into_iter().all(is_pivot));
        bad.map_or(Ok(()), |i| Err(jacobi.refuse(i, pivots(i))))
    }
}

/// Rows of the six planes of inverses.
struct Inverses<'a>([&'a mut [f64]; 6]);

impl Divisible for Inverses<'_> {
    fn split(self, blocks: usize) -> (Self, Self) {
        let [planes, others] = split_each(self.0, blocks * BLOCK);
        (Self(planes), Self(others))
    }
}

impl Preconditioner for BlockJacobi {
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        self.apply_in_bands(1, r, z);
    }

    fn apply_in_bands(&self, bands: usize, r: &[Vec3], z: &mut [Vec3]) {
        assert_eq!(r.len(), self.n, "one vector a row");
        assert_eq!(z.len(), self.n, "one vector a row");
        in_bands(bands, self.n, z, &|band, z: &mut [Vec3]| {
            let first = band.start;
            let (r, z) = (bytemuck::cast_slice(&r[band]), bytemuck::cast_slice_mut(z));
            pulp::Arch::new().dispatch(Application { jacobi: self, first, r, z });
        });
    }
}

struct InvertedRows<'a, B> {
    /// First row.
    first: usize,
    n: usize,
    block: &'a B,
    planes: [&'a mut [f64]; 6],
}

impl<B: Fn(usize) -> [f64; 6]> pulp::WithSimd for InvertedRows<'_, B> {
    /// Whether all pivots are positive.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> bool {
        let Self { first, n, block, mut planes } = self;
        let mut bad = [0_u64; GROUP];
        let (mut blocks, mut inverses) = ([[0.0; GROUP]; 6], [[0.0; GROUP]; 6]);
        for i in (0..n).step_by(GROUP) {
            let m = GROUP.min(n - i);
            for t in 0..m {
                let block = block(first + i + t);
                for c in 0..6 {
                    blocks[c][t] = block[c];
                }
            }
            for t in 0..m {
                let (inverse, pivots) = inverse(blocks.each_ref().map(|plane| plane[t]));
                let good = is_pivot(pivots[0]) & is_pivot(pivots[1]) & is_pivot(pivots[2]);
                bad[t] |= u64::from(!good);
                for c in 0..6 {
                    inverses[c][t] = inverse[c];
                }
            }
            for (plane, inverse) in planes.iter_mut().zip(&inverses) {
                plane[i..][..m].copy_from_slice(&inverse[..m]);
            }
        }
        bad.iter().all(|bad| *bad == 0)
    }
}

struct Application<'a> {
    jacobi: &'a BlockJacobi,
    /// Particle of the first numbers of `r` and `z`, a multiple of [`GROUP`].
    first: usize,
    r: &'a [f64],
    z: &'a mut [f64],
}

impl pulp::WithSimd for Application<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { jacobi, first, r, z } = self;
        let stride = jacobi.stride();
        let (mut from, mut to) = ([[0.0; GROUP]; 3], [[0.0; GROUP]; 3]);
        for (g, (r, z)) in r.chunks(3 * GROUP).zip(z.chunks_mut(3 * GROUP)).enumerate() {
            let m = r.len() / 3;
            split(from.as_flattened_mut(), GROUP, &r[..3 * m]);
            let p: [&[f64]; 6] =
                std::array::from_fn(|c| &jacobi.planes[c * stride + first + g * GROUP..][..GROUP]);
            for t in 0..GROUP {
                to[0][t] = p[0][t] * from[0][t] + p[1][t] * from[1][t] + p[2][t] * from[2][t];
                to[1][t] = p[1][t] * from[0][t] + p[3][t] * from[1][t] + p[4][t] * from[2][t];
                to[2][t] = p[2][t] * from[0][t] + p[4][t] * from[1][t] + p[5][t] * from[2][t];
            }
            join(to.as_flattened(), GROUP, z);
        }
    }
}

/// The inverse of a symmetric positive definite 3×3 block, `A⁻¹ = Mᵀ D⁻¹ M` with `M = L⁻¹` from
/// `A = L D Lᵀ`, and the pivots `D`. The inverse is valid only if all pivots are positive.
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
    use crate::{Coupling, Mat3};
    use drape_kernels::blocks::SIX;
    use drape_kernels::testing::assert_same_bits;
    use proptest::prelude::*;

    const LAYOUTS: fn() -> [Coupling; 3] =
        || [Coupling::Rows, Coupling::Pairs, Coupling::Bands(vec![1])];

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
        fn every_layout_gives_the_bits_of_the_formula(n in 1_usize..900, seed in any::<u64>()) {
            let mut random = Random::new(seed);
            let blocks: Vec<Mat3> = (0..n)
                .map(|_| [(); 2].map(|()| random.vector()))
                .map(|[u, v]| Mat3::identity() + u * u.transpose() + v * v.transpose())
                .collect();
            let r = random.vectors(n);
            let inverses: Vec<_> = blocks
                .iter()
                .map(|a| inverse(SIX.map(|(row, column)| a[(column, row)])).0)
                .collect();
            let reference: Vec<Vec3> = inverses
                .iter()
                .zip(&r)
                .map(|([a, b, c, d, e, f], r)| {
                    let row = |p: [&f64; 3]| p[0] * r[0] + p[1] * r[1] + p[2] * r[2];
                    Vec3::new(row([a, b, c]), row([b, d, e]), row([c, e, f]))
                })
                .collect();
            for coupling in LAYOUTS() {
                let mut a = BlockMatrix::new(n, &coupling, []);
                (0..n).for_each(|i| a.add_diagonal(i, &blocks[i]));
                for bands in [1, 2, 5] {
                    a.set_bands(bands);
                    let mut p = BlockJacobi::identity(n);
                    p.update(&a).unwrap();
                    let mut z = random.vectors(n);
                    p.apply(&r, &mut z);
                    assert_same_bits((&coupling, bands), &reference, &z);
                    let kept = |i: usize| [0, 1, 2, 3, 4, 5].map(|c| p.planes[c * p.stride() + i]);
                    let kept = (0..n).map(kept).collect();
                    assert_same_bits((&coupling, bands), &inverses, &kept);
                }
            }
        }
    }

    #[test]
    fn block_jacobi_names_the_scalar_row_and_is_the_identity_again() {
        let bad = Mat3::new(1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        for coupling in LAYOUTS() {
            let mut a = BlockMatrix::new(2, &coupling, []);
            a.set_bands(2);
            a.add_diagonal(0, &(2.0 * Mat3::identity()));
            a.add_diagonal(1, &bad);
            let mut p = BlockJacobi::new(&a);
            let expected = SolverError::NotPositiveDefinite { row: 4, pivot: Some(-3.0) };
            assert_eq!(p.update(&a).unwrap_err(), expected);
            let (r, mut z) = ([Vec3::x(), Vec3::new(1.0, 2.0, 3.0)], [Vec3::zeros(); 2]);
            p.apply(&r, &mut z);
            assert_eq!(z, r);
            let error = p.update(&BlockMatrix::new(3, &coupling, [])).unwrap_err();
            assert!(matches!(error, SolverError::PatternChanged { size: 3, .. }));
        }
    }
}
