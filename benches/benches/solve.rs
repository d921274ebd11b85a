//! One linear solve of a fixed number of iterations on the mesh of a square sheet, by each kind of kernels.

#![allow(missing_docs, reason = "the macro that collects the benches makes undocumented items")]

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use drape_solvers::{
    Constraints, Filter, IncompleteCholesky, Jacobi, Norm, PcgSettings, PcgWorkspace,
    Preconditioner, Reference, ScalarLayout, ScalarMatrix, ScalarPcg, ScalarPreconditioner, Vec3,
    filtered_pcg,
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
                    |x| pcg.solve(&a, p, &constraints, &b, x, reference, &settings),
                    BatchSize::LargeInput,
                );
            });
        }
        group.finish();
    }
}

criterion_group!(benches, solves);
criterion_main!(benches);
