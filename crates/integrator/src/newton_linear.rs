//! The linear systems of Newton's method: fresh or saved Jacobian, direct or by conjugate
//! gradients.

use crate::{
    Declared, Declares, Forcing, ForcingRule, IncrementalPotential, Linearisation, NewtonReport,
    PrepareError, Setting, Settings, StepError, Tau, Word, declare,
};
use drape_model::{Revisions, System, Tangent, Vec3};
use drape_solvers::{
    BlockFactor, BlockJacobi, BlockMatrix, Constraints, FactorKind, Filter, Multigrid, Norm,
    PcgSettings, PcgWorkspace, Preconditioner, Reference, ScalarMatrix, SinglePcg, SolveStatus,
    SolverError, filtered_pcg,
};
use std::cell::RefCell;

#[cfg(test)]
mod tests;

/// When Newton's method factorises its matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jacobian {
    /// In every iteration.
    Fresh,
    /// When the saved factor no longer gives progress: the Newton-like iteration with a saved
    /// Jacobian.
    Saved,
}

/// How Newton's method solves its linear systems.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NewtonSolver {
    /// By the sparse Cholesky factor.
    Cholesky,
    /// By conjugate gradients on the Hessian of each iterate. The rule sets the tolerance. The
    /// preconditioner is the inverse of the diagonal blocks, or the saved factor.
    Cg(ForcingRule),
    /// By conjugate gradients on the Hessian, preconditioned by a cycle of [`Multigrid`]. The
    /// levels follow the stiffnesses of the springs or, without springs, the couplings of the other
    /// effects. Nothing is saved.
    Multigrid(ForcingRule),
    /// The faster of the two, chosen by the stiffness of the stage: conjugate gradients with the
    /// diagonal blocks up to a limit of the greatest `τ_x τ_v k/m`, multigrid above it. The
    /// tolerance is that of [Eisenstat and Walker](ForcingRule::EisenstatWalker). With a
    /// [saved Jacobian](Jacobian::Saved) it acts as [`Cholesky`](Self::Cholesky).
    ///
    /// From 1000 particles on, multigrid reuses its coarse matrices within a stage while they work.
    /// Conjugate gradients then run in [single precision](SinglePcg) on regular grids without
    /// obstacles. This is safe because Newton's method checks each step by the residual. Contacts
    /// give matrices that are not symmetric block by block, which single precision does not hold:
    /// scenes with obstacles are solved in double precision throughout. If single precision fails,
    /// the rest of the stage is solved in double precision.
    ///
    /// The line search judges a step by gradients, which cost a fraction of the energies. The start
    /// is the candidate with the least residual.
    Auto,
}

impl NewtonSolver {
    /// The forcing rule of conjugate gradients; 0 for Cholesky.
    pub(crate) fn forcing(self) -> ForcingRule {
        match self {
            Self::Cholesky => ForcingRule::Constant(0.0),
            Self::Cg(rule) | Self::Multigrid(rule) => rule,
            Self::Auto => ForcingRule::EisenstatWalker,
        }
    }
}

/// Settings of the linear systems of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonLinear {
    /// When the matrix is factorised.
    pub jacobian: Jacobian,
    /// The solver.
    pub solver: NewtonSolver,
}

impl Word for Jacobian {
    const WORDS: &'static [(&'static str, Self)] =
        &[("fresh", Self::Fresh), ("saved", Self::Saved)];
}

/// The solver without its numbers, as the setting `solver` names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SolverWord {
    Cholesky,
    Cg,
    Multigrid,
    Auto,
}

impl Word for SolverWord {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("cholesky", Self::Cholesky),
        ("cg", Self::Cg),
        ("multigrid", Self::Multigrid),
        ("auto", Self::Auto),
    ];
}

const JACOBIAN: Declared<Jacobian> = declare!(
    jacobian: Jacobian [Fresh, Saved] = Fresh,
    "factorise the Hessian in each Newton iteration, or keep the factor over iterations and steps \
     while it serves (solver=multigrid keeps nothing)"
);

const SOLVER: Declared<SolverWord> = declare!(
    solver: SolverWord [Cholesky, Cg, Multigrid, Auto] = Auto,
    "solve Newton's linear systems by sparse Cholesky, or by CG on the Hessian, preconditioned by \
     its diagonal blocks (jacobian=fresh) or by the kept factor (jacobian=saved), or by CG \
     preconditioned by multigrid on the Hessian; auto: by CG with diagonal blocks where h²k/m \
     is small, by multigrid where it is large, with forcing=eisenstat-walker and a line search \
     by gradients; with jacobian=saved by the kept factor"
);

