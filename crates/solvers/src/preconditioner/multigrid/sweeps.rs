//! Sweeps of block Gauss-Seidel over the lower triangle of a symmetric matrix.
//!
//! Block (j, i) is the transpose of block (i, j), so a sweep needs only the blocks left of the
//! diagonal. It uses block (i, j) twice while it is in the nearest cache: for row i, and transposed
//! for row j. So a sweep and the residual after it read half a matrix once. Vectors have four
//! numbers a particle. The fourth one fills the register and means nothing.

use crate::block::{BlockSource, symmetric};
use crate::pattern::Pattern;
use crate::{BlockJacobi, Mat3, SolverError};
use drape_kernels::lanes::{Four, Lanes, four_wide, vectorised};
use std::ops::Range;

/// The lower triangle of a matrix, and the inverses of its diagonal blocks.
#[derive(Clone, Debug)]
pub(super) struct Sweeps {
    /// First slot of each row; row `i` is `starts[i]..starts[i + 1]`.
    starts: Vec<usize>,
    columns: Vec<u32>,
    /// The blocks left of the diagonal, and one more, since registers read ten numbers of a block.
    lower: Vec<Mat3>,
    diagonal: BlockJacobi,
    /// The inverse diagonal blocks, and one more.
    inverse: Vec<Mat3>,
    /// Whether each block left of the diagonal is symmetric, as those of springs are.
    is_symmetric: bool,
}

impl Sweeps {
    /// Memory for a matrix with this pattern.
    pub(super) fn new(pattern: &Pattern) -> Self {
        let n = pattern.n();
        let (starts, columns) = pattern.lower_triangle();
        let zeros = |n| vec![Mat3::zeros(); n + 1];
        Self {
            lower: zeros(columns.len()),
            inverse: zeros(n),
            diagonal: BlockJacobi::identity(n),
            is_symmetric: true,
            starts,
            columns,
        }
    }

    /// Reads a matrix.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] if a diagonal block is not positive definite.
    pub(super) fn read(&mut self, a: &impl BlockSource) -> Result<(), SolverError> {
        self.is_symmetric = a.read_lower(&mut self.lower[..self.columns.len()]);
        self.diagonal.invert(a, 1)?;
        let planes = self.diagonal.planes();
        for (i, inverse) in self.inverse.iter_mut().take(planes[0].len()).enumerate() {
            *inverse = symmetric(planes.map(|plane| plane[i]));
        }
        Ok(())
    }

    /// The blocks left of the diagonal, row by row.
    pub(super) fn lower(&self) -> &[Mat3] {
        &self.lower[..self.columns.len()]
    }

    /// The inverse diagonal blocks.
    #[cfg(test)]
    pub(super) fn inverse(&self) -> &[Mat3] {
        &self.inverse[..self.starts.len() - 1]
    }

    /// Solves `(D + L) z = r`, and writes the residual `r − A z = −Lᵀ z` to `left`.
    pub(super) fn forward(&self, r: &[Lanes], z: &mut [Lanes], left: &mut [Lanes]) {
        vectorised!(
            four_wide(),
            [
                four,
                sweeps: &'k Sweeps = self,
                r: &'k [Lanes] = r,
                z: &'k mut [Lanes] = z,
                left: &'k mut [Lanes] = left,
            ] -> () {
                if sweeps.is_symmetric {
                    sweeps.forward_with::<true>(four, r, z, left);
                } else {
                    sweeps.forward_with::<false>(four, r, z, left);
                }
            }
        );
    }

    #[inline(always)]
    fn forward_with<const SYMMETRIC: bool>(
        &self,
        four: impl Four,
        r: &[Lanes],
        z: &mut [Lanes],
        left: &mut [Lanes],
    ) {
        let lower: &[f64] = bytemuck::cast_slice(&self.lower);
        let inverse: &[f64] = bytemuck::cast_slice(&self.inverse);
        left.fill([0.0; 4]);
        for (i, r) in r.iter().enumerate() {
            let mut sum = four.load(*r);
            for slot in self.row(i) {
                let block = columns(four, lower, slot);
                sum = four.sub(sum, product(four, block, &z[self.columns[slot] as usize]));
            }
            let own = four.store(product(four, columns(four, inverse, i), &four.store(sum)));
            z[i] = own;
            self.subtract_column::<SYMMETRIC>(four, i, &own, left);
        }
    }

