//! Local step and global step in turn: the plain iteration.
//!
//! The local step projects each spring on its rest length, `z = ℓ û(x_n + h v^k)`, which gives
//! `F2 = k z`. The global step solves for the velocities:
//!
//! ```text
//! A v^{k+1} = M v̂ − h L_k x_n + h F2(x_n + h v^k)
//! ```
//!
//! Its right-hand side is `A v^k − ∇Φ(v^k)`, so both steps together are
//!
//! ```text
//! f^k = −A⁻¹ S ∇Φ(v^k)            v^{k+1} = v^k + f^k                                  (P3)
//! ```
//!
//! The Hessian of `Φ` never exceeds `A`. So a quadratic with the matrix `A` that touches `Φ` at
//! `v^k` lies above it everywhere, and (P3) is its minimum:
//!
//! ```text
//! Φ(v^{k+1}) ≤ Φ(v^k) − ½ ‖f^k‖²_A                                                     (P4)
//! ```

use super::Iterate;
use drape_model::Vec3;
use drape_solvers::vector::axpy;

impl Iterate<'_> {
    /// `f^k = −A⁻¹ S ∇Φ(v^k)`, (P3).
    pub(super) fn fixed_point_residual(&mut self) -> &[Vec3] {
        self.metric.solve(self.gradient, self.residual, self.report);
        self.residual.iter_mut().for_each(|f| *f = -*f);
        self.residual
    }
}

/// `v^{k+1} = v^k + f^k`, (P3).
#[doc(alias = "Liu et al. 2013")]
#[doc(alias = "Bouaziz et al. 2014")]
#[doc(alias = "local-global")]
pub(super) fn advance(at: &mut Iterate<'_>) {
    at.fixed_point_residual();
    axpy(1.0, at.residual, at.v);
}
