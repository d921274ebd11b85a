//! A triangular factor laid out for its sweeps: narrow dense panels, three right-hand sides at once.
//!
//! The factor is `L D Lᵀ` with ones on the diagonal of `L`. Neighbouring columns with the same rows
//! below them (a supernode) are cut into panels of at most [`WIDEST`] columns. A panel has the
//! strictly lower triangle of its square on the diagonal, and below it dense rows; the entries of a
//! row are consecutive, in the order in which both sweeps read them. A vector of the right-hand side
//! is four lanes (x, y, z, 0): one entry of `L` meets a whole vector, and there is nothing to be
//! shuffled or summed across lanes.
//!
//! # What a sweep costs
//!
//! A pair of sweeps reads each entry of `L` twice. For `e` entries in panels of mean width `w` and `n`
//! rows these are `2e (8 + 4/w)` bytes of the factor, read in order, and `12 e` floating-point
//! operations (16 with the idle lane). A row of a panel takes one index and one vector from
//! memory, and an entry one multiplication, one subtraction and one broadcast of 8 bytes. A processor that broadcasts two
//! numbers a cycle is done no sooner than after `e` cycles.
//!
//! | one solve, grid with structural edges, µs, one Zen 4 core | 52×52 | 100×100 | 316×316 |
//! |---|---|---|---|
//! | expected: `e` cycles at 3.65 GHz, or the memory's rate | 12 | 57 | 900 |
//! | these panels, baseline instructions (SSE2) | 65 | 304 | 9070 |
//! | AVX2 | 38 | 186 | 6070 |
//! | the same, fewer zeros accepted when supernodes are merged | 36 | 169 | |
//! | CHOLMOD, METIS order, three right-hand sides at once | 85 | 970 | 18 000 |
//!
//! What is left over the expectation are short loops: 1400 panels of 3 columns and 8 rows on the mean at 52×52, each with a
//! branch or two that cannot be predicted. Wider panels (up to 16 columns with 80 % zeros, the library's choice) and no merging at
//! all are both slower by a tenth.

use faer::sparse::linalg::cholesky::SymbolicCholesky;
use std::ops::Range;

use crate::sparse_factor::{Kind, supernodes};

/// Columns of a panel, at most: eight vectors of four lanes, which stay in registers.
const WIDEST: usize = 8;

/// One vector of the right-hand side, the last lane being idle.
pub(crate) type Lanes = [f64; 4];

/// Some columns of the factor.
#[derive(Clone, Copy, Debug)]
struct Panel {
    /// Its first column.
    first: u32,
    width: u32,
    /// Where its rows begin and end.
    rows: (usize, usize),
    /// Where its values begin: the triangle by rows, then the rows below.
    values: usize,
}

/// The factor by panels.
#[derive(Debug)]
pub(crate) struct Panels {
    panels: Vec<Panel>,
    rows: Vec<u32>,
    values: Vec<f64>,
    inverse_pivots: Vec<f64>,
    /// What the CPU can do, asked once.
    arch: pulp::Arch,
}

impl Panels {
    /// Memory for the factors of a symbolic factorisation by supernodes.
    pub(crate) fn new(symbolic: &SymbolicCholesky<u32>) -> Self {
        let (mut panels, mut rows, mut values) = (Vec::new(), Vec::new(), 0);
        for supernode in supernodes(symbolic) {
            let Range { start, end } = supernode.columns;
            // As wide as each other, but for one column.
            let count = (end - start).div_ceil(WIDEST);
            let cut = |k: usize| start + (end - start) * k / count;
            for k in 0..count {
                let (first, last) = (cut(k), cut(k + 1));
                let width = last - first;
                let begin = rows.len();
                rows.extend((last..end).map(|i| i as u32).chain(supernode.below.iter().copied()));
                panels.push(Panel {
                    first: first as u32,
                    width: width as u32,
                    rows: (begin, rows.len()),
                    values,
                });
                values += width * (width - 1) / 2 + width * (rows.len() - begin);
            }
        }
        Self {
            panels,
            rows,
            values: vec![0.0; values],
            inverse_pivots: vec![0.0; symbolic.nrows()],
            arch: crate::scalar::four_wide(),
        }
    }

