//! The reference of the stop test of a linear solve.
//!
//! `|b|` is not suitable, because it grows for three reasons that do not matter. It holds the
//! momentum `M v_n`, so a fast sheet would be solved too loosely. Across the springs it grows like
//! `θ`: there `b = A v`, and `A` has the full stiffness in directions in which the springs have
//! none. And one heavy particle hides the residuals of all light ones.

use crate::{ContactSet, LaplacianSolver};
use drape_model::{Effect, EffectKind, Revisions, State, System, Vec3};
use drape_solvers::bands::{PerBlock, bands, in_bands};
use drape_solvers::vector::BLOCK;
use drape_solvers::{Constraints, Norm, Reference};
use std::ops::Range;

/// Round-off of `A v` over `|A| |v|`, and of a force over `k |x|`.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

/// The stop test of a linear solve `A v = b`: the norm of the residual `r`, and its reference. `p`
/// is the impulse of the forces of the old level, and `m_min` the lightest free mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopNorm {
    /// `|S r| ≤ ε m_min |M⁻¹ S p|`: the error of each particle's velocity is a fraction of the
    /// change of velocity that the forces make. The test is the same in every frame.
    Velocity,
    /// `|S r| ≤ ε |S b|`, as Eberhardt, Etzmuß and Hauth print it.
    Euclid,
    /// As [`Velocity`](Self::Velocity), with both sides in the norm `√(rᵀPr)` of the
    /// preconditioner.
    Preconditioned,
}

impl StopNorm {
    /// The norm of the residual.
    pub fn residual(self) -> Norm {
        match self {
            Self::Velocity | Self::Euclid => Norm::Euclid,
            Self::Preconditioned => Norm::Preconditioned,
        }
    }
}

/// The lightest mass of a particle that is not pinned, kg; 1 where all are pinned.
pub fn lightest_free_mass(system: &System) -> f64 {
    let free = system.mass().iter().zip(system.pinned()).filter(|(_, pinned)| !**pinned);
    let mass = free.fold(f64::INFINITY, |least, (&m, _)| least.min(m));
    if mass.is_finite() { mass } else { 1.0 }
}

/// The start of a step, and the time constant `τ` of its solve, s.
#[derive(Clone, Copy, Debug)]
pub struct StepStart<'a> {
    /// System of the step.
    pub system: &'a System,
    /// State at level `n`.
    pub state: &'a State,
    /// Time constant of the solve, s.
    pub tau: f64,
    /// Whether the step rounds positions before it evaluates the forces there.
    pub rounds_positions: bool,
}

/// Sums over the particles of a block, and the largest vectors in it.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// `|m_min M⁻¹ S p|²` of all forces.
    impulse: f64,
    /// The same of the external forces.
    external: f64,
    /// Largest `|x|²`.
    reach: f64,
    /// Largest `|v|²`, of the old level or prescribed.
    speed: f64,
}

/// How large velocities are, for the round-off of residuals.
#[derive(Clone, Copy, Debug)]
struct Size {
    /// Largest velocity, m/s.
    speed: f64,
    /// Largest distance from the origin over `τ`, m/s; 0 where the step rounds no positions.
    reach: f64,
}

impl Size {
    /// Round-off of a residual on rows of the matrix with these springs and this diagonal, kg m/s.
    fn round_off(self, springs: f64, diagonal: f64) -> f64 {
        ROUND_OFF * (springs * self.reach + diagonal * self.speed)
    }
}

impl Sums {
    fn add(self, other: Self) -> Self {
        Self {
            impulse: self.impulse + other.impulse,
            external: self.external + other.external,
            reach: self.reach.max(other.reach),
            speed: self.speed.max(other.speed),
        }
    }
}

/// Computes the reference of the stop test of each step.
///
/// The reference is the impulse that would change the velocity of a particle of the lightest mass
/// as the forces of level `n` change that of each particle in a step. If the same impulse of the
/// external forces alone is greater, it is used instead, so a sheet that hangs at rest has a
/// reference. `ε` times the reference is never below round-off. Each row counts with the lightest
/// mass over its own, because the round-off of a heavy particle would hide the light ones. The row
/// of a heavy particle itself may stay above the reference; see [`LaplacianSolver::solve_from`].
///
/// Particles that friction holds count as free along the surface, because the reference must also
/// be correct if they turn out to slide.
#[derive(Debug)]
pub struct StepReference {
    norm: StopNorm,
    forcing_term: f64,
    lightest: Option<(Revisions, f64)>,
    blocks: Vec<Sums>,
    /// External forces that are no uniform field, N; empty where there are none.
    external: Vec<Vec3>,
    /// Scratch; empty unless the norm is that of the preconditioner.
    scratch: Vec<Vec3>,
}

