//! A triangular factor in a layout for its sweeps: narrow panels of columns, below them tiles of
//! rows.
//!
//! The factor is `L D Lᵀ` with ones on the diagonal of `L`. Neighbouring columns with the same rows
//! below them (a supernode) are cut into panels of at most [`WIDEST`] columns. A panel holds the
//! strictly lower triangle of its square on the diagonal. Below it, `ROWS` rows form a tile, in
//! which the entries of a column are consecutive. Zeros fill up the last tile; they meet an idle
//! entry at the end of the vector.
//!
//! The [`Vector`] of the right-hand side decides how a register is filled:
//!
//! | right-hand side | `ROWS` | a register holds |
//! |---|---|---|
//! | three coordinates and an idle lane: [`Lanes`] | 1 | the vector of a row; an entry of `L` is broadcast |
//! | one number: `f64` | 4 | four entries of a column |
//!
//! With four rows the backward sweep keeps one register for each column. At the end its four lanes
//! are added as `(0 + 1) + (2 + 3)`.
//!
//! # What a sweep costs
//!
//! A pair of sweeps reads each of `e` entries of `L` twice, `16 e` bytes in order. With one number
//! a row it does `4 e` floating-point operations in `e` vector operations, so the memory of the
//! factor bounds it. The block matrix of a sheet of 52×52 particles with structural, shear and
//! bending springs has 1.05 million entries: 0.2 ms at the 85 GB/s of the third-level cache.
//! Measured: 0.43 ms, against 0.65 ms by the library's supernodes.
//!
//! With four lanes it does `12 e` operations (16 with the idle lane), and a broadcast for each
//! entry. A processor that broadcasts two numbers a cycle takes at least `e` cycles.
//!
//! | one solve, four lanes, grid with structural edges, µs, one Zen 4 core | 52×52 | 100×100 | 316×316 |
//! |---|---|---|---|
//! | expected: `e` cycles at 3.65 GHz, or the memory's rate | 12 | 57 | 900 |
//! | these panels, baseline instructions (SSE2) | 65 | 304 | 9070 |
//! | AVX2 | 38 | 186 | 6070 |
//! | the same, fewer zeros accepted when supernodes are merged | 36 | 169 | |
//! | CHOLMOD, METIS order, three right-hand sides at once | 85 | 970 | 18 000 |
//!
//! Short loops cost the rest: at 52×52 there are 1400 panels of 3 columns and 8 rows on the mean,
//! each with a branch or two that cannot be predicted. Wider panels (up to 16 columns with 80 %
//! zeros, the library's choice) and no merging at all are both slower by a tenth.

use faer::sparse::linalg::cholesky::SymbolicCholesky;
use std::ops::Range;

use crate::sparse_factor::{FactorKind, supernodes};
use drape_kernels::lanes::{Lanes, four_wide};

/// Most columns of a panel: one register of four lanes each.
const WIDEST: usize = 8;

/// `ROWS` entries of each of `W` columns.
type Tile<const W: usize, const ROWS: usize> = [[f64; ROWS]; W];

/// An entry of the right-hand side, with `ROWS` rows a tile.
pub(crate) trait Vector<const ROWS: usize>: Copy {
    const ZERO: Self;

    /// `self − value other`, rounded twice.
    fn minus(self, value: f64, other: Self) -> Self;

    /// `self · value`.
    fn times(self, value: f64) -> Self;

    /// Subtracts the products of each column below the panel with its rows from `x`.
    fn subtract_below<const W: usize>(
        x: &mut [Self; W],
        tiles: &[Tile<W, ROWS>],
        rows: &[[u32; ROWS]],
        z: &[Self],
    );
}

impl Vector<1> for Lanes {
    const ZERO: Self = [0.0; 4];

    #[inline(always)]
    fn minus(self, value: f64, other: Self) -> Self {
        let mut result = self;
        for k in 0..4 {
            result[k] -= value * other[k];
        }
        result
    }

    #[inline(always)]
    fn times(self, value: f64) -> Self {
        self.map(|lane| lane * value)
    }

    #[inline(always)]
    fn subtract_below<const W: usize>(
        x: &mut [Self; W],
        tiles: &[Tile<W, 1>],
        rows: &[[u32; 1]],
        z: &[Self],
    ) {
        for (&[row], tile) in rows.iter().zip(tiles) {
            let known = z[row as usize];
            for j in 0..W {
                x[j] = x[j].minus(tile[j][0], known);
            }
        }
    }
}

