//! The linear system of the implicit-explicit split: one scalar matrix for three coordinates.

use crate::{
    Implicit, PrepareError, SetupCause, Slopes, Split, StepError, StopNorm, choice,
    lightest_free_mass,
};
use drape_model::{Revisions, System, Vec3};
use drape_solvers::{
    CompleteCholesky, Constraints, DenseInverse, Filter, Identity, IncompleteCholesky, Jacobi,
    Norm, PcgReport, PcgSettings, PcgWorkspace, Preconditioner, Reference, ScalarMatrix, ScalarPcg,
    ScalarPreconditioner, SolveStatus, SolverError, StartValue, constraint_impulse, filtered_pcg,
    vector::{axpy, dot, norm, subtract_from},
};

/// Which preconditioner CG uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PreconditionerKind {
    /// None.
    None,
    /// Division by the diagonal.
    Jacobi,
    /// Incomplete Cholesky without fill-in, as in the paper.
    Ic0,
    /// The faster of Jacobi and IC(0), according to estimates; see [`crate::choice`].
    Auto,
}

/// Which solver a method uses for its linear system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverKind {
    /// Filtered conjugate gradients.
    Cg,
    /// Sparse Cholesky, a direct solve. CG runs on top of it if contacts couple the coordinates.
    Cholesky,
    /// The faster of CG and Cholesky, according to estimates; see [`crate::choice`].
    Auto,
    /// A direct solve with the inverse, stored as a full matrix.
    DenseInverse {
        /// Most bytes that the matrix and its scratch memory may take.
        limit_bytes: usize,
    },
}

/// Settings of a linear solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearSettings {
    /// Relative tolerance `ε` of the residual.
    pub forcing_term: f64,
    /// Preconditioner of CG.
    pub preconditioner: PreconditionerKind,
    /// Stop test. [`StopNorm::Velocity`] needs a [reference](crate::StepReference); without one it
    /// acts as [`StopNorm::Euclid`].
    pub norm: StopNorm,
    /// Solver.
    pub solver: SolverKind,
    /// Whether each step sets up matrix and preconditioner, even without a change.
    pub rebuild_every_step: bool,
}

/// Which Laplacians the matrix contains beside the masses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weights {
    /// `M + τ² L_k + τ L_c`, EEH (21).
    StiffnessAndDamping,
    /// `M + τ L_c`.
    Damping,
}

/// Relative tolerance of CG where the Cholesky factor alone does not solve the system.
const DIRECT_TOLERANCE: f64 = 1e-13;

/// A direct solve that leaves more than this part of the right-hand side is refined.
const REFINED: f64 = 1e-12;

/// A direct solve that leaves more than this part of the right-hand side has failed.
const DIRECT_FAILURE: f64 = 1e-8;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    tau_bits: u64,
    revisions: Revisions,
}

#[derive(Debug)]
enum Prepared {
    None(Identity),
    Jacobi(Jacobi),
    Ic0(Box<IncompleteCholesky>),
    Cholesky(Box<CompleteCholesky>),
    Dense(Box<DenseInverse>),
}

impl Prepared {
    /// Memory and symbolic factorisation; [`update`](Self::update) fills them.
    fn new(settings: &LinearSettings, a: &ScalarMatrix) -> Result<Self, SolverError> {
        Ok(match (settings.solver, settings.preconditioner) {
            (SolverKind::Cholesky, _) => Self::Cholesky(Box::new(CompleteCholesky::new(a)?)),
            (SolverKind::DenseInverse { limit_bytes }, _) => {
                Self::Dense(Box::new(DenseInverse::new(a, limit_bytes)?))
            }
            (_, PreconditionerKind::None) => Self::None(Identity),
            (_, PreconditionerKind::Jacobi) => Self::Jacobi(Jacobi::new(a)),
            (_, PreconditionerKind::Ic0 | PreconditionerKind::Auto) => {
                Self::Ic0(Box::new(IncompleteCholesky::new(a)))
            }
        })
    }