/// The acceleration of an effect that is a uniform field, m/s².
fn field(effect: &dyn Effect) -> Option<Vec3> {
    let mut acceleration = [Vec3::zeros()];
    let is_uniform = effect.kind() == EffectKind::Gravity;
    is_uniform.then(|| {
        effect.add_force(&[1.0], &[Vec3::zeros()], &mut acceleration);
        acceleration[0]
    })
}

fn external(system: &System) -> impl Iterator<Item = &dyn Effect> {
    system.effects().filter(|effect| !effect.has_jacobian())
}

impl StepReference {
    /// Memory for the steps of a system with this solver.
    pub fn new(system: &System, linear: &LaplacianSolver) -> Self {
        let n = system.len();
        let settings = linear.settings();
        let zeros = |wanted: bool| vec![Vec3::zeros(); if wanted { n } else { 0 }];
        let is_other = |effect: &dyn Effect| field(effect).is_none();
        Self {
            norm: settings.norm,
            forcing_term: settings.forcing_term,
            lightest: None,
            blocks: vec![Sums::default(); n.div_ceil(BLOCK)],
            external: zeros(external(system).any(is_other)),
            scratch: zeros(settings.norm == StopNorm::Preconditioned),
        }
    }

    /// The reference of a step. `impulse` is `p`, kg m/s: `τ` times the forces of level `n` on each
    /// particle.
    pub fn of(
        &mut self,
        start: StepStart<'_>,
        linear: &mut LaplacianSolver,
        contacts: &mut ContactSet,
        constraints: &mut Constraints,
        impulse: impl Fn(usize) -> Vec3 + Sync,
    ) -> Reference {
        if self.norm == StopNorm::Euclid || linear.solves_directly(constraints) {
            return Reference::FilteredRightHandSide;
        }
        let field = self.evaluate_external(start);
        contacts.without_friction(start.system, constraints, |constraints| {
            let (lightest, sums) = self.sum(start, constraints, field, &impulse);
            let reach = if start.rounds_positions { sums.reach.sqrt() / start.tau } else { 0.0 };
            let size = Size { speed: sums.speed.sqrt(), reach };
            let (value, round_off) = if self.norm == StopNorm::Preconditioned {
                self.preconditioned(start, linear, constraints, (lightest, field), size, &impulse)
            } else {
                let (springs, diagonal) = linear.row_norms();
                let round_off = size.round_off(springs, diagonal);
                (sums.impulse.max(sums.external).sqrt(), round_off)
            };
            Reference::Absolute(value.max(round_off / self.forcing_term))
        })
    }

    /// The reference and the round-off in the norm of the preconditioner.
    fn preconditioned(
        &mut self,
        StepStart { system, tau, .. }: StepStart<'_>,
        linear: &mut LaplacianSolver,
        constraints: &Constraints,
        (lightest, field): (f64, Vec3),
        size: Size,
        impulse: &impl Fn(usize) -> Vec3,
    ) -> (f64, f64) {
        let Self { scratch, external, .. } = self;
        let ratio = |i: usize| lightest / system.mass()[i];
        scratch.iter_mut().enumerate().for_each(|(i, s)| *s = impulse(i) * ratio(i));
        let total = linear.filtered_norm(constraints, scratch);
        scratch.fill(field * (lightest * tau));
        for (i, (s, f)) in scratch.iter_mut().zip(&*external).enumerate() {
            *s += f * (ratio(i) * tau);
        }
        let external = linear.filtered_norm(constraints, scratch);
        for (i, (s, m)) in scratch.iter_mut().zip(system.mass()).enumerate() {
            let diagonal = linear.matrix().diagonal(i);
            s.fill(size.round_off(diagonal - m, diagonal) * (lightest / m));
        }
        (total.max(external), linear.filtered_norm(constraints, scratch))
    }

