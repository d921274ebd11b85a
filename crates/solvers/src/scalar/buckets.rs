//! The constrained particles, sorted by block of particles.

use crate::Constraints;
use crate::vector::BLOCK;

/// The constrained particles of each block of [`BLOCK`] particles.
#[derive(Debug)]
pub(super) struct Buckets {
    /// Particles of block `k` are `particles[starts[k]..starts[k + 1]]`.
    starts: Vec<u32>,
    particles: Vec<u32>,
}

impl Buckets {
    /// Room for the constraints of `n` particles.
    pub(super) fn new(n: usize) -> Self {
        Self { starts: vec![0; n.div_ceil(BLOCK) + 2], particles: Vec::with_capacity(n) }
    }

    /// Sorts the constrained particles, by counting.
    pub(super) fn fill(&mut self, constraints: &Constraints) {
        let constrained = constraints.constrained();
        // `starts[k + 2]` counts block k; then it is the place of the next block's next particle.
        self.starts.fill(0);
        for &i in constrained {
            self.starts[i as usize / BLOCK + 2] += 1;
        }
        for k in 2..self.starts.len() {
            self.starts[k] += self.starts[k - 1];
        }
        self.particles.clear();
        self.particles.resize(constrained.len(), 0);
        for &i in constrained {
            let next = &mut self.starts[i as usize / BLOCK + 1];
            self.particles[*next as usize] = i;
            *next += 1;
        }
    }

    /// The constrained particles of block `k`.
    #[inline(always)]
    pub(super) fn block(&self, k: usize) -> &[u32] {
        &self.particles[self.starts[k] as usize..self.starts[k + 1] as usize]
    }
}
