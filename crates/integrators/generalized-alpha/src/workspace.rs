//! The memory of a step, and what the step does beside its equations.

use crate::settings::GeneralizedAlphaSettings;
use drape_integrator::{Phase, PhaseClock, PrepareError, StageMemory, StepReport};
use drape_model::{Revisions, State, System, Vec3};
use drape_solvers::Filter;

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) memory: StageMemory,
    /// System of the last step; `None` where there is none.
    pub(crate) known: Option<Revisions>,
    /// `a_n`, the acceleration that the method carries, m/s².
    pub(crate) a: Vec<Vec3>,
    /// `g_n = M⁻¹f_n`, without impulses of pins and contacts, m/s².
    pub(crate) g: Vec<Vec3>,
    /// `g_{n+1}`.
    pub(crate) g_new: Vec<Vec3>,
    /// The velocity that `g_n` belongs to, m/s.
    velocity: Vec<Vec3>,
    /// Pins and contacts of the step as they were found.
    found: Vec<Filter>,
}

impl Workspace {
    pub(crate) fn allocate(
        system: &System,
        settings: &GeneralizedAlphaSettings,
    ) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            memory: StageMemory::new(system, settings.stage.linear)?,
            known: None,
            a: zeros(),
            g: zeros(),
            g_new: zeros(),
            velocity: zeros(),
            found: vec![Filter::Free; system.len()],
        })
    }

    /// Finds the contacts, and brings `a_n` and `g_n` to the velocity with which the step begins.
    pub(crate) fn begin(
        &mut self,
        system: &System,
        state: &State,
        h: f64,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) {
        let Self { memory, known, a, g, velocity, found, .. } = self;
        memory.begin(system, state, h, clock);
        for (i, filter) in found.iter_mut().enumerate() {
            *filter = memory.constraints.filter(i);
        }
        clock.switch(Phase::Forces);
        if *known != Some(system.revisions()) {
            memory.accelerate(system, state, g, report);
            a.copy_from_slice(g); // a_0 = M⁻¹f_0
            return;
        }
        memory.damp(system, state, velocity, report, |i, change| {
            a[i] += change;
            g[i] += change;
        });
        for i in 0..a.len() {
            if found[i] != Filter::Free {
                a[i] = g[i]; // in contact: no memory of the free flight
            }
        }
    }

    /// The part of an acceleration in the free directions of a particle: the others are
    /// constrained.
    pub(crate) fn along(&self, particle: usize, a: Vec3) -> Vec3 {
        self.found[particle].apply(a)
    }

    /// Ends the step. A particle whose contact began, ended or cut its velocity forgets the
    /// acceleration that the method carries.
    pub(crate) fn finish(&mut self, system: &System, state: &mut State) {
        let Self { memory, known, a, g, velocity, .. } = self;
        memory.place(system, &mut state.x);
        *known = Some(system.revisions());
        velocity.copy_from_slice(&state.v);
        memory.contacts.settle(&mut state.v, |change| a[change.particle] = g[change.particle]);
    }
}
