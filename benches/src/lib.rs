//! What the benches share: bundled scenes, ready to be stepped.

use drape_harness::methods::Choice;
use drape_integrator::{Integrator, PhaseClock, TimeStep};
use drape_model::{State, System};

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
    /// Loads a bundled scene, prepares a method and takes `warm_up` steps, so that what is measured is a
    /// step in the middle of the motion and not the first one from rest.
    ///
    /// # Panics
    /// When the scene or the method does not exist, which only an edit of the benches can cause.
    pub fn new(scene: &str, method: &str, warm_up: usize) -> Self {
        let input = drape_model::load(scene).expect("a bundled scene");
        let time = input.scene().expect("bundled scenes are scenes").time;
        let (system, mut state) = input.spec().build().expect("bundled scenes are valid");
        let step = TimeStep::new(time.step_s).expect("bundled scenes have a positive step");
        let choice = Choice::parse(method, &[]).expect("a known method");
        let mut integrator = choice.build().expect("checked settings");
        integrator.prepare(&system, step).expect("a supported scene");
        for _ in 0..warm_up {
            integrator
                .step(&system, &mut state, step, &mut PhaseClock::off())
                .expect("a prepared method");
        }
        Self { integrator, system, state, step }
    }

    /// One step.
    ///
    /// # Panics
    /// When the integrator breaks its contract.
    pub fn step(&mut self) {
        self.integrator
            .step(&self.system, &mut self.state, self.step, &mut PhaseClock::off())
            .expect("a prepared method");
    }
}