    /// Takes over the numbers of a factor of the library.
    pub(crate) fn fill(&mut self, symbolic: &SymbolicCholesky<u32>, kind: Kind, factor: &[f64]) {
        let mut panels = self.panels.iter();
        for supernode in supernodes(symbolic) {
            let Range { start, end } = supernode.columns;
            let height = end - start + supernode.below.len();
            let columns = &factor[supernode.values];
            // Entry (i, j) of the panel of columns, scaled to ones on the diagonal.
            let entry = |i: usize, j: usize| columns[(j - start) * height + i - start];
            let mut next = start;
            while next < end {
                let Some(panel) = panels.next() else { return };
                let (first, width) = (next, panel.width as usize);
                next += width;
                let mut scale = [1.0; WIDEST];
                for (j, scale) in (first..next).zip(&mut scale) {
                    let pivot = entry(j, j);
                    (*scale, self.inverse_pivots[j]) = match kind {
                        Kind::Llt => (1.0 / pivot, 1.0 / (pivot * pivot)),
                        Kind::Ldlt => (1.0, 1.0 / pivot),
                    };
                }
                let mut values = self.values[panel.values..].iter_mut();
                for i in first + 1..start + height {
                    for j in first..next.min(i) {
                        if let Some(value) = values.next() {
                            *value = entry(i, j) * scale[j - first];
                        }
                    }
                }
            }
        }
    }

    /// `z ← (L D Lᵀ)⁻¹ z`, in the order of elimination.
    pub(crate) fn solve(&self, z: &mut [Lanes]) {
        assert_eq!(z.len(), self.inverse_pivots.len(), "one vector a row");
        self.arch.dispatch(Sweeps { factor: self, z });
    }

    #[inline(always)]
    fn forward(&self, panel: &Panel, z: &mut [Lanes]) {
        match panel.width {
            1 => self.forward_panel::<1>(panel, z),
            2 => self.forward_panel::<2>(panel, z),
            3 => self.forward_panel::<3>(panel, z),
            4 => self.forward_panel::<4>(panel, z),
            5 => self.forward_panel::<5>(panel, z),
            6 => self.forward_panel::<6>(panel, z),
            7 => self.forward_panel::<7>(panel, z),
            _ => self.forward_panel::<WIDEST>(panel, z),
        }
    }

    #[inline(always)]
    fn backward(&self, panel: &Panel, z: &mut [Lanes]) {
        match panel.width {
            1 => self.backward_panel::<1>(panel, z),
            2 => self.backward_panel::<2>(panel, z),
            3 => self.backward_panel::<3>(panel, z),
            4 => self.backward_panel::<4>(panel, z),
            5 => self.backward_panel::<5>(panel, z),
            6 => self.backward_panel::<6>(panel, z),
            7 => self.backward_panel::<7>(panel, z),
            _ => self.backward_panel::<WIDEST>(panel, z),
        }
    }

    /// The triangle, the rows below it and their numbers.
    #[inline(always)]
    fn parts<const W: usize>(&self, panel: &Panel) -> (&[f64], &[[f64; W]], &[u32]) {
        let rows = &self.rows[panel.rows.0..panel.rows.1];
        let (triangle, below) = self.values[panel.values..].split_at(W * (W - 1) / 2);
        (triangle, &below.as_chunks::<W>().0[..rows.len()], rows)
    }

    /// `L y = z` for the columns of a panel; its rows below lose their part.
    #[inline(always)]
    fn forward_panel<const W: usize>(&self, panel: &Panel, z: &mut [Lanes]) {
        let (triangle, below, rows) = self.parts::<W>(panel);
        let first = panel.first as usize;
        let mut y: [Lanes; W] = [[0.0; 4]; W];
        y.copy_from_slice(&z[first..first + W]);
        let mut entries = triangle.iter();
        for i in 1..W {
            for j in 0..i {
                if let Some(&value) = entries.next() {
                    y[i] = minus(y[i], value, y[j]);
                }
            }
        }
        z[first..first + W].copy_from_slice(&y);
        for (&row, values) in rows.iter().zip(below) {
            let target = &mut z[row as usize];
            let mut sum = *target;
            for j in 0..W {
                sum = minus(sum, values[j], y[j]);
            }
            *target = sum;
        }
    }

    /// `Lᵀ x = D⁻¹ y` for the columns of a panel.
    #[inline(always)]
    fn backward_panel<const W: usize>(&self, panel: &Panel, z: &mut [Lanes]) {
        let (triangle, below, rows) = self.parts::<W>(panel);
        let first = panel.first as usize;
        let mut x: [Lanes; W] = [[0.0; 4]; W];
        for j in 0..W {
            x[j] = z[first + j].map(|y| y * self.inverse_pivots[first + j]);
        }
        for (&row, values) in rows.iter().zip(below) {
            let known = z[row as usize];
            for j in 0..W {
                x[j] = minus(x[j], values[j], known);
            }
        }
        let mut entries = triangle.iter().rev();
        for i in (1..W).rev() {
            for j in (0..i).rev() {
                if let Some(&value) = entries.next() {
                    x[j] = minus(x[j], value, x[i]);
                }
            }
        }
        z[first..first + W].copy_from_slice(&x);
    }
}

