//! Scratch memory of an integrator: there after `prepare`, checked at each step.

use crate::StepError;
use drape_model::{State, System};

/// What `prepare` allocated, with the topology that it fits.
#[derive(Debug)]
pub struct Scratch<W> {
    prepared: Option<(u64, W)>,
}

impl<W> Default for Scratch<W> {
    fn default() -> Self {
        Self { prepared: None }
    }
}

impl<W> Scratch<W> {
    /// Keeps the memory that was prepared for `system`.
    pub fn set(&mut self, system: &System, workspace: W) {
        self.prepared = Some((system.revisions().topology, workspace));
    }

    /// The memory, if any was prepared.
    pub fn get_mut(&mut self) -> Option<&mut W> {
        self.prepared.as_mut().map(|(_, workspace)| workspace)
    }

    /// The memory for a step.
    ///
    /// # Errors
    /// [`StepError::SizeMismatch`] when the state does not fit the system,
    /// [`StepError::NeedsPrepare`] when nothing was prepared for this topology.
    pub fn ready(&mut self, system: &System, state: &State) -> Result<&mut W, StepError> {
        let expected = system.len();
        if let Some(found) = [state.x.len(), state.v.len()].into_iter().find(|&n| n != expected) {
            return Err(StepError::SizeMismatch { expected, found });
        }
        match &mut self.prepared {
            Some((topology, workspace)) if *topology == system.revisions().topology => {
                Ok(workspace)
            }
            _ => Err(StepError::NeedsPrepare),
        }
    }
}
