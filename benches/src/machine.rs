//! Measured speeds of the processor and its caches.

use pulp::{Arch, Simd, WithSimd};
use std::hint::black_box;
use std::time::Instant;

/// Speeds of one core on numbers that its second-level cache holds, with its widest registers.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// A square root and a quotient of its result, s.
    pub root_and_quotient_s: f64,
    /// Sums and products, not fused.
    pub flops_per_s: f64,
    /// Bytes read and written by `b ← b + s a`.
    pub bytes_per_s: f64,
}

/// Numbers of an array: two arrays take a third of a second-level cache of 1 MiB.
const LENGTH: usize = 20_480;
/// Numbers that the first-level cache holds.
const SHORT: usize = 1024;
/// Numbers that are multiplied and added side by side. They fill more registers than are needed to
/// hide the latency of both operations.
const CHAINS: usize = 12;
/// Repetitions within a sample.
const PASSES: usize = 200;
/// Samples, of which the shortest counts.
const SAMPLES: usize = 30;

impl Machine {
    /// Measures for some tenths of a second.
    pub fn measure() -> Self {
        let a: Vec<f64> = (0..LENGTH).map(|i| 1.0 + i as f64).collect();
        let mut b = vec![1.0; LENGTH];
        let roots = shortest(|| Arch::new().dispatch(Roots { a: &a[..SHORT], b: &mut b }));
        let sum = shortest(|| triad(&a, &mut b));
        let mut flops = 0;
        let chains = shortest(|| flops = Arch::new().dispatch(Flops));
        Self {
            root_and_quotient_s: roots / SHORT as f64,
            flops_per_s: flops as f64 / chains,
            bytes_per_s: (24 * LENGTH) as f64 / sum,
        }
    }
}

/// The shortest time of a pass, s.
fn shortest(mut pass: impl FnMut()) -> f64 {
    let samples = (0..SAMPLES).map(|_| {
        let begin = Instant::now();
        (0..PASSES).for_each(|_| pass());
        begin.elapsed().as_secs_f64() / PASSES as f64
    });
    samples.fold(f64::INFINITY, f64::min)
}

/// `b ← 1 / √a`.
struct Roots<'a> {
    a: &'a [f64],
    b: &'a mut [f64],
}

impl WithSimd for Roots<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let one = simd.splat_f64s(1.0);
        let (a, b) = (S::as_simd_f64s(self.a).0, S::as_mut_simd_f64s(self.b).0);
        for (b, &a) in b.iter_mut().zip(a) {
            *b = simd.div_f64s(one, simd.sqrt_f64s(a));
        }
        black_box(b);
    }
}

/// `b ← b + s a` with a small `s`: reads both and writes `b`.
pub fn triad(a: &[f64], b: &mut [f64]) {
    Arch::new().dispatch(Triad { a, b });
}

struct Triad<'a> {
    a: &'a [f64],
    b: &'a mut [f64],
}

impl WithSimd for Triad<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let s = simd.splat_f64s(black_box(1e-9));
        let (a, b) = (S::as_simd_f64s(self.a).0, S::as_mut_simd_f64s(self.b).0);
        for (b, &a) in b.iter_mut().zip(a) {
            *b = simd.add_f64s(*b, simd.mul_f64s(s, a));
        }
        black_box(b);
    }
}

/// Products and sums, of which the number is returned.
struct Flops;

impl WithSimd for Flops {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        const LINKS: usize = 256;
        let (factor, term) = (simd.splat_f64s(black_box(0.5)), simd.splat_f64s(black_box(1.0)));
        let mut chains = [simd.splat_f64s(1.0); CHAINS];
        for _ in 0..LINKS {
            for x in &mut chains {
                *x = simd.add_f64s(simd.mul_f64s(*x, factor), term);
            }
        }
        black_box(chains);
        2 * LINKS * CHAINS * S::F64_LANES
    }
}
