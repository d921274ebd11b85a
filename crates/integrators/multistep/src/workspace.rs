//! Memory of the steps, and history; nothing here computes a step.

use crate::coefficients::MAX_STEPS;
use crate::settings::Steps;
use drape_integrator::{ContactSet, History, ImplicitStage, NewtonLinear, PrepareError};
use drape_model::{System, Vec3};
use drape_solvers::Constraints;

/// Sizes of the last steps, s, the present one first, and how many of them the history allows.
pub(crate) fn step_sizes(history: &History<2>, h: f64) -> ([f64; MAX_STEPS], usize) {
    let mut steps = [h; MAX_STEPS];
    for age in 0..history.len() {
        steps[age + 1] = history.step(age);
    }
    (steps, history.len() + 1)
}

/// Fields of the history of Adams–Bashforth.
pub(crate) const OLD_VELOCITY: usize = 0;
pub(crate) const ACCELERATION: usize = 1;

/// Memory of Adams–Bashforth.
#[derive(Debug)]
pub struct AdamsWorkspace {
    /// Velocities and accelerations.
    pub(crate) history: History<2>,
    /// `a_n = M⁻¹ f(x_n, v_n)`, 0 where pinned.
    pub(crate) acceleration: Vec<Vec3>,
    /// `Σ_j β_j a_{n−j}`.
    pub(crate) mean_acceleration: Vec<Vec3>,
    /// `Σ_j β_j v_{n−j} − v_n`, which moves the positions in addition to `v_n`.
    pub(crate) lead: Vec<Vec3>,
    /// `v_n` under pins and contacts.
    pub(crate) velocity: Vec<Vec3>,
    pub(crate) predicted: (Vec<Vec3>, Vec<Vec3>),
    /// `v_{n+1}` without pins and contacts.
    pub(crate) free_velocity: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
}

impl AdamsWorkspace {
    pub(crate) fn allocate(system: &System, steps: Steps) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Self {
            history: History::new(system.len(), steps.count() - 1),
            acceleration: zeros(),
            mean_acceleration: zeros(),
            lead: zeros(),
            velocity: zeros(),
            predicted: (zeros(), zeros()),
            free_velocity: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
        }
    }
}

/// Fields of the history of BDF.
pub(crate) const POSITION: usize = 0;
pub(crate) const VELOCITY: usize = 1;

/// Memory of BDF.
#[derive(Debug)]
pub struct BdfWorkspace {
    /// Positions and velocities.
    pub(crate) history: History<2>,
    pub(crate) stage: ImplicitStage,
    /// `x* = −Σ_{j<k} α_j x_{n+j} / α_k`, and `v*` likewise.
    pub(crate) mean: (Vec<Vec3>, Vec<Vec3>),
    /// Positions and velocities at the new time, by extrapolation.
    pub(crate) extrapolated: (Vec<Vec3>, Vec<Vec3>),
    /// Time of the extrapolation, s.
    pub(crate) ahead: f64,
    /// The acceleration that lasts after an impact, for the history.
    pub(crate) acceleration: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) pins_alone: ContactSet,
    pub(crate) constraints: Constraints,
}

impl BdfWorkspace {
    pub(crate) fn allocate(
        system: &System,
        steps: Steps,
        linear: NewtonLinear,
    ) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            history: History::new(system.len(), steps.count() - 1),
            stage: ImplicitStage::with_linear(system, linear)?,
            mean: (zeros(), zeros()),
            extrapolated: (zeros(), zeros()),
            ahead: 0.0,
            acceleration: zeros(),
            contacts: ContactSet::new(system),
            pins_alone: ContactSet::for_pins(system),
            constraints: Constraints::free(system.len()),
        })
    }
}
