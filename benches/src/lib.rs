//! Shared parts of the benches: prepared runs of bundled scenes, and the hanging sheet of the cost
//! comparisons.

mod machine;
mod sheet;

pub use machine::{Machine, triad};
pub use sheet::{HangingSheet, Mesh, STEP_S};

use drape_harness::Source;
use drape_harness::methods::Choice;
use drape_integrator::{Integrator, PhaseClock, TimeStep};
use drape_model::{State, System};
use drape_report::Provenance;
use std::collections::BTreeMap;
use std::num::NonZero;
use std::path::Path;

/// Provenance of a measurement that begins now. A bench is built and run at once, so the source
/// tree is what the program was built from.
pub fn provenance() -> Provenance {
    let source = Source::of_folder(Path::new(env!("CARGO_MANIFEST_DIR")));
    drape_harness::provenance(&source, BTreeMap::new())
}

/// Commit and time of a measurement, for the last line of a page.
pub fn origin(provenance: &Provenance) -> String {
    let commit = provenance.commit.as_deref().unwrap_or("no commit");
    let dirty = if provenance.dirty == Some(true) { " with changes" } else { "" };
    format!("{commit}{dirty}, {}", provenance.date)
}

/// A method prepared on a scene, past its first steps.
#[derive(Debug)]
pub struct Prepared {
    /// The method.
    pub integrator: Box<dyn Integrator>,
    /// The system.
    pub system: System,
    /// State after the warm-up.
    pub state: State,
    /// Step size.
    pub step: TimeStep,
}

impl Prepared {
    /// Loads a bundled scene, prepares a method and takes `warm_up` steps. So the bench measures a
    /// step in the middle of the motion, not the first one from rest.
    ///
    /// # Panics
    /// When the scene or the method does not exist, which only an edit of the benches can cause.
    pub fn new(scene: &str, method: &str, warm_up: usize) -> Self {
        let input = drape_model::load(scene).expect("a bundled scene");
        let time = input.scene().expect("bundled scenes are scenes").time;
        let (system, state) = input.spec().build().expect("bundled scenes are valid");
        let step = TimeStep::new(time.step_s).expect("bundled scenes have a positive step");
        Self::from((system, state), step, method, warm_up)
    }

    /// As [`new`](Self::new) on the hanging sheet, with its own step; a general mesh is numbered
    /// anew, as runs do.
    ///
    /// # Panics
    /// As [`new`](Self::new).
    pub fn on_sheet(side: u32, mesh: Mesh, method: &str, warm_up: usize) -> Self {
        Self::with_threads(side, mesh, method, warm_up, NonZero::<usize>::MIN)
    }

    /// As [`on_sheet`](Self::on_sheet), for steps in a pool of that many threads.
    ///
    /// # Panics
    /// As [`new`](Self::new).
    pub fn with_threads(
        side: u32,
        mesh: Mesh,
        method: &str,
        warm_up: usize,
        threads: NonZero<usize>,
    ) -> Self {
        let sheet = HangingSheet::new(side, 1e4, mesh).expect("a valid sheet");
        let (mut system, state, _) = sheet.spec.build_ordered().expect("a valid sheet");
        system.set_threads(threads);
        let step = TimeStep::new(STEP_S).expect("a positive step");
        Self::from((system, state), step, method, warm_up)
    }

    fn from(
        (system, state): (System, State),
        step: TimeStep,
        method: &str,
        warm_up: usize,
    ) -> Self {
        let choice = Choice::parse(method, &[]).expect("a known method");
        let mut integrator = choice.build().expect("checked settings");
        integrator.prepare(&system, step).expect("a supported scene");
        let mut prepared = Self { integrator, system, state, step };
        (0..warm_up).for_each(|_| prepared.step());
        prepared
    }

    /// One step.
    ///
    /// # Panics
    /// When the integrator breaks its contract.
    pub fn step(&mut self) {
        self.step_by(&mut PhaseClock::off());
    }

    /// One step, timed by a clock.
    ///
    /// # Panics
    /// As [`step`](Self::step).
    pub fn step_by(&mut self, clock: &mut PhaseClock) {
        self.integrator
            .step(&self.system, &mut self.state, self.step, clock)
            .expect("a prepared method");
    }
}
