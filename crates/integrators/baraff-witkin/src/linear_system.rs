//! The linear system of a step, and what solves it.

use crate::settings::{BaraffWitkinSettings, BlockSolver, Preconditioning};
use drape_integrator::{Implicit, Linearisation, PrepareError, SolveStatus, StepError, StepReport};
use drape_model::{State, System, Tangent, Vec3};
use drape_solvers::{
    BlockCholesky, BlockJacobi, BlockLdlt, BlockMatrix, Constraints, Identity, LinearOperator,
    PcgReport, PcgSettings, PcgWorkspace, Preconditioner, Reference, SolverError,
    constraint_impulse, filtered_pcg,
    vector::{norm, subtract_from},
};

/// `A Δv = b`, Baraff-Witkin (16).
#[derive(Debug)]
pub(crate) struct LinearSystem {
    implicit: Implicit,
    tangent: Tangent,
    /// `A = M − h ∂f/∂v − h² ∂f/∂x`, kg.
    matrix: BlockMatrix,
    /// `b`, kg m/s.
    b: Vec<Vec3>,
    /// `h v_0 + y`, m.
    displacement: Vec<Vec3>,
    force: Vec<Vec3>,
    solver: Solver,
}

#[derive(Debug)]
enum Solver {
    Cg(ConjugateGradients),
    Direct(Box<Direct>),
}

impl LinearSystem {
    /// Memory and symbolic factorisation.
    pub(crate) fn new(
        system: &System,
        settings: &BaraffWitkinSettings,
    ) -> Result<Self, PrepareError> {
        let &BaraffWitkinSettings { implicit, tangent, .. } = settings;
        let matrix = implicit.block_matrix(system);
        let solver = match settings.solver {
            BlockSolver::Cg => Solver::Cg(ConjugateGradients::new(&matrix, settings)),
            BlockSolver::Direct => Solver::Direct(Box::new(Direct::new(&matrix, tangent)?)),
        };
        let zeros = || vec![Vec3::zeros(); system.len()];
        let (b, displacement, force) = (zeros(), zeros(), zeros());
        Ok(Self { implicit, tangent, matrix, b, displacement, force, solver })
    }

    fn at<'a>(&self, state: &'a State, h: f64) -> Linearisation<'a> {
        let (implicit, tangent) = (self.implicit, self.tangent);
        Linearisation { implicit, tau: h, x: &state.x, directions: &state.x, tangent }
    }

    /// `A = M − h ∂f/∂v − h² ∂f/∂x` at the start of the step.
    #[doc(alias = "Baraff-Witkin 15")]
    #[doc(alias = "Baraff-Witkin 16")]
    pub(crate) fn assemble(&mut self, system: &System, state: &State, h: f64) {
        self.at(state, h).assemble(system, &mut self.matrix);
        if let Solver::Cg(cg) = &mut self.solver {
            cg.update(&self.matrix);
        }
    }

    /// `b = h (f_0 + h ∂f/∂x v_0 + ∂f/∂x y)`: one sweep over the springs for the forces, one for the
    /// products with `∂f/∂x`.
    #[doc(alias = "Baraff-Witkin 18")]
    pub(crate) fn set_right_hand_side(
        &mut self,
        system: &System,
        state: &State,
        y: &[Vec3],
        h: f64,
        report: &mut StepReport,
    ) {
        let Self { b, displacement, force, .. } = self;
        for i in 0..b.len() {
            displacement[i] = state.v[i] * h + y[i];
        }
        system.forces(&state.x, &state.v, force);
        self.implicit.multiply_stiffness(system, &state.x, self.tangent, displacement, b);
        for i in 0..b.len() {
            b[i] = (force[i] - b[i]) * h; // Baraff-Witkin (18)
        }
        report.force_evaluations += 1;
        report.matvecs += 1;
    }

    /// Solves for `Δv` under constraints on it, from the prescribed part alone.
    ///
    /// # Errors
    /// [`SolverError`] when the direct solver cannot factorise the matrix.
    pub(crate) fn solve(
        &mut self,
        system: &System,
        state: &State,
        h: f64,
        constraints: &Constraints,
        change: &mut [Vec3],
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        change.fill(Vec3::zeros());
        let at = self.at(state, h);
        let Self { matrix, b, solver, .. } = self;
        match solver {
            Solver::Cg(cg) => *report += cg.solve(matrix, constraints, b, change),
            Solver::Direct(direct) => {
                at.assemble(system, &mut direct.projected);
                *report += direct.solve(matrix, constraints, b, change)?;
                report.factorisations += 1;
            }
        }
        Ok(())
    }

    /// `p = A Δv − b`, the impulse of the constraints, kg m/s: on a contact `p·n > 0` pushes.
    #[doc(alias = "Baraff-Witkin 17")]
    pub(crate) fn constraint_impulse(
        &self,
        change: &[Vec3],
        impulse: &mut [Vec3],
        report: &mut StepReport,
    ) {
        constraint_impulse(&self.matrix, &self.b, change, impulse);
        report.matvecs += 1;
    }
}

