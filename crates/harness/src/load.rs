//! A probe that tells whether something else slows this machine down while runs are timed.
//!
//! Other programs on the same processor take no processor time from a thread, but they take its
//! caches, its bandwidth and its clock rate. A fixed loop, timed before and after a run, shows it.

use crate::processor::spent;
use std::hint::black_box;
use std::sync::OnceLock;
use std::time::Instant;

/// Numbers in the larger array, 8 bytes each: more than a core has for itself, less than all share.
const SHARED: usize = 2 << 20;
/// Numbers in the smaller array, which stays next to the core.
const OWN: usize = 2 << 10;

/// The array from which both loops read.
fn numbers() -> &'static [f64] {
    static NUMBERS: OnceLock<Vec<f64>> = OnceLock::new();
    NUMBERS.get_or_init(|| (0..SHARED).map(|n| n as f64).collect())
}

/// Sums in eight independent lanes.
fn sum(values: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    for chunk in values.chunks_exact(lanes.len()) {
        lanes.iter_mut().zip(chunk).for_each(|(lane, value)| *lane += value);
    }
    lanes.iter().sum()
}

/// Reads as many numbers from the shared cache as from the core's own.
fn read() {
    let numbers = black_box(numbers());
    black_box(sum(numbers));
    for _ in 0..SHARED / OWN {
        black_box(sum(black_box(&numbers[..OWN])));
    }
}

/// Seconds of the thread in a fixed loop of a few milliseconds, half of whose reads go beyond the
/// core's own cache. Processor time if the system reports it, else wall time.
pub(crate) fn probe_s() -> f64 {
    // The run before has filled the caches with its own numbers.
    read();
    let (before, begin) = (spent(), Instant::now());
    read();
    let wall = begin.elapsed();
    spent().zip(before).map_or(wall, |(after, before)| after - before).as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lanes_add_up_to_the_sum_of_all_numbers() {
        let all = SHARED as f64;
        assert_eq!(sum(numbers()), all * (all - 1.0) / 2.0);
    }

    #[test]
    fn a_probe_takes_time() {
        assert!(probe_s() > 0.0);
    }
}