    fn update(&mut self, a: &ScalarMatrix, free: &[bool]) -> Result<(), SolverError> {
        match self {
            Self::None(_) => Ok(()),
            Self::Jacobi(jacobi) => jacobi.update(a),
            Self::Ic0(factor) => factor.update(a, Some(free)),
            Self::Cholesky(factor) => factor.update(a, Some(free)),
            Self::Dense(inverse) => inverse.update(a, Some(free)),
        }
    }

    /// The preconditioner of the fast conjugate gradients; `None` where the matrix is factorised
    /// completely.
    fn fast(&self) -> Option<ScalarPreconditioner<'_>> {
        match self {
            Self::None(_) => Some(ScalarPreconditioner::Identity),
            Self::Jacobi(jacobi) => Some(ScalarPreconditioner::Jacobi(jacobi)),
            Self::Ic0(factor) => Some(ScalarPreconditioner::Ic0(factor)),
            Self::Cholesky(_) | Self::Dense(_) => None,
        }
    }

    fn as_dyn(&self) -> &dyn Preconditioner {
        match self {
            Self::None(identity) => identity,
            Self::Jacobi(jacobi) => jacobi,
            Self::Ic0(factor) => factor.as_ref(),
            Self::Cholesky(factor) => factor.as_ref(),
            Self::Dense(inverse) => inverse.as_ref(),
        }
    }
}

/// `A = M + τ² L_k + τ L_c` over the implicit springs, its preconditioner and the solver.
///
/// `A` is a symmetric `n × n` M-matrix, diagonally dominant by exactly `m_i` in row `i`; it acts on
/// each coordinate in the same way. In contrast to EEH (21) it is multiplied by the masses, so that
/// it stays symmetric when masses differ.
///
/// Conjugate gradients with a diagonal preconditioner on a regular mesh use the
/// [threads](System::threads) of the system. IC(0), the factor, the inverse and set-ups run on one
/// thread. Residual checks use as many threads as the solve they check.
#[derive(Debug)]
pub struct LaplacianSolver {
    implicit: Implicit,
    weights: Weights,
    /// Slopes in the matrix instead of the constant stiffnesses.
    slopes: Option<Slopes>,
    settings: LinearSettings,
    matrix: ScalarMatrix,
    preconditioner: Prepared,
    free: Vec<bool>,
    /// `m_min/m_i`, with the lightest free mass.
    ratio: Vec<f64>,
    row_norms: (f64, f64),
    /// Conjugate gradients by fast kernels; with a complete factor they compute the residuals.
    fast: ScalarPcg,
    /// Memory of the readable conjugate gradients; empty where the fast ones serve.
    workspace: PcgWorkspace,
    residual: Vec<Vec3>,
    correction: Vec<Vec3>,
    /// The step and system of the operators; `None` after a failed rebuild.
    key: Option<Key>,
    topology: u64,
    first: bool,
    max_iterations: usize,
}

impl LaplacianSolver {
    /// Allocates the sparsity pattern, and builds matrix and preconditioner for steps with
    /// `τ = tau` seconds.
    ///
    /// # Errors
    /// [`PrepareError::Solver`] if the preconditioner cannot be factorised.
    pub fn new(
        system: &System,
        implicit: Implicit,
        weights: Weights,
        settings: LinearSettings,
        tau: f64,
    ) -> Result<Self, PrepareError> {
        Self::with_split(system, implicit, weights, settings, Split::Majorant, tau)
    }

