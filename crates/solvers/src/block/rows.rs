//! Compressed rows, both triangles stored: blocks of any kind.

use crate::pattern::Pattern;
use crate::{Constraints, Mat3, Vec3};
use std::ops::Range;

/// A symmetric matrix of 3×3 blocks in compressed rows: block (j, i) is the transpose of block (i,
/// j).
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    pattern: Pattern,
    blocks: Vec<Mat3>,
    /// Places of the pairs in the order of the last filling. The next filling in the same order
    /// needs no search.
    places: Vec<Place>,
    /// Number of pairs added since the last clearing.
    added: usize,
}

/// The slots of (i, j) and (j, i).
#[derive(Clone, Copy, Debug)]
struct Place {
    ends: [u32; 2],
    slots: [u32; 2],
}

impl Rows {
    /// The zero matrix with room for `n` diagonal blocks and for each edge.
    pub(crate) fn new(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
        Self::of_pattern(Pattern::new(n, edges))
    }

    /// The zero matrix with room for the blocks of a pattern.
    pub(crate) fn of_pattern(pattern: Pattern) -> Self {
        let blocks = vec![Mat3::zeros(); pattern.nonzeros()];
        // Springs add a pair once for stiffness and once for damping. Further pairs are searched.
        let places = Vec::with_capacity(pattern.nonzeros());
        Self { pattern, blocks, places, added: 0 }
    }

    pub(crate) fn n(&self) -> usize {
        self.pattern.n()
    }

    pub(super) fn nonzeros(&self) -> usize {
        self.pattern.nonzeros()
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.blocks.fill(Mat3::zeros());
        self.added = 0;
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.blocks.copy_from_slice(&other.blocks);
    }

    /// Overwrites all blocks.
    pub(crate) fn fill(&mut self, block: impl Fn(usize, usize) -> Mat3) {
        for i in 0..self.n() {
            for slot in self.pattern.row(i) {
                self.blocks[slot] = block(i, self.pattern.column(slot));
            }
        }
    }

    pub(crate) fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.blocks[self.pattern.diagonal(i)] += block;
    }

    pub(crate) fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_both(i, j, block, block);
    }

    pub(super) fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_both(i, j, block, &block.transpose());
    }

    #[inline]
    fn add_both(&mut self, i: usize, j: usize, block: &Mat3, transpose: &Mat3) {
        if i == j {
            return;
        }
        let Some((ij, ji)) = self.pair_slots(i, j) else {
            return;
        };
        self.blocks[ij] -= block;
        self.blocks[ji] -= transpose;
        self.add_diagonal(i, block);
        self.add_diagonal(j, transpose);
    }

    pub(crate) fn get(&self, i: usize, j: usize) -> Mat3 {
        self.pattern.slot(i, j).map_or_else(Mat3::zeros, |slot| self.blocks[slot])
    }

    /// `xx, xy, xz, yy, yz, zz` of the lower triangle of diagonal block `i`.
    #[inline(always)]
    pub(super) fn diagonal(&self, i: usize) -> [f64; 6] {
        let a = &self.blocks[self.pattern.diagonal(i)];
        [a[(0, 0)], a[(1, 0)], a[(2, 0)], a[(1, 1)], a[(2, 1)], a[(2, 2)]]
    }

    pub(super) fn project(&mut self, constraints: &Constraints) {
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

    /// As [`project`](Self::project), for blocks that are not symmetric.
    pub(crate) fn project_both_sides(&mut self, constraints: &Constraints) {
        for &i in constraints.constrained() {
            let i = i as usize;
            let s = constraints.filter(i).matrix();
            for ij in self.pattern.row(i) {
                let j = self.pattern.column(ij);
                if j != i
                    && let Some(ji) = self.pattern.slot(j, i)
                {
                    self.blocks[ij] = s * self.blocks[ij];
                    self.blocks[ji] *= s;
                }
            }
            let ii = self.pattern.diagonal(i);
            let third = self.blocks[ii].trace() / 3.0;
            let scale = if third > 0.0 { third } else { 1.0 };
            self.blocks[ii] = s * self.blocks[ii] * s + (Mat3::identity() - s) * scale;
        }
    }

    pub(super) fn has_pattern(&self, pattern: &Pattern) -> bool {
        self.pattern == *pattern
    }

    /// Writes the blocks left of the diagonal, row by row. Returns whether all are symmetric.
    pub(super) fn read_lower(&self, lower: &mut [Mat3]) -> bool {
        let mut all = true;
        let slots = (0..self.n()).flat_map(|i| self.pattern.lower(i));
        for (to, slot) in lower.iter_mut().zip(slots) {
            *to = self.blocks[slot];
            all &= is_symmetric(to);
        }
        all
    }

    /// Sets the blocks left of the diagonal to `lower`, row by row, those on it to `diagonal(i)`,
    /// and those right of it to the transposes. `mirrors` are those of the pattern.
    pub(crate) fn write_lower(
        &mut self,
        lower: &[Mat3],
        diagonal: impl Fn(usize) -> Mat3,
        mirrors: &[u32],
    ) {
        debug_assert_eq!(lower.len(), mirrors.len(), "one mirror a block");
        let mut lower = lower.iter();
        for i in 0..self.n() {
            for (to, from) in self.blocks[self.pattern.lower(i)].iter_mut().zip(&mut lower) {
                *to = *from;
            }
            self.blocks[self.pattern.diagonal(i)] = diagonal(i);
        }
        self.mirror_lower(mirrors);
    }

    /// The block of a slot of the pattern.
    #[inline(always)]
    pub(crate) fn block_mut(&mut self, slot: usize) -> &mut Mat3 {
        &mut self.blocks[slot]
    }

    /// Makes the upper triangle the transpose of the lower one, in diagonal blocks too. `mirrors`
    /// are those of the pattern.
    pub(crate) fn mirror_lower(&mut self, mirrors: &[u32]) {
        let mut mirrors = mirrors.iter();
        for i in 0..self.n() {
            let block = &mut self.blocks[self.pattern.diagonal(i)];
            block.fill_upper_triangle_with_lower_triangle();
            for (ij, &ji) in self.pattern.lower(i).zip(&mut mirrors) {
                self.blocks[ji as usize] = self.blocks[ij].transpose();
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
            // In another order, or with more pairs, the following ones are searched, too.
            self.places.truncate(at);
            self.places.push(Place { ends, slots: [first, second] });
            self.added += 1;
        }
        Some((ij, ji))
    }

    /// The pattern of the blocks.
    #[inline(always)]
    pub(crate) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The blocks, in the slots of the pattern.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> &[Mat3] {
        &self.blocks
    }

    /// These rows of `A x`, into `y`.
    pub(crate) fn multiply(&self, rows: Range<usize>, x: &[Vec3], y: &mut [Vec3]) {
        for (i, y) in rows.zip(y) {
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

#[inline(always)]
fn is_symmetric(block: &Mat3) -> bool {
    let equal = |row, column| block[(row, column)] == block[(column, row)];
    equal(0, 1) & equal(0, 2) & equal(1, 2)
}
