//! A level of multigrid: its sweeps, and the way to the next coarser one.

use super::Vectors;
use super::aggregation::Prolongation;
use super::sweeps::Sweeps;
use crate::block::{BlockSource, Rows};
use crate::pattern::Pattern;
use crate::{Mat3, SolverError};
use drape_kernels::lanes::{Four, Lanes, four_wide, vectorised};
use std::ops::Range;

/// The step from a fine matrix `A` to a coarse one.
#[derive(Debug)]
pub(super) struct Level {
    prolongation: Prolongation,
    restriction: Prolongation,
    /// `A P` by rows: starts of their slots, columns, and blocks.
    starts: Vec<u32>,
    columns: Vec<u32>,
    product: Vec<Mat3>,
    /// `Pᵀ A P`.
    coarse: Rows,
    /// [`Pattern::mirrors`] of the coarse pattern.
    mirrors: Vec<u32>,
    /// Slot of each column in the present row.
    slots: Vec<u32>,
    sweeps: Sweeps,
}

impl Prolongation {
    /// Adds a row times a vector to `sum`.
    #[inline(always)]
    fn add_row<F: Four>(&self, four: F, row: usize, x: &[Lanes], sum: Lanes) -> Lanes {
        let mut sum = four.load(sum);
        for &(column, weight) in self.row(row) {
            let x = four.load(x[column as usize]);
            sum = four.add(sum, four.mul(x, four.splat(weight)));
        }
        four.store(sum)
    }

    /// `y ← P x`, or `y ← y + P x` if it `adds`.
    fn multiply(&self, x: &[Lanes], y: &mut [Lanes], adds: bool) {
        vectorised!(
            four_wide(),
            [
                four,
                rows: &'k Prolongation = self,
                x: &'k [Lanes] = x,
                y: &'k mut [Lanes] = y,
                adds: bool = adds,
            ] -> () {
                for (row, y) in y.iter_mut().enumerate() {
                    *y = rows.add_row(four, row, x, if adds { *y } else { [0.0; 4] });
                }
            }
        );
    }
}

