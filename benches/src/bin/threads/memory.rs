//! How fast cores read and write, one alone and all at once.

use drape_benches::triad;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::Barrier;
use std::time::Instant;

/// Sizes of what each thread reads, of which it writes half again: in a second-level cache, in
/// caches that cores share, and in memory.
pub(crate) const SIZES: [(&str, usize); 3] =
    [("0.5 MB", 1 << 19), ("8 MB", 1 << 23), ("256 MB", 1 << 28)];
/// Bytes that a measurement moves.
const MOVED: usize = 3 << 30;
/// Measurements, of which the fastest counts.
const SAMPLES: usize = 5;

/// Bytes a second of one thread alone, and of all together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Speed {
    pub(crate) alone: f64,
    pub(crate) together: f64,
}

/// For each of the [`SIZES`].
pub(crate) fn speeds(threads: NonZero<usize>) -> [Speed; 3] {
    SIZES.map(|(_, bytes)| {
        let fastest =
            |threads| (0..SAMPLES).map(|_| bytes_per_s(threads, bytes)).fold(0.0, f64::max);
        Speed { alone: fastest(1), together: fastest(threads.get()) }
    })
}

/// What so many threads move in a second, each in arrays of its own.
fn bytes_per_s(threads: usize, bytes: usize) -> f64 {
    let start = Barrier::new(threads);
    let thread = || {
        let (a, mut b) = (vec![1.0; bytes / 16], vec![1.0; bytes / 16]);
        triad(&a, &mut b);
        start.wait();
        let passes = MOVED / (24 * a.len());
        let begin = Instant::now();
        (0..passes).for_each(|_| triad(&a, &mut b));
        (24 * a.len() * passes) as f64 / begin.elapsed().as_secs_f64()
    };
    std::thread::scope(|scope| {
        let each: Vec<_> = (0..threads).map(|_| scope.spawn(thread)).collect();
        each.into_iter()
            .map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
            .sum()
    })
}
