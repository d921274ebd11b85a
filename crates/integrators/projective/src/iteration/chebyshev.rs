//! Chebyshev's semi-iterative method (Wang 2015).
//!
//! On a quadratic, (P3) multiplies the error along each eigenvector by its eigenvalue, between 0
//! and `ρ`. A combination of three iterates replaces the `k`-th power of the eigenvalue by a
//! Chebyshev polynomial, which is smaller for the largest eigenvalues:
//!
//! ```text
//! v^{k+1} = ω_{k+1} (f^k + v^k − v^{k−1}) + v^{k−1}                                    (P5)
//! ω_{k+1} = 1                    k < S
//!         = 2/(2 − ρ²)           k = S
//!         = 4/(4 − ρ² ω_k)       k > S
//! ```
//!
//! `ρ` is a guess, and nothing checks that `Φ` falls. While directions still turn, the problem is
//! no quadratic. So the first `S` = 10 iterations are plain.

use super::Iterate;
use drape_model::Vec3;

/// `S`, the number of plain iterations before the method sets in.
const DELAY: u32 = 10;

#[derive(Debug)]
pub(super) struct Chebyshev {
    rho: f64,
    omega: f64,
    /// `k`.
    count: u32,
    /// `v^{k−1}`, m/s.
    previous: Vec<Vec3>,
}

impl Chebyshev {
    pub(super) fn new(n: usize, rho: f64) -> Self {
        Self { rho, omega: 1.0, count: 0, previous: vec![Vec3::zeros(); n] }
    }

    pub(super) fn begin(&mut self) {
        self.count = 0;
    }

    /// (P5).
    #[doc(alias = "Wang 2015")]
    pub(super) fn advance(&mut self, at: &mut Iterate<'_>) {
        let square = self.rho * self.rho;
        self.omega = match self.count {
            k if k < DELAY => 1.0,
            DELAY => 2.0 / (2.0 - square),
            _ => 4.0 / (4.0 - square * self.omega),
        };
        at.fixed_point_residual();
        for ((v, before), f) in at.v.iter_mut().zip(&mut self.previous).zip(&*at.residual) {
            let next = if self.count < DELAY {
                *v + f
            } else {
                (f + *v - *before) * self.omega + *before // (P5)
            };
            *before = *v;
            *v = next;
        }
        self.count += 1;
    }
}