impl Declares for NewtonLinear {
    const SETTINGS: &'static [Setting] = &[
        JACOBIAN.setting,
        SOLVER.setting,
        ForcingRule::FORCING.setting,
        ForcingRule::CG_TOLERANCE.setting,
    ];

    fn read(settings: &Settings) -> Self {
        let term = ForcingRule::CG_TOLERANCE.read(settings);
        let rule = ForcingRule::new(ForcingRule::FORCING.read(settings), term);
        let jacobian = JACOBIAN.read(settings);
        let solver = match SOLVER.read(settings) {
            SolverWord::Cholesky => NewtonSolver::Cholesky,
            SolverWord::Cg => NewtonSolver::Cg(rule),
            SolverWord::Multigrid => NewtonSolver::Multigrid(rule),
            SolverWord::Auto => NewtonSolver::Auto,
        };
        Self { jacobian, solver }.resolved()
    }
}

impl Default for NewtonLinear {
    fn default() -> Self {
        Self { jacobian: JACOBIAN.default, solver: NewtonSolver::Auto }
    }
}

impl NewtonLinear {
    /// A sparse Cholesky factor in each iteration, for exact solves and for small systems.
    pub const CHOLESKY: Self = Self { jacobian: Jacobian::Fresh, solver: NewtonSolver::Cholesky };

    /// The same with the solver that [`Auto`](NewtonSolver::Auto) stands for beside a saved
    /// Jacobian: the kept factor.
    pub(crate) fn resolved(self) -> Self {
        match (self.jacobian, self.solver) {
            (Jacobian::Saved, NewtonSolver::Auto) => {
                Self { solver: NewtonSolver::Cholesky, ..self }
            }
            _ => self,
        }
    }

    /// Whether the Hessian is factorised.
    fn factorises(self) -> bool {
        match self.solver {
            NewtonSolver::Cholesky => true,
            NewtonSolver::Cg(_) => self.jacobian == Jacobian::Saved,
            NewtonSolver::Multigrid(_) | NewtonSolver::Auto => false,
        }
    }

    /// Whether these settings avoid the factorisations of a library, whose results differ between
    /// machines.
    pub fn is_portable(self) -> bool {
        matches!(self.solver, NewtonSolver::Cg(_)) && self.jacobian == Jacobian::Fresh
    }
}

/// Stages above this `τ_x τ_v k/m` are solved by multigrid; the table stands in the docs of
/// `drape-backward-euler`.
const STIFF: f64 = 200.0;
/// The same where conjugate gradients run in single precision: an iteration takes half the time.
const STIFF_SINGLE: f64 = 2000.0;
/// Greatest forcing term there, but where a looser solve reaches the goal: iterations are cheap
/// beside the Hessian of another iterate.
const GREATEST_OF_SINGLE: f64 = 0.03;
/// From so many particles on, stages of grids without obstacles are solved in single precision, and
/// coarse matrices are kept: smaller systems stay in the nearest caches.
const LARGE: usize = 1000;
/// A factor is dropped when the next correction is longer than this fraction of the last one.
const SLOW: f64 = 0.3;
/// A factor is dropped when it takes more CG iterations than this as a preconditioner.
const MANY_ITERATIONS: u32 = 10;
/// A factor is dropped when `τ_x` or `τ_v` has changed by more than this fraction.
const TAU_CHANGE: f64 = 0.2;
/// A factor is dropped after this many stages.
const MAX_STAGES: u32 = 20;

/// The stage that the saved factor was made for.
#[derive(Debug)]
struct Saved {
    tau: Tau,
    revisions: Option<Revisions>,
    filters: Vec<Filter>,
    stages: u32,
}

/// The matrix of Newton's method and its solvers.
#[derive(Debug)]
pub(crate) struct NewtonMatrix {
    matrix: BlockMatrix,
    /// `None` where the settings need no factor.
    factor: Option<BlockFactor>,
    saved: Saved,
    diagonal: BlockJacobi,
    /// `None` unless the settings ask for it.
    multigrid: Option<Multigrid>,
    /// Whether the coarse matrices of multigrid belong to this stage and still serve.
    coarse_serves: bool,
    /// Whether they are kept over the iterations of a stage.
    keeps_coarse: bool,
    /// Where the settings leave the choice, the mesh has bands and the scene no obstacles.
    single: Option<SinglePcg>,
    /// Whether it has not failed in this stage.
    single_serves: bool,
    workspace: PcgWorkspace,
    /// No constraints, since the matrix is already projected to them.
    none: Constraints,
    /// Norm of the last correction of this stage, m/s.
    last_length: Option<f64>,
    /// Whether the last solve factorised.
    is_new: bool,
    /// For stiff stages, where the settings leave the choice.
    stiff: Option<Box<Self>>,
}

