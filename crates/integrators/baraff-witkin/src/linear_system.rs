//! The linear system of a step, and its solvers.

use crate::settings::{BaraffWitkinSettings, BlockSolver, FirstChange, Preconditioning};
use drape_integrator::{
    Implicit, Linearisation, PrepareError, SolveStatus, StepError, StepReport, lightest_free_mass,
};
use drape_model::{Part, Revisions, State, StiffnessProduct, System, Tangent, Vec3};
use drape_solvers::{
    BlockFactor, BlockJacobi, BlockMatrix, Constraints, FactorKind, Identity, LinearOperator, Norm,
    PcgReport, PcgSettings, PcgWorkspace, Preconditioner, Reference, SolverError,
    bands::{bands, in_bands},
    constraint_impulse, filtered_pcg,
    vector::{dot, norm, subtract_from},
};

/// `A Δv = b`, Baraff-Witkin (16).
#[derive(Debug)]
pub(crate) struct LinearSystem {
    implicit: Implicit,
    tangent: Tangent,
    /// `b`, kg m/s.
    b: Vec<Vec3>,
    /// `h v_0 + y`, m.
    displacement: Vec<Vec3>,
    force: Vec<Vec3>,
    starts_at_last: bool,
    solver: Solver,
}

/// The matrix and its solver.
#[derive(Debug)]
enum Solver {
    Cg(Box<ConjugateGradients>),
    Direct(Box<Direct>),
}

impl Solver {
    fn matrix(&self) -> &BlockMatrix {
        match self {
            Self::Cg(cg) => &cg.matrix,
            Self::Direct(direct) => &direct.matrix,
        }
    }

    fn matrix_mut(&mut self) -> &mut BlockMatrix {
        match self {
            Self::Cg(cg) => &mut cg.matrix,
            Self::Direct(direct) => &mut direct.matrix,
        }
    }
}

impl LinearSystem {
    /// Memory and symbolic factorisation.
    pub(crate) fn new(
        system: &System,
        settings: &BaraffWitkinSettings,
    ) -> Result<Self, PrepareError> {
        let (implicit, tangent) = (settings.implicit, settings.tangent());
        let solver = match settings.solver {
            BlockSolver::Cg => Solver::Cg(Box::new(ConjugateGradients::new(system, settings))),
            BlockSolver::Direct => {
                Solver::Direct(Box::new(Direct::new(implicit.block_rows(system), tangent)?))
            }
        };
        let zeros = || vec![Vec3::zeros(); system.len()];
        let (b, displacement, force) = (zeros(), zeros(), zeros());
        let starts_at_last = settings.start == FirstChange::Last;
        Ok(Self { implicit, tangent, b, displacement, force, starts_at_last, solver })
    }

