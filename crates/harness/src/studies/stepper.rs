//! Runs a method step by step, for experiments that examine single steps or act between them.

use crate::HarnessError;
use crate::methods::{Choice, MethodError};
use drape_integrator::{Integrator, PhaseClock, StepError, StepReport, TimeStep};
use drape_model::{State, System};

/// A particle has left the scene if it is farther from the origin than this, m. Scenes here are a
/// few metres large.
const FAR: f64 = 1e3;

/// A method with the system for which it was prepared.
#[derive(Debug)]
pub(super) struct Stepper {
    integrator: Box<dyn Integrator>,
    h: TimeStep,
    clock: PhaseClock,
}

impl Stepper {
    /// Prepares a method for steps of `step_s` seconds.
    pub(super) fn new(choice: &Choice, system: &System, step_s: f64) -> Result<Self, HarnessError> {
        let mut integrator = choice.build().map_err(MethodError::from)?;
        let h = TimeStep::new(step_s)?;
        integrator.prepare(system, h)?;
        Ok(Self { integrator, h, clock: PhaseClock::off() })
    }

    /// Length of the next step, s.
    pub(super) fn step_s(&self) -> f64 {
        self.h.seconds()
    }

    /// Sets the length of the next steps, s.
    pub(super) fn set_step_s(&mut self, step_s: f64) -> Result<(), HarnessError> {
        self.h = TimeStep::new(step_s)?;
        Ok(())
    }

    /// Takes one step. Returns `None` if the run diverged in it.
    pub(super) fn step(
        &mut self,
        system: &System,
        state: &mut State,
    ) -> Result<Option<StepReport>, HarnessError> {
        match self.integrator.step(system, state, self.h, &mut self.clock) {
            Ok(report) => Ok(Some(report).filter(|_| state.x.iter().all(|x| x.norm() < FAR))),
            // The numbers are too large for a matrix, or a user's program failed.
            Err(StepError::Solver(_) | StepError::Outside(_)) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Tells the method that its state was changed between two steps.
    pub(super) fn restart(&mut self, state: &State) {
        self.integrator.restart(state);
    }
}