/// Both sweeps, compiled for what the CPU can do. (A closure would do if it were sure to be inlined.)
struct Sweeps<'a> {
    factor: &'a Panels,
    z: &'a mut [Lanes],
}

impl pulp::WithSimd for Sweeps<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        for panel in &self.factor.panels {
            self.factor.forward(panel, self.z);
        }
        for panel in self.factor.panels.iter().rev() {
            self.factor.backward(panel, self.z);
        }
    }
}

/// `sum − value y`, rounded twice.
#[inline(always)]
fn minus(sum: Lanes, value: f64, y: Lanes) -> Lanes {
    let mut result = sum;
    for k in 0..4 {
        result[k] -= value * y[k];
    }
    result
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::{Random, graph, supernodal_factor};
    use proptest::prelude::*;

    /// The columns of `L`, read from the panels: panel's end, then the rows and values below the diagonal.
    fn columns(panels: &Panels) -> Vec<(usize, Vec<(usize, f64)>)> {
        let mut columns = Vec::new();
        for panel in &panels.panels {
            let (first, width) = (panel.first as usize, panel.width as usize);
            let below = panels.rows[panel.rows.0..panel.rows.1].iter().map(|&row| row as usize);
            let rows: Vec<usize> = (first..first + width).chain(below).collect();
            let mut of_panel = vec![Vec::new(); width];
            let mut values = panels.values[panel.values..].iter();
            for (i, &row) in rows.iter().enumerate() {
                for column in &mut of_panel[..i.min(width)] {
                    column.push((row, *values.next().unwrap()));
                }
            }
            columns.extend(of_panel.into_iter().map(|column| (first + width, column)));
        }
        columns
    }

    /// The sweeps as they are taught, on one right-hand side: forward column by column, backward row of `Lᵀ` by row,
    /// which takes the rows below the panel first, downward, and then those of the panel, upward.
    fn solve_by_columns(panels: &Panels, z: &mut [f64]) {
        let columns = columns(panels);
        for (j, (_, column)) in columns.iter().enumerate() {
            for &(i, value) in column {
                z[i] -= value * z[j];
            }
        }
        for (j, (end, column)) in columns.iter().enumerate().rev() {
            let mut sum = z[j] * panels.inverse_pivots[j];
            let (inside, below): (Vec<_>, Vec<_>) = column.iter().partition(|&&(i, _)| i < *end);
            for (i, value) in below.into_iter().chain(inside.into_iter().rev()) {
                sum -= value * z[i];
            }
            z[j] = sum;
        }
    }

    /// A factor of random values.
    fn random_factor(n: usize, edges: &[(usize, usize)], random: &mut Random) -> Panels {
        let factor = supernodal_factor(n, edges);
        let mut panels = Panels::new(factor.symbolic());
        let values: Vec<f64> = factor.factor().iter().map(|_| random.unit() + 1.5).collect();
        panels.fill(factor.symbolic(), Kind::Llt, &values);
        panels
    }

    proptest! {
        #[test]
        fn panels_give_the_bits_of_the_sweeps_by_columns(
            (n, edges) in graph(60),
            seed in 0..1_000_000_u64,
        ) {
            let mut random = Random::new(seed);
            let panels = random_factor(n, &edges, &mut random);
            let b: Vec<Lanes> = (0..n)
                .map(|_| [random.unit(), random.unit(), random.unit(), 0.0])
                .collect();
            let mut z = b.clone();
            panels.solve(&mut z);
            let mut scalar = b.clone();
            pulp::WithSimd::with_simd(Sweeps { factor: &panels, z: &mut scalar }, pulp::Scalar);
            for k in 0..3 {
                let mut expected: Vec<f64> = b.iter().map(|b| b[k]).collect();
                solve_by_columns(&panels, &mut expected);
                for i in 0..n {
                    prop_assert_eq!(z[i][k].to_bits(), expected[i].to_bits());
                    prop_assert_eq!(scalar[i][k].to_bits(), expected[i].to_bits());
                }
            }
        }
    }
}