impl Level {
    /// Memory for the step from a matrix with this pattern.
    pub(super) fn new(fine: &Pattern, prolongation: Prolongation) -> Self {
        let restriction = prolongation.transposed();
        let (n, coarse) = (prolongation.rows(), prolongation.columns());
        let (mut starts, mut columns): (_, Vec<u32>) = (vec![0], Vec::new());
        for i in 0..n {
            let neighbours = fine.columns()[fine.row(i)].iter();
            let mut row: Vec<u32> = neighbours
                .flat_map(|&j| prolongation.row(j as usize).iter().map(|entry| entry.0))
                .collect();
            row.sort_unstable();
            row.dedup();
            columns.extend(row);
            starts.push(columns.len() as u32);
        }
        let mut edges = Vec::new();
        for row in 0..coarse {
            for &(i, _) in restriction.row(row) {
                let slots = starts[i as usize] as usize..starts[i as usize + 1] as usize;
                let left = columns[slots].iter().map(|&column| column as usize);
                edges.extend(left.take_while(|&column| column < row).map(|column| (column, row)));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let coarse = Rows::new(coarse, edges);
        Self {
            product: vec![Mat3::zeros(); columns.len()],
            sweeps: Sweeps::new(fine),
            mirrors: coarse.pattern().mirrors(),
            slots: vec![0; coarse.n()],
            coarse,
            prolongation,
            restriction,
            starts,
            columns,
        }
    }

    /// Slots of a row of `A P`.
    #[inline(always)]
    fn row(&self, i: usize) -> Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    /// Reads the fine matrix for the sweeps.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] if a diagonal block is not positive definite.
    pub(super) fn read(&mut self, a: &impl BlockSource) -> Result<(), SolverError> {
        self.sweeps.read(a)
    }

    /// Computes `A P`, and the lower triangle of `Pᵀ (A P)` with its mirror.
    pub(super) fn coarsen(&mut self, a: &Rows) {
        vectorised!(four_wide(), [four, level: &'k mut Level = self, a: &'k Rows = a] -> () {
            level.prolong_matrix(four, a);
            level.restrict_product(four);
        });
        self.coarse.mirror_lower(&self.mirrors);
    }

    /// `A P`.
    #[inline(always)]
    fn prolong_matrix(&mut self, four: impl Four, a: &Rows) {
        let (pattern, blocks) = (a.pattern(), a.blocks());
        self.product.fill(Mat3::zeros());
        for i in 0..a.n() {
            for slot in self.row(i) {
                self.slots[self.columns[slot] as usize] = slot as u32;
            }
            for slot in pattern.row(i) {
                for &(column, weight) in self.prolongation.row(pattern.column(slot)) {
                    let to = self.slots[column as usize] as usize;
                    add_scaled(four, &mut self.product[to], weight, &blocks[slot]);
                }
            }
        }
    }

    /// The lower triangle of `Pᵀ (A P)`.
    #[inline(always)]
    fn restrict_product(&mut self, four: impl Four) {
        self.coarse.clear();
        for row in 0..self.restriction.rows() {
            let slots = self.coarse.pattern().row(row);
            for slot in slots {
                self.slots[self.coarse.pattern().column(slot)] = slot as u32;
            }
            for &(i, weight) in self.restriction.row(row) {
                let own = self.row(i as usize);
                for (&column, block) in self.columns[own.clone()].iter().zip(&self.product[own]) {
                    if column as usize > row {
                        break;
                    }
                    let to = self.slots[column as usize] as usize;
                    add_scaled(four, self.coarse.block_mut(to), weight, block);
                }
            }
        }
    }

    /// The coarse matrix.
    pub(super) fn coarse(&self) -> &Rows {
        &self.coarse
    }

    /// The blocks of the fine matrix left of its diagonal, row by row.
    pub(super) fn lower(&self) -> &[Mat3] {
        self.sweeps.lower()
    }

    /// Blocks that a cycle multiplies on this level, and those that [`coarsen`](Self::coarsen)
    /// adds, where the fine matrix has the pattern `fine`.
    pub(super) fn blocks(&self, fine: &Pattern) -> (usize, usize) {
        let cycle = 2 * fine.nonzeros() + 2 * self.columns.len() / 3;
        let entries = |&column: &u32| self.prolongation.row(column as usize).len();
        let products: usize = fine.columns().iter().map(entries).sum();
        let rows = 0..self.restriction.rows();
        let entries = rows.flat_map(|row| self.restriction.row(row));
        let sums = entries.map(|&(i, _)| self.row(i as usize).len()).sum::<usize>() / 2;
        (cycle, products + sums)
    }

    /// A sweep from zero. The residual that it leaves goes to the `coarse` right-hand side.
    pub(super) fn descend(&self, fine: &mut Vectors, coarse: &mut [Lanes]) {
        let Vectors { right, solution, residual } = fine;
        self.sweeps.forward(right, solution, residual);
        self.restriction.multiply(residual, coarse, false);
    }

    /// Adds the `coarse` solution, and sweeps backwards. Overwrites the right-hand side.
    pub(super) fn ascend(&self, coarse: &[Lanes], fine: &mut Vectors) {
        let Vectors { right, solution, .. } = fine;
        self.prolongation.multiply(coarse, solution, true);
        self.sweeps.backward(right, solution);
    }

    #[cfg(test)]
    pub(super) fn sweeps(&self) -> &Sweeps {
        &self.sweeps
    }
}

/// `to ← to + w block`.
#[inline(always)]
fn add_scaled(four: impl Four, to: &mut Mat3, w: f64, block: &Mat3) {
    let (to, last) = to.as_mut_slice().as_chunks_mut::<4>();
    let (from, from_last) = block.as_slice().as_chunks::<4>();
    let weight = four.splat(w);
    for (to, from) in to.iter_mut().zip(from) {
        let product = four.mul(weight, four.load(*from));
        *to = four.store(four.add(four.load(*to), product));
    }
    for (to, from) in last.iter_mut().zip(from_last) {
        *to += w * from;
    }
}
