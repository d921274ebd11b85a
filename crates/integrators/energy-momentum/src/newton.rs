//! Newton's method for the mean velocity of a step.

use crate::settings::EnergyMomentumSettings;
use drape_integrator::{Implicit, IncrementalPotential, PrepareError, StepError, StepReport};
use drape_model::{Effect, Level, Mat3, Part, System, Vec3};
use drape_solvers::{BlockLu, Constraints, SolveStatus, UnsymmetricBlocks};

/// Least relative decrease of the residual, over the length of the step.
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Most halvings of a Newton step.
const MAX_HALVINGS: u32 = 12;
/// A residual that falls no further within this multiple of its round-off is solved.
const NEAR_ROUND_OFF: f64 = 10.0;

/// Newton iterations of a step times particles. A step that no iteration solves would divide itself
/// into 64 parts of 180 iterations each, which takes hours with 10 000 particles; this limit ends
/// it after 400 iterations. With up to 170 particles the limit is never reached without contacts.
const MOST_WORK: usize = 4_000_000;

/// Number of candidates for the start.
const CANDIDATES: usize = 3;

/// Candidates for the start of Newton's method, m/s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Starts<'a> {
    /// `v_n`.
    pub(crate) old: &'a [Vec3],
    /// What the last steps say.
    pub(crate) guess: &'a [Vec3],
}

/// The equation `r(v̄) = 0` of a step, and its solution.
#[derive(Debug)]
pub(crate) struct MeanVelocity {
    /// The velocity without springs, the scale of residuals, and their round-off.
    pub(crate) potential: IncrementalPotential,
    matrix: UnsymmetricBlocks,
    factor: BlockLu,
    h: f64,
    /// `x_n`, m.
    pub(crate) start: Vec<Vec3>,
    /// `x_n + h v̄` of the last evaluation, m.
    pub(crate) end: Vec<Vec3>,
    force: Vec<Vec3>,
    /// `r` of the last evaluation, kg m/s.
    pub(crate) residual: Vec<Vec3>,
    filtered: Vec<Vec3>,
    direction: Vec<Vec3>,
    trial: Vec<Vec3>,
    /// The velocity with the least residual so far, m/s.
    best: Vec<Vec3>,
    evaluations: u32,
    /// Most Newton iterations of a step and all of its parts.
    pub(crate) most: u32,
    /// Those that are left to the step.
    left: u32,
}

/// Adds the discrete gradients of all springs between two positions, N.
pub(crate) fn add_mean_force(effect: &dyn Effect, from: &[Vec3], to: &[Vec3], out: &mut [Vec3]) {
    let Some(split) = effect.split() else { return };
    split.visit_discrete_gradients(from, to, &mut |i, j, g, _| {
        let f = ((from[i] - from[j]) + (to[i] - to[j])) * g; // F̄ = −g (d_n + d₊), (3)
        out[i] -= f;
        out[j] += f;
    });
}

