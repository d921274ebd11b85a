//! One block `a I + κ w wᵀ` for each spring: the matrix of a general mesh.
//!
//! A spring from `i` to `j` adds its block `B` at (i, i) and (j, j), and `−B` at (i, j) and (j, i).
//! With full damping, or none, `B` is a multiple of the identity and a multiple of the square of
//! the direction. So four numbers hold it, and a product computes one force
//! `B (x_i − x_j) = a d + w (κ w·d)` for both ends. Diagonal blocks are computed when they are read.
//! Two springs between the same rows have one block each.
//!
//! The springs lie in the order of their lower, then of their higher end. A row sums its mass times
//! `x_i`, the forces of springs from earlier rows in their order, then those of its own springs.
//! Threads share the rows in bands; a band computes the forces that lead into it once more. So the
//! bits depend neither on the number of threads nor on the vector units. They are not those of
//! compressed rows, which round elsewhere.
//!
//! # What it costs
//!
//! With `p` springs a row a product takes `24 p + 3` flops a row and moves `36 p` bytes of springs
//! and their ends, 16 of mass and places, and 72 of vectors: on a sheet with tension, shear and
//! bending springs (`p` = 6) 147 flops and 304 bytes, against 234 flops and 1036 bytes in
//! compressed rows. The springs from earlier rows wrote to `y`. Where coupled rows have near
//! numbers, it is still in cache.
//!
//! Products of square sheets in disorder, renumbered from 1000 rows on, on one core of a shared
//! Zen 4, median µs, before the blocks had a unit:
//!
//! | tried | 400 rows | 2704 | 10 000 | 99 856 |
//! |---|---|---|---|---|
//! | six numbers a pair of rows in a line of the cache, four rows side by side: 600 bytes a row | 10.6 | 74 | 297 | 6900 |
//! | four numbers a spring, read from both rows | 8.8 | 63 | 224 | 3630 |
//! | **four numbers a spring, one force for both rows** | 5.7 | 41 | 151 | 2210 |
//! | the same, vectors padded to four numbers | 7.0 | 47 | 174 | 2780 |
//! | the same, eight springs at a time | 8.7 | 64 | 233 | 2750 |
//! | two numbers a spring and the positions | 7.0 | 49 | 196 | 2220 |

use super::symmetric;
use crate::pattern::Pattern;
use crate::{Mat3, Vec3};
use drape_kernels::blocks::{SIX, SpringBlock, SpringBlocks, six};
use std::ops::Range;

/// A symmetric matrix of springs.
#[derive(Clone, Debug)]
pub(super) struct Pairs {
    /// The multiple of the identity of each row.
    own: Vec<f64>,
    /// Further diagonal blocks, one a row: `xx, xy, xz, yy, yz, zz`. Empty if there are none.
    general: Vec<[f64; 6]>,
    springs: Vec<SpringBlock>,
    /// `κ`.
    unit: f64,
    /// Rows of each spring, the lower first; rising.
    ends: Vec<[u32; 2]>,
    /// The spring of each edge given to [`new`](Self::new).
    slots: Vec<u32>,
    /// The springs of row `i` to later rows are `starts[i]..starts[i + 1]`.
    starts: Vec<usize>,
    /// The higher row of each spring.
    others: Vec<u32>,
    /// The springs of row `j` from earlier rows are
    /// `incoming[incoming_starts[j]..incoming_starts[j + 1]]`.
    incoming: Vec<u32>,
    incoming_starts: Vec<usize>,
    /// The greatest distance of coupled rows.
    reach: usize,
}

impl Pairs {
    /// The zero matrix with `n` rows and room for a spring at each edge.
    pub(super) fn new(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
        assert!(n < u32::MAX as usize, "more rows than a u32 can number");
        let list: Vec<[u32; 2]> = edges
            .into_iter()
            .inspect(|&(i, j)| assert!(i < n && j < n, "edge ({i}, {j}) leaves the {n} rows"))
            .map(|(i, j)| [i.min(j) as u32, i.max(j) as u32])
            .collect();
        assert!(list.len() < u32::MAX as usize, "more springs than a u32 can number");
        let mut order: Vec<u32> = (0..list.len() as u32).collect();
        order.retain(|&edge| list[edge as usize][0] != list[edge as usize][1]);
        order.sort_by_key(|&edge| list[edge as usize]);
        let mut slots = vec![u32::MAX; list.len()];
        (0..).zip(&order).for_each(|(slot, &edge)| slots[edge as usize] = slot);
        let ends: Vec<_> = order.iter().map(|&edge| list[edge as usize]).collect();
        let incoming_starts = starts(n, ends.iter().map(|[_, j]| *j));
        let mut next = incoming_starts.clone();
        let mut incoming = vec![0; ends.len()];
        for (spring, [_, j]) in (0..).zip(&ends) {
            let next = &mut next[*j as usize];
            incoming[*next] = spring;
            *next += 1;
        }
        Self {
            own: vec![0.0; n],
            general: Vec::new(),
            springs: vec![[0.0; 4]; ends.len()],
            unit: 1.0,
            slots,
            starts: starts(n, ends.iter().map(|[i, _]| *i)),
            others: ends.iter().map(|[_, j]| *j).collect(),
            incoming,
            incoming_starts,
            reach: ends.iter().map(|[i, j]| (j - i) as usize).max().unwrap_or(0),
            ends,
        }
    }

