//! The operations of conjugate gradients on whole vectors, and their readable form.

use super::{Norm, PcgWorkspace};
use crate::bands::in_bands;
use crate::vector::{axpy, dot, dot_in_bands, norm, scale_add, subtract_from};
use crate::{Constraints, LinearOperator, Preconditioner, Vec3};

/// Results of the start of a solve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StartReport {
    /// Length of `S (b − A (I − S) z)` in the requested norm; NaN if there was no request.
    pub(crate) reference: f64,
    /// Products with the matrix for the reference.
    pub(crate) multiplications: usize,
}

/// The operations of [`conjugate_gradients`](super::conjugate_gradients) on its vectors: the
/// solution `x`, the residual `r`, the direction `c` and `q = S A c`. An implementation may
/// postpone and fuse operations. Every number that it returns, and `x` after
/// [`finish`](Self::finish), has the bits of [`Readable`].
pub(crate) trait Operations {
    /// `x ← S x + (I − S) z`, `r ← S (b − A x)`, and the reference if a norm for it is given.
    fn start(&mut self, reference: Option<Norm>) -> StartReport;

    /// Ends a solve with zero reference: `x ← (I − S) z`, `r ← 0`.
    fn stop_at_prescribed(&mut self);

    /// `√(rᵀr)`.
    fn residual_norm(&mut self) -> f64;

    /// `δ = rᵀ P r`; the next [`direction`](Self::direction) uses this `P r`.
    fn precondition(&mut self) -> f64;

    /// `r ← S (b − A x)`; returns the length of the change.
    fn refresh(&mut self) -> f64;

    /// `c ← S (P r + β c)`, or `S P r` without `β`, and `q ← S A c`; returns `cᵀq`.
    fn direction(&mut self, beta: Option<f64>) -> f64;

    /// Whether the squares of `c` sum to zero.
    fn direction_is_zero(&mut self) -> bool;

    /// `x ← x + α c`, `r ← r − α q`.
    fn advance(&mut self, alpha: f64);

    /// Completes postponed updates of `x`.
    fn finish(&mut self);
}

/// Each operation as a sweep over vectors of [`Vec3`], for any operator and preconditioner. It
/// defines the bits of the fast kernels.
pub(super) struct Readable<'a, A: ?Sized> {
    pub(super) a: &'a A,
    pub(super) p: &'a dyn Preconditioner,
    pub(super) constraints: &'a Constraints,
    pub(super) b: &'a [Vec3],
    pub(super) x: &'a mut [Vec3],
    pub(super) workspace: &'a mut PcgWorkspace,
}

impl<A: LinearOperator + ?Sized> Operations for Readable<'_, A> {
    fn start(&mut self, reference: Option<Norm>) -> StartReport {
        let mut start = StartReport { reference: f64::NAN, multiplications: 0 };
        let bands = self.a.bands();
        let PcgWorkspace { r, c, q, s, sums } = &mut *self.workspace;
        if let Some(wanted) = reference {
            // b̂ = S (b − A (I − S) z), in q.
            if self.constraints.has_prescribed_motion() {
                self.constraints.prescribed_only(c);
                filtered_residual(self.a, self.constraints, self.b, c, q);
                start.multiplications = 1;
            } else {
                q.copy_from_slice(self.b);
                self.constraints.project(q);
            }
            start.reference = match wanted {
                Norm::Euclid => dot_in_bands(bands, q, q, sums).sqrt(),
                Norm::Preconditioned => {
                    self.p.apply_in_bands(bands, q, s);
                    dot_in_bands(bands, q, s, sums).sqrt()
                }
            };
        }
        self.constraints.impose(self.x);
        filtered_residual(self.a, self.constraints, self.b, self.x, r);
        start
    }

    fn stop_at_prescribed(&mut self) {
        self.constraints.prescribed_only(self.x);
        self.workspace.r.fill(Vec3::zeros());
    }

    fn residual_norm(&mut self) -> f64 {
        let PcgWorkspace { r, sums, .. } = &mut *self.workspace;
        dot_in_bands(self.a.bands(), r, r, sums).sqrt()
    }

    fn precondition(&mut self) -> f64 {
        let PcgWorkspace { r, s, sums, .. } = &mut *self.workspace;
        self.p.apply_in_bands(self.a.bands(), r, s);
        dot_in_bands(self.a.bands(), r, s, sums)
    }

    fn refresh(&mut self) -> f64 {
        let PcgWorkspace { r, q, .. } = &mut *self.workspace;
        filtered_residual(self.a, self.constraints, self.b, self.x, q);
        subtract_from(q, r);
        let gap = norm(r);
        r.copy_from_slice(q);
        gap
    }

    fn direction(&mut self, beta: Option<f64>) -> f64 {
        let bands = self.a.bands();
        let PcgWorkspace { c, q, s, sums, .. } = &mut *self.workspace;
        in_bands(bands, c.len(), &mut c[..], &|band, c: &mut [Vec3]| match beta {
            Some(beta) => scale_add(beta, &s[band], c),
            None => c.copy_from_slice(&s[band]),
        });
        self.constraints.project(c);
        self.a.multiply(c, q);
        self.constraints.project(q);
        dot_in_bands(bands, c, q, sums)
    }

    fn direction_is_zero(&mut self) -> bool {
        dot(&self.workspace.c, &self.workspace.c) == 0.0
    }

    fn advance(&mut self, alpha: f64) {
        let PcgWorkspace { r, c, q, .. } = &mut *self.workspace;
        in_bands(self.a.bands(), c.len(), (&mut *self.x, &mut r[..]), &|band, (x, r)| {
            axpy(alpha, &c[band.clone()], x);
            axpy(-alpha, &q[band], r);
        });
    }

    fn finish(&mut self) {}
}

/// `out ← S (b − A x)`, one multiplication.
fn filtered_residual(
    a: &(impl LinearOperator + ?Sized),
    constraints: &Constraints,
    b: &[Vec3],
    x: &[Vec3],
    out: &mut [Vec3],
) {
    a.multiply(x, out);
    subtract_from(b, out);
    constraints.project(out);
}
