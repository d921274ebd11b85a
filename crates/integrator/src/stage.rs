//! One implicit stage with pins and contacts: what backward Euler, the BDF methods and the start-up of
//! two-step methods share.

use crate::{
    ContactSet, Implicit, IncrementalPotential, Kind, Newton, NewtonSettings, Phase, PhaseClock,
    PrepareError, Setting, Settings, StepError, StepReport,
};
use drape_model::{System, Vec3};
use drape_solvers::Constraints;

/// When Newton's method stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageSettings {
    /// Residual over the change of velocity that the forces would make; never below round-off.
    pub residual: f64,
    /// Most iterations.
    pub max_iterations: u32,
}

impl StageSettings {
    /// Setting `residual`.
    pub const RESIDUAL: Setting = Setting {
        key: "residual",
        kind: Kind::Number { min: 1e-16, max: 0.5 },
        default: "1e-9",
        help: "residual at which Newton stops, relative to the change of velocity that the forces would make; \
               never below round-off",
    };
    /// Setting `max_iterations`.
    pub const MAX_ITERATIONS: Setting = Setting {
        key: "max_iterations",
        kind: Kind::Integer { min: 1, max: 10_000 },
        default: "100",
        help: "most Newton iterations in a step",
    };

    /// Reads the two settings, both of which the method must declare.
    pub fn read(settings: &Settings) -> Self {
        Self {
            residual: settings.number("residual"),
            max_iterations: settings.integer("max_iterations") as u32,
        }
    }
}

impl Default for StageSettings {
    fn default() -> Self {
        Self { residual: 1e-9, max_iterations: 100 }
    }
}

/// What defines a stage: `M (v − v*) = τ f(x, v)`, `x = x* + τ v`. It is EEH (10), `x'' = M⁻¹ f(x, x')` as a system of
/// first order, under any implicit method; Newton's iteration has the `3n` unknowns of section 2.3, since `x`
/// follows from `v`.
///
/// | method | `τ` | `x*` | `v*` |
/// |---|---|---|---|
/// | backward Euler | `h` | `x_n` | `v_n` |
/// | `k`-step BDF | `h β_k/α_k` | `−Σ_{j<k} α_j x_{n+j} / α_k` | likewise of `v` |
/// | implicit midpoint, then `y_{n+1} = 2y − y_n` | `h/2` | `x_n` | `v_n` |
#[doc(alias = "EEH 10")]
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// `τ`, s.
    pub tau: f64,
    /// `(x*, v*)`, m and m/s.
    pub from: (&'a [Vec3], &'a [Vec3]),
    /// Positions and velocities at which everything is taken that is not implicit: explicit forces, and
    /// the directions of projected damping. A method of order `p` needs them within `O(h^p)` of the new ones.
    pub lagged: (&'a [Vec3], &'a [Vec3]),
    /// Velocity at the start of the step, m/s: what contacts bounce with, and the first candidate for the
    /// start of Newton's method.
    pub velocity: &'a [Vec3],
}

/// Solves stages of one system by [`Newton`]; every effect with a Jacobian is implicit.
#[derive(Debug)]
pub struct ImplicitStage {
    potential: IncrementalPotential,
    newton: Newton,
    frozen: Vec<Vec3>,
    velocity: Vec<Vec3>,
    impulse: Vec<Vec3>,
}

impl ImplicitStage {
    /// Memory and symbolic factorisation.
    ///
    /// # Errors
    /// [`PrepareError::Solver`] when the symbolic factorisation fails.
    pub fn new(system: &System) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let potential = IncrementalPotential::new(system, Implicit::Everything);
        let newton = Newton::new(system, &potential)?;
        Ok(Self { potential, newton, frozen: zeros(), velocity: zeros(), impulse: zeros() })
    }

    /// Solves a stage from whichever of `stage.velocity`, `start` and the inertial target has the lowest
    /// potential. Contacts are those at `x*`.
    ///
    /// # Errors
    /// As [`Newton::minimise`].
    #[expect(clippy::too_many_arguments, reason = "each is owned by the method that calls")]
    pub fn solve(
        &mut self,
        system: &System,
        stage: Stage<'_>,
        start: &[Vec3],
        contacts: &mut ContactSet,
        constraints: &mut Constraints,
        settings: StageSettings,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        clock.switch(Phase::Contact);
        contacts.detect(system, stage.from.0, stage.velocity, stage.tau, constraints);
        self.solve_constrained(system, stage, start, contacts, constraints, settings, clock, report)
    }

    /// As [`solve`](Self::solve) under the contacts that `contacts` has detected already.
    ///
    /// # Errors
    /// As [`Newton::minimise`].
    #[expect(clippy::too_many_arguments, reason = "each is owned by the method that calls")]
    pub fn solve_constrained(
        &mut self,
        system: &System,
        stage: Stage<'_>,
        start: &[Vec3],
        contacts: &mut ContactSet,
        constraints: &mut Constraints,
        settings: StageSettings,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let Stage { tau, from, lagged: (x, v), velocity: v_n } = stage;
        let Self { potential, newton, frozen, velocity, impulse } = self;
        clock.switch(Phase::Forces);
        frozen.fill(Vec3::zeros());
        potential.implicit().add_explicit_forces(system, x, v, frozen);
        potential.begin(system, tau, from, x, frozen);
        clock.switch(Phase::Solve);
        let settings = NewtonSettings {
            residual: (settings.residual * potential.scale()).max(potential.round_off()),
            max_iterations: settings.max_iterations,
        };
        velocity.copy_from_slice(v_n);
        contacts.solve(system, constraints, impulse, |constraints, impulse| {
            potential.choose_start(system, constraints, velocity, &[start], true);
            *report += newton.minimise(system, potential, constraints, velocity, &settings)?;
            if let Some(impulse) = impulse {
                impulse.copy_from_slice(potential.gradient(system, velocity)); // ∇Φ, unfiltered
            }
            Ok::<(), StepError>(())
        })?;
        report.relative_residual = potential.relative(report.relative_residual);
        report.force_evaluations += potential.evaluations();
        Ok(())
    }

    /// Force of what was not implicit in the last stage, at `stage.lagged`, N.
    pub fn explicit_force(&self) -> &[Vec3] {
        &self.frozen
    }

    /// `v`, the solution of the last stage, m/s.
    pub fn velocity(&self) -> &[Vec3] {
        &self.velocity
    }

    /// `x* + τ v` of the last stage, m.
    pub fn positions(&mut self) -> &[Vec3] {
        self.potential.positions(&self.velocity)
    }
}