    pub(super) fn n(&self) -> usize {
        self.own.len()
    }

    pub(super) fn nonzeros(&self) -> usize {
        self.n() + 2 * self.ends.chunk_by(|a, b| a == b).count()
    }

    /// The ends of all springs.
    pub(super) fn edges(&self) -> Vec<(usize, usize)> {
        self.ends.iter().map(|&[i, j]| (i as usize, j as usize)).collect()
    }

    pub(super) fn clear(&mut self) {
        self.own.fill(0.0);
        self.general.clear();
        self.springs.fill([0.0; 4]);
        self.unit = 1.0;
    }

    pub(super) fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        let a = block[(0, 0)];
        if *block == Mat3::from_diagonal_element(a) {
            self.own[i] += a;
        } else {
            self.add_general(i, SIX.map(|place| block[place]));
        }
    }

    fn add_general(&mut self, i: usize, block: [f64; 6]) {
        self.general.resize(self.own.len(), [0.0; 6]);
        for (sum, b) in self.general[i].iter_mut().zip(block) {
            *sum += b;
        }
    }

    pub(super) fn get(&self, i: usize, j: usize) -> Mat3 {
        symmetric(if i == j {
            self.diagonal(i)
        } else {
            let ends = [i.min(j) as u32, i.max(j) as u32];
            let first = self.ends.partition_point(|other| *other < ends);
            let springs = self.ends[first..].iter().zip(&self.springs[first..]);
            let between = springs.take_while(|(other, _)| **other == ends);
            between.fold([0.0; 6], |sum, (_, spring)| subtracted(sum, six(*spring, self.unit)))
        })
    }

    /// Whether the springs join just the rows that a pattern couples.
    pub(super) fn has_pattern(&self, pattern: &Pattern) -> bool {
        let row = |j: usize| {
            let lower = |spring: &u32| self.ends[*spring as usize][0] as usize;
            let springs = self.incoming(j).chunk_by(move |a, b| lower(a) == lower(b));
            let own = pattern.lower(j).map(|slot| pattern.column(slot));
            springs.map(|springs| lower(&springs[0])).eq(own)
        };
        pattern.n() == self.n() && (0..self.n()).all(row)
    }

    /// Writes the blocks left of the diagonal, row by row. Returns whether all are symmetric.
    pub(super) fn read_lower(&self, lower: &mut [Mat3]) -> bool {
        let mut lower = lower.iter_mut();
        for j in 0..self.n() {
            let end = |spring: &u32| self.ends[*spring as usize];
            for springs in self.incoming(j).chunk_by(|a, b| end(a) == end(b)) {
                let blocks = springs.iter().map(|&s| six(self.springs[s as usize], self.unit));
                if let Some(to) = lower.next() {
                    *to = symmetric(blocks.fold([0.0; 6], subtracted));
                }
            }
        }
        true
    }

    /// `xx, xy, xz, yy, yz, zz` of diagonal block `i`.
    #[inline(always)]
    pub(super) fn diagonal(&self, i: usize) -> [f64; 6] {
        let own = self.own[i];
        let mut sum = [own, 0.0, 0.0, own, 0.0, own];
        if let Some(general) = self.general.get(i) {
            sum = added(sum, *general);
        }
        for &spring in self.incoming(i) {
            sum = added(sum, six(self.springs[spring as usize], self.unit));
        }
        for spring in &self.springs[self.outgoing(i)] {
            sum = added(sum, six(*spring, self.unit));
        }
        sum
    }

    /// Cuts all couplings of row `i`, and sets its diagonal block to `scale(trace / 3)` times the
    /// identity.
    pub(super) fn fix(&mut self, i: usize, scale: impl Fn(f64) -> f64) {
        let [xx, _, _, yy, _, zz] = self.diagonal(i);
        let scale = scale((xx + yy + zz) / 3.0);
        let incoming = self.incoming(i).iter().map(|&spring| spring as usize);
        let springs: Vec<usize> = incoming.chain(self.outgoing(i)).collect();
        for spring in springs {
            let block = six(std::mem::take(&mut self.springs[spring]), self.unit);
            let [lower, higher] = self.ends[spring].map(|end| end as usize);
            self.add_general(if lower == i { higher } else { lower }, block);
        }
        if let Some(general) = self.general.get_mut(i) {
            *general = [0.0; 6];
        }
        self.own[i] = scale;
    }

    pub(super) fn blocks_mut(&mut self) -> SpringBlocks<'_> {
        let Self { own, general, springs, unit, ends, slots, .. } = self;
        SpringBlocks { own, general, springs, unit, ends, slots }
    }

    /// The springs of row `i` to later rows.
    #[inline(always)]
    fn outgoing(&self, i: usize) -> Range<usize> {
        self.starts[i]..self.starts[i + 1]
    }

    /// The springs of row `j` from earlier rows, in their order.
    #[inline(always)]
    fn incoming(&self, j: usize) -> &[u32] {
        &self.incoming[self.incoming_starts[j]..self.incoming_starts[j + 1]]
    }

    /// These rows of `A x`, into `y`.
    pub(super) fn multiply(&self, rows: Range<usize>, x: &[Vec3], y: &mut [Vec3]) {
        pulp::Arch::new().dispatch(Product { matrix: self, first: rows.start, x, y });
    }

    /// As [`multiply`](Self::multiply), row by row: each force is computed at both ends.
    #[cfg(test)]
    pub(super) fn multiply_reference(&self, x: &[Vec3], y: &mut [Vec3]) {
        for (i, y) in y.iter_mut().enumerate() {
            *y = x[i] * self.own[i];
            if let Some(general) = self.general.get(i) {
                add_product(y, general, &x[i]);
            }
            for &spring in self.incoming(i) {
                let spring = spring as usize;
                let d = x[self.ends[spring][0] as usize] - x[i];
                *y -= force(&self.springs[spring], self.unit, &d);
            }
            for spring in self.outgoing(i) {
                let d = x[i] - x[self.ends[spring][1] as usize];
                *y += force(&self.springs[spring], self.unit, &d);
            }
        }
    }
}

