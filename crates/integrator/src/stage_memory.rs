//! Memory of methods whose steps consist of several implicit stages under one set of contacts.

use crate::{
    ContactSet, ImplicitStage, MultistepMotion, NewtonLinear, Phase, PhaseClock, PrepareError,
    StepReport,
};
use drape_model::{Level, State, System, Vec3};
use drape_solvers::Constraints;

/// An [`ImplicitStage`] with its input, pins and contacts, and the accelerations that follow from
/// its solution.
///
/// A particle in contact, or led by a pin, moves at one velocity along its constraint through the
/// whole step. So it ends where the constraint requires.
#[derive(Debug)]
pub struct StageMemory {
    /// Solver of a stage.
    pub stage: ImplicitStage,
    /// `X*`, m.
    pub x_star: Vec<Vec3>,
    /// `V*`, m/s.
    pub v_star: Vec<Vec3>,
    /// Prediction of positions (m) and velocities (m/s) at the end of the stage.
    pub ahead: (Vec<Vec3>, Vec<Vec3>),
    /// Velocity at the start of the step, m/s: `v_n` after impacts, with pins led along their
    /// paths.
    pub first: Vec<Vec3>,
    /// Contacts of the step.
    pub contacts: ContactSet,
    /// Pins and contacts as constraints.
    pub constraints: Constraints,
    scratch: Vec<Vec3>,
}

impl StageMemory {
    /// Allocates memory and makes the symbolic factorisation.
    ///
    /// # Errors
    /// As [`ImplicitStage::new`].
    pub fn new(system: &System, linear: NewtonLinear) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            stage: ImplicitStage::with_linear(system, linear)?,
            x_star: zeros(),
            v_star: zeros(),
            ahead: (zeros(), zeros()),
            first: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            scratch: zeros(),
        })
    }

    /// Finds the contacts of a step of `h` seconds, once for all stages, and the velocity at its
    /// start.
    pub fn begin(&mut self, system: &System, state: &State, h: f64, clock: &mut PhaseClock) {
        let Self { first, contacts, constraints, .. } = self;
        clock.switch(Phase::Contact);
        let (from, end) = ((&state.x[..], &state.v[..]), state.t + h);
        let motion = MultistepMotion { from, h, end, x_star: &state.x, tau: h };
        contacts.detect_multistep(system, motion, constraints);
        contacts.strike(system, constraints, &state.v, first);
    }

    /// Writes `M⁻¹f` at the start of a step, m/s²; 0 for pinned particles.
    pub fn accelerate(
        &self,
        system: &System,
        state: &State,
        out: &mut [Vec3],
        report: &mut StepReport,
    ) {
        system.forces(Level { t: state.t, x: &state.x, v: &self.first }, out);
        report.force_evaluations += 1;
        for (i, m) in system.mass().iter().enumerate() {
            out[i] = if system.pinned()[i] { Vec3::zeros() } else { out[i] / *m };
        }
    }

    /// Calls `add` with each free particle and a part of the change of its damping acceleration,
    /// m/s², since the accelerations belonged to the velocity `known`. Impacts or pins may have
    /// changed velocities since then. A new evaluation of the whole force would multiply the
    /// residual of the last stage by `h²k/m`.
    pub fn damp(
        &mut self,
        system: &System,
        state: &State,
        known: &[Vec3],
        report: &mut StepReport,
        mut add: impl FnMut(usize, Vec3),
    ) {
        let Self { first, scratch, .. } = self;
        if first[..] == *known {
            return;
        }
        for (v, sign) in [(&first[..], 1.0), (known, -1.0)] {
            scratch.fill(Vec3::zeros());
            for effect in system.effects() {
                effect.add_damping_force(Level { t: state.t, x: &state.x, v }, scratch);
            }
            for (i, m) in system.mass().iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
                add(i, scratch[i] * (sign / m));
            }
        }
        report.force_evaluations += 1;
    }

    /// Writes `M⁻¹f = (v − V*)/τ` at the solution of a stage, m/s², without the impulses of pins
    /// and contacts. Each stage finds these impulses anew, and the coefficients of a method would
    /// reverse an impact.
    pub fn unload(&mut self, system: &System, tau: f64, out: &mut [Vec3], report: &mut StepReport) {
        let Self { stage, v_star, scratch, contacts, constraints, .. } = self;
        for (i, v) in stage.velocity().iter().enumerate() {
            let rate = (v - v_star[i]) / tau;
            out[i] = if system.pinned()[i] { Vec3::zeros() } else { rate };
        }
        if !contacts.is_empty() {
            scratch.copy_from_slice(stage.gradient(system));
            report.force_evaluations += 1;
            for (i, m) in system.mass().iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
                out[i] -= constraints.filter(i).complement(scratch[i]) / (m * tau);
            }
        }
    }

    /// Stores in `X*` where the pins on paths are after a step of `h` seconds from `x`. If their
    /// displacements were summed over the stages, the sum would be wrong by round-off, which the
    /// pins would correct in the next step.
    pub fn lead(&mut self, system: &System, x: &[Vec3], h: f64) {
        for i in system.moving_pins().iter().map(|pin| pin.particle) {
            self.x_star[i] = x[i] + self.first[i] * h;
        }
    }

    /// Moves the pins on paths to the places that [`lead`](Self::lead) stored.
    pub fn place(&self, system: &System, x: &mut [Vec3]) {
        for i in system.moving_pins().iter().map(|pin| pin.particle) {
            x[i] = self.x_star[i];
        }
    }

    /// Forgets contacts and the saved factor, if there is one.
    pub fn restart(&mut self) {
        self.contacts.restart();
        self.stage.restart();
    }
}
