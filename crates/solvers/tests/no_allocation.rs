//! After their construction, solvers and factorisations allocate nothing.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

use drape_kernels::testing::mesh_edges;
use drape_solvers::*;

const SIDE: usize = 20;
const N: usize = SIDE * SIDE;

/// Structural and diagonal springs of a square sheet.
fn sheet(side: usize) -> Vec<(usize, usize)> {
    mesh_edges(side, side, &[(0, 1), (1, 0), (1, 1), (1, -1)])
}

fn allocations(work: impl FnOnce()) -> u64 {
    allocation_counter::measure(work).count_total
}

fn fill_scalars(a: &mut ScalarMatrix, edges: &[(usize, usize)]) {
    a.clear();
    for i in 0..N {
        a.add_diagonal(i, 1.0);
    }
    for &(i, j) in edges {
        a.add_edge(i, j, 10.0);
    }
}

fn fill_blocks(a: &mut BlockMatrix, edges: &[(usize, usize)]) {
    a.clear();
    for i in 0..a.n() {
        a.add_diagonal(i, &Mat3::identity());
    }
    for &(i, j) in edges {
        let d = Vec3::new(1.0, i as f64 / 400.0, (j % 7) as f64 / 7.0);
        a.add_pair(i, j, &(d * d.transpose()));
    }
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![0; 10]))), 1);
}

#[test]
fn preconditioned_solves_and_updates_allocate_nothing() {
    let edges = sheet(SIDE);
    let mut a = ScalarMatrix::with_pattern(N, edges.iter().copied());
    let mut jacobi = Jacobi::new(&a);
    let mut incomplete = IncompleteCholesky::new(&a);
    let mut complete = CompleteCholesky::new(&a).unwrap();
    let mut ldlt = CompleteLdlt::new(&a).unwrap();
    let mut dense = DenseInverse::new(&a, usize::MAX).unwrap();
    let mut constraints = Constraints::free(N);
    let mut workspace = PcgWorkspace::new(N);
    let free = vec![true; N];
    let b = vec![Vec3::new(0.0, 1.0, -9.81); N];
    let mut x = vec![Vec3::zeros(); N];
    let settings =
        PcgSettings { forcing_term: 1e-14, norm: Norm::Preconditioned, max_iterations: 1000 };
    let count = allocations(|| {
        fill_scalars(&mut a, &edges);
        jacobi.update(&a).unwrap();
        incomplete.update(&a, Some(&free)).unwrap();
        complete.update(&a, Some(&free)).unwrap();
        ldlt.update(&a, Some(&free)).unwrap();
        ldlt.solve(&b, &mut x);
        dense.update(&a, Some(&free)).unwrap();
        for i in 0..N {
            constraints.set(i, Filter::Fixed, Vec3::x());
        }
        constraints.clear();
        constraints.set(0, Filter::Fixed, Vec3::x());
        constraints.set(7, Filter::Plane { normal: Vec3::z() }, Vec3::z());
        let preconditioners: [&dyn Preconditioner; 5] =
            [&Identity, &jacobi, &incomplete, &complete, &dense];
        for p in preconditioners {
            x.fill(Vec3::zeros());
            let report = filtered_pcg(
                &a,
                p,
                &constraints,
                &b,
                &mut x,
                Reference::FilteredRightHandSide,
                &settings,
                &mut workspace,
            );
            assert!(report.iterations > 0);
        }
        constraint_impulse(&a, &b, &x.clone(), &mut x);
    });
    // The one clone above.
    assert_eq!(count, 1);
}

#[test]
fn fast_solves_and_updates_allocate_nothing() {
    let edges = sheet(SIDE);
    let mut a = ScalarMatrix::with_pattern(N, edges.iter().copied());
    fill_scalars(&mut a, &edges);
    let (mut jacobi, mut factor) = (Jacobi::new(&a), IncompleteCholesky::new(&a));
    jacobi.update(&a).unwrap();
    factor.update(&a, None).unwrap();
    let mut constraints = Constraints::free(N);
    let b = vec![Vec3::new(0.0, 1.0, -9.81); N];
    let mut x = vec![Vec3::zeros(); N];
    let settings = PcgSettings { forcing_term: 1e-14, norm: Norm::Euclid, max_iterations: 1000 };
    let reference = Reference::FilteredRightHandSide;
    for p in [ScalarPreconditioner::Jacobi(&jacobi), ScalarPreconditioner::Ic0(&factor)] {
        let mut pcg = ScalarPcg::new(&a, matches!(p, ScalarPreconditioner::Jacobi(_)));
        let count = allocations(|| {
            for held in [1, N] {
                (0..held).for_each(|i| constraints.set(i, Filter::Fixed, Vec3::x()));
                pcg.update(&a, p);
                x.fill(Vec3::zeros());
                pcg.solve(&a, p, &constraints, &b, StartValue::Given, &mut x, reference, &settings);
                pcg.multiply(&a, &b, &mut x);
                constraints.clear();
            }
        });
        assert_eq!(count, 0);
    }
}