    /// Evaluates the external forces. Returns the acceleration of uniform fields, m/s².
    fn evaluate_external(&mut self, StepStart { system, state, .. }: StepStart<'_>) -> Vec3 {
        self.external.fill(Vec3::zeros());
        let mut acceleration = Vec3::zeros();
        for effect in external(system) {
            match field(effect) {
                Some(field) => acceleration += field,
                None => effect.add_force(system.mass(), &state.x, &mut self.external),
            }
        }
        acceleration
    }

    /// The lightest free mass, and the sums over all particles.
    fn sum(
        &mut self,
        StepStart { system, state, tau, .. }: StepStart<'_>,
        constraints: &Constraints,
        field: Vec3,
        impulse: &(impl Fn(usize) -> Vec3 + Sync),
    ) -> (f64, Sums) {
        let now = system.revisions();
        let lightest = match self.lightest {
            Some((then, lightest)) if then == now => lightest,
            _ => lightest_free_mass(system),
        };
        self.lightest = Some((now, lightest));
        let (mass, other) = (system.mass(), &self.external);
        let of_block = |particles: Range<usize>| {
            let mut sums = Sums::default();
            for i in particles {
                let (filter, ratio) = (constraints.filter(i), lightest / mass[i]);
                let other = other.get(i).map_or(field * lightest, |f| field * lightest + f * ratio);
                sums.impulse += filter.apply(impulse(i) * ratio).norm_squared();
                sums.external += filter.apply(other * tau).norm_squared();
                sums.reach = sums.reach.max(state.x[i].norm_squared());
                // A pin that is led moves at its prescribed velocity, whatever it did before.
                let led = constraints.prescribed(i).norm_squared();
                sums.speed = sums.speed.max(state.v[i].norm_squared()).max(led);
            }
            sums
        };
        let n = system.len();
        let bands = bands(system.threads(), n);
        in_bands(bands, n, PerBlock(&mut self.blocks), &|particles, blocks| {
            for (k, sums) in blocks.0.iter_mut().enumerate() {
                let first = particles.start + k * BLOCK;
                *sums = of_block(first..particles.end.min(first + BLOCK));
            }
        });
        (lightest, self.blocks.iter().fold(Sums::default(), |sum, block| sum.add(*block)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::net;
    use crate::{Implicit, LinearSettings, PreconditionerKind, SolverKind, Weights};

    /// Pairs on springs, all at rest at 1 m from the origin: round-off alone sets the reference. The
    /// springs' part of the matrix grows with the root of their number; the reach does not grow.
    #[test]
    fn the_reach_is_that_of_the_farthest_particle_however_many_there_are() {
        let reference = |pairs: usize| {
            let x = [Vec3::x(), Vec3::y()].repeat(pairs);
            let springs: Vec<_> = (0..pairs).map(|i| (2 * i, 2 * i + 1, 1e3, 1.0)).collect();
            let (system, state) = net("tension", &vec![1.0; 2 * pairs], &x, &springs, &[]);
            let settings = LinearSettings {
                forcing_term: 1e-3,
                preconditioner: PreconditionerKind::Jacobi,
                norm: StopNorm::Velocity,
                solver: SolverKind::Cg,
                rebuild_every_step: false,
            };
            let (tau, weights) = (0.01, Weights::StiffnessAndDamping);
            let linear = LaplacianSolver::new(&system, Implicit::Springs, weights, settings, tau);
            let mut linear = linear.expect("a solver");
            linear.refresh(&system, tau).expect("a matrix");
            let mut contacts = ContactSet::new(&system);
            let mut constraints = Constraints::free(system.len());
            let start = StepStart { system: &system, state: &state, tau, rounds_positions: true };
            let found = StepReference::new(&system, &linear).of(
                start,
                &mut linear,
                &mut contacts,
                &mut constraints,
                |_| Vec3::zeros(),
            );
            let Reference::Absolute(value) = found else { panic!("{found:?}") };
            value
        };
        let (one, many) = (reference(1), reference(4 * BLOCK));
        let expected = one * (4.0 * BLOCK as f64).sqrt();
        assert!(one > 0.0 && (many / expected - 1.0).abs() < 1e-12, "{many:e} {expected:e}");
    }
}
