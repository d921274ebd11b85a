//! Properties of all preconditioners of a scalar matrix.

use super::*;
use crate::test_support::{Random, dense, diagonal, flat, graph, grid_edges, laplacian};
use crate::{LinearOperator, ScalarMatrix, SolverError};
use proptest::prelude::*;

/// A preconditioner behind one interface.
trait Update: Preconditioner {
    fn update(&mut self, a: &ScalarMatrix, free: Option<&[bool]>) -> Result<(), SolverError>;
}

macro_rules! update {
    ($($name:ident, |$p:ident, $a:ident, $free:ident| $call:expr;)*) => {
        $(impl Update for $name {
            fn update(&mut self, $a: &ScalarMatrix, $free: Option<&[bool]>) -> Result<(), SolverError> {
                let $p = self;
                $call
            }
        })*
    };
}

update! {
    Jacobi, |p, a, _free| p.update(a);
    IncompleteCholesky, |p, a, free| p.update(a, free);
    CompleteCholesky, |p, a, free| p.update(a, free);
    DenseInverse, |p, a, free| p.update(a, free);
}

/// Made for a matrix, in the state of the identity.
struct Row {
    name: &'static str,
    new: fn(&ScalarMatrix) -> Box<dyn Update>,
    /// Whether it is the inverse up to round-off.
    is_inverse: bool,
    /// Whether it reads couplings, so that other couplings are another pattern.
    reads_couplings: bool,
    /// Whether its error holds the pivot.
    tells_pivot: bool,
}

const TABLE: [Row; 4] = [
    Row {
        name: "Jacobi",
        new: |a| Box::new(Jacobi::new(a)),
        is_inverse: false,
        reads_couplings: false,
        tells_pivot: true,
    },
    Row {
        name: "IncompleteCholesky",
        new: |a| Box::new(IncompleteCholesky::new(a)),
        is_inverse: false,
        reads_couplings: true,
        tells_pivot: true,
    },
    Row {
        name: "CompleteCholesky",
        new: |a| Box::new(CompleteCholesky::new(a).unwrap()),
        is_inverse: true,
        reads_couplings: true,
        tells_pivot: false,
    },
    Row {
        name: "DenseInverse",
        new: |a| Box::new(DenseInverse::new(a, usize::MAX).unwrap()),
        is_inverse: true,
        reads_couplings: false,
        tells_pivot: false,
    },
];

fn apply(p: &dyn Update, r: &[Vec3]) -> Vec<Vec3> {
    let mut z = vec![Vec3::repeat(f64::NAN); r.len()];
    p.apply(r, &mut z);
    z
}

