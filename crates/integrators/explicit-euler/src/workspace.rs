//! Memory of the steps.

use crate::settings::{LEAPFROG, LeapfrogDamping, LeapfrogSettings};
use drape_integrator::{
    ContactSet, DampingBound, ExplicitKick, Implicit, KeptForce, LaplacianSolver, LinearSettings,
    PreconditionerKind, PrepareError, StabilityLimit, StepError, StepReport, Weights, hold_pins,
    is_damped,
};
use drape_model::{System, Vec3};
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
    /// `F`, the conservative force, N.
    pub(crate) kept: KeptForce,
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
    /// `None` without damping, and where it is explicit.
    pub(crate) damping: Option<Damping>,
    /// The half kicks; `None` without damping, and where half of it is implicit.
    pub(crate) explicit: Option<[ExplicitKick; 2]>,
    damping_bound: DampingBound,
    /// `None` unless steps are divided.
    limit: Option<StabilityLimit>,
    /// The longest substep times `√λ`, and times `δ`.
    longest: (f64, f64),
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
        let has = |treatment| settings.damping == treatment && is_damped(system);
        let limit = settings.step.limit(system, &LEAPFROG)?;
        Ok(Self {
            kept: KeptForce::new(system),
            old_velocity: zeros(),
            free_velocity: zeros(),
            unsettled: zeros(),
            last_substeps: 0,
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            pins: Constraints::free(system.len()),
            damping: has(LeapfrogDamping::CrankNicolson).then(damping).transpose()?,
            explicit: has(LeapfrogDamping::Explicit)
                .then(|| [(); 2].map(|()| ExplicitKick::new(system))),
            damping_bound: DampingBound::new(system),
            limit,
            longest: (settings.safety * 2.0, settings.safety * 4.0),
        })
    }

    /// Forgets the force, the contacts and the estimate of the stability limit.
    pub(crate) fn forget(&mut self) {
        self.kept.forget();
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
        let Some(limit) = &mut self.limit else { return Ok(1) };
        let (of_stiffness, of_damping) = self.longest;
        let damping = self.explicit.is_some().then(|| self.damping_bound.evaluate(system));
        limit.substeps(system, x, h, report, |lambda| {
            let longest = of_stiffness / lambda.sqrt();
            damping.map_or(longest, |damping| longest.min(of_damping / damping))
        })
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
}