    fn at<'a>(&self, state: &'a State, h: f64) -> Linearisation<'a> {
        let (implicit, tangent) = (self.implicit, self.tangent);
        Linearisation { implicit, tau: h, x: &state.x, lagged: state.level(), tangent }
    }

    /// `A = M − h ∂f/∂v − h² ∂f/∂x` at the start of the step. The same sweep over the springs gives
    /// `−∂f/∂x (h v_0 + y)` for the right-hand side.
    #[doc(alias = "Baraff-Witkin 15")]
    #[doc(alias = "Baraff-Witkin 16")]
    pub(crate) fn linearise(&mut self, system: &System, state: &State, y: &[Vec3], h: f64) {
        let at = self.at(state, h);
        let Self { b, displacement, solver, .. } = self;
        let bands = bands(system.threads(), y.len());
        in_bands(bands, y.len(), &mut displacement[..], &|band, displacement: &mut [Vec3]| {
            for ((d, v), y) in displacement.iter_mut().zip(&state.v[band.clone()]).zip(&y[band]) {
                *d = v * h + y;
            }
        });
        let product = StiffnessProduct { w: displacement, out: b };
        at.assemble(system, solver.matrix_mut(), Some(product));
        if let Solver::Cg(cg) = solver {
            cg.update(system);
        }
    }

    /// `b = h (f_0 + h ∂f/∂x v_0 + ∂f/∂x y)`; [`linearise`](Self::linearise) has already computed
    /// all terms but the forces.
    #[doc(alias = "Baraff-Witkin 18")]
    pub(crate) fn set_right_hand_side(
        &mut self,
        system: &System,
        state: &State,
        h: f64,
        report: &mut StepReport,
    ) {
        let Self { b, force, .. } = self;
        let terms = system.effects().map(|effect| (effect, Part::All));
        system.write_forces_and(terms, state.level(), force, &|particles, force| {
            for (force, b) in force.iter_mut().zip(&b[particles]) {
                *force = (*force - b) * h; // Baraff-Witkin (18)
            }
        });
        std::mem::swap(b, force);
        report.force_evaluations += 1;
        report.matvecs += 1;
    }

    /// Solves for `Δv` under constraints on it. Conjugate gradients start from the prescribed part
    /// alone, or from `change`.
    ///
    /// # Errors
    /// [`SolverError`] when the direct solver cannot factorise the matrix.
    pub(crate) fn solve(
        &mut self,
        constraints: &Constraints,
        change: &mut [Vec3],
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        if !self.starts_at_last {
            change.fill(Vec3::zeros());
        }
        let b = &self.b;
        match &mut self.solver {
            Solver::Cg(cg) => *report += cg.solve(constraints, b, change),
            Solver::Direct(direct) => {
                *report += direct.solve(constraints, b, change)?;
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
        constraint_impulse(self.solver.matrix(), &self.b, change, impulse);
        report.matvecs += 1;
    }
}

/// The modified conjugate gradients of Baraff and Witkin's section 5.
#[derive(Debug)]
struct ConjugateGradients {
    matrix: BlockMatrix,
    block_jacobi: Option<BlockJacobi>,
    settings: PcgSettings,
    workspace: PcgWorkspace,
    mass: MassScale,
}

impl ConjugateGradients {
    fn new(system: &System, settings: &BaraffWitkinSettings) -> Self {
        let n = system.len();
        let matrix = settings.implicit.block_matrix(system);
        let block_jacobi = match settings.preconditioner {
            Preconditioning::None => None,
            Preconditioning::BlockJacobi => Some(BlockJacobi::identity(n)),
        };
        let settings = PcgSettings {
            forcing_term: settings.forcing_term,
            norm: settings.norm,
            max_iterations: PcgSettings::default_max(n),
        };
        let workspace = PcgWorkspace::new(n);
        Self { matrix, block_jacobi, settings, workspace, mass: MassScale::new(n) }
    }

    /// Updates the preconditioner. It is the identity where a diagonal block is not positive
    /// definite; the iteration then finds the direction of negative curvature itself.
    fn update(&mut self, system: &System) {
        self.mass.update(system);
        if let Some(block_jacobi) = &mut self.block_jacobi {
            let _ = block_jacobi.update(&self.matrix);
        }
    }

    fn solve(&mut self, constraints: &Constraints, b: &[Vec3], change: &mut [Vec3]) -> PcgReport {
        let Self { matrix, block_jacobi, settings, workspace, mass } = self;
        let preconditioner: &dyn Preconditioner = match block_jacobi {
            Some(block_jacobi) => block_jacobi,
            None => &Identity,
        };
        let scale = mass.scale(constraints, preconditioner, settings.norm, b);
        let forcing_term = settings.forcing_term * scale.map_or(1.0, |scale| scale.factor);
        let reference = Reference::FilteredRightHandSide;
        let mut report = filtered_pcg(
            &*matrix,
            preconditioner,
            constraints,
            b,
            change,
            reference,
            &PcgSettings { forcing_term, ..*settings },
            workspace,
        );
        if let Some(Scale { lightest, .. }) = scale
            && report.status == SolveStatus::Stagnated
        {
            // Only rows of heavy particles may be left, at their round-off.
            let residual = mass.weigh(preconditioner, settings.norm, workspace.residual());
            if residual <= settings.forcing_term * lightest {
                report.status = SolveStatus::Converged;
            }
        }
        report
    }
}

/// How much smaller the right-hand side is where every particle counts by the lightest free mass,
/// `m_min M⁻¹ b`. Measured against `b` itself a heavy particle would hide the residuals of the
/// light ones.
#[derive(Debug)]
struct MassScale {
    /// `m_min/m_i`; empty where all free masses are equal.
    ratio: Vec<f64>,
    scaled: Vec<Vec3>,
    product: Vec<Vec3>,
    revisions: Option<Revisions>,
    is_uneven: bool,
}

impl MassScale {
    fn new(n: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        let (scaled, product) = (zeros(), zeros());
        Self { ratio: vec![1.0; n], scaled, product, revisions: None, is_uneven: false }
    }

    fn update(&mut self, system: &System) {
        let now = system.revisions();
        if self.revisions.replace(now) == Some(now) {
            return;
        }
        let lightest = lightest_free_mass(system);
        self.is_uneven = false;
        for (i, (ratio, m)) in self.ratio.iter_mut().zip(system.mass()).enumerate() {
            *ratio = lightest / m;
            self.is_uneven |= !system.pinned()[i] && *ratio != 1.0;
        }
    }

    /// The scale of `b` in a norm; `None` where all free masses are equal, or `b` is 0.
    fn scale(
        &mut self,
        constraints: &Constraints,
        preconditioner: &dyn Preconditioner,
        of: Norm,
        b: &[Vec3],
    ) -> Option<Scale> {
        if !self.is_uneven {
            return None;
        }
        self.scaled.copy_from_slice(b);
        constraints.project(&mut self.scaled);
        let all = length(preconditioner, of, &self.scaled, &mut self.product);
        self.scaled.iter_mut().zip(&self.ratio).for_each(|(b, ratio)| *b *= *ratio);
        let lightest = length(preconditioner, of, &self.scaled, &mut self.product);
        (all > 0.0 && lightest.is_finite()).then_some(Scale { factor: lightest / all, lightest })
    }

    /// `|m_min M⁻¹ r|` of a filtered residual in a norm.
    fn weigh(&mut self, preconditioner: &dyn Preconditioner, of: Norm, r: &[Vec3]) -> f64 {
        for ((scaled, r), ratio) in self.scaled.iter_mut().zip(r).zip(&self.ratio) {
            *scaled = r * *ratio;
        }
        length(preconditioner, of, &self.scaled, &mut self.product)
    }
}

/// A right-hand side in which every particle counts by the lightest free mass.
#[derive(Clone, Copy, Debug)]
struct Scale {
    /// `|m_min M⁻¹ S b|` over `|S b|`.
    factor: f64,
    /// `|m_min M⁻¹ S b|`.
    lightest: f64,
}

/// The length of `a` in a norm; `product` is scratch.
fn length(preconditioner: &dyn Preconditioner, of: Norm, a: &[Vec3], product: &mut [Vec3]) -> f64 {
    match of {
        Norm::Euclid => norm(a),
        Norm::Preconditioned => {
            preconditioner.apply(a, product);
            dot(a, product).sqrt()
        }
    }
}

/// A factorisation in each step.
#[derive(Debug)]
struct Direct {
    matrix: BlockMatrix,
    /// `S A S`, with positive numbers on the constrained part of the diagonal.
    projected: BlockMatrix,
    factor: BlockFactor,
    residual: Vec<Vec3>,
    correction: Vec<Vec3>,
}

impl Direct {
    fn new(matrix: BlockMatrix, tangent: Tangent) -> Result<Self, SolverError> {
        let zeros = || vec![Vec3::zeros(); matrix.n()];
        let kind = match tangent {
            Tangent::Projected => FactorKind::Cholesky,
            Tangent::Exact => FactorKind::Ldlt,
        };
        let factor = BlockFactor::new(&matrix, kind)?;
        let (projected, residual, correction) = (matrix.clone(), zeros(), zeros());
        Ok(Self { matrix, projected, factor, residual, correction })
    }

    fn solve(
        &mut self,
        constraints: &Constraints,
        b: &[Vec3],
        change: &mut [Vec3],
    ) -> Result<PcgReport, SolverError> {
        self.projected.copy_from(&self.matrix);
        self.projected.project(constraints);
        self.factor.factorise(&self.projected)?;
        let is_definite = self.factor.negative_pivots() == Some(0);
        constraints.prescribed_only(change);
        let before = self.measure(constraints, b, change);
        self.factor.solve(&self.residual, &mut self.correction);
        change.iter_mut().zip(&self.correction).for_each(|(change, c)| *change += c);
        let after = self.measure(constraints, b, change);
        let relative_residual = if after > 0.0 { after / before } else { after };
        let solved = is_definite && relative_residual.is_finite();
        let status = if solved { SolveStatus::Converged } else { SolveStatus::Indefinite };
        Ok(PcgReport { iterations: 0, multiplications: 2, relative_residual, status })
    }

    /// `S (b − A Δv)`, left in `residual`; returns its length.
    fn measure(&mut self, constraints: &Constraints, b: &[Vec3], change: &[Vec3]) -> f64 {
        self.matrix.multiply(change, &mut self.residual);
        subtract_from(b, &mut self.residual);
        constraints.project(&mut self.residual);
        norm(&self.residual)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::rough_sheet;
    use drape_kernels::testing::assert_same_bits;
    use drape_model::{DampingLaw, SystemSpec};
    use drape_oracle::scenes::{Sheet, build, stir};
    use drape_solvers::Coupling;

    /// The product with the velocities, and `K w` of the right-hand side.
    fn numbers(
        matrix: &mut BlockMatrix,
        (system, state): &(System, State),
        tangent: Tangent,
    ) -> [Vec<Vec3>; 2] {
        let (implicit, lagged) = (Implicit::Springs, state.level());
        let at = Linearisation { implicit, tau: 0.02, x: &state.x, lagged, tangent };
        let [mut stiffness, mut product] = [(); 2].map(|()| vec![Vec3::x(); state.len()]);
        for _ in 0..2 {
            let wanted = StiffnessProduct { w: &state.v, out: &mut stiffness };
            at.assemble(system, matrix, Some(wanted));
        }
        matrix.multiply(&state.v, &mut product);
        [product, stiffness]
    }

    fn in_disorder(side: usize) -> SystemSpec {
        let mut spec = rough_sheet(side, 1e4, 0.3, DampingLaw::Full);
        spec.springs.sort_by_key(|s| (s.i * 7919 + s.j * 104_729) % 1009);
        spec
    }

    /// Products with springs round elsewhere than products with compressed rows.
    fn assert_close(case: impl std::fmt::Debug, a: &[Vec3], b: &[Vec3]) {
        let greatest = a.iter().map(Vec3::norm).fold(0.0, f64::max);
        let distance = a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(distance < 1e-13 * greatest, "{case:?}: {distance} of {greatest}");
    }

    #[test]
    fn bands_have_the_bits_of_compressed_rows_and_springs_the_same_numbers() {
        let grid = Sheet { side: 20, tension: 1e4, shear: 1e3, damping: 2.0, ..Sheet::default() };
        let mut scenes = vec![stir(grid.build(), 0.01, 0.5)];
        scenes.extend([3, 7, 20].map(|side| build(&in_disorder(side))));
        for (k, scene) in scenes.into_iter().enumerate() {
            let mut matrix = Implicit::Springs.block_matrix(&scene.0);
            let coupling = matrix.coupling();
            let is_fast = match k {
                0 => matches!(coupling, Coupling::Bands(_)),
                _ => coupling == Coupling::Pairs,
            };
            assert!(is_fast, "scene {k}: {coupling:?}");
            let mut rows = Implicit::Springs.block_rows(&scene.0);
            for tangent in [Tangent::Exact, Tangent::Projected] {
                let [fast, reference] =
                    [&mut matrix, &mut rows].map(|m| numbers(m, &scene, tangent));
                assert_same_bits((k, tangent), &reference[1], &fast[1]);
                assert_close((k, tangent), &reference[0], &fast[0]);
                if k == 0 {
                    assert_same_bits((k, tangent), &reference[0], &fast[0]);
                }
            }
        }
        let (system, _) = build(&rough_sheet(7, 1e4, 0.3, DampingLaw::Projected));
        assert_eq!(Implicit::Springs.block_matrix(&system).coupling(), Coupling::Rows);
    }

    /// A matrix whose table belongs to other springs becomes compressed rows.
    #[test]
    fn a_matrix_made_for_another_order_of_the_springs_gives_the_same_numbers() {
        let mut spec = in_disorder(6);
        let scene = build(&spec);
        let mut own = Implicit::Springs.block_matrix(&scene.0);
        spec.springs.reverse();
        let mut other = Implicit::Springs.block_matrix(&build(&spec).0);
        let [own, other] = [&mut own, &mut other].map(|m| numbers(m, &scene, Tangent::Projected));
        assert_same_bits("another order", &own[1], &other[1]);
        assert_close("another order", &own[0], &other[0]);
    }
}
