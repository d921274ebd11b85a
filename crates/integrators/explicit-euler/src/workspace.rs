//! Memory of the steps.

use crate::settings::{LEAPFROG, LeapfrogSettings, StepControl};
use crate::stability_limit::StabilityLimit;
use drape_integrator::{
    ContactSet, Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, PrepareError,
    StepError, StepReport, Weights, hold_pins,
};
use drape_model::{Revisions, System, Vec3};
use drape_solvers::Constraints;

/// Memory that explicit and symplectic Euler share.
#[derive(Debug)]
pub(crate) struct EulerMemory {
    pub(crate) force: Vec<Vec3>,
    pub(crate) free_velocity: Vec<Vec3>,
    pub(crate) velocity: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
}

impl EulerMemory {
    pub(crate) fn new(system: &System) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Self {
            force: zeros(),
            free_velocity: zeros(),
            velocity: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
        }
    }
}

/// Relative residual at which the conjugate gradients of leapfrog stop.
const CG_TOLERANCE: f64 = 1e-14;

/// Memory of a step, with the force that the next step reuses.
#[derive(Debug)]
pub struct LeapfrogWorkspace {
    /// `F`, the conservative force at `positions`, N.
    pub(crate) force: Vec<Vec3>,
    /// The system that `force` was evaluated for.
    remembered: Option<Revisions>,
    positions: Vec<Vec3>,
    pub(crate) old_velocity: Vec<Vec3>,
    pub(crate) free_velocity: Vec<Vec3>,
    /// `v_{n+1}` before the contacts settle, m/s; filled only where there are contacts.
    pub(crate) unsettled: Vec<Vec3>,
    /// Number of substeps of the last step.
    pub(crate) last_substeps: u32,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    /// The pins alone, which the second half kick obeys.
    pub(crate) pins: Constraints,
    /// `None` without damping.
    pub(crate) damping: Option<Damping>,
    /// `None` unless steps are divided.
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
    pub(crate) fn allocate(
        system: &System,
        settings: &LeapfrogSettings,
        h: f64,
    ) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let linear =
            LinearSettings::kept(CG_TOLERANCE, PreconditionerKind::Jacobi, settings.solver);
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
                let what = "step=bound with a stiffness other than springs".to_owned();
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
    pub(crate) fn forget(&mut self) {
        self.remembered = None;
        self.contacts.restart();
        if let Some(limit) = &mut self.limit {
            limit.restart();
        }
    }

    /// Number of equal substeps in the next `h` seconds.
    pub(crate) fn substeps(
        &mut self,
        system: &System,
        x: &[Vec3],
        h: f64,
        report: &mut StepReport,
    ) -> Result<u32, StepError> {
        self.limit.as_mut().map_or(Ok(1), |limit| limit.substeps(system, x, h, report))
    }

    /// Brings the matrix for substeps of `h` seconds, and the pins, up to date.
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

    /// Whether the kept force belongs to this system at `x`.
    pub(crate) fn remembers(&self, system: &System, x: &[Vec3]) -> bool {
        self.remembered == Some(system.revisions()) && same_bits(&self.positions, x)
    }

    /// Keeps the force for the next step, which starts at `x`.
    pub(crate) fn remember(&mut self, system: &System, x: &[Vec3]) {
        self.remembered = Some(system.revisions());
        self.positions.copy_from_slice(x);
    }
}

/// Whether two block vectors are equal to the last bit. Without an early exit, the loop costs
/// little beside a sweep over the springs.
fn same_bits(a: &[Vec3], b: &[Vec3]) -> bool {
    let differing =
        |a: &Vec3, b: &Vec3| (0..3).fold(0, |bits, k| bits | (a[k].to_bits() ^ b[k].to_bits()));
    a.iter().zip(b).fold(0, |bits, (a, b)| bits | differing(a, b)) == 0
}
