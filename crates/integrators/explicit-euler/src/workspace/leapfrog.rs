//! Scratch memory of leapfrog: the force that the next step reuses, and what its damping needs.

use crate::settings::{LEAPFROG, LeapfrogSettings, StepControl};
use crate::stability_limit::StabilityLimit;
use drape_integrator::{
    ContactSet, Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, PrepareError,
    SolveStatus, StepError, StepReport, Weights, hold_pins, kick, lead_pins,
};
use drape_model::{Level, Part, Revisions, System, Vec3};
use drape_solvers::{Constraints, Filter, Norm};

/// Relative residual at which the conjugate gradients stop.
const TOLERANCE: f64 = 1e-14;

#[derive(Debug)]
pub(crate) struct LeapfrogWorkspace {
    /// `F`, the conservative force at the positions that `remembered` names, N.
    pub(crate) force: Vec<Vec3>,
    /// What `force` was evaluated for: the system, and the positions in `positions`.
    remembered: Option<Revisions>,
    positions: Vec<Vec3>,
    pub(crate) old_velocity: Vec<Vec3>,
    free_velocity: Vec<Vec3>,
    /// `v_{n+1}` before the contacts settle, m/s; filled only where there are any.
    pub(crate) unsettled: Vec<Vec3>,
    /// Number of substeps of the last step.
    pub(crate) last_substeps: u32,
    impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    /// The pins alone: what the second half kick obeys.
    pub(crate) pins: Constraints,
    /// Only where something is damped.
    pub(crate) damping: Option<Damping>,
    /// Only where steps are divided.
    limit: Option<StabilityLimit>,
}

#[derive(Debug)]
pub(crate) struct Damping {
    /// `M + h/2 L_c`.
    pub(crate) solver: LaplacianSolver,
    /// After a step: the remainder `R` of its last solve, N.
    pub(crate) force: Vec<Vec3>,
    pub(crate) right_hand_side: Vec<Vec3>,
}

impl LeapfrogWorkspace {
    pub(crate) fn new(
        system: &System,
        settings: LeapfrogSettings,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let linear = LinearSettings {
            forcing_term: TOLERANCE,
            preconditioner: PreconditionerKind::Jacobi,
            norm: Norm::Euclid,
            solver: settings.solver,
            rebuild_every_step: false,
        };
        let damping = || -> Result<Damping, PrepareError> {
            let springs = Implicit::Springs;
            let solver = LaplacianSolver::new(system, springs, Weights::Damping, linear, 0.5 * h)?;
            Ok(Damping { solver, force: zeros(), right_hand_side: zeros() })
        };
        let is_damped = system.effects().any(|effect| effect.has_damping());
        let limit = match settings.step {
            StepControl::Fixed => None,
            StepControl::Auto => Some(StabilityLimit::followed(system, settings.safety)),
            StepControl::Bound => {
                let limit = StabilityLimit::bound(system, settings.safety);
                let what = "step=bound with a stiffness that is no spring's".to_owned();
                let key = "effects".to_owned();
                Some(limit.ok_or(PrepareError::Unsupported { method: LEAPFROG.id, what, key })?)
            }
        };
        Ok(Self {
            force: zeros(),
            remembered: None,
            positions: zeros(),
            old_velocity: zeros(),
            free_velocity: zeros(),
            unsettled: zeros(),
            last_substeps: 0,
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            pins: Constraints::free(system.len()),
            damping: is_damped.then(damping).transpose()?,
            limit,
        })
    }

    /// Forgets the force, the contacts and the estimate of the stability limit.
    pub(crate) fn restart(&mut self) {
        self.remembered = None;
        self.contacts.restart();
        if let Some(limit) = &mut self.limit {
            limit.restart();
        }
    }

    /// How many equal substeps the next `h` seconds take.
    pub(crate) fn substeps(
        &mut self,
        system: &System,
        x: &[Vec3],
        h: f64,
        report: &mut StepReport,
    ) -> u32 {
        self.limit.as_mut().map_or(1, |limit| limit.substeps(system, x, h, report))
    }

    /// Brings the matrix, for substeps of `h` seconds, and the pins up to date.
    pub(crate) fn refresh(
        &mut self,
        system: &System,
        h: f64,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        if let Some(damping) = &mut self.damping {
            let cause = damping.solver.refresh(system, 0.5 * h)?;
            cause.into_iter().for_each(|cause| report.setups.count(cause));
        }
        self.pins.clear();
        hold_pins(system, &mut self.pins);
        Ok(())
    }