proptest! {
    #[test]
    fn an_inverse_undoes_the_product((n, edges) in graph(20)) {
        let mut random = Random::new(14);
        let a = laplacian(n, &edges, 0.3, || random.unit().abs());
        for row in TABLE.iter().filter(|row| row.is_inverse) {
            let mut p = (row.new)(&a);
            p.update(&a, None).unwrap();
            let x = random.vectors(n);
            let mut b = x.clone();
            a.multiply(&x, &mut b);
            prop_assert!((flat(&apply(&*p, &b)) - flat(&x)).norm() < 1e-11, "{}", row.name);
        }
    }

    /// Compares with the matrix without the couplings of the pinned rows.
    #[test]
    fn pinned_rows_keep_their_diagonal_alone((n, edges) in graph(20)) {
        let mut random = Random::new(15);
        let a = laplacian(n, &edges, 0.3, || 0.5 + random.unit().abs());
        let free: Vec<bool> = (0..n).map(|i| i % 3 != 1).collect();
        let r = random.vectors(n);
        let is_kept = |&&(i, j): &&(usize, usize)| i != j && free[i] && free[j];
        let mut reduced = ScalarMatrix::with_pattern(n, edges.iter().copied());
        for &(i, j) in edges.iter().filter(is_kept) {
            if reduced.get(i, j) == 0.0 {
                reduced.add_edge(i, j, -a.get(i, j));
            }
        }
        (0..n).for_each(|i| reduced.add_diagonal(i, a.diagonal(i) - reduced.diagonal(i)));
        let kept = dense(&reduced);
        for i in 0..n {
            for j in 0..n {
                let expected = if i == j || free[i] && free[j] { a.get(i, j) } else { 0.0 };
                prop_assert!((kept[(i, j)] - expected).abs() < 1e-13);
            }
        }
        for row in TABLE {
            let [mut masked, mut own] = [&a, &reduced].map(row.new);
            masked.update(&a, Some(&free)).unwrap();
            own.update(&reduced, None).unwrap();
            let [masked, own] = [masked, own].map(|p| flat(&apply(&*p, &r)));
            prop_assert!((masked - own).norm() < 1e-11 * flat(&r).norm(), "{}", row.name);
            let mut p = (row.new)(&a);
            p.update(&a, Some(&free)).unwrap();
            for i in (0..n).filter(|&i| !free[i]) {
                let mut impulse = vec![Vec3::zeros(); n];
                impulse[i] = Vec3::x();
                let mut z = apply(&*p, &impulse);
                prop_assert!((z[i].x * a.diagonal(i) - 1.0).abs() < 1e-14, "{}", row.name);
                z[i] = Vec3::zeros();
                prop_assert_eq!(z, vec![Vec3::zeros(); n], "{}", row.name);
            }
        }
    }
}

#[test]
fn a_failed_update_names_the_row_and_leaves_the_identity_and_the_next_one_succeeds() {
    let good = laplacian(9, &grid_edges(3), 1.0, || 1.0);
    let r = Random::new(16).vectors(9);
    for row in TABLE {
        let mut p = (row.new)(&good);
        assert_eq!(apply(&*p, &r), r, "{}", row.name);
        p.update(&good, None).unwrap();
        let before = apply(&*p, &r);
        assert_ne!(before, r);
        for bad in [-100.0, f64::NAN, f64::INFINITY] {
            let mut a = good.clone();
            a.add_diagonal(0, bad);
            let error = p.update(&a, None).unwrap_err();
            let SolverError::NotPositiveDefinite { row: at, pivot } = error else {
                panic!("{}: {error:?}", row.name);
            };
            assert_eq!((at, pivot.is_some()), (0, row.tells_pivot || !bad.is_finite()));
            assert_eq!(apply(&*p, &r), r, "{}, {bad}", row.name);
        }
        p.update(&good, None).unwrap();
        assert_eq!(apply(&*p, &r), before, "{}", row.name);
    }
}

#[test]
fn the_row_that_is_not_positive_is_named() {
    for (row, at) in TABLE.iter().flat_map(|row| [0, 1, 70, 199].map(|at| (row, at))) {
        for bad in [0.0, -1.0] {
            let mut values = [1.0; 200];
            values[at] = bad;
            let a = diagonal(&values);
            let pivot = row.tells_pivot.then_some(bad);
            let expected = SolverError::NotPositiveDefinite { row: at, pivot };
            assert_eq!((row.new)(&a).update(&a, None), Err(expected), "{}", row.name);
        }
    }
}

#[test]
fn another_pattern_is_refused_and_the_factor_stays() {
    let a = laplacian(3, &[(0, 1)], 1.0, || 1.0);
    let r = Random::new(17).vectors(3);
    for row in TABLE {
        let mut p = (row.new)(&a);
        p.update(&a, None).unwrap();
        let before = apply(&*p, &r);
        let others = [laplacian(4, &[(0, 1)], 1.0, || 1.0), laplacian(3, &[(0, 2)], 1.0, || 1.0)];
        for other in &others[..if row.reads_couplings { 2 } else { 1 }] {
            let error = p.update(other, None).unwrap_err();
            assert!(matches!(error, SolverError::PatternChanged { .. }), "{}", row.name);
            assert_eq!(apply(&*p, &r), before, "{}", row.name);
        }
    }
}