impl NewtonMatrix {
    pub(crate) fn new(
        system: &System,
        potential: &IncrementalPotential,
        settings: NewtonLinear,
    ) -> Result<Self, PrepareError> {
        let n = system.len();
        let stiff = match settings.solver {
            NewtonSolver::Auto => {
                let solver = NewtonSolver::Multigrid(ForcingRule::EisenstatWalker);
                let mut stiff = Self::new(system, potential, NewtonLinear { solver, ..settings })?;
                stiff.keeps_coarse = n >= LARGE;
                Some(Box::new(stiff))
            }
            _ => None,
        };
        // Factors read compressed rows, and contacts give blocks that are not symmetric.
        let matrix = if !settings.factorises() && system.obstacles().is_empty() {
            potential.implicit().block_matrix(system)
        } else {
            potential.implicit().block_rows(system)
        };
        let saved = Saved {
            tau: Tau::from(0.0),
            revisions: None,
            filters: vec![Filter::Free; n],
            stages: 0,
        };
        Ok(Self {
            factor: settings
                .factorises()
                .then(|| BlockFactor::new(&matrix, FactorKind::Cholesky))
                .transpose()?,
            saved,
            diagonal: BlockJacobi::new(&matrix),
            multigrid: match settings.solver {
                NewtonSolver::Multigrid(_) => Some(multigrid(system, potential, &matrix)?),
                _ => None,
            },
            coarse_serves: false,
            keeps_coarse: false,
            single: match settings.solver {
                NewtonSolver::Auto if n >= LARGE => SinglePcg::new(&matrix),
                _ => None,
            },
            single_serves: false,
            workspace: PcgWorkspace::new(n),
            none: Constraints::free(n),
            last_length: None,
            is_new: false,
            stiff,
            matrix,
        })
    }

    /// Begins a stage.
    pub(crate) fn begin(&mut self) {
        self.last_length = None;
        self.saved.stages = self.saved.stages.saturating_add(1);
        self.coarse_serves = false;
        self.single_serves = self.single.is_some();
        if let Some(stiff) = &mut self.stiff {
            stiff.begin();
        }
    }

    /// Whether [`Auto`](NewtonSolver::Auto) solves this stage by multigrid.
    fn is_stiff(&self, potential: &IncrementalPotential) -> bool {
        let limit = if self.single_serves { STIFF_SINGLE } else { STIFF };
        self.stiff.is_some() && potential.stiffness() > limit
    }

    /// The forcing terms of the stage that has begun.
    pub(crate) fn forcing(
        &self,
        solver: NewtonSolver,
        potential: &IncrementalPotential,
    ) -> Forcing {
        if self.single_serves && !self.is_stiff(potential) {
            return Forcing::at_most(solver.forcing(), GREATEST_OF_SINGLE);
        }
        Forcing::new(solver.forcing())
    }

    /// Drops the saved factor.
    pub(crate) fn restart(&mut self) {
        self.saved.revisions = None;
    }

    /// Drops the saved factor; returns `false` if the last solve had a new one.
    pub(crate) fn forget(&mut self) -> bool {
        self.saved.revisions = None;
        !self.is_new
    }

