//! Smoothed aggregation: the particles of a coarse one, and their weights.

use crate::ScalarMatrix;

/// A coupling is weak below this part of the geometric mean of its two ends' largest couplings.
const STRONG: f64 = 0.25;
/// Weight of the Jacobi step that smooths the prolongation: 4/3 over the bound 2 of `D⁻¹A` of a
/// Laplacian.
const DAMPING: f64 = 2.0 / 3.0;
/// Not in an aggregate yet.
const NONE: u32 = u32::MAX;

/// `P` of a level by rows: `x_i = Σ_I p_iI X_I`, the same for the three coordinates.
#[derive(Clone, Debug)]
pub(super) struct Prolongation {
    starts: Vec<u32>,
    entries: Vec<(u32, f64)>,
    columns: usize,
}

impl Prolongation {
    /// By rows with increasing columns; `columns` is their number.
    fn from_rows(rows: impl Iterator<Item = Vec<(u32, f64)>>, columns: usize) -> Self {
        let (mut starts, mut entries) = (vec![0], Vec::new());
        for mut row in rows {
            row.sort_unstable_by_key(|entry| entry.0);
            entries.extend(row);
            starts.push(entries.len() as u32);
        }
        Self { starts, entries, columns }
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of columns.
    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// The columns and weights of a row.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> &[(u32, f64)] {
        &self.entries[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// `Pᵀ`.
    pub(super) fn transposed(&self) -> Self {
        let mut rows = vec![Vec::new(); self.columns];
        for i in 0..self.rows() {
            for &(column, weight) in self.row(i) {
                rows[column as usize].push((i as u32, weight));
            }
        }
        Self::from_rows(rows.into_iter(), self.rows())
    }

    /// `Pᵀ A P` of a scalar matrix.
    pub(super) fn galerkin(&self, a: &ScalarMatrix) -> ScalarMatrix {
        let mut edges = Vec::new();
        let each = |visit: &mut dyn FnMut(u32, u32, f64)| {
            for i in 0..a.n() {
                let (columns, values) = a.row(i);
                for (&j, value) in columns.iter().zip(values) {
                    for &(row, left) in self.row(i) {
                        for &(column, right) in self.row(j as usize) {
                            visit(row, column, left * value * right);
                        }
                    }
                }
            }
        };
        each(&mut |row, column, _| {
            if row < column {
                edges.push((row as usize, column as usize));
            }
        });
        edges.sort_unstable();
        edges.dedup();
        let mut coarse = ScalarMatrix::with_pattern(self.columns, edges);
        // An edge of weight w also adds w at its two diagonal places: subtract it there.
        each(&mut |row, column, value| {
            if row < column {
                coarse.add_edge(row as usize, column as usize, -value);
                coarse.add_diagonal(row as usize, value);
                coarse.add_diagonal(column as usize, value);
            } else if row == column {
                coarse.add_diagonal(row as usize, value);
            }
        });
        coarse
    }
}

/// A scalar matrix with its strong couplings.
struct Couplings<'a> {
    a: &'a ScalarMatrix,
    /// The largest coupling of each row.
    largest: Vec<f64>,
}

impl<'a> Couplings<'a> {
    fn new(a: &'a ScalarMatrix) -> Self {
        let largest = |i: usize| {
            let (columns, values) = a.row(i);
            let others = columns.iter().zip(values).filter(|(j, _)| **j as usize != i);
            others.fold(0.0, |largest: f64, (_, value)| largest.max(value.abs()))
        };
        Self { a, largest: (0..a.n()).map(largest).collect() }
    }

    /// Strong neighbours of a row.
    fn strong(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (columns, values) = self.a.row(i);
        columns.iter().zip(values).filter_map(move |(&j, &value)| {
            let j = j as usize;
            let mean = (self.largest[i] * self.largest[j]).sqrt();
            (j != i && value != 0.0 && value.abs() >= STRONG * mean).then_some((j, value))
        })
    }
}

/// Aggregates after Vaněk, Mandel, Brezina (1996). Whole neighbourhoods become aggregates; each
/// remaining row joins the aggregate with its strongest coupling, and always has one. Returns the
/// aggregate of each row and their number.
fn aggregates(couplings: &Couplings<'_>) -> (Vec<u32>, usize) {
    let n = couplings.a.n();
    let mut of = vec![NONE; n];
    let mut count = 0;
    for i in 0..n {
        if of[i] == NONE && couplings.strong(i).all(|(j, _)| of[j] == NONE) {
            of[i] = count;
            couplings.strong(i).for_each(|(j, _)| of[j] = count);
            count += 1;
        }
    }
    let whole = of.clone();
    for i in 0..n {
        if of[i] == NONE {
            let strongest = couplings
                .strong(i)
                .filter(|&(j, _)| whole[j] != NONE)
                .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            if let Some((j, _)) = strongest {
                of[i] = whole[j];
            }
        }
    }
    debug_assert!(of.iter().all(|of| *of != NONE), "strong couplings go both ways");
    (of, count as usize)
}

/// `P = (I − ω D⁻¹ Ā) P₀`. `P₀` is 1 where a particle belongs to an aggregate; `Ā` is the matrix
/// with its weak couplings added to the diagonal. Constants are kept.
pub(super) fn smoothed(a: &ScalarMatrix) -> Prolongation {
    let couplings = Couplings::new(a);
    let (of, count) = aggregates(&couplings);
    let rows = (0..a.n()).map(|i| {
        let weight: f64 = couplings.strong(i).map(|(_, value)| -value).sum();
        let factor = if weight > 0.0 { DAMPING / weight } else { 0.0 };
        let mut row = vec![(of[i], 1.0 - factor * weight)];
        for (j, value) in couplings.strong(i) {
            match row.iter_mut().find(|(column, _)| *column == of[j]) {
                Some((_, sum)) => *sum -= factor * value,
                None => row.push((of[j], -factor * value)),
            }
        }
        row
    });
    Prolongation::from_rows(rows, count)
}