    /// As [`new`](Self::new), but the stiffness in the matrix is the one that the [`Split`] names.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_split(
        system: &System,
        implicit: Implicit,
        weights: Weights,
        settings: LinearSettings,
        split: Split,
        tau: f64,
    ) -> Result<Self, PrepareError> {
        let n = system.len();
        let slopes = Slopes::new(system, implicit, split);
        let mut edges = Vec::new();
        implicit.visit_weights(system, &mut |i, j, _, _| edges.push((i, j)));
        let mut matrix = ScalarMatrix::with_pattern(n, edges);
        assemble(&mut matrix, system, (implicit, slopes.as_ref()), weights, tau);
        let rebuild_every_step = settings.rebuild_every_step;
        let changes = LinearSettings {
            rebuild_every_step: rebuild_every_step || slopes.is_some(),
            ..settings
        };
        let chosen = choice::choose(changes, system, &matrix);
        let settings = LinearSettings { rebuild_every_step, ..chosen };
        let free: Vec<bool> = system.pinned().iter().map(|pinned| !pinned).collect();
        let ratio = mass_ratios(system);
        let mut preconditioner = Prepared::new(&settings, &matrix)?;
        preconditioner.update(&matrix, &free)?;
        let is_complete = preconditioner.fast().is_none();
        let p = preconditioner.fast().unwrap_or(ScalarPreconditioner::Identity);
        let mut fast = ScalarPcg::new(&matrix, !matches!(p, ScalarPreconditioner::Ic0(_)));
        fast.update(&matrix, p);
        fast.set_threads(system.threads());
        Ok(Self {
            implicit,
            weights,
            slopes,
            settings,
            preconditioner,
            row_norms: row_norms(&matrix, system, &free, &ratio),
            matrix,
            free,
            ratio,
            workspace: PcgWorkspace::new(if is_complete { n } else { 0 }),
            fast,
            residual: vec![Vec3::zeros(); n],
            correction: vec![Vec3::zeros(); n],
            key: Some(Key { tau_bits: tau.to_bits(), revisions: system.revisions() }),
            topology: system.revisions().topology,
            first: true,
            max_iterations: PcgSettings::default_max(n),
        })
    }

    /// Updates matrix and preconditioner in place. Returns the cause of a rebuild, or `None` if
    /// nothing changed.
    ///
    /// # Errors
    /// [`StepError::NeedsPrepare`] after a change of topology; [`StepError::Solver`] if the
    /// preconditioner cannot be factorised.
    pub fn refresh(&mut self, system: &System, tau: f64) -> Result<Option<SetupCause>, StepError> {
        self.renew(system, tau, false)
    }

    /// As [`refresh`](Self::refresh), for a step from the positions `x`. If the [split](Split)
    /// follows the slopes of the springs, a changed slope counts as a change of stiffness.
    ///
    /// # Errors
    /// As [`refresh`](Self::refresh).
    pub fn refresh_at(
        &mut self,
        system: &System,
        tau: f64,
        x: &[Vec3],
    ) -> Result<Option<SetupCause>, StepError> {
        let has_moved = self.slopes.as_mut().is_some_and(|slopes| slopes.update(system, x));
        self.renew(system, tau, has_moved)
    }

    /// The slopes in the matrix; `None` if the matrix has constant stiffnesses.
    pub fn slopes(&self) -> Option<&Slopes> {
        self.slopes.as_ref()
    }

    fn renew(
        &mut self,
        system: &System,
        tau: f64,
        has_moved: bool,
    ) -> Result<Option<SetupCause>, StepError> {
        let key = Key { tau_bits: tau.to_bits(), revisions: system.revisions() };
        if key.revisions.topology != self.topology {
            return Err(StepError::NeedsPrepare);
        }
        self.fast.set_threads(system.threads());
        let is_first = std::mem::take(&mut self.first) && self.key == Some(key);
        if is_first && !has_moved {
            return Ok(Some(SetupCause::First));
        }
        // A rebuild that fails must not leave operators that look valid.
        let before = self.key.take();
        let old = before.map_or(key.revisions, |before| before.revisions);
        let new = key.revisions;
        let cause = if is_first {
            SetupCause::First
        } else if before.is_none_or(|before| before.tau_bits != key.tau_bits) {
            SetupCause::StepSize
        } else if (old.mass, old.stiffness, old.damping) != (new.mass, new.stiffness, new.damping)
            || has_moved
        {
            SetupCause::Stiffness
        } else if old.pins != new.pins {
            SetupCause::Constraints
        } else if self.settings.rebuild_every_step {
            SetupCause::EveryStep
        } else {
            self.key = before;
            return Ok(None);
        };
        let springs = (self.implicit, self.slopes.as_ref());
        assemble(&mut self.matrix, system, springs, self.weights, tau);
        for (free, pinned) in self.free.iter_mut().zip(system.pinned()) {
            *free = !pinned;
        }
        let lightest = lightest_free_mass(system);
        self.ratio.iter_mut().zip(system.mass()).for_each(|(ratio, m)| *ratio = lightest / m);
        self.row_norms = row_norms(&self.matrix, system, &self.free, &self.ratio);
        self.preconditioner.update(&self.matrix, &self.free)?;
        let p = self.preconditioner.fast().unwrap_or(ScalarPreconditioner::Identity);
        self.fast.update(&self.matrix, p);
        self.key = Some(key);
        Ok(Some(cause))
    }

    /// The settings, with every `auto` replaced by the choice that was made.
    pub fn settings(&self) -> LinearSettings {
        self.settings
    }

    /// Euclidean norms over the free particles, kg: of the springs' part of the diagonal, and of
    /// the whole diagonal. Each row is weighted by the lightest free mass over its own mass,
    /// because round-off in the row of a heavy particle changes its velocity correspondingly less.
    pub fn row_norms(&self) -> (f64, f64) {
        self.row_norms
    }

    /// Whether solves use a complete factor or inverse. Such solves need no iterations unless
    /// contacts couple the coordinates.
    pub fn is_direct(&self) -> bool {
        self.settings.solver != SolverKind::Cg
    }

    /// The matrix.
    pub fn matrix(&self) -> &ScalarMatrix {
        &self.matrix
    }

    /// The matrix, and the solver that [multiplies](ScalarPcg::multiply) vectors by it.
    pub fn product(&mut self) -> (&ScalarMatrix, &mut ScalarPcg) {
        (&self.matrix, &mut self.fast)
    }

    /// Solves `A v = b` under constraints, kg m/s and m/s. On entry `v` holds the start value, on
    /// return the solution. The solve stops when the residual falls below the forcing term,
    /// relative to the filtered right-hand side.
    pub fn solve(&mut self, constraints: &Constraints, b: &[Vec3], v: &mut [Vec3]) -> PcgReport {
        self.solve_from(StartValue::Given, constraints, b, v, Reference::FilteredRightHandSide)
    }

    /// As [`solve`](Self::solve) from `start`, with the forcing term relative to `reference`, in
    /// the norm of the stop test. A direct solve ignores both.
    ///
    /// If round-off keeps the residual above an absolute reference, the residual is measured again
    /// as `m_min M⁻¹ r`. No velocity is wrong by more than `|M⁻¹ r|`, because the rows of the
    /// matrix sum to the masses and its inverse has no negative entry. So a heavy particle may keep
    /// a residual that is small beside its mass.
    ///
    /// # Panics
    /// If the sizes of the arguments differ.
    pub fn solve_from(
        &mut self,
        start: StartValue<'_>,
        constraints: &Constraints,
        b: &[Vec3],
        v: &mut [Vec3],
        reference: Reference,
    ) -> PcgReport {
        let mut report = self.solve_with(start, constraints, b, v, reference, self.stop_test());
        if let Reference::Absolute(reference) = reference
            && report.status == SolveStatus::Stagnated
            && self.settings.solver == SolverKind::Cg
        {
            // Only rows of heavy particles may be left, at their round-off.
            self.filtered_residual(constraints, b, v);
            report.multiplications += 1;
            self.residual.iter_mut().zip(&self.ratio).for_each(|(r, ratio)| *r *= *ratio);
            let residual = self.norm_of_residual();
            if residual <= self.settings.forcing_term * reference {
                report.status = SolveStatus::Converged;
                report.relative_residual = if residual > 0.0 { residual / reference } else { 0.0 };
            }
        }
        report
    }

    /// As [`solve`](Self::solve), until `‖r‖ ≤ residual` (kg m/s, Euclidean).
    pub fn solve_to(
        &mut self,
        constraints: &Constraints,
        b: &[Vec3],
        v: &mut [Vec3],
        residual: f64,
    ) -> PcgReport {
        let max_iterations = self.max_iterations;
        let settings = PcgSettings { forcing_term: 1.0, norm: Norm::Euclid, max_iterations };
        let (start, reference) = (StartValue::Given, Reference::Absolute(residual));
        self.solve_with(start, constraints, b, v, reference, settings)
    }

    /// Norm of the filtered vector `S r`, kg m/s, in the norm of the stop test.
    pub fn filtered_norm(&mut self, constraints: &Constraints, r: &[Vec3]) -> f64 {
        self.residual.copy_from_slice(r);
        constraints.project(&mut self.residual);
        self.norm_of_residual()
    }

    fn norm_of_residual(&mut self) -> f64 {
        match self.settings.norm.residual() {
            Norm::Euclid => norm(&self.residual),
            Norm::Preconditioned => {
                self.preconditioner.as_dyn().apply(&self.residual, &mut self.correction);
                dot(&self.residual, &self.correction).sqrt()
            }
        }
    }

    fn stop_test(&self) -> PcgSettings {
        PcgSettings {
            forcing_term: self.settings.forcing_term,
            norm: self.settings.norm.residual(),
            max_iterations: self.max_iterations,
        }
    }

    fn solve_with(
        &mut self,
        start: StartValue<'_>,
        constraints: &Constraints,
        b: &[Vec3],
        v: &mut [Vec3],
        reference: Reference,
        mut settings: PcgSettings,
    ) -> PcgReport {
        let mut reference = reference;
        if self.solves_directly(constraints) {
            return self.solve_directly(constraints, b, v);
        }
        if self.settings.solver != SolverKind::Cg {
            reference = Reference::FilteredRightHandSide;
            settings.forcing_term = DIRECT_TOLERANCE;
            settings.max_iterations = self.max_iterations;
        }
        if let Some(p) = self.preconditioner.fast() {
            let (a, fast) = (&self.matrix, &mut self.fast);
            return fast.solve(a, p, constraints, b, start, v, reference, &settings);
        }
        start.write(v);
        let preconditioner = self.preconditioner.as_dyn();
        let workspace = &mut self.workspace;
        filtered_pcg(
            &self.matrix,
            preconditioner,
            constraints,
            b,
            v,
            reference,
            &settings,
            workspace,
        )
    }

    /// Whether a solve under these constraints is one application of the factor or the inverse,
    /// whatever the start value.
    pub fn solves_directly(&self, constraints: &Constraints) -> bool {
        // The factor knows pins alone. Contacts on one or two sides couple the coordinates;
        // contacts on three sides hold a particle that the factor takes as free.
        let is_known = |&i: &u32| match constraints.filter(i as usize) {
            Filter::Free => true,
            Filter::Plane { .. } | Filter::Line { .. } => false,
            Filter::Fixed => !self.free[i as usize],
        };
        self.settings.solver != SolverKind::Cg && constraints.constrained().iter().all(is_known)
    }

    /// `out ← P b`, one application of the preconditioner. A Cholesky factor or the inverse gives
    /// the solution up to round-off, if no contact couples the coordinates. Pinned rows use their
    /// diagonal entry alone.
    pub fn apply_preconditioner(&self, b: &[Vec3], out: &mut [Vec3]) {
        self.preconditioner.as_dyn().apply(b, out);
    }

    /// The residual `‖S (b − A v)‖` over the reference. In the Euclidean norm the reference is the
    /// norm of the filtered right-hand side; otherwise both are in the norm of the stop test.
    pub fn relative_residual(
        &mut self,
        constraints: &Constraints,
        b: &[Vec3],
        v: &[Vec3],
        reference: Reference,
    ) -> f64 {
        let (residual, reference) = match reference {
            Reference::Absolute(reference) => {
                self.filtered_residual(constraints, b, v);
                (self.norm_of_residual(), reference)
            }
            Reference::FilteredRightHandSide => {
                constraints.prescribed_only(&mut self.correction);
                self.fast.multiply(&self.matrix, &self.correction, &mut self.residual);
                subtract_from(b, &mut self.residual);
                constraints.project(&mut self.residual);
                let reference = norm(&self.residual);
                (self.residual(constraints, b, v), reference)
            }
        };
        if residual > 0.0 { residual / reference } else { 0.0 }
    }

    /// `‖S (b − A v)‖`, Euclidean, kg m/s.
    pub fn residual(&mut self, constraints: &Constraints, b: &[Vec3], v: &[Vec3]) -> f64 {
        self.filtered_residual(constraints, b, v);
        norm(&self.residual)
    }

    /// One application of the factor, checked by its residual. Above [`REFINED`] one step of
    /// iterative refinement follows.
    fn solve_directly(
        &mut self,
        constraints: &Constraints,
        b: &[Vec3],
        v: &mut [Vec3],
    ) -> PcgReport {
        let (mut multiplications, moving) = (1, constraints.has_prescribed_motion());
        let mut reference = f64::NAN;
        if moving {
            constraints.prescribed_only(v);
            self.filtered_residual(constraints, b, v);
            multiplications += 1;
            reference = norm(&self.residual);
            self.add_correction(constraints, v);
        } else {
            self.preconditioner.as_dyn().apply(b, v);
            constraints.project(v);
        }
        let norms = self.fast.residual_norms(&self.matrix, constraints, b, v, !moving);
        reference = norms.reference.unwrap_or(reference);
        let relative = |residual: f64| if reference == 0.0 { 0.0 } else { residual / reference };
        let mut relative_residual = relative(norms.residual);
        if relative_residual.is_nan() || relative_residual > REFINED {
            self.fast.residual(&mut self.residual);
            self.add_correction(constraints, v);
            let norms = self.fast.residual_norms(&self.matrix, constraints, b, v, false);
            multiplications += 1;
            relative_residual = relative(norms.residual);
        }
        let status = if relative_residual <= DIRECT_FAILURE {
            SolveStatus::Converged
        } else {
            SolveStatus::Stagnated
        };
        PcgReport { iterations: 0, multiplications, relative_residual, status }
    }

    /// `v ← v + S A⁻¹ r` for the `r` in `self.residual`.
    fn add_correction(&mut self, constraints: &Constraints, v: &mut [Vec3]) {
        self.preconditioner.as_dyn().apply(&self.residual, &mut self.correction);
        constraints.project(&mut self.correction);
        axpy(1.0, &self.correction, v);
    }

    /// `S (b − A v)`, in `self.residual`.
    fn filtered_residual(&mut self, constraints: &Constraints, b: &[Vec3], v: &[Vec3]) {
        self.fast.multiply(&self.matrix, v, &mut self.residual);
        subtract_from(b, &mut self.residual);
        constraints.project(&mut self.residual);
    }

    /// The impulse of the constraints, `p = A v − b` (kg m/s), written to `impulse`.
    pub fn constraint_impulse(&self, b: &[Vec3], v: &[Vec3], impulse: &mut [Vec3]) {
        constraint_impulse(&self.matrix, b, v, impulse);
    }
}