    /// `z_i ← D_i⁻¹ (r_i − Σ_{j≠i} A_ij z_j)` from the last row to the first. Overwrites `r`.
    pub(super) fn backward(&self, r: &mut [Lanes], z: &mut [Lanes]) {
        vectorised!(
            four_wide(),
            [
                four,
                sweeps: &'k Sweeps = self,
                r: &'k mut [Lanes] = r,
                z: &'k mut [Lanes] = z,
            ] -> () {
                if sweeps.is_symmetric {
                    sweeps.backward_with::<true>(four, r, z);
                } else {
                    sweeps.backward_with::<false>(four, r, z);
                }
            }
        );
    }

    #[inline(always)]
    fn backward_with<const SYMMETRIC: bool>(
        &self,
        four: impl Four,
        r: &mut [Lanes],
        z: &mut [Lanes],
    ) {
        let lower: &[f64] = bytemuck::cast_slice(&self.lower);
        let inverse: &[f64] = bytemuck::cast_slice(&self.inverse);
        for i in (0..r.len()).rev() {
            // Later rows have already subtracted their products from r_i.
            let mut sum = four.splat(0.0);
            for slot in self.row(i) {
                let block = columns(four, lower, slot);
                sum = four.add(sum, product(four, block, &z[self.columns[slot] as usize]));
            }
            let sum = four.store(four.sub(four.load(r[i]), sum));
            let own = four.store(product(four, columns(four, inverse, i), &sum));
            z[i] = own;
            self.subtract_column::<SYMMETRIC>(four, i, &own, r);
        }
    }

    /// Subtracts the products of `own` with the blocks right of the diagonal in column `i`, the
    /// transposes of row `i`.
    #[inline(always)]
    fn subtract_column<const SYMMETRIC: bool>(
        &self,
        four: impl Four,
        i: usize,
        own: &Lanes,
        sums: &mut [Lanes],
    ) {
        let lower: &[f64] = bytemuck::cast_slice(&self.lower);
        for slot in self.row(i) {
            let sum = &mut sums[self.columns[slot] as usize];
            let block = transposed::<_, SYMMETRIC>(four, columns(four, lower, slot));
            *sum = four.store(four.sub(four.load(*sum), product(four, block, own)));
        }
    }

    /// Slots of row `i`.
    #[inline(always)]
    fn row(&self, i: usize) -> Range<usize> {
        self.starts[i]..self.starts[i + 1]
    }
}

/// The columns of a block in registers, whose fourth numbers belong to the next column.
#[inline(always)]
fn columns<F: Four>(four: F, blocks: &[f64], block: usize) -> [F::Numbers; 3] {
    let numbers = &blocks[9 * block..][..10];
    let column = |k: usize| four.load(numbers[k..k + 4].try_into().unwrap_or_default());
    [column(0), column(3), column(6)]
}

/// The columns of the transpose.
#[inline(always)]
fn transposed<F: Four, const SYMMETRIC: bool>(
    four: F,
    [a, b, c]: [F::Numbers; 3],
) -> [F::Numbers; 3] {
    if SYMMETRIC {
        return [a, b, c];
    }
    let [a, b, c, _] = four.transpose([a, b, c, c]);
    [a, b, c]
}

/// A block times a vector.
#[inline(always)]
fn product<F: Four>(four: F, [a, b, c]: [F::Numbers; 3], x: &Lanes) -> F::Numbers {
    let [a, b] = [four.mul(a, four.splat(x[0])), four.mul(b, four.splat(x[1]))];
    four.add(four.add(a, b), four.mul(c, four.splat(x[2])))
}
