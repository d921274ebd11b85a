//! One step of each method on the bundled scenes.
//!
//! Steps are taken one after the other from a warmed-up state, so that the extrapolated start and the
//! contacts are those of a running simulation.

#![allow(missing_docs, reason = "criterion_group! makes undocumented items")]

use criterion::{Criterion, criterion_group, criterion_main};
use drape_benches::Prepared;

const CASES: [(&str, &str); 8] = [
    ("hanging-textile-1e4", "explicit-euler"),
    ("hanging-textile-1e4", "symplectic-euler"),
    ("hanging-textile-1e4", "imex-euler"),
    ("hanging-textile-1e4", "imex-euler:forcing_term=0.05"),
    ("hanging-textile-1e4", "imex-euler:solver=cholesky"),
    ("hanging-textile-1e4", "imex-updated"),
    ("hanging-textile-1e4", "backward-euler"),
    ("square-table-1e4", "imex-euler"),
];

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    for (scene, method) in CASES {
        // Explicit Euler blows up in time; it is measured from the start.
        let warm_up = if method == "explicit-euler" { 0 } else { 20 };
        group.bench_function(format!("{scene}/{method}"), |bencher| {
            bencher.iter_batched_ref(
                || Prepared::new(scene, method, warm_up),
                |prepared| (0..STEPS_A_SAMPLE).for_each(|_| prepared.step()),
                criterion::BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

/// A step is short; this many are timed together. Divide the printed time by it.
const STEPS_A_SAMPLE: usize = 10;

criterion_group!(benches, steps);
criterion_main!(benches);