    /// `direction ← H⁻¹ gradient` with the projected `gradient`; `forcing` is the tolerance of CG.
    pub(crate) fn solve(
        &mut self,
        system: &System,
        potential: &IncrementalPotential,
        constraints: &Constraints,
        (settings, forcing): (NewtonLinear, f64),
        (gradient, direction): (&[Vec3], &mut [Vec3]),
        report: &mut NewtonReport,
    ) -> Result<(), StepError> {
        if self.is_stiff(potential)
            && let Some(stiff) = self.stiff.as_mut()
        {
            let solver = NewtonSolver::Multigrid(ForcingRule::EisenstatWalker);
            let how = (NewtonLinear { solver, ..settings }, forcing);
            return stiff.solve(system, potential, constraints, how, (gradient, direction), report);
        }
        let saves = settings.jacobian == Jacobian::Saved
            && !matches!(settings.solver, NewtonSolver::Multigrid(_) | NewtonSolver::Auto);
        let fits = saves && self.fits(system, potential.tau(), constraints);
        self.is_new = !fits;
        if settings.solver == NewtonSolver::Cholesky {
            if !fits {
                report.factorisations += self.factorise(system, potential, constraints)?;
            }
            self.solve_with_factor(gradient, direction)?; // (I − hβJ) Δy = r
            let length = saves.then(|| drape_solvers::vector::norm(direction));
            let is_slow = |last: f64| length.is_some_and(|length| length > SLOW * last);
            if fits && self.last_length.is_some_and(is_slow) {
                report.factorisations += self.factorise(system, potential, constraints)?;
                self.solve_with_factor(gradient, direction)?;
                self.is_new = true;
            }
            self.last_length = length;
        } else {
            if saves && !fits {
                report.factorisations += self.factorise(system, potential, constraints)?;
            } else {
                self.assemble(system, potential, constraints, Tangent::Exact);
            }
            let (before, in_single) = (report.cg_iterations, self.single_serves);
            let vectors = (gradient, &mut *direction);
            let how = (saves, forcing, Tangent::Exact);
            let is_solved = self.iterate(how, vectors, report).unwrap_or(false);
            // The exact Hessian may be indefinite; the projected one is positive definite.
            if !is_solved && self.single_serves == in_single {
                self.coarse_serves = false;
                self.assemble(system, potential, constraints, Tangent::Projected);
                let how = (saves, forcing, Tangent::Projected);
                self.iterate(how, (gradient, direction), report)?;
            }
            if self.single_serves != in_single {
                // Single precision does not do: once more, by what the stiffness then asks for.
                let how = (settings, forcing);
                let vectors = (gradient, direction);
                return self.solve(system, potential, constraints, how, vectors, report);
            }
            if report.cg_iterations - before > MANY_ITERATIONS {
                self.restart();
                self.coarse_serves = false;
            }
        }
        constraints.project(direction);
        Ok(())
    }

    /// Conjugate gradients on the matrix, which `tangent` names. `Ok(false)` where they find that it
    /// is not positive definite, or where single precision fails, which then serves no longer; an
    /// error where the preconditioner finds it, but that projected matrices whose coarse matrices
    /// are lost in rounding are preconditioned by the diagonal blocks.
    fn iterate(
        &mut self,
        (with_factor, forcing, tangent): (bool, f64, Tangent),
        (gradient, direction): (&[Vec3], &mut [Vec3]),
        report: &mut NewtonReport,
    ) -> Result<bool, StepError> {
        let is_kept = self.keeps_coarse && self.coarse_serves;
        let Self { matrix, factor, diagonal, multigrid, single, workspace, none, .. } = self;
        direction.fill(Vec3::zeros());
        let max_iterations = PcgSettings::default_max(gradient.len());
        let settings = PcgSettings { forcing_term: forcing, norm: Norm::Euclid, max_iterations };
        let kept;
        let mut cycle_products = 0;
        let mut has_levels = false;
        if let Some(multigrid) = multigrid {
            let made = if is_kept {
                multigrid.keep(matrix)
            } else {
                report.matvecs += multigrid.products().update as u32;
                multigrid.update(matrix)
            };
            has_levels = made.is_ok();
            self.coarse_serves = has_levels;
            // Of a positive definite matrix, only rounding leaves a coarse one that is not: a mass of
            // 10¹⁶ times the others. The diagonal blocks do not sum such masses.
            if tangent == Tangent::Exact {
                made?;
            }
        }
        let preconditioner: &dyn Preconditioner = if let Some(multigrid) =
            multigrid.as_ref().filter(|_| has_levels)
        {
            cycle_products = multigrid.products().cycle;
            multigrid
        } else if let Some(factor) = factor.as_mut().filter(|_| with_factor) {
            kept = Kept(RefCell::new(factor));
            &kept
        } else {
            diagonal.update(matrix)?;
            let single = single.as_mut().filter(|_| self.single_serves);
            let solve = single
                .and_then(|single| single.solve(matrix, diagonal, gradient, direction, &settings));
            if let Some(solve) = solve {
                report.cg_iterations += solve.iterations as u32;
                report.matvecs += solve.multiplications as u32;
                let is_indefinite =
                    tangent == Tangent::Exact && solve.status == SolveStatus::Indefinite;
                let is_solved = solve.status == SolveStatus::Converged;
                self.single_serves = is_solved || is_indefinite;
                return Ok(is_solved);
            }
            diagonal
        };
        let reference = Reference::FilteredRightHandSide;
        let solve = filtered_pcg(
            matrix,
            preconditioner,
            none,
            gradient,
            direction,
            reference,
            &settings,
            workspace,
        );
        report.cg_iterations += solve.iterations as u32;
        let cycles = (solve.iterations + 1) * cycle_products;
        report.matvecs += (solve.multiplications + cycles) as u32;
        Ok(solve.status != SolveStatus::Indefinite)
    }