/// The modified conjugate gradients of Baraff and Witkin's section 5.
#[derive(Debug)]
struct ConjugateGradients {
    block_jacobi: Option<BlockJacobi>,
    settings: PcgSettings,
    workspace: PcgWorkspace,
}

impl ConjugateGradients {
    fn new(matrix: &BlockMatrix, settings: &BaraffWitkinSettings) -> Self {
        let block_jacobi = match settings.preconditioning {
            Preconditioning::None => None,
            Preconditioning::BlockJacobi => Some(BlockJacobi::new(matrix)),
        };
        let settings = PcgSettings {
            forcing_term: settings.forcing_term,
            norm: settings.norm,
            max_iterations: PcgSettings::default_max(matrix.n()),
        };
        Self { block_jacobi, settings, workspace: PcgWorkspace::new(matrix.n()) }
    }

    /// Where a diagonal block is not positive definite the preconditioner is the identity, and the
    /// iteration finds the direction of negative curvature itself.
    fn update(&mut self, matrix: &BlockMatrix) {
        if let Some(block_jacobi) = &mut self.block_jacobi {
            let _ = block_jacobi.update(matrix);
        }
    }

    fn solve(
        &mut self,
        matrix: &BlockMatrix,
        constraints: &Constraints,
        b: &[Vec3],
        change: &mut [Vec3],
    ) -> PcgReport {
        let preconditioner: &dyn Preconditioner = match &self.block_jacobi {
            Some(block_jacobi) => block_jacobi,
            None => &Identity,
        };
        let (reference, workspace) = (Reference::FilteredRightHandSide, &mut self.workspace);
        let settings = &self.settings;
        filtered_pcg(matrix, preconditioner, constraints, b, change, reference, settings, workspace)
    }
}

/// A factorisation in each step.
#[derive(Debug)]
struct Direct {
    /// `S A S` with something on the rest of the diagonal.
    projected: BlockMatrix,
    factor: Factor,
    residual: Vec<Vec3>,
    correction: Vec<Vec3>,
}

#[derive(Debug)]
enum Factor {
    Cholesky(BlockCholesky),
    Ldlt(BlockLdlt),
}

impl Factor {
    /// Factorises; returns whether the matrix turned out positive definite.
    fn factorise(&mut self, matrix: &BlockMatrix) -> Result<bool, SolverError> {
        match self {
            Self::Cholesky(factor) => factor.factorise(matrix).map(|()| true),
            Self::Ldlt(factor) => {
                factor.factorise(matrix).map(|()| factor.negative_pivots() == Some(0))
            }
        }
    }

    fn solve(&mut self, rhs: &[Vec3], x: &mut [Vec3]) {
        match self {
            Self::Cholesky(factor) => factor.solve(rhs, x),
            Self::Ldlt(factor) => factor.solve(rhs, x),
        }
    }
}

impl Direct {
    fn new(matrix: &BlockMatrix, tangent: Tangent) -> Result<Self, SolverError> {
        let zeros = || vec![Vec3::zeros(); matrix.n()];
        let factor = match tangent {
            Tangent::Projected => Factor::Cholesky(BlockCholesky::new(matrix)?),
            Tangent::Exact => Factor::Ldlt(BlockLdlt::new(matrix)?),
        };
        let projected = matrix.clone();
        Ok(Self { projected, factor, residual: zeros(), correction: zeros() })
    }

    /// Solves with `projected`, which holds `matrix` on entry.
    fn solve(
        &mut self,
        matrix: &BlockMatrix,
        constraints: &Constraints,
        b: &[Vec3],
        change: &mut [Vec3],
    ) -> Result<PcgReport, SolverError> {
        self.projected.project(constraints);
        let is_definite = self.factor.factorise(&self.projected)?;
        constraints.prescribed_only(change);
        let before = self.measure(matrix, constraints, b, change);
        self.factor.solve(&self.residual, &mut self.correction);
        change.iter_mut().zip(&self.correction).for_each(|(change, c)| *change += c);
        let after = self.measure(matrix, constraints, b, change);
        let relative_residual = if after > 0.0 { after / before } else { after };
        let solved = is_definite && relative_residual.is_finite();
        let status = if solved { SolveStatus::Converged } else { SolveStatus::Indefinite };
        Ok(PcgReport { iterations: 0, multiplications: 2, relative_residual, status })
    }

    /// `S (b − A Δv)`, left in `residual`; returns its length.
    fn measure(
        &mut self,
        matrix: &BlockMatrix,
        constraints: &Constraints,
        b: &[Vec3],
        change: &[Vec3],
    ) -> f64 {
        matrix.multiply(change, &mut self.residual);
        subtract_from(b, &mut self.residual);
        constraints.project(&mut self.residual);
        norm(&self.residual)
    }
}
