//! Symmetric matrices of 3×3 blocks, for Jacobians that couple the coordinates.

use crate::pattern::Pattern;
use crate::{Constraints, LinearOperator, Mat3, Vec3};

/// A symmetric matrix of 3×3 blocks in compressed rows, both triangles stored: block (j, i) is the
/// transpose of block (i, j).
///
/// ```
/// use drape_solvers::{BlockMatrix, LinearOperator, Mat3, Vec3};
/// let mut a = BlockMatrix::with_pattern(2, [(0, 1)]);
/// a.add_diagonal(0, &Mat3::identity());
/// a.add_diagonal(1, &Mat3::identity());
/// // A spring along x resists in that direction only.
/// a.add_pair(0, 1, &(10.0 * Vec3::x() * Vec3::x().transpose()));
/// let mut y = [Vec3::zeros(); 2];
/// a.multiply(&[Vec3::new(1.0, 1.0, 0.0), Vec3::zeros()], &mut y);
/// assert_eq!(y, [Vec3::new(11.0, 1.0, 0.0), Vec3::new(-10.0, 0.0, 0.0)]);
/// ```
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    pattern: Pattern,
    blocks: Vec<Mat3>,
    /// Where the pairs went that were added since it was cleared before, in their order: whoever fills a matrix again does
    /// so in the same order, and need not search.
    places: Vec<Place>,
    /// How many have been added since it was cleared.
    added: usize,
}

/// The slots of (i, j) and (j, i).
#[derive(Clone, Copy, Debug)]
struct Place {
    ends: [u32; 2],
    slots: [u32; 2],
}

impl BlockMatrix {
    /// The zero matrix with room for `n` diagonal blocks and for each edge. Repeated edges and
    /// edges of a node to itself are harmless.
    ///
    /// # Panics
    /// When an edge names a node that is not below `n`.
    pub fn with_pattern(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
        let pattern = Pattern::new(n, edges);
        let blocks = vec![Mat3::zeros(); pattern.nonzeros()];
        // Springs add a pair once for their stiffness and once for their damping. What adds more often searches.
        let places = Vec::with_capacity(pattern.nonzeros());
        Self { pattern, blocks, places, added: 0 }
    }

    /// Number of block rows.
    pub fn n(&self) -> usize {
        self.pattern.n()
    }

    /// Number of stored blocks, both triangles and the diagonal.
    pub fn nonzeros(&self) -> usize {
        self.pattern.nonzeros()
    }

    /// Sets all blocks to zero; the pattern stays.
    pub fn clear(&mut self) {
        self.blocks.fill(Mat3::zeros());
        self.added = 0;
    }

    /// Takes over all blocks of a matrix with the same pattern.
    ///
    /// # Panics
    /// When the other matrix has another number of blocks.
    pub fn copy_from(&mut self, other: &Self) {
        self.blocks.copy_from_slice(&other.blocks);
    }

