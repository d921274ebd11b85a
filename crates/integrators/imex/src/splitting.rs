//! The error of taking `F2` at an old level, which makes a stiff sheet lock.

use crate::right_hand_side::add_nonlinear_forces;
use drape_integrator::{Implicit, LaplacianSolver, Slopes, StepReport};
use drape_model::{System, Vec3};
use drape_solvers::{Constraints, vector::norm};

/// Estimates the error of a step that took an expected `F2` instead of `F2` at the new positions.
///
/// One more update of the right-hand side (Algorithm 1) would change the velocity by
///
/// ```text
/// δ = A⁻¹ r        r = τ (F2(x_{n+1}) − F2 expected)
/// ```
///
/// `δ` alone cannot see locking: the matrix that locks the sheet makes `δ` as small as the motion.
/// Further updates would add a geometric series with the ratio `1 − 1/q`, where `q = 1 + θ` of the
/// mode at hand, so their sum is `q δ`. `q` is the Rayleigh quotient
///
/// ```text
/// q = δᵀ A δ / δᵀ M δ = rᵀ δ / δᵀ M δ
/// ```
///
/// It is exact where one mode dominates, as in the fall of a locked sheet. The error of the
/// positions is `τ q δ`. Damping in `A` makes it an upper estimate. The part of the error that
/// positions do show is added to it.
#[derive(Debug)]
pub(crate) struct SplittingError {
    /// The force that the step expected, N.
    expected: Vec<Vec3>,
    /// Whether the step split the force; the first step of a method does not.
    is_split: bool,
    residual: Vec<Vec3>,
    change: Vec<Vec3>,
}

/// Relative tolerance of the solve, enough for an estimate.
const ESTIMATE_TOLERANCE: f64 = 0.03;

impl SplittingError {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        Self { expected: zeros(), is_split: false, residual: zeros(), change: zeros() }
    }

    /// Notes `F2` at the old positions, which IMEX Euler takes instead of the new one.
    pub(crate) fn expect(
        &mut self,
        system: &System,
        implicit: Implicit,
        slopes: Option<&Slopes>,
        x: &[Vec3],
    ) {
        self.is_split = true;
        self.expected.fill(Vec3::zeros());
        add_nonlinear_forces(implicit, slopes, system, x, &mut self.expected);
    }

    /// Notes the extrapolation `(1 + ω) F_n − ω F_{n−1}` of a two-step method.
    pub(crate) fn expect_extrapolated(&mut self, omega: f64, now: &[Vec3], old: &[Vec3]) {
        self.is_split = true;
        for ((expected, now), old) in self.expected.iter_mut().zip(now).zip(old) {
            *expected = now + (now - old) * omega;
        }
    }

    /// Notes that the step splits nothing.
    pub(crate) fn expect_nothing(&mut self) {
        self.is_split = false;
    }

    /// Adds `τ q δ` to `error`, m, after a step. `add_force` adds the force at the new level that
    /// the step took at the old one. The constraints are brought to rest.
    #[expect(clippy::too_many_arguments, reason = "each is owned by the step that calls")]
    pub(crate) fn add(
        &mut self,
        system: &System,
        add_force: impl FnOnce(&LaplacianSolver, &mut [Vec3]),
        tau: f64,
        linear: &mut LaplacianSolver,
        constraints: &mut Constraints,
        error: &mut [Vec3],
        report: &mut StepReport,
    ) {
        let Self { expected, residual, change, is_split } = self;
        if !*is_split {
            return;
        }
        residual.fill(Vec3::zeros());
        add_force(linear, residual);
        report.force_evaluations += 1;
        for (r, expected) in residual.iter_mut().zip(expected) {
            *r = (*r - *expected) * tau;
        }
        constraints.project(residual);
        change.fill(Vec3::zeros());
        constraints.bring_to_rest();
        let solve =
            linear.solve_to(constraints, residual, change, ESTIMATE_TOLERANCE * norm(residual));
        report.cg_iterations += solve.iterations as u32;
        report.matvecs += solve.multiplications as u32;
        let (mut work, mut inertia) = (0.0, 0.0);
        for ((r, d), m) in residual.iter().zip(&*change).zip(system.mass()) {
            work += r.dot(d);
            inertia += m * d.norm_squared();
        }
        if inertia > 0.0 {
            let q = work / inertia;
            for (error, d) in error.iter_mut().zip(&*change) {
                *error += d * (tau * q);
            }
        }
    }
}
