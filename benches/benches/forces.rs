//! All forces of the hanging sheet, once, at several sizes and in both orders of particles and
//! springs.

#![allow(missing_docs, reason = "the macro that collects the benches makes undocumented items")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use drape_benches::{Mesh, Prepared};
use drape_model::Vec3;

const SIDES: [u32; 4] = [20, 52, 100, 316];

fn forces(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("forces");
    for side in SIDES {
        for mesh in Mesh::ALL {
            // A sheet in motion: at the start every spring is at rest.
            let Prepared { system, state, .. } = Prepared::on_sheet(side, mesh, "imex-euler", 3);
            let mut out = vec![Vec3::zeros(); system.len()];
            group.throughput(Throughput::Elements(system.len() as u64));
            group.bench_function(format!("{side}/{}", mesh.name()), |bencher| {
                bencher.iter(|| system.forces(state.level(), &mut out));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, forces);
criterion_main!(benches);
