//! The robust form of updated CG: EEH Algorithm 1 with energy safeguards.
//!
//! ```text
//! b(v) = M v_n + h [F_frozen − L_k x_n + F2(x_n + h v)]                 (U1)
//! A v  = b(v), by CG until ‖S (b − A v)‖ ≤ √m_min · goal                (U2)
//! ∇Φ(v) = 0, by Newton's method where (U1) and (U2) do not converge     (U3)
//! ½‖v‖²_M + U(x_n + h v) ≤ H_n                                          (U4)
//! A v  = b(0), which is IMEX Euler, where (U4) cannot be had            (U5)
//! ```

use super::updated::Problem;
use crate::right_hand_side::RightHandSide;
use drape_integrator::{
    Forcing, ForcingKind, ForcingRule, Implicit, IncrementalPotential, LaplacianSolver, Newton,
    NewtonLinear, NewtonSettings, PrepareError, Safeguard, SolveStatus, StepError, StepReport,
    lightest_free_mass,
};
use drape_model::{Obstacle, Revisions, State, System, Vec3};

/// A residual below this fraction of the scale counts as converged, whatever the energy does.
const CONVERGED: f64 = 1e-9;
/// Factor of the tolerance after a step that gained energy.
const TIGHTEN: f64 = 0.1;
const MAX_NEWTON_ITERATIONS: u32 = 100;

/// Minimises the incremental potential `Φ`.
#[derive(Debug)]
pub(crate) struct Descent {
    potential: IncrementalPotential,
    newton: Newton,
    by_newton: bool,
    /// `max k (1/m_i + 1/m_j)/2` of the implicit springs, 1/s², and the system that it belongs to.
    stiffness: Option<(Revisions, f64)>,
}

impl Descent {
    /// Minimises from `v`. A result that gains energy is accepted only when it has converged. Where
    /// it cannot converge, a step of IMEX Euler replaces it, which with full damping never gains
    /// energy.
    pub(super) fn minimise(
        &mut self,
        problem: Problem<'_>,
        rhs: &mut RightHandSide,
        linear: &mut LaplacianSolver,
        v: &mut [Vec3],
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let Problem { system, state, h, constraints, .. } = problem;
        let Targets { updates, frame, allowed, tightest, wanted, mut tolerance } =
            self.targets(problem);
        report.force_evaluations += 1;
        constraints.impose(v);
        loop {
            // (U1) and (U2) in turn
            let converged =
                updates && self.update_until(problem, rhs, linear, v, tolerance, report);
            self.by_newton = !converged;
            if !converged {
                if linear.slopes().is_some() {
                    // Slopes that are not the steepest ones promise no descent.
                    v.copy_from_slice(&state.v);
                    constraints.impose(v);
                }
                self.finish(problem, v, tolerance, report)?; // ∇Φ(v) = 0, (U3)
            }
            report.force_evaluations += 1;
            // ½‖v‖²_M + U(x_n + h v) > H_n, (U4)
            let gained = self.energy(problem, frame, v) > allowed;
            if gained && report.solve != SolveStatus::Converged {
                let status = report.solve;
                self.by_newton = false;
                v.fill(Vec3::zeros());
                rhs.update(system, state, h, v, linear.slopes()); // b(0) = b of EEH (21), (U5)
                *report += linear.solve_to(constraints, &rhs.b, v, tightest * lightest(system));
                report.relative_residual *= tightest;
                report.solve = status;
            } else if gained && tolerance > tightest {
                tolerance = (tolerance * TIGHTEN).max(tightest);
                continue;
            }
            report.solve = self.potential.status(report.solve, report.relative_residual, wanted);
            report.relative_residual = self.potential.relative(report.relative_residual);
            return Ok(());
        }
    }

    /// Updates until one leaves a residual below `tolerance`, √J; `false` at the outer cap.
    fn update_until(
        &mut self,
        problem: Problem<'_>,
        rhs: &mut RightHandSide,
        linear: &mut LaplacianSolver,
        v: &mut [Vec3],
        tolerance: f64,
        report: &mut StepReport,
    ) -> bool {
        let Problem { system, state, h, constraints, settings, .. } = problem;
        let lightest = lightest(system);
        let direct = linear.is_direct();
        let follows_progress = settings.forcing == ForcingKind::EisenstatWalker;
        let mut forcing = Forcing::new(ForcingRule::EisenstatWalker);
        while report.outer_passes < settings.max_outer {
            rhs.update(system, state, h, v, linear.slopes()); // b(v), (U1)
            report.outer_passes += 1;
            // The iteration count of a direct solve says nothing about the update.
            let mut goal = tolerance;
            if direct || follows_progress {
                let residual = linear.residual(constraints, &rhs.b, v) / lightest;
                report.matvecs += 1;
                report.solve = SolveStatus::Converged;
                if residual <= tolerance {
                    report.relative_residual = residual;
                    return true;
                }
                if follows_progress {
                    goal = residual * forcing.next(residual, tolerance);
                }
            }
            let solve = linear.solve_to(constraints, &rhs.b, v, goal * lightest); // A v = b, (U2)
            *report += solve;
            report.relative_residual *= goal;
            if !direct && solve.iterations == 0 && solve.status == SolveStatus::Converged {
                return true;
            }
            if solve.status == SolveStatus::Stagnated || solve.status == SolveStatus::Indefinite {
                return false;
            }
        }
        false
    }

    /// Newton's method from where the updates stopped.
    fn finish(
        &mut self,
        problem: Problem<'_>,
        v: &mut [Vec3],
        tolerance: f64,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let settings = NewtonSettings {
            residual: tolerance,
            max_iterations: MAX_NEWTON_ITERATIONS,
            safeguard: Safeguard::None,
        };
        let Problem { system, constraints, .. } = problem;
        *report += self.newton.minimise(system, &mut self.potential, constraints, v, &settings)?;
        Ok(())
    }