#[test]
fn direct_solves_and_refactorisations_allocate_nothing() {
    // The small sheet is factored column by column, the large one by supernodes.
    for side in [SIDE, 2 * SIDE] {
        let n = side * side;
        let edges = sheet(side);
        let mut a = BlockMatrix::with_pattern(n, edges.iter().copied());
        let mut cholesky = BlockFactor::new(&a, FactorKind::Cholesky).unwrap();
        let mut ldlt = BlockFactor::new(&a, FactorKind::Ldlt).unwrap();
        let mut block_jacobi = BlockJacobi::new(&a);
        let mut couplings = ScalarMatrix::with_pattern(n, edges.iter().copied());
        fill_scalars(&mut couplings, &edges);
        let mut multigrid = Multigrid::new(&a, &couplings).unwrap();
        let mut constraints = Constraints::free(n);
        let direction = Vec3::x();
        constraints.set(3, Filter::Line { direction }, Vec3::zeros());
        let b = vec![Vec3::new(0.0, 1.0, -9.81); n];
        let mut x = vec![Vec3::zeros(); n];
        let mut factor_and_solve = || {
            fill_blocks(&mut a, &edges);
            a.project(&constraints);
            block_jacobi.update(&a).unwrap();
            multigrid.update(&a).unwrap();
            multigrid.apply(&b, &mut x);
            cholesky.factorise(&a).unwrap();
            cholesky.solve(&b, &mut x);
            ldlt.factorise(&a).unwrap();
            ldlt.solve(&b, &mut x);
        };
        let first = allocations(&mut factor_and_solve);
        let second = allocations(&mut factor_and_solve);
        assert_eq!((first, second), (0, 0), "{n} particles");
    }
}

/// Tests run in threads of their own, so no other operator has run in this one.
#[test]
fn the_first_indefinite_factorisation_by_supernodes_allocates_nothing() {
    let n = 4 * N;
    let edges = sheet(2 * SIDE);
    let mut a = BlockMatrix::with_pattern(n, edges.iter().copied());
    fill_blocks(&mut a, &edges);
    a.add_diagonal(7, &(-40.0 * Mat3::identity()));
    let mut ldlt = BlockFactor::new(&a, FactorKind::Ldlt).unwrap();
    let b = vec![Vec3::y(); n];
    let mut x = vec![Vec3::zeros(); n];
    let count = allocations(|| {
        ldlt.factorise(&a).unwrap();
        ldlt.solve(&b, &mut x);
    });
    assert_eq!(count, 0);
    assert!(ldlt.negative_pivots() > Some(0));
}

#[test]
fn the_first_dense_inverse_allocates_nothing_and_a_failed_one_neither() {
    for side in [2, 10, 30] {
        let edges = sheet(side);
        let n = side * side;
        let mut a = ScalarMatrix::with_pattern(n, edges.iter().copied());
        for &(i, j) in &edges {
            a.add_edge(i, j, 10.0);
        }
        for i in 0..n {
            a.add_diagonal(i, 1.0);
        }
        let mut bad = a.clone();
        bad.add_diagonal(n - 1, -1000.0);
        let mut dense = DenseInverse::new(&a, usize::MAX).unwrap();
        let r = vec![Vec3::y(); n];
        let mut z = r.clone();
        let count = allocations(|| {
            dense.update(&a, None).unwrap();
            dense.update(&bad, None).unwrap_err();
            dense.apply(&r, &mut z);
        });
        assert_eq!(count, 0, "{n} rows");
    }
}

#[test]
fn a_dense_inverse_allocates_what_it_says_it_needs() {
    for n in [1, 10, 333] {
        let a = ScalarMatrix::with_pattern(n, []);
        // The first inverse in a thread also lets the library allocate memory that it keeps.
        drop(DenseInverse::new(&a, usize::MAX).unwrap());
        let taken = allocation_counter::measure(|| {
            drop(DenseInverse::new(&a, usize::MAX).unwrap());
        });
        assert_eq!(taken.bytes_total, DenseInverse::bytes_needed(n), "{n} rows");
    }
}

#[test]
fn a_dense_inverse_that_is_too_large_is_refused_before_anything_is_allocated() {
    let n = 1_000_000;
    let a = ScalarMatrix::with_pattern(n, []);
    let limit = 1 << 40;
    let count = allocations(|| {
        let error = DenseInverse::new(&a, limit).unwrap_err();
        let bytes = DenseInverse::bytes_needed(n);
        assert_eq!(error, SolverError::TooLarge { bytes, limit: limit as u64 });
        assert!(bytes > 16_000_000_000_000);
    });
    assert_eq!(count, 0);
}
