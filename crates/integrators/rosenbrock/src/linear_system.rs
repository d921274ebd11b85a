//! The matrix of a step and its factor.

use crate::settings::JacobianForm;
use drape_integrator::{Implicit, Linearisation, PrepareError, SolveStatus, StepError, StepReport};
use drape_model::{State, System, Tangent, Vec3};
use drape_solvers::vector::{norm, subtract_from};
use drape_solvers::{BlockFactor, BlockMatrix, Constraints, LinearOperator};

/// A solve that leaves more than this part of the right-hand side is refined: a factorisation
/// without exchanges of rows may lose digits.
const REFINED: f64 = 1e-12;
/// A solve that leaves more than this part has failed.
const FAILED: f64 = 1e-8;

/// `A = M + τ² K_n + τ D_n` of all effects with a Jacobian, under the pins.
#[derive(Debug)]
pub(crate) struct LinearSystem {
    form: JacobianForm,
    /// Form of `K` in the matrix of this step.
    tangent: Tangent,
    matrix: BlockMatrix,
    factor: BlockFactor,
    residual: Vec<Vec3>,
    correction: Vec<Vec3>,
}

impl LinearSystem {
    pub(crate) fn new(system: &System, form: JacobianForm) -> Result<Self, PrepareError> {
        let matrix = Implicit::Everything.block_rows(system);
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            form,
            tangent: form.tangent(),
            factor: BlockFactor::new(&matrix, form.factor_kind())?,
            matrix,
            residual: zeros(),
            correction: zeros(),
        })
    }

    /// Sets the matrix up at the start of a step and factorises it. An exact Jacobian without a
    /// factor, because a pivot vanishes, is replaced by the clamped one, and the report says so.
    ///
    /// # Errors
    /// [`StepError::Solver`] when no matrix can be factorised, because it is not finite.
    pub(crate) fn linearise(
        &mut self,
        system: &System,
        state: &State,
        tau: f64,
        constraints: &Constraints,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        report.factorisations += 1;
        let outcome = self.factorise(self.form.tangent(), system, state, tau, constraints);
        if outcome.is_err() && self.form == JacobianForm::Exact {
            report.factorisations += 1;
            report.solve = SolveStatus::Indefinite;
            return self.factorise(Tangent::Projected, system, state, tau, constraints);
        }
        outcome
    }

    fn factorise(
        &mut self,
        tangent: Tangent,
        system: &System,
        state: &State,
        tau: f64,
        constraints: &Constraints,
    ) -> Result<(), StepError> {
        self.tangent = tangent;
        let (implicit, lagged) = (Implicit::Everything, state.level());
        let at = Linearisation { implicit, tau, x: &state.x, lagged, tangent };
        at.assemble(system, &mut self.matrix, None);
        self.matrix.project(constraints);
        Ok(self.factor.factorise(&self.matrix)?)
    }

    /// `out ← K_n w` with the `K_n` of the matrix.
    pub(crate) fn multiply_stiffness(
        &self,
        system: &System,
        x: &[Vec3],
        w: &[Vec3],
        out: &mut [Vec3],
    ) {
        Implicit::Everything.multiply_stiffness(system, x, self.tangent, w, out);
    }

    /// Solves `A u = S b`, and refines `u` once where the factor has lost digits.
    pub(crate) fn solve(
        &mut self,
        constraints: &Constraints,
        b: &mut [Vec3],
        u: &mut [Vec3],
        report: &mut StepReport,
    ) {
        constraints.project(b);
        self.factor.solve(b, u);
        constraints.project(u);
        let mut left = self.residual_of(b, u, report);
        if left > REFINED || left.is_nan() {
            let Self { factor, residual, correction, .. } = self;
            factor.solve(residual, correction);
            constraints.project(correction);
            u.iter_mut().zip(&*correction).for_each(|(u, c)| *u += c);
            left = self.residual_of(b, u, report);
        }
        report.relative_residual = report.relative_residual.max(left);
        if left > FAILED || left.is_nan() {
            report.solve = SolveStatus::Stagnated;
        }
    }

    /// `‖b − A u‖/‖b‖`; the residual stays.
    fn residual_of(&mut self, b: &[Vec3], u: &[Vec3], report: &mut StepReport) -> f64 {
        self.matrix.multiply(u, &mut self.residual);
        subtract_from(b, &mut self.residual);
        report.matvecs += 1;
        let left = norm(&self.residual);
        if left == 0.0 { left } else { left / norm(b) }
    }
}
