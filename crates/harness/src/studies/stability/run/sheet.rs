//! The small hanging sheet, its true motion and its perturbed starts.

use crate::methods::Choice;
use crate::run::{Counts, Runner, Simulation};
use crate::schedule::Schedule;
use crate::stability::gershgorin;
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::{HarnessError, system_hash};
use drape_model::{DampingLaw, SystemSpec, TimeSpan, Vec3};
use drape_oracle::Random;

const SIDE: u32 = 8;
pub(super) const SHEAR: f64 = 0.1;
/// Least simulated time, s, and number of steps.
pub(super) const DURATION: f64 = 2.0;
const LEAST_STEPS: f64 = 200.0;
/// Step of the reference, as a share of its stability limit.
const SAFETY: f64 = 0.25;
/// Seeds of the perturbations.
pub(super) const SEEDS: [u64; 3] = [1, 2, 3];
/// Greatest perturbation, in mesh widths, and the greatest energy that it may store in the springs,
/// over `E_ref`.
const PERTURBATION: f64 = 1e-4;
const PERTURBATION_ENERGY: f64 = 1e-3;

/// A sheet with its true motion.
pub(super) struct Setting {
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    pub(super) hash: String,
    /// The unperturbed start.
    pub(super) simulation: Simulation,
    /// `E_ref`, J.
    pub(super) released: f64,
    /// Greatest distance of the free edge's midpoint from its start within [`DURATION`], m.
    pub(super) reach: f64,
}

/// Step and duration of a run.
pub(super) fn schedule(step_s: f64) -> Schedule {
    Schedule::steady(TimeSpan { step_s, duration_s: DURATION.max(LEAST_STEPS * step_s) })
}

/// Makes a run. Returns its counts and the greatest distance of the free edge's midpoint from its
/// start within [`DURATION`], m. The distance is `None` if the run ended before.
pub(super) fn run(
    simulation: &Simulation,
    choice: &Choice,
    schedule: &Schedule,
    limit: Option<f64>,
) -> Result<(Counts, Option<f64>), HarnessError> {
    let midpoint = ((SIDE - 1) * SIDE + SIDE / 2) as usize;
    let start = simulation.state.x[midpoint];
    let (mut reach, mut lasted) = (0.0_f64, false);
    let runner = Runner::by(choice, schedule).budget(limit).observe(|moment| {
        let time = schedule.elapsed(moment.step);
        // A first step that is longer than the duration still counts.
        if time <= DURATION * (1.0 + 1e-9) {
            reach = reach.max((moment.state.x[midpoint] - start).norm());
        }
        lasted |= time >= DURATION * (1.0 - 1e-9);
    });
    let counts = runner.count(simulation)?;
    let reach = (lasted && counts.outcome.divergence.is_none()).then_some(reach);
    Ok((counts, reach.filter(|reach| reach.is_finite())))
}

pub(super) fn name(stiffness: f64, damping: f64) -> String {
    format!("sheet, k/m={stiffness:e}, d/m={damping}")
}

/// The sheet at rest; `shear` is the stiffness of the shear springs over that of the tension
/// springs.
pub(super) fn spec(stiffness: f64, damping: f64, shear: f64) -> Result<SystemSpec, HarnessError> {
    Sheet {
        side: SIDE,
        tension: stiffness,
        shear: shear * stiffness,
        damping,
        law: DampingLaw::Full,
        gravity: GRAVITY,
        is_pinned: true,
    }
    .spec()
}

impl Setting {
    pub(super) fn new(stiffness: f64, damping: f64) -> Result<Self, HarnessError> {
        Self::with_shear(stiffness, damping, SHEAR)
    }

    /// A setting with another ratio of the shear to the tension springs.
    pub(super) fn with_shear(
        stiffness: f64,
        damping: f64,
        shear: f64,
    ) -> Result<Self, HarnessError> {
        let resting = Self::resting(stiffness, damping, shear)?;
        let simulation = &resting.simulation;
        let (bound, brake) = gershgorin(&simulation.system);
        // Symplectic Euler is stable for h²λ + 2hδ < 4.
        let limit = 4.0 / (brake + (brake * brake + 4.0 * bound).sqrt());
        let time = TimeSpan { step_s: (SAFETY * limit).min(0.001), duration_s: DURATION };
        let choice = Choice::parse("symplectic-euler", &[])?;
        let (counts, reach) = run(simulation, &choice, &Schedule::steady(time), None)?;
        let reach = reach.unwrap_or(f64::INFINITY);
        Ok(Self { released: counts.energy.released, reach, ..resting })
    }

    /// A setting without its true motion.
    pub(super) fn resting(stiffness: f64, damping: f64, shear: f64) -> Result<Self, HarnessError> {
        let spec = spec(stiffness, damping, shear)?;
        let (system, state) = spec.build()?;
        let simulation = Simulation { system, state };
        let hash = system_hash(&spec);
        Ok(Self { stiffness, damping, hash, simulation, released: 0.0, reach: 0.0 })
    }

    pub(super) fn name(&self) -> String {
        name(self.stiffness, self.damping)
    }

    /// The start with every free particle moved at random by up to 1e-4 mesh widths along each
    /// axis. The offsets are scaled down if they would store more than a thousandth of `E_ref` in
    /// the springs.
    pub(super) fn start(&self, seed: u64) -> Simulation {
        let mut random = Random::new(seed);
        let Simulation { system, state } = &self.simulation;
        let reach = PERTURBATION / f64::from(SIDE - 1);
        let offset = |pinned: &bool| {
            let offset = random.vector() * reach;
            if *pinned { Vec3::zeros() } else { offset }
        };
        let offsets: Vec<Vec3> = system.pinned().iter().map(offset).collect();
        let moved = |factor: f64| {
            let mut moved = state.clone();
            for (x, offset) in moved.x.iter_mut().zip(&offsets) {
                *x += offset * factor;
            }
            moved
        };
        let stored = system.potential_energy(&moved(1.0).x) - system.potential_energy(&state.x);
        let most = PERTURBATION_ENERGY * self.released;
        // The energy grows with the square of the distance.
        let factor = if stored > most { (most / stored).sqrt() } else { 1.0 };
        Simulation { system: system.clone(), state: moved(factor) }
    }
}