impl Vector<4> for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn minus(self, value: f64, other: Self) -> Self {
        self - value * other
    }

    #[inline(always)]
    fn times(self, value: f64) -> Self {
        self * value
    }

    #[inline(always)]
    fn subtract_below<const W: usize>(
        x: &mut [Self; W],
        tiles: &[Tile<W, 4>],
        rows: &[[u32; 4]],
        z: &[Self],
    ) {
        let mut sums = [[0.0; 4]; W];
        for (rows, tile) in rows.iter().zip(tiles) {
            let known = rows.map(|row| z[row as usize]);
            for j in 0..W {
                for k in 0..4 {
                    sums[j][k] += tile[j][k] * known[k];
                }
            }
        }
        for j in 0..W {
            x[j] -= (sums[j][0] + sums[j][1]) + (sums[j][2] + sums[j][3]);
        }
    }
}

/// Some columns of the factor.
#[derive(Clone, Copy, Debug)]
struct Panel {
    /// Its first column.
    first: u32,
    width: u32,
    /// Start and end of its tiles among the rows of all tiles.
    tiles: (usize, usize),
    /// Start of its values: the triangle by rows, then the tiles.
    values: usize,
}

/// The factor by panels and tiles of `ROWS` rows.
#[derive(Debug)]
pub(crate) struct Tiles<const ROWS: usize> {
    panels: Vec<Panel>,
    rows: Vec<[u32; ROWS]>,
    values: Vec<f64>,
    inverse_pivots: Vec<f64>,
    /// The instruction set of the CPU.
    arch: pulp::Arch,
}

impl<const ROWS: usize> Tiles<ROWS> {
    /// Memory for the factors of a symbolic factorisation by supernodes.
    pub(crate) fn new(symbolic: &SymbolicCholesky<u32>) -> Self {
        let idle = symbolic.nrows() as u32;
        let (mut panels, mut tiles, mut values) = (Vec::new(), Vec::new(), 0);
        for supernode in supernodes(symbolic) {
            let Range { start, end } = supernode.columns;
            // Panels of equal width, up to one column.
            let count = (end - start).div_ceil(WIDEST);
            let cut = |k: usize| start + (end - start) * k / count;
            for k in 0..count {
                let (first, last) = (cut(k), cut(k + 1));
                let width = last - first;
                let begin = tiles.len();
                let below = (last..end).map(|i| i as u32).chain(supernode.below.iter().copied());
                let rows: Vec<u32> = below.collect();
                tiles.extend(rows.chunks(ROWS).map(|rows| {
                    let mut tile = [idle; ROWS];
                    tile[..rows.len()].copy_from_slice(rows);
                    tile
                }));
                let tiles = (begin, tiles.len());
                panels.push(Panel { first: first as u32, width: width as u32, tiles, values });
                values += width * (width - 1) / 2 + width * ROWS * (tiles.1 - tiles.0);
            }
        }
        Self {
            panels,
            rows: tiles,
            values: vec![0.0; values],
            inverse_pivots: vec![0.0; symbolic.nrows()],
            arch: four_wide(),
        }
    }

    /// Copies the numbers of a factor of the library.
    pub(crate) fn fill(
        &mut self,
        symbolic: &SymbolicCholesky<u32>,
        kind: FactorKind,
        factor: &[f64],
    ) {
        let mut panels = self.panels.iter();
        for supernode in supernodes(symbolic) {
            let Range { start, end } = supernode.columns;
            let height = end - start + supernode.below.len();
            let entries = &factor[supernode.values];
            let mut next = start;
            while next < end {
                let Some(panel) = panels.next() else { return };
                let (first, width) = (next, panel.width as usize);
                next += width;
                let (triangle, below) =
                    self.values[panel.values..].split_at_mut(width * (width - 1) / 2);
                let below = &mut below[..width * ROWS * (panel.tiles.1 - panel.tiles.0)];
                let mut scales = [1.0; WIDEST];
                let mut columns: [&[f64]; WIDEST] = [&[]; WIDEST];
                for j in 0..width {
                    columns[j] = &entries[(first + j - start) * height..][first - start..]
                        [..height + start - first];
                    let pivot = columns[j][j];
                    (scales[j], self.inverse_pivots[first + j]) = match kind {
                        FactorKind::Cholesky => (1.0 / pivot, 1.0 / (pivot * pivot)),
                        FactorKind::Ldlt => (1.0, 1.0 / pivot),
                    };
                    for i in j + 1..width {
                        triangle[i * (i - 1) / 2 + j] = columns[j][i] * scales[j];
                    }
                    columns[j] = &columns[j][width..];
                }
                // The zeros that fill up the last tile stay.
                let columns = &columns[..width];
                for (tile, slots) in below.chunks_exact_mut(ROWS * width).enumerate() {
                    for ((slot, column), scale) in
                        slots.chunks_exact_mut(ROWS).zip(columns).zip(scales)
                    {
                        let rows = &column[ROWS * tile..];
                        slot.iter_mut().zip(rows).for_each(|(to, from)| *to = from * scale);
                    }
                }
            }
        }
    }

