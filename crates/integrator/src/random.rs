//! Pseudo-random numbers, the same on every machine.

/// A linear congruential generator with Knuth's MMIX constants and a fixed seed.
#[derive(Clone, Debug)]
pub(crate) struct Lcg(u64);

impl Lcg {
    pub(crate) fn new() -> Self {
        Self(1)
    }

    /// The upper 31 bits of the next number; the lower ones have short periods.
    pub(crate) fn next_bits(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    /// Uniform in [−1, 1).
    pub(crate) fn signed(&mut self) -> f64 {
        self.next_bits() as f64 / (1_u64 << 30) as f64 - 1.0
    }

    /// Fisher–Yates.
    pub(crate) fn shuffle<T>(&mut self, list: &mut [T]) {
        for last in (1..list.len()).rev() {
            list.swap(last, (self.next_bits() % (last as u64 + 1)) as usize);
        }
    }
}
