//! One step of each method on the bundled scenes, and one step of IMEX Euler and of single sweeps
//! on sheets of several sizes. This is the time for which a user waits.

#![allow(missing_docs, reason = "the macro that collects the benches makes undocumented items")]

use criterion::{Criterion, criterion_group, criterion_main};
use drape_benches::{Mesh, Prepared};
use drape_harness::methods;
use std::time::{Duration, Instant};

const SCENE: &str = "hanging-textile-1e4";
/// Beside every method with its defaults on [`SCENE`].
const MORE: [(&str, &str); 3] = [
    (SCENE, "imex-euler:forcing_term=0.05"),
    (SCENE, "imex-euler:solver=cholesky"),
    ("square-table-1e4", "imex-euler"),
];
/// Particles along each edge of the sheets.
const SIDES: [u32; 4] = [20, 52, 100, 316];
const SOLVERS: [&str; 5] = [
    "imex-euler",
    "imex-euler:preconditioner=jacobi",
    "xpbd:substeps=1",
    "xpbd:substeps=1,sweep=coloured",
    "vbd:sweeps=1",
];

/// A run starts again after this many steps, so that the bench times a falling sheet and not one at
/// rest.
const STEPS_A_RUN: u64 = 50;

/// Time of this many steps; `start` begins each run.
fn run(steps: u64, start: impl Fn() -> Prepared) -> Duration {
    let mut time = Duration::ZERO;
    let mut left = steps;
    while left > 0 {
        let mut prepared = start();
        let run = left.min(STEPS_A_RUN);
        let begin = Instant::now();
        (0..run).for_each(|_| prepared.step());
        time += begin.elapsed();
        left -= run;
    }
    time
}

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    let all = methods::all().map(|method| (SCENE, method.id));
    for (scene, method) in all.chain(MORE) {
        // Explicit Euler blows up in time; it is measured from the start.
        let warm_up = if method == "explicit-euler" { 0 } else { 10 };
        group.bench_function(format!("{scene}/{method}"), |bencher| {
            bencher.iter_custom(|steps| run(steps, || Prepared::new(scene, method, warm_up)));
        });
    }
    group.finish();
}

fn sizes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("sheet");
    group.sample_size(10);
    for side in SIDES {
        for mesh in Mesh::ALL {
            for method in SOLVERS {
                let name = format!("{side}/{}/{method}", mesh.name());
                group.bench_function(name, |bencher| {
                    bencher.iter_custom(|steps| {
                        run(steps, || Prepared::on_sheet(side, mesh, method, 10))
                    });
                });
            }
        }
    }
    group.finish();
}

criterion_group!(benches, steps, sizes);
criterion_main!(benches);
