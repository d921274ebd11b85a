//! One step of each method on the bundled scenes: what a user waits for.

#![allow(missing_docs, reason = "the macro that collects the benches makes undocumented items")]

use criterion::{Criterion, criterion_group, criterion_main};
use drape_benches::Prepared;
use std::time::{Duration, Instant};

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

/// A run is begun anew after this many steps, so that what is timed is a falling sheet and not one at
/// rest.
const STEPS_A_RUN: u64 = 50;

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    for (scene, method) in CASES {
        // Explicit Euler blows up in time; it is measured from the start.
        let warm_up = if method == "explicit-euler" { 0 } else { 10 };
        group.bench_function(format!("{scene}/{method}"), |bencher| {
            bencher.iter_custom(|steps| {
                let mut time = Duration::ZERO;
                let mut left = steps;
                while left > 0 {
                    let mut prepared = Prepared::new(scene, method, warm_up);
                    let run = left.min(STEPS_A_RUN);
                    let begin = Instant::now();
                    (0..run).for_each(|_| prepared.step());
                    time += begin.elapsed();
                    left -= run;
                }
                time
            });
        });
    }
    group.finish();
}

criterion_group!(benches, steps);
criterion_main!(benches);