/// The lightest free mass over each mass.
fn mass_ratios(system: &System) -> Vec<f64> {
    let lightest = lightest_free_mass(system);
    system.mass().iter().map(|m| lightest / m).collect()
}

/// Norms of the springs' part of the diagonal and of all of it, over the free particles, each row
/// by its `ratio`.
fn row_norms(matrix: &ScalarMatrix, system: &System, free: &[bool], ratio: &[f64]) -> (f64, f64) {
    let (mut springs, mut all) = (0.0, 0.0);
    for (i, m) in system.mass().iter().enumerate().filter(|(i, _)| free[*i]) {
        let diagonal = matrix.diagonal(i);
        let (spring, whole) = ((diagonal - m) * ratio[i], diagonal * ratio[i]);
        springs += spring * spring;
        all += whole * whole;
    }
    (springs.sqrt(), all.sqrt())
}

/// Assembles EEH (16), (17) and the left-hand side of (21).
#[doc(alias = "EEH 16")]
#[doc(alias = "EEH 17")]
fn assemble(
    matrix: &mut ScalarMatrix,
    system: &System,
    (implicit, slopes): (Implicit, Option<&Slopes>),
    weights: Weights,
    tau: f64,
) {
    matrix.clear();
    for (i, &m) in system.mass().iter().enumerate() {
        matrix.add_diagonal(i, m);
    }
    let mut add = |i: usize, j: usize, k: f64, c: f64| {
        let weight = match weights {
            Weights::StiffnessAndDamping => tau * tau * k + tau * c,
            Weights::Damping => tau * c,
        };
        matrix.add_edge(i, j, weight);
    };
    match slopes {
        None => implicit.visit_weights(system, &mut add),
        Some(slopes) => slopes.visit_weights(system, &mut add),
    }
}