    /// Adds `block` to diagonal block `i`, which must be symmetric once all is added.
    pub fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.blocks[self.pattern.diagonal(i)] += block;
    }

    /// Adds the symmetric `block` at (i, i) and (j, j), and its negative at (i, j) and (j, i): what
    /// a force between `i` and `j` contributes that depends on their difference only. For `i = j`
    /// that is nothing.
    ///
    /// A pair that the pattern lacks is a mistake of the caller: it stops a debug build, and a
    /// release build leaves the pair out.
    pub fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if i == j {
            return;
        }
        let Some((ij, ji)) = self.pair_slots(i, j) else {
            return;
        };
        self.blocks[ij] -= block;
        self.blocks[ji] -= block;
        self.add_diagonal(i, block);
        self.add_diagonal(j, block);
    }

    /// As [`add_pair`](Self::add_pair) for a block that need not be symmetric: `B` at (i, i), `Bᵀ` at (j, j), `−B` at (i, j),
    /// `−Bᵀ` at (j, i).
    pub fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if i == j {
            return;
        }
        let Some((ij, ji)) = self.pair_slots(i, j) else {
            return;
        };
        let transpose = block.transpose();
        self.blocks[ij] -= block;
        self.blocks[ji] -= transpose;
        self.add_diagonal(i, block);
        self.add_diagonal(j, &transpose);
    }

    /// Adds `block` at (i, j) and its transpose at (j, i), for `i ≠ j`: what a force on more than
    /// two particles contributes. A missing pair is treated as in [`add_pair`](Self::add_pair).
    pub fn add_off_diagonal(&mut self, i: usize, j: usize, block: &Mat3) {
        debug_assert_ne!(i, j, "diagonal blocks are added by add_diagonal");
        let Some((ij, ji)) = self.pair_slots(i, j) else {
            return;
        };
        self.blocks[ij] += block;
        self.blocks[ji] += block.transpose();
    }

    /// Block (i, j); zero outside the pattern.
    pub fn get(&self, i: usize, j: usize) -> Mat3 {
        self.pattern.slot(i, j).map_or_else(Mat3::zeros, |slot| self.blocks[slot])
    }

    /// `A ← S A S + (I − S) D` with a positive number `dᵢ` for each constrained particle: a third
    /// of the trace of its diagonal block, or one if that is not positive.
    ///
    /// The matrix stays symmetric, and positive definite if it was. For a right-hand side with
    /// nothing in the constrained directions (`b = S b`) the solution has nothing there either, and
    /// solves the filtered problem; so a direct solver can stand in for filtered conjugate gradients.
    ///
    /// # Panics
    /// When `constraints` is for another number of particles.
    pub fn project(&mut self, constraints: &Constraints) {
        assert_eq!(constraints.len(), self.n(), "one filter a block row");
        for &i in constraints.constrained() {
            let i = i as usize;
            let s = constraints.filter(i).matrix();
            for ij in self.pattern.row(i) {
                let j = self.pattern.column(ij);
                if j != i
                    && let Some(ji) = self.pattern.slot(j, i)
                {
                    let filtered = s * self.blocks[ij];
                    self.blocks[ij] = filtered;
                    self.blocks[ji] = filtered.transpose();
                }
            }
            let ii = self.pattern.diagonal(i);
            let third = self.blocks[ii].trace() / 3.0;
            let scale = if third > 0.0 { third } else { 1.0 };
            self.blocks[ii] = s * self.blocks[ii] * s + (Mat3::identity() - s) * scale;
        }
    }

    /// The block of a slot of the pattern.
    pub(crate) fn block_mut(&mut self, slot: usize) -> &mut Mat3 {
        &mut self.blocks[slot]
    }

    /// Makes the upper triangle the transpose of the lower one, in diagonal blocks too.
    pub(crate) fn mirror_lower(&mut self) {
        for i in 0..self.n() {
            let block = &mut self.blocks[self.pattern.diagonal(i)];
            block.fill_upper_triangle_with_lower_triangle();
            for ij in self.pattern.lower(i) {
                if let Some(ji) = self.pattern.slot(self.pattern.column(ij), i) {
                    self.blocks[ji] = self.blocks[ij].transpose();
                }
            }
        }
    }

    /// Slots of (i, j) and (j, i).
    fn pair_slots(&mut self, i: usize, j: usize) -> Option<(usize, usize)> {
        let (at, ends) = (self.added, [i as u32, j as u32]);
        if let Some(place) = self.places.get(at)
            && place.ends == ends
        {
            self.added += 1;
            return Some((place.slots[0] as usize, place.slots[1] as usize));
        }
        let slots = self.pattern.slot(i, j).zip(self.pattern.slot(j, i));
        debug_assert!(slots.is_some(), "the pattern has no pair ({i}, {j})");
        let (ij, ji) = slots?;
        let slots = u32::try_from(ij).ok().zip(u32::try_from(ji).ok());
        if let Some((first, second)) = slots.filter(|_| at < self.places.capacity()) {
            // Another order than before, or more: what follows will be searched for, too.
            self.places.truncate(at);
            self.places.push(Place { ends, slots: [first, second] });
            self.added += 1;
        }
        Some((ij, ji))
    }

    /// The pattern of the blocks.
    pub(crate) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The blocks, in the slots of the pattern.
    pub(crate) fn blocks(&self) -> &[Mat3] {
        &self.blocks
    }
}

impl LinearOperator for BlockMatrix {
    fn size(&self) -> usize {
        self.n()
    }