    /// `z ← (L D Lᵀ)⁻¹ z`, in the order of elimination; `z` has one idle entry more.
    pub(crate) fn solve<V: Vector<ROWS>>(&self, z: &mut [V]) {
        let n = self.inverse_pivots.len();
        assert_eq!(z.len(), n + 1, "one entry a row and the idle one");
        // Zeros times overflowed numbers may have left any value there.
        z[n] = V::ZERO;
        self.arch.dispatch(Sweeps { factor: self, z });
    }

    /// The triangle, the tiles below it and their rows.
    #[inline(always)]
    fn parts<const W: usize>(&self, panel: &Panel) -> (&[f64], &[Tile<W, ROWS>], &[[u32; ROWS]]) {
        let rows = &self.rows[panel.tiles.0..panel.tiles.1];
        let (triangle, below) = self.values[panel.values..].split_at(W * (W - 1) / 2);
        let (columns, _) = below[..W * ROWS * rows.len()].as_chunks::<ROWS>();
        (triangle, columns.as_chunks::<W>().0, rows)
    }

    /// Solves `L y = z` for the columns of a panel, and updates the rows below it.
    #[inline(always)]
    fn forward<V: Vector<ROWS>, const W: usize>(&self, panel: &Panel, z: &mut [V]) {
        let (triangle, tiles, rows) = self.parts::<W>(panel);
        let first = panel.first as usize;
        let mut y = [V::ZERO; W];
        y.copy_from_slice(&z[first..first + W]);
        let mut entries = triangle.iter();
        for i in 1..W {
            for j in 0..i {
                if let Some(&value) = entries.next() {
                    y[i] = y[i].minus(value, y[j]);
                }
            }
        }
        z[first..first + W].copy_from_slice(&y);
        for (rows, tile) in rows.iter().zip(tiles) {
            let mut sums = rows.map(|row| z[row as usize]);
            for j in 0..W {
                for k in 0..ROWS {
                    sums[k] = sums[k].minus(tile[j][k], y[j]);
                }
            }
            for k in 0..ROWS {
                z[rows[k] as usize] = sums[k];
            }
        }
    }

    /// Solves `Lᵀ x = D⁻¹ y` for the columns of a panel.
    #[inline(always)]
    fn backward<V: Vector<ROWS>, const W: usize>(&self, panel: &Panel, z: &mut [V]) {
        let (triangle, tiles, rows) = self.parts::<W>(panel);
        let first = panel.first as usize;
        let mut x = [V::ZERO; W];
        for j in 0..W {
            x[j] = z[first + j].times(self.inverse_pivots[first + j]);
        }
        V::subtract_below(&mut x, tiles, rows, z);
        let mut entries = triangle.iter().rev();
        for i in (1..W).rev() {
            for j in (0..i).rev() {
                if let Some(&value) = entries.next() {
                    x[j] = x[j].minus(value, x[i]);
                }
            }
        }
        z[first..first + W].copy_from_slice(&x);
    }
}

/// Both sweeps, compiled for the CPU's instruction set. A closure might not be inlined.
struct Sweeps<'a, V, const ROWS: usize> {
    factor: &'a Tiles<ROWS>,
    z: &'a mut [V],
}

/// Calls the sweep for the width of a panel.
macro_rules! by_width {
    ($factor:ident.$sweep:ident($panel:ident, $z:ident)) => {
        match $panel.width {
            1 => $factor.$sweep::<V, 1>($panel, $z),
            2 => $factor.$sweep::<V, 2>($panel, $z),
            3 => $factor.$sweep::<V, 3>($panel, $z),
            4 => $factor.$sweep::<V, 4>($panel, $z),
            5 => $factor.$sweep::<V, 5>($panel, $z),
            6 => $factor.$sweep::<V, 6>($panel, $z),
            7 => $factor.$sweep::<V, 7>($panel, $z),
            _ => $factor.$sweep::<V, WIDEST>($panel, $z),
        }
    };
}

