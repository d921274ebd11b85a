//! Scratch memory of an integrator. `prepare` makes it, and each step checks it.

use crate::{StepError, TimeStep, lead_pins};
use drape_model::{State, System};

/// The memory that `prepare` allocated, with the topology that it was made for.
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
    /// Stores the memory that was prepared for `system`.
    pub fn set(&mut self, system: &System, workspace: W) {
        self.prepared = Some((system.revisions().topology, workspace));
    }

    /// The memory, for reading; `None` if nothing was prepared.
    pub fn get(&self) -> Option<&W> {
        self.prepared.as_ref().map(|(_, workspace)| workspace)
    }

    /// The memory; `None` if nothing was prepared.
    pub fn get_mut(&mut self) -> Option<&mut W> {
        self.prepared.as_mut().map(|(_, workspace)| workspace)
    }

    /// The memory for a step of `h`. It first sets the velocity of each pinned particle to its
    /// velocity in this step (0 without a path). So no neighbour feels another velocity.
    ///
    /// # Errors
    /// [`StepError::SizeMismatch`] if the state does not fit the system;
    /// [`StepError::NeedsPrepare`] if nothing was prepared for this topology.
    pub fn ready(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
    ) -> Result<&mut W, StepError> {
        let expected = system.len();
        if let Some(found) = [state.x.len(), state.v.len()].into_iter().find(|&n| n != expected) {
            return Err(StepError::SizeMismatch { expected, found });
        }
        match &mut self.prepared {
            Some((topology, workspace)) if *topology == system.revisions().topology => {
                system.clear_pinned(&mut state.v);
                lead_pins(system, state.t, h.seconds(), &state.x, &mut state.v);
                Ok(workspace)
            }
            _ => Err(StepError::NeedsPrepare),
        }
    }
}