/// Where the springs of each of `n` rows start in a list that rises by these rows.
fn starts(n: usize, rows: impl Iterator<Item = u32>) -> Vec<usize> {
    let mut starts = vec![0; n + 1];
    rows.for_each(|row| starts[row as usize + 1] += 1);
    for i in 0..n {
        starts[i + 1] += starts[i];
    }
    starts
}

#[inline(always)]
fn added(a: [f64; 6], b: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|k| a[k] + b[k])
}

#[inline(always)]
fn subtracted(a: [f64; 6], b: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|k| a[k] - b[k])
}

#[inline(always)]
fn add_product(y: &mut Vec3, [xx, xy, xz, yy, yz, zz]: &[f64; 6], x: &Vec3) {
    y.x += xx * x.x + xy * x.y + xz * x.z;
    y.y += xy * x.x + yy * x.y + yz * x.z;
    y.z += xz * x.x + yz * x.y + zz * x.z;
}

/// The product of a spring's block with the difference `d` of its ends.
#[inline(always)]
fn force([wx, wy, wz, a]: &SpringBlock, unit: f64, d: &Vec3) -> Vec3 {
    let along = unit * (wx * d.x + wy * d.y + wz * d.z);
    Vec3::new(a * d.x + wx * along, a * d.y + wy * along, a * d.z + wz * along)
}

struct Product<'a> {
    matrix: &'a Pairs,
    /// The row of `y[0]`.
    first: usize,
    x: &'a [Vec3],
    y: &'a mut [Vec3],
}

impl pulp::WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { matrix, first, x, y } = self;
        let rows = first..first + y.len();
        let own = matrix.own[rows.clone()].iter().zip(&x[rows.clone()]);
        for (y, (own, x)) in y.iter_mut().zip(own) {
            *y = x * *own;
        }
        if !matrix.general.is_empty() {
            let general = matrix.general[rows.clone()].iter().zip(&x[rows.clone()]);
            y.iter_mut().zip(general).for_each(|(y, (block, x))| add_product(y, block, x));
        }
        if first > 0 {
            // Springs from rows before the band.
            for j in first..rows.end.min(first + matrix.reach) {
                for &spring in matrix.incoming(j) {
                    let i = matrix.ends[spring as usize][0] as usize;
                    if i < first {
                        let block = &matrix.springs[spring as usize];
                        y[j - first] -= force(block, matrix.unit, &(x[i] - x[j]));
                    }
                }
            }
        }
        for i in rows {
            let springs = matrix.outgoing(i);
            let others = &matrix.others[springs.clone()];
            let (here, mut sum) = (x[i], y[i - first]);
            for (spring, &other) in matrix.springs[springs].iter().zip(others) {
                let other = other as usize;
                let force = force(spring, matrix.unit, &(here - x[other]));
                sum += force;
                // The other end may belong to a later band.
                if let Some(y) = y.get_mut(other - first) {
                    *y -= force;
                }
            }
            y[i - first] = sum;
        }
    }
}