    /// Each row is summed from its first scalar column to its last.
    fn multiply(&self, x: &[Vec3], y: &mut [Vec3]) {
        assert_eq!(x.len(), self.n(), "one vector a block row");
        assert_eq!(y.len(), self.n(), "one vector a block row");
        for (i, y) in y.iter_mut().enumerate() {
            let mut sum = [0.0; 3];
            for slot in self.pattern.row(i) {
                let (block, x) = (&self.blocks[slot], &x[self.pattern.column(slot)]);
                for column in 0..3 {
                    for row in 0..3 {
                        sum[row] += block[(row, column)] * x[column];
                    }
                }
            }
            *y = Vec3::from(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{
        Random, dense_blocks, dense_filter, flat, graph, random_blocks, random_filter,
    };
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn products_match_the_dense_matrix((n, edges) in graph(8)) {
            let mut random = Random::new(6);
            let a = random_blocks(n, &edges, &mut random);
            let dense = dense_blocks(&a);
            prop_assert!((&dense - dense.transpose()).norm() < 1e-13);
            let x = random.vectors(n);
            let mut y = random.vectors(n);
            a.multiply(&x, &mut y);
            prop_assert!((flat(&y) - dense * flat(&x)).norm() < 1e-12);
        }

        #[test]
        fn projection_keeps_the_matrix_definite_and_cuts_all_couplings((n, edges) in graph(8)) {
            let mut random = Random::new(7);
            let mut a = random_blocks(n, &edges, &mut random);
            let before = dense_blocks(&a);
            let mut constraints = Constraints::free(n);
            for i in 0..n {
                constraints.set(i, random_filter(&mut random), Vec3::zeros());
            }
            a.project(&constraints);
            let after = dense_blocks(&a);
            let s = dense_filter(&constraints);
            let rest = nalgebra::DMatrix::identity(3 * n, 3 * n) - &s;
            prop_assert!((&s * &after * &s - &s * before * &s).norm() < 1e-11);
            prop_assert!((&s * &after * &rest).norm() < 1e-12);
            prop_assert!((&after - after.transpose()).norm() < 1e-12);
            prop_assert!(after.symmetric_eigenvalues().min() > 0.1);
        }
    }

    #[test]
    fn pairs_annihilate_translations_and_off_diagonals_stay_symmetric() {
        let mut random = Random::new(8);
        let mut a = BlockMatrix::with_pattern(2, [(0, 1)]);
        let v = random.vector();
        a.add_pair(0, 1, &(v * v.transpose()));
        a.add_pair(1, 1, &Mat3::identity());
        let mut y = [Vec3::x(); 2];
        a.multiply(&[Vec3::new(1.0, 2.0, 3.0); 2], &mut y);
        assert!(y[0].norm() < 1e-14 && y[1].norm() < 1e-14);
        a.clear();
        let b = Mat3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0);
        a.add_off_diagonal(1, 0, &b);
        assert_eq!((a.get(1, 0), a.get(0, 1)), (b, b.transpose()));
        assert_eq!(a.get(0, 0), Mat3::zeros());
    }

    #[test]
    fn pairs_are_found_in_whatever_order_they_come() {
        let mut random = Random::new(9);
        let edges = [(0, 1), (1, 2), (2, 0), (3, 1), (1, 0)];
        let block = |k: usize| Mat3::from_diagonal_element((1 << k) as f64);
        let mut a = BlockMatrix::with_pattern(4, edges);
        for round in 0..40 {
            let mut fresh = BlockMatrix::with_pattern(4, edges);
            a.clear();
            let (count, twist) = (1 + round % 7, (5.0 * (random.unit() + 1.0)) as usize);
            for k in 0..count {
                let (i, j) = edges[if round % 3 == 0 { k } else { k * twist + round } % 5];
                for matrix in [&mut a, &mut fresh] {
                    matrix.add_pair(i, j, &block(k));
                    matrix.add_off_diagonal(j, i, &block(k + 9));
                }
            }
            assert_eq!(a.blocks, fresh.blocks, "{round}");
        }
    }

    #[test]
    #[cfg_attr(debug_assertions, should_panic(expected = "no pair (2, 0)"))]
    fn a_pair_outside_the_pattern_stops_debug_builds_and_is_left_out_of_others() {
        let mut a = BlockMatrix::with_pattern(3, [(0, 1)]);
        a.add_pair(2, 0, &Mat3::identity());
        assert_eq!(dense_blocks(&a).norm(), 0.0);
    }
}