impl MeanVelocity {
    pub(crate) fn new(system: &System) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let mut pairs = Vec::new();
        for effect in Implicit::Springs.effects(system) {
            effect.visit_pairs(&mut |i, j| pairs.push((i, j)));
        }
        let matrix = UnsymmetricBlocks::with_pattern(system.len(), pairs);
        Ok(Self {
            potential: IncrementalPotential::new(system, Implicit::Springs),
            factor: BlockLu::new(&matrix)?,
            matrix,
            h: 0.0,
            start: zeros(),
            end: zeros(),
            force: zeros(),
            residual: zeros(),
            filtered: zeros(),
            direction: zeros(),
            trial: zeros(),
            best: zeros(),
            evaluations: 0,
            most: u32::try_from(MOST_WORK / system.len().max(1)).unwrap_or(u32::MAX).max(1),
            left: 0,
        })
    }

    /// Begins a step, whose parts share its iterations.
    pub(crate) fn refill(&mut self) {
        self.left = self.most;
    }

    /// Whether the step has used up its iterations. What is not solved then stays unsolved.
    pub(crate) fn is_spent(&self) -> bool {
        self.left == 0
    }

    /// Begins a step of `h` seconds from `level`; `explicit` are the forces that stay as they are
    /// there, N.
    pub(crate) fn begin(&mut self, system: &System, h: f64, level: Level<'_>, explicit: &[Vec3]) {
        self.h = h;
        self.evaluations = 0;
        self.start.copy_from_slice(level.x);
        self.potential.begin(system, 0.5 * h, (level.x, level.v), level, explicit);
    }

    /// Evaluates `r(v̄) = M (v̄ − v_n) − h/2 (F̄ − D v̄ + f_explicit)`, (2), and returns `‖S r‖`.
    pub(crate) fn evaluate(
        &mut self,
        system: &System,
        constraints: &Constraints,
        v: &[Vec3],
    ) -> f64 {
        self.evaluations += 1;
        for i in 0..v.len() {
            self.end[i] = self.start[i] + v[i] * self.h;
        }
        self.force.fill(Vec3::zeros());
        for effect in Implicit::Springs.effects(system) {
            add_mean_force(effect, &self.start, &self.end, &mut self.force);
        }
        let damped = Implicit::Springs.effects(system).filter(|effect| effect.has_damping());
        let at = Level { t: 0.0, x: &self.start, v };
        system.add_forces(damped.map(|effect| (effect, Part::Damping)), at, &mut self.force);
        let (mass, target) = (system.mass(), self.potential.target());
        for i in 0..v.len() {
            self.residual[i] = (v[i] - target[i]) * mass[i] - self.force[i] * (0.5 * self.h);
        }
        self.filtered.copy_from_slice(&self.residual);
        self.potential.filtered_norm(constraints, &mut self.filtered)
    }

    /// Writes a candidate for the start of Newton's method to `v`: `v_n`, the guess, or the
    /// velocity without springs.
    fn candidate(
        &self,
        which: usize,
        starts: Starts<'_>,
        constraints: &Constraints,
        v: &mut [Vec3],
    ) {
        v.copy_from_slice([starts.old, starts.guess, self.potential.target()][which % CANDIDATES]);
        constraints.impose(v);
    }

    /// Solves `S r(v̄) = 0` under constraints for `v`. Newton's method starts from the candidate
    /// with the least residual and, where that leads nowhere, from the others.
    ///
    /// # Errors
    /// [`StepError::Solver`] for numbers that are not finite.
    pub(crate) fn solve(
        &mut self,
        system: &System,
        constraints: &Constraints,
        settings: &EnergyMomentumSettings,
        starts: Starts<'_>,
        v: &mut [Vec3],
        report: &mut StepReport,
    ) -> Result<SolveStatus, StepError> {
        let before = self.evaluations;
        let (mut best, mut least) = (0, f64::INFINITY);
        for which in 0..CANDIDATES {
            self.candidate(which, starts, constraints, v);
            let norm = self.evaluate(system, constraints, v);
            if norm < least {
                (best, least) = (which, norm);
            }
        }
        let (mut status, mut norm) = (SolveStatus::IterationLimit, f64::INFINITY);
        for which in 0..CANDIDATES {
            self.candidate(best + which, starts, constraints, v);
            let (end, reached) = self.iterate(system, constraints, settings, v, report)?;
            if reached < norm || end == SolveStatus::Converged {
                (status, norm) = (end, reached);
                self.best.copy_from_slice(v);
            }
            if end == SolveStatus::Converged || self.is_spent() {
                break;
            }
        }
        if status != SolveStatus::Converged {
            v.copy_from_slice(&self.best);
            norm = self.evaluate(system, constraints, v);
        }
        report.force_evaluations += self.evaluations - before;
        report.relative_residual = report.relative_residual.max(self.potential.relative(norm));
        let wanted = settings.residual * self.potential.scale();
        Ok(self.potential.status(status, norm, wanted))
    }

    /// Newton's method from `v`. Returns how it ended, and the residual.
    fn iterate(
        &mut self,
        system: &System,
        constraints: &Constraints,
        settings: &EnergyMomentumSettings,
        v: &mut [Vec3],
        report: &mut StepReport,
    ) -> Result<(SolveStatus, f64), StepError> {
        let round_off = self.potential.round_off();
        let goal = round_off.max(settings.residual * self.potential.scale());
        let mut norm = self.evaluate(system, constraints, v);
        for _ in 0..settings.max_iterations {
            if norm <= goal {
                return Ok((SolveStatus::Converged, norm));
            }
            if self.is_spent() {
                break;
            }
            self.left -= 1;
            self.assemble(system, constraints, v);
            report.newton_iterations += 1;
            report.factorisations += 1;
            if let Err(error) = self.factor.factorise(&self.matrix) {
                let is_result = norm.is_finite();
                return if is_result {
                    Ok((SolveStatus::Stagnated, norm))
                } else {
                    Err(error.into())
                };
            }
            self.factor.solve(&self.filtered, &mut self.direction);
            constraints.project(&mut self.direction);
            let Some(less) = self.descend(system, constraints, norm, v) else {
                let is_solved = norm <= NEAR_ROUND_OFF * round_off;
                let norm = self.evaluate(system, constraints, v);
                let end = if is_solved { SolveStatus::Converged } else { SolveStatus::Stagnated };
                return Ok((end, norm));
            };
            norm = less;
        }
        let is_solved = norm <= goal;
        Ok((if is_solved { SolveStatus::Converged } else { SolveStatus::IterationLimit }, norm))
    }

    /// Takes the longest of the steps `1, ½, ¼, …` along `−direction` that lowers the residual
    /// `norm`, and returns the new one; `None` where no step does.
    fn descend(
        &mut self,
        system: &System,
        constraints: &Constraints,
        norm: f64,
        v: &mut [Vec3],
    ) -> Option<f64> {
        let mut trial = std::mem::take(&mut self.trial);
        let (mut length, mut found) = (1.0, None);
        for _ in 0..=MAX_HALVINGS {
            for i in 0..v.len() {
                trial[i] = v[i] - self.direction[i] * length;
            }
            let less = self.evaluate(system, constraints, &trial);
            if less <= (1.0 - SUFFICIENT_DECREASE * length) * norm {
                v.copy_from_slice(&trial);
                found = Some(less);
                break;
            }
            length *= 0.5;
        }
        self.trial = trial;
        found
    }

    /// `A = ∂r/∂v̄ = M + h/2 (h ∂F̄ + D)` at `v`, (4), projected to the constraints.
    fn assemble(&mut self, system: &System, constraints: &Constraints, v: &[Vec3]) {
        let Self { matrix, start, end, h, .. } = self;
        for i in 0..v.len() {
            end[i] = start[i] + v[i] * *h;
        }
        matrix.clear();
        for (i, m) in system.mass().iter().enumerate() {
            matrix.add_diagonal(i, &Mat3::from_diagonal_element(*m));
        }
        for split in Implicit::Springs.effects(system).filter_map(Effect::split) {
            split.visit_discrete_gradients(start, end, &mut |i, j, g, slope| {
                let (d, new) = (start[i] - start[j], end[i] - end[j]);
                let length = new.norm();
                let u = if length > 0.0 { new / length } else { new };
                // ∂F̄/∂d₊ = −[g I + g' (d_n + d₊) û₊ᵀ]
                let block = Mat3::from_diagonal_element(g) + (d + new) * (u * slope).transpose();
                matrix.add_pair(i, j, &(block * (0.5 * *h * *h)));
            });
            split.visit_weights(&mut |i, j, _, c| {
                if c > 0.0 {
                    matrix.add_pair(i, j, &Mat3::from_diagonal_element(0.5 * *h * c));
                }
            });
        }
        matrix.project(constraints);
    }
}
