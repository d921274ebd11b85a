//! Times the work before the first step: building the system from its specification, and `prepare`.

#![allow(missing_docs, reason = "the macro that collects the benches makes undocumented items")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use drape_benches::{HangingSheet, Mesh, STEP_S};
use drape_harness::methods::Choice;
use drape_integrator::TimeStep;

const SIDES: [u32; 3] = [20, 100, 316];
const METHODS: [&str; 4] = [
    "imex-euler",
    "imex-euler:preconditioner=jacobi",
    "imex-euler:solver=cholesky",
    "baraff-witkin",
];

fn setups(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("setup");
    group.sample_size(10);
    let h = TimeStep::new(STEP_S).expect("a positive step");
    for side in SIDES {
        for mesh in Mesh::ALL {
            let sheet = HangingSheet::new(side, 1e4, mesh).expect("a valid sheet");
            let (system, _) = sheet.spec.build().expect("a valid sheet");
            let name = |what: &str| format!("{side}/{}/{what}", mesh.name());
            group.throughput(Throughput::Elements(system.len() as u64));
            group.bench_function(name("system"), |bencher| bencher.iter(|| sheet.spec.build()));
            for method in METHODS {
                let choice = Choice::parse(method, &[]).expect("a known method");
                group.bench_function(name(method), |bencher| {
                    bencher.iter(|| {
                        let mut integrator = choice.build().expect("checked settings");
                        integrator.prepare(&system, h).expect("a supported scene");
                        integrator
                    });
                });
            }
        }
    }
    group.finish();
}

criterion_group!(benches, setups);
criterion_main!(benches);