impl<V: Vector<ROWS>, const ROWS: usize> pulp::WithSimd for Sweeps<'_, V, ROWS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        let Self { factor, z } = self;
        for panel in &factor.panels {
            by_width!(factor.forward(panel, z));
        }
        for panel in factor.panels.iter().rev() {
            by_width!(factor.backward(panel, z));
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::{Random, graph, supernodal_factor};
    use drape_kernels::testing::{Bits, assert_same_bits};
    use proptest::prelude::*;

    /// Column `j` of `L`: the end of its panel, and entries with their rows.
    fn columns<const ROWS: usize>(tiles: &Tiles<ROWS>) -> Vec<(usize, Vec<(usize, f64)>)> {
        let mut columns = Vec::new();
        for panel in &tiles.panels {
            let (first, width) = (panel.first as usize, panel.width as usize);
            let (triangle, below) = tiles.values[panel.values..].split_at(width * (width - 1) / 2);
            for j in 0..width {
                let inside = (j + 1..width).map(|i| (first + i, triangle[i * (i - 1) / 2 + j]));
                let rows = tiles.rows[panel.tiles.0..panel.tiles.1].iter().enumerate();
                let outside = rows.flat_map(|(tile, rows)| {
                    let value = move |k: usize| below[(tile * width + j) * ROWS + k];
                    (0..ROWS).map(move |k| (rows[k] as usize, value(k)))
                });
                columns.push((first + width, inside.chain(outside).collect()));
            }
        }
        columns
    }

    /// The textbook sweeps, column by column, on one number per row. With four rows a tile the
    /// products below a panel are summed in four parts.
    fn solve_reference<const ROWS: usize>(tiles: &Tiles<ROWS>, z: &mut [f64]) {
        let columns = columns(tiles);
        for (j, (_, column)) in columns.iter().enumerate() {
            for &(i, value) in column {
                z[i] -= value * z[j];
            }
        }
        for (j, (end, column)) in columns.iter().enumerate().rev() {
            let (inside, below): (Vec<_>, Vec<_>) = column.iter().partition(|&&(i, _)| i < *end);
            let mut sum = z[j] * tiles.inverse_pivots[j];
            if ROWS == 1 {
                below.into_iter().for_each(|(i, value)| sum -= value * z[i]);
            } else {
                let mut parts = [0.0; 4];
                for (k, (i, value)) in below.into_iter().enumerate() {
                    parts[k % 4] += value * z[i];
                }
                sum -= (parts[0] + parts[1]) + (parts[2] + parts[3]);
            }
            for (i, value) in inside.into_iter().rev() {
                sum -= value * z[i];
            }
            z[j] = sum;
        }
    }

    /// Compares solves with and without vector registers with the reference, for each number of an
    /// entry.
    fn assert_same<V: Vector<ROWS> + Bits, const ROWS: usize, const NUMBERS: usize>(
        (n, edges): (usize, &[(usize, usize)]),
        random: &mut Random,
        entry: impl Fn([f64; NUMBERS]) -> V,
    ) {
        let factor = supernodal_factor(n, edges);
        let mut tiles = Tiles::<ROWS>::new(factor.symbolic());
        let values: Vec<f64> = factor.factor().iter().map(|_| random.unit() + 1.5).collect();
        tiles.fill(factor.symbolic(), FactorKind::Cholesky, &values);
        let b: [Vec<f64>; NUMBERS] = std::array::from_fn(|_| random.units(n));
        let entries = |z: &[Vec<f64>; NUMBERS]| -> Vec<V> {
            (0..n).map(|i| entry(z.each_ref().map(|z| z[i]))).chain([V::ZERO]).collect()
        };
        let [mut fast, mut scalar] = [(); 2].map(|()| entries(&b));
        tiles.solve(&mut fast);
        pulp::WithSimd::with_simd(Sweeps { factor: &tiles, z: &mut scalar }, pulp::Scalar);
        let reference = entries(&b.map(|mut z| {
            z.push(0.0);
            solve_reference(&tiles, &mut z);
            z
        }));
        assert_same_bits("fast", &reference[..n], &fast[..n]);
        assert_same_bits("without registers", &reference[..n], &scalar[..n]);
    }

    proptest! {
        #[test]
        fn tiles_give_the_bits_of_the_reference(graph in graph(60), seed in any::<u64>()) {
            let (random, graph) = (&mut Random::new(seed), (graph.0, &graph.1[..]));
            assert_same::<Lanes, 1, 3>(graph, random, |[x, y, z]| [x, y, z, 0.0]);
            assert_same::<f64, 4, 1>(graph, random, |[x]| x);
        }
    }
}
