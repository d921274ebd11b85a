//! After their construction, solvers and factorisations allocate nothing.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

use drape_solvers::*;

const SIDE: usize = 20;
const N: usize = SIDE * SIDE;

/// Structural and diagonal springs of a square sheet.
fn sheet(side: usize) -> Vec<(usize, usize)> {
    let mut edges = Vec::new();
    for i in 0..side * side {
        let (row, column) = (i / side, i % side);
        if column + 1 < side {
            edges.push((i, i + 1));
        }
        if row + 1 < side {
            edges.push((i, i + side));
            if column + 1 < side {
                edges.push((i, i + side + 1));
                edges.push((i + 1, i + side));
            }
        }
    }
    edges
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
        for i in 0..N {
            constraints.set(i, Filter::Fixed, Vec3::x());
        }
        constraints.clear();
        constraints.set(0, Filter::Fixed, Vec3::x());
        constraints.set(7, Filter::Plane { normal: Vec3::z() }, Vec3::z());
        let preconditioners: [&dyn Preconditioner; 4] =
            [&Identity, &jacobi, &incomplete, &complete];
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
fn direct_solves_and_refactorisations_allocate_nothing() {
    // The small sheet is factored column by column, the large one by supernodes.
    for side in [SIDE, 2 * SIDE] {
        let n = side * side;
        let edges = sheet(side);
        let mut a = BlockMatrix::with_pattern(n, edges.iter().copied());
        let mut cholesky = BlockCholesky::new(&a).unwrap();
        let mut block_jacobi = BlockJacobi::new(&a);
        let mut constraints = Constraints::free(n);
        let direction = Vec3::x();
        constraints.set(3, Filter::Line { direction }, Vec3::zeros());
        let b = vec![Vec3::new(0.0, 1.0, -9.81); n];
        let mut x = vec![Vec3::zeros(); n];
        let mut factor_and_solve = || {
            fill_blocks(&mut a, &edges);
            a.project(&constraints);
            block_jacobi.update(&a).unwrap();
            cholesky.factorise(&a).unwrap();
            cholesky.solve(&b, &mut x);
        };
        let first = allocations(&mut factor_and_solve);
        let second = allocations(&mut factor_and_solve);
        assert_eq!((first, second), (0, 0), "{n} particles");
    }
}
