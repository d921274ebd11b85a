//! One linear solve with a fixed number of iterations on the mesh of a square sheet, by each kind
//! of kernel. Also the parts of a solve with 3×3 blocks: one product, one update and one
//! application of each preconditioner.

#![allow(missing_docs, reason = "the macro that collects the benches makes undocumented items")]

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use drape_solvers::{
    BlockFactor, BlockJacobi, BlockMatrix, Constraints, Coupling, FactorKind, Filter,
    IncompleteCholesky, Jacobi, LinearOperator, Mat3, Multigrid, Norm, PcgSettings, PcgWorkspace,
    Preconditioner, Reference, ScalarLayout, ScalarMatrix, ScalarPcg, ScalarPreconditioner,
    StartValue, Vec3, filtered_pcg,
};

/// About as many as a step takes.
const ITERATIONS: usize = 10;

/// `M + τ² L_k + τ L_c` at `τ² k = m` and `τ c = 0.4 m`, the stiffness of the bundled sheets.
fn sheet(side: usize) -> ScalarMatrix {
    let right = (0..side * side).filter(|i| i % side + 1 < side).map(|i| (i, i + 1));
    let down = (0..side * (side - 1)).map(|i| (i, i + side));
    let edges: Vec<_> = right.chain(down).collect();
    let mut a = ScalarMatrix::with_pattern(side * side, edges.iter().copied());
    (0..side * side).for_each(|i| a.add_diagonal(i, 1.0));
    edges.iter().for_each(|&(i, j)| a.add_edge(i, j, 1.4));
    a
}

fn solves(criterion: &mut Criterion) {
    let settings =
        PcgSettings { forcing_term: 1e-30, norm: Norm::Euclid, max_iterations: ITERATIONS };
    let reference = Reference::FilteredRightHandSide;
    for side in [20, 52, 100, 316] {
        let a = sheet(side);
        let n = a.n();
        let mut constraints = Constraints::free(n);
        for corner in [0, side - 1] {
            constraints.set(corner, Filter::Fixed, Vec3::zeros());
        }
        let b: Vec<Vec3> = (0..n).map(|i| Vec3::new(i as f64, 1.0, 0.5).map(f64::sin)).collect();
        let (mut jacobi, mut factor) = (Jacobi::new(&a), IncompleteCholesky::new(&a));
        jacobi.update(&a).expect("a positive definite matrix");
        factor.update(&a, None).expect("a positive definite matrix");
        let start = vec![Vec3::zeros(); n];

        let mut group = criterion.benchmark_group(format!("solve/{side}"));
        group.throughput(Throughput::Elements((n * ITERATIONS) as u64));
        let readable: [(_, &dyn Preconditioner); 2] = [("jacobi", &jacobi), ("ic0", &factor)];
        let mut workspace = PcgWorkspace::new(n);
        for (name, p) in readable {
            group.bench_function(format!("{name}/readable"), |bencher| {
                bencher.iter_batched_ref(
                    || start.clone(),
                    |x| {
                        let w = &mut workspace;
                        filtered_pcg(&a, p, &constraints, &b, x, reference, &settings, w)
                    },
                    BatchSize::LargeInput,
                );
            });
        }
        let fast = [
            ("jacobi", ScalarPreconditioner::Jacobi(&jacobi), ScalarLayout::Diagonals),
            ("jacobi", ScalarPreconditioner::Jacobi(&jacobi), ScalarLayout::Rows),
            ("ic0", ScalarPreconditioner::Ic0(&factor), ScalarLayout::Rows),
        ];
        for (name, p, layout) in fast {
            let diagonal = name == "jacobi";
            let mut pcg = ScalarPcg::with_layout(&a, diagonal, layout).expect("a mesh suits both");
            pcg.update(&a, p);
            group.bench_function(format!("{name}/{layout:?}").to_lowercase(), |bencher| {
                bencher.iter_batched_ref(
                    || start.clone(),
                    |x| {
                        pcg.solve(
                            &a,
                            p,
                            &constraints,
                            &b,
                            StartValue::Given,
                            x,
                            reference,
                            &settings,
                        )
                    },
                    BatchSize::LargeInput,
                );
            });
        }
        group.finish();
    }
}

/// The matrix of a Newton iteration at `h² k = 10⁴ m`, on a sheet that is stretched by a twentieth.
fn stiff(side: usize, coupling: &Coupling) -> (BlockMatrix, ScalarMatrix) {
    let springs = [(1, 0, 1.0), (0, 1, 1.0), (1, 1, 0.1), (-1, 1, 0.1), (2, 0, 0.1), (0, 2, 0.1)];
    let side = side as isize;
    let edges: Vec<_> = springs
        .into_iter()
        .flat_map(|(right, down, stiffness)| {
            let is_inside =
                move |i: &isize| (0..side).contains(&(i % side + right)) && i / side + down < side;
            let u = Vec3::new(right as f64, down as f64, 0.0).normalize();
            let from = (0..side * side).filter(is_inside);
            from.map(move |i| (i as usize, (i + down * side + right) as usize, u, stiffness))
        })
        .collect();
    let n = (side * side) as usize;
    let pairs = || edges.iter().map(|&(i, j, _, _)| (i, j));
    let mut a = BlockMatrix::new(n, coupling, pairs());
    let mut springs = ScalarMatrix::with_pattern(n, pairs());
    (0..n).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
    for &(i, j, u, stiffness) in &edges {
        let block = 0.05 * Mat3::identity() + 0.95 * u * u.transpose();
        a.add_pair(i, j, &(1e4 * stiffness * block));
        springs.add_edge(i, j, stiffness);
    }
    (a, springs)
}

fn blocks(criterion: &mut Criterion) {
    for side in [20, 52, 100] {
        let bands = Coupling::Bands(vec![1, 2, side - 1, side, side + 1, 2 * side]);
        for (layout, coupling) in [("blocks", Coupling::Rows), ("bands", bands)] {
            let (a, springs) = stiff(side, &coupling);
            let b: Vec<Vec3> =
                (0..a.n()).map(|i| Vec3::new(i as f64, 1.0, 0.5).map(f64::sin)).collect();
            let mut x = b.clone();
            let fits = "a factor that fits into memory";
            let mut multigrid = Multigrid::new(&a, &springs).expect(fits);
            let mut jacobi = BlockJacobi::new(&a);
            let mut group = criterion.benchmark_group(format!("{layout}/{side}"));
            group.throughput(Throughput::Elements(a.n() as u64));
            group.bench_function("product", |bencher| bencher.iter(|| a.multiply(&b, &mut x)));
            group.bench_function("multigrid/update", |bencher| {
                bencher.iter(|| multigrid.update(&a));
            });
            group.bench_function("multigrid/keep", |bencher| bencher.iter(|| multigrid.keep(&a)));
            group.bench_function("multigrid/apply", |bencher| {
                bencher.iter(|| multigrid.apply(&b, &mut x));
            });
            group.bench_function("jacobi/update", |bencher| bencher.iter(|| jacobi.update(&a)));
            group.bench_function("jacobi/apply", |bencher| {
                bencher.iter(|| jacobi.apply(&b, &mut x));
            });
            if coupling == Coupling::Rows {
                let mut factor = BlockFactor::new(&a, FactorKind::Cholesky).expect(fits);
                group.bench_function("cholesky/update", |bencher| {
                    bencher.iter(|| factor.factorise(&a));
                });
                group.bench_function("cholesky/apply", |bencher| {
                    bencher.iter(|| factor.solve(&b, &mut x));
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, solves, blocks);
criterion_main!(benches);