    /// Leads pins on paths through a substep of `h` seconds that starts at `t`.
    pub(crate) fn lead_pins(
        &mut self,
        system: &System,
        t: f64,
        h: f64,
        x: &[Vec3],
        v: &mut [Vec3],
    ) {
        lead_pins(system, t, h, x, v);
        for pin in system.moving_pins() {
            self.pins.set(pin.particle, Filter::Fixed, v[pin.particle]);
        }
    }

    /// Evaluates the force unless it is the one that the last step ended with.
    pub(crate) fn ensure_force(&mut self, system: &System, x: &[Vec3], report: &mut StepReport) {
        if self.remembered != Some(system.revisions()) || !same_bits(&self.positions, x) {
            self.evaluate_force(system, x, report);
        }
    }

    /// Keeps the force for a next step that starts at `x`.
    pub(crate) fn remember_force(&mut self, system: &System, x: &[Vec3]) {
        self.remembered = Some(system.revisions());
        self.positions.copy_from_slice(x);
    }

    /// `F(x)`.
    pub(crate) fn evaluate_force(&mut self, system: &System, x: &[Vec3], report: &mut StepReport) {
        let at = Level { t: 0.0, x, v: x }; // of which Part::Force takes the positions alone
        let effects = system.effects().map(|effect| (effect, Part::Force));
        system.write_forces(effects, at, &mut self.force);
        report.force_evaluations += 1;
    }

    /// Adds `−(h/2) M⁻¹ D(x_n) v_n` to `v`, `half` being `h/2`.
    pub(crate) fn kick_by_damping(
        &mut self,
        system: &System,
        (t, x): (f64, &[Vec3]),
        half: f64,
        v: &mut [Vec3],
    ) {
        let Some(Damping { force, .. }) = &mut self.damping else { return };
        let damped = system.effects().filter(|effect| effect.has_damping());
        let at = Level { t, x, v: &self.old_velocity };
        system.write_forces(damped.map(|effect| (effect, Part::Damping)), at, force);
        kick(system, half, force, v);
    }

    /// Pins and contacts on `v½`.
    pub(crate) fn project(&mut self, system: &System, v: &mut [Vec3]) {
        let Self { free_velocity, impulse, contacts, constraints, .. } = self;
        free_velocity.copy_from_slice(v);
        contacts.project(system, constraints, free_velocity, v, impulse);
    }

    /// `v½` to `v_{n+1}`: `(M + h/2 L_c) v_{n+1} = M v½ + h/2 (F_{n+1} + R(x_{n+1}, v_{n+1}))`.
    ///
    /// `R = L_c v − D v` is what projected damping has less than full damping. It is taken first at `v_n`, then at the
    /// velocity that this gives, which is right to second order: `2 v½ − v_n` and `2 v_n − v_{n−1}` are too, and would
    /// save a solve, but are unstable on modes that `L_c` damps and `D` does not.
    pub(crate) fn solve_half_kick(
        &mut self,
        system: &System,
        (t, x): (f64, &[Vec3]),
        half: f64,
        v: &mut [Vec3],
        report: &mut StepReport,
    ) {
        let Some(Damping { solver, force: remainder, right_hand_side: b }) = &mut self.damping
        else {
            return;
        };
        let momentum = &mut self.free_velocity;
        for i in 0..v.len() {
            momentum[i] = v[i] * system.mass()[i] + self.force[i] * half;
        }
        v.copy_from_slice(&self.old_velocity);
        let mut is_linear = true;
        for prediction in [true, false] {
            remainder.fill(Vec3::zeros());
            for effect in system.effects() {
                match effect.split() {
                    Some(split) => split.add_damping_remainder(x, v, remainder),
                    None => effect.add_damping_force(Level { t, x, v }, remainder), // nothing of it is in L_c
                }
            }
            is_linear &= remainder.iter().all(|r| *r == Vec3::zeros());
            if is_linear && !prediction {
                return;
            }
            for i in 0..v.len() {
                b[i] = momentum[i] + remainder[i] * half;
            }
            let before = report.solve;
            *report += solver.solve(&self.pins, b, v);
            if before != SolveStatus::Converged {
                report.solve = before; // one bad solve of a step must not hide behind a good one
            }
        }
        report.force_evaluations += 1; // two sweeps for R, as one with force and damping
    }
}

/// Whether two block vectors are the same to the last bit; without an early exit, so that it costs little beside a
/// sweep over the springs.
fn same_bits(a: &[Vec3], b: &[Vec3]) -> bool {
    let differing =
        |a: &Vec3, b: &Vec3| (0..3).fold(0, |bits, k| bits | (a[k].to_bits() ^ b[k].to_bits()));
    a.iter().zip(b).fold(0, |bits, (a, b)| bits | differing(a, b)) == 0
}
