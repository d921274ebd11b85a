//! One step of each method on the bundled scenes.
//!
//! Steps are taken one after the other from a warmed-up state, so that the extrapolated start and the
//! contacts are those of a running simulation.

#![allow(missing_docs, reason = "criterion_group!(benches, steps);
criterion_main!(benches);