    /// Total energy after the step, J, in a frame that moves at `frame`. There gravity pulls on a
    /// cloth that has moved less far by `h` times that velocity.
    fn energy(&mut self, problem: Problem<'_>, frame: Vec3, v: &[Vec3]) -> f64 {
        let Problem { system, h, .. } = problem;
        let potential = system.potential_energy(self.potential.positions(v));
        let energy = kinetic_energy(system, v, frame) + potential;
        if frame == Vec3::zeros() {
            energy
        } else {
            energy + h * frame.dot(&self.potential.external_force())
        }
    }

    /// The targets of a step.
    fn targets(&mut self, problem: Problem<'_>) -> Targets {
        let Problem { system, state, h, settings, .. } = problem;
        let theta = h * h * self.stiffness(settings.implicit, system);
        let (scale, floor) = (self.potential.scale(), self.potential.round_off());
        let frame = frame(problem);
        let kinetic = kinetic_energy(system, &state.v, frame);
        let potential = system.potential_energy(&state.x);
        let wanted = settings.forcing_term * scale;
        Targets {
            frame,
            updates: theta <= settings.newton_above * (1.0 + 1e-12),
            allowed: kinetic
                + potential
                + 1e-9 * scale * scale
                + 1e-12 * (kinetic + potential.abs()),
            tightest: (CONVERGED * scale).max(floor),
            wanted,
            tolerance: wanted.max(floor),
        }
    }
}

/// The limits within which a step is solved.
struct Targets {
    /// Whether updates are tried at all, or Newton's method starts at once.
    updates: bool,
    /// The frame in which energy is measured, m/s.
    frame: Vec3,
    /// `H_n` and its round-off, J.
    allowed: f64,
    /// The tightest tolerance, √J.
    tightest: f64,
    /// The tolerance that the settings ask for, √J.
    wanted: f64,
    /// The tolerance to begin with, √J: not below round-off.
    tolerance: f64,
}

/// The velocity of the frame in which a step may not gain energy, m/s: that of the pins, else of
/// the air, else of the first obstacle. They do no work there, so the step does not depend on how
/// fast the scene moves as a whole.
fn frame(Problem { system, state, h, constraints, .. }: Problem<'_>) -> Vec3 {
    let pins = system.pins();
    if !pins.is_empty() {
        if system.moving_pins().is_empty() {
            return Vec3::zeros();
        }
        let velocities = pins.iter().map(|&pin| constraints.prescribed(pin as usize));
        return velocities.sum::<Vec3>() / pins.len() as f64;
    }
    if let Some(drag) = system.effects().find(|effect| effect.is_drag()) {
        return drag.medium_velocity(state.t);
    }
    let velocity = |obstacle: &Obstacle| {
        let moves = obstacle.path.is_some();
        let way = || obstacle.offset(state.t + h) - obstacle.offset(state.t);
        if moves { way() / h } else { Vec3::zeros() }
    };
    system.obstacles().first().map_or(Vec3::zeros(), velocity)
}

/// Kinetic energy in a frame that moves at `frame`, J.
fn kinetic_energy(system: &System, v: &[Vec3], frame: Vec3) -> f64 {
    if frame == Vec3::zeros() {
        return system.kinetic_energy(v);
    }
    system.mass().iter().zip(v).map(|(m, v)| 0.5 * m * (v - frame).norm_squared()).sum()
}

/// `√m` of the lightest particle that moves: `‖r‖` in the norm of `M⁻¹` is at most `‖r‖` over this.
fn lightest(system: &System) -> f64 {
    lightest_free_mass(system).sqrt()
}

/// Memory and lookups.
impl Descent {
    pub(crate) fn new(system: &System, implicit: Implicit) -> Result<Self, PrepareError> {
        let potential = IncrementalPotential::new(system, implicit);
        let newton = Newton::new(system, &potential, NewtonLinear::CHOLESKY)?;
        Ok(Self { potential, newton, by_newton: false, stiffness: None })
    }

    /// Begins a step.
    pub(crate) fn begin(&mut self, system: &System, state: &State, h: f64, frozen: &[Vec3]) {
        self.potential.begin(system, h, (&state.x, &state.v), state.level(), frozen);
    }

    /// Puts the better of `v` and `other` into `v`.
    pub(crate) fn choose(&mut self, problem: Problem<'_>, v: &mut [Vec3], other: &[Vec3]) {
        self.potential.choose_start(problem.system, problem.constraints, v, &[other], false);
    }

    /// `∇Φ(v)`, unfiltered: the impulse of the constraints, kg m/s.
    pub(crate) fn gradient(&mut self, system: &System, v: &[Vec3]) -> &[Vec3] {
        self.potential.gradient(system, v)
    }

    /// Evaluations of forces and energies since the step began.
    pub(crate) fn evaluations(&self) -> u32 {
        self.potential.evaluations()
    }

    /// Whether Newton's method ended the last solve, and not an update of the right-hand side.
    pub(crate) fn by_newton(&self) -> bool {
        self.by_newton
    }

    /// The greatest stiffness over mass, computed once for each revision of the system.
    fn stiffness(&mut self, implicit: Implicit, system: &System) -> f64 {
        let now = system.revisions();
        match self.stiffness {
            Some((then, stiffness)) if then == now => stiffness,
            _ => {
                let stiffness = implicit.max_stiffness_over_mass(system);
                self.stiffness = Some((now, stiffness));
                stiffness
            }
        }
    }
}

#[cfg(test)]
mod tests;
