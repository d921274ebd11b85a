//! Dense counterparts and random problems for the unit tests.

pub(crate) use drape_kernels::testing::Random;
use drape_kernels::testing::mesh_edges;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::ordering::fill_reducing;
use crate::pattern::Pattern;
use crate::sparse_factor::{FactorKind, SparseFactor};
use crate::{BlockMatrix, Constraints, Filter, Mat3, ScalarMatrix, Vec3};

/// Any of the four filters.
pub(crate) fn random_filter(random: &mut Random) -> Filter {
    let direction = random.vector().normalize();
    match (2.0 + 2.0 * random.unit()) as usize {
        0 => Filter::Free,
        1 => Filter::Plane { normal: direction },
        2 => Filter::Line { direction },
        _ => Filter::Fixed,
    }
}

/// A graph with up to `largest` nodes.
pub(crate) fn graph(largest: usize) -> impl Strategy<Value = (usize, Vec<(usize, usize)>)> {
    (1..=largest).prop_flat_map(|n| (Just(n), prop::collection::vec((0..n, 0..n), 0..3 * n)))
}

/// Edges of a `side`×`side` grid.
pub(crate) fn grid_edges(side: usize) -> Vec<(usize, usize)> {
    mesh_edges(side, side, &[(0, 1), (1, 0)])
}

/// `mass` on the diagonal plus a Laplacian with the given weight on each edge.
pub(crate) fn laplacian(
    n: usize,
    edges: &[(usize, usize)],
    mass: f64,
    mut weight: impl FnMut() -> f64,
) -> ScalarMatrix {
    let mut a = ScalarMatrix::with_pattern(n, edges.iter().copied());
    for i in 0..n {
        a.add_diagonal(i, mass);
    }
    for &(i, j) in edges {
        a.add_edge(i, j, weight());
    }
    a
}

/// A positive definite matrix of springs in random directions.
pub(crate) fn random_blocks(
    n: usize,
    edges: &[(usize, usize)],
    random: &mut Random,
) -> BlockMatrix {
    let mut a = BlockMatrix::with_pattern(n, edges.iter().copied());
    for i in 0..n {
        a.add_diagonal(i, &Mat3::identity());
    }
    for &(i, j) in edges {
        let d = random.vector();
        a.add_pair(i, j, &(3.0 * d * d.transpose()));
    }
    a
}

/// A matrix of pushing and pulling springs in random directions, mostly indefinite.
pub(crate) fn indefinite_blocks(
    n: usize,
    edges: &[(usize, usize)],
    random: &mut Random,
) -> BlockMatrix {
    let mut a = BlockMatrix::with_pattern(n, edges.iter().copied());
    for i in 0..n {
        a.add_diagonal(i, &(0.5 * Mat3::identity()));
    }
    for &(i, j) in edges {
        let d = random.vector();
        a.add_pair(i, j, &(random.unit() * Mat3::identity() + d * d.transpose()));
    }
    a
}

pub(crate) fn diagonal(values: &[f64]) -> ScalarMatrix {
    let mut a = ScalarMatrix::with_pattern(values.len(), []);
    for (i, &value) in values.iter().enumerate() {
        a.add_diagonal(i, value);
    }
    a
}

pub(crate) fn dense(a: &ScalarMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(a.n(), a.n(), |i, j| a.get(i, j))
}

pub(crate) fn dense_blocks(a: &BlockMatrix) -> DMatrix<f64> {
    let n = 3 * a.n();
    DMatrix::from_fn(n, n, |i, j| a.get(i / 3, j / 3)[(i % 3, j % 3)])
}

pub(crate) fn dense_filter(constraints: &Constraints) -> DMatrix<f64> {
    let n = 3 * constraints.len();
    DMatrix::from_fn(n, n, |i, j| {
        if i / 3 == j / 3 { constraints.filter(i / 3).matrix()[(i % 3, j % 3)] } else { 0.0 }
    })
}

pub(crate) fn flat(x: &[Vec3]) -> DVector<f64> {
    DVector::from_iterator(3 * x.len(), x.iter().flat_map(|v| [v.x, v.y, v.z]))
}

/// Number of negative eigenvalues of a symmetric matrix. `None` if some are so small a part of the
/// largest that their sign is not certain.
pub(crate) fn negative_eigenvalues(a: DMatrix<f64>, certain: f64) -> Option<usize> {
    let eigenvalues = a.symmetric_eigenvalues();
    (eigenvalues.amin() > certain * eigenvalues.amax())
        .then(|| eigenvalues.iter().filter(|&&value| value < 0.0).count())
}

/// A factorisation by supernodes of the pattern of a graph.
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
pub(crate) fn supernodal_factor(n: usize, edges: &[(usize, usize)]) -> SparseFactor {
    let pattern = Pattern::new(n, edges.iter().copied());
    let (mut starts, mut rows) = (vec![0], Vec::new());
    for j in 0..n {
        rows.extend_from_slice(&pattern.columns()[pattern.lower(j)]);
        rows.push(j as u32);
        starts.push(rows.len() as u32);
    }
    let order = fill_reducing(&pattern).unwrap();
    SparseFactor::new(FactorKind::Cholesky, starts, rows, &order).unwrap()
}