    fn solve_with_factor(
        &mut self,
        gradient: &[Vec3],
        direction: &mut [Vec3],
    ) -> Result<(), StepError> {
        let factor = self.factor.as_mut().ok_or(StepError::NeedsPrepare)?;
        factor.solve(gradient, direction);
        Ok(())
    }

    /// Whether the saved factor serves this stage.
    fn fits(&self, system: &System, tau: Tau, constraints: &Constraints) -> bool {
        let Saved { tau: saved, revisions, filters, stages } = &self.saved;
        let is_close = |tau: f64, saved: f64| (tau - saved).abs() <= TAU_CHANGE * saved;
        *revisions == Some(system.revisions())
            && is_close(tau.x, saved.x)
            && is_close(tau.v, saved.v)
            && *stages <= MAX_STAGES
            && filters.iter().enumerate().all(|(i, filter)| constraints.filter(i) == *filter)
    }

    /// Factorises the matrix; an error where the settings have no factor.
    fn factor(&mut self) -> Result<Result<(), SolverError>, StepError> {
        let Self { matrix, factor, .. } = self;
        Ok(factor.as_mut().ok_or(StepError::NeedsPrepare)?.factorise(matrix))
    }

    /// Assembles and factorises; returns the number of factorisations.
    fn factorise(
        &mut self,
        system: &System,
        potential: &IncrementalPotential,
        constraints: &Constraints,
    ) -> Result<u32, StepError> {
        self.saved.revisions = None; // a failure leaves no factor
        self.assemble(system, potential, constraints, Tangent::Exact);
        let mut count = 1;
        if self.factor()?.is_err() {
            self.assemble(system, potential, constraints, Tangent::Projected);
            self.factor()??;
            count = 2;
        }
        for (i, filter) in self.saved.filters.iter_mut().enumerate() {
            *filter = constraints.filter(i);
        }
        (self.saved.tau, self.saved.stages) = (potential.tau(), 1);
        self.saved.revisions = Some(system.revisions());
        Ok(count)
    }

    /// `H = M + τ_x τ_v ∇²U + τ_v D` at the positions of the last gradient, projected to the
    /// constraints.
    fn assemble(
        &mut self,
        system: &System,
        potential: &IncrementalPotential,
        constraints: &Constraints,
        tangent: Tangent,
    ) {
        let tau = potential.tau();
        let at = Linearisation {
            implicit: potential.implicit(),
            tau: tau.v,
            x: potential.last_positions(),
            lagged: potential.lagged(),
            tangent,
        };
        at.assemble_scaled((tau.x * tau.v, tau.v), system, &mut self.matrix, None);
        self.matrix.project(constraints);
    }
}

/// Multigrid for the Hessian, with levels that follow the stiffnesses of the springs or, without
/// springs, the couplings of the other effects.
fn multigrid(
    system: &System,
    potential: &IncrementalPotential,
    matrix: &BlockMatrix,
) -> Result<Multigrid, PrepareError> {
    let implicit = potential.implicit();
    let mut edges = Vec::new();
    implicit.visit_weights(system, &mut |i, j, k, _| edges.push((i, j, k)));
    if edges.is_empty() {
        let effects = implicit.effects(system);
        effects.for_each(|effect| effect.visit_pairs(&mut |i, j| edges.push((i, j, 1.0))));
    }
    let pairs = edges.iter().map(|&(i, j, _)| (i, j));
    let mut couplings = ScalarMatrix::with_pattern(system.len(), pairs);
    edges.iter().for_each(|&(i, j, k)| couplings.add_edge(i, j, k));
    Ok(Multigrid::new(matrix, &couplings)?)
}

/// The factor as a preconditioner: its solve needs scratch memory of its own.
struct Kept<'a>(RefCell<&'a mut BlockFactor>);

impl Preconditioner for Kept<'_> {
    fn apply(&self, r: &[Vec3], z: &mut [Vec3]) {
        self.0.borrow_mut().solve(r, z);
    }
}
