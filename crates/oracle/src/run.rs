//! An integrator with its system and state, for tests.

use crate::order::{ObservedOrder, OrderError, Sample, observed_order};
use drape_integrator::{Integrator, PhaseClock, StepError, StepReport, TimeStep};
use drape_model::{State, System, Vec3};

/// A prepared integrator with its system and state.
#[derive(Debug)]
pub struct Run {
    /// The integrator.
    pub integrator: Box<dyn Integrator>,
    /// The system.
    pub system: System,
    /// The present state.
    pub state: State,
    /// Step size, s.
    pub h: f64,
}

/// A checked step size.
///
/// # Panics
/// If `h` is not positive and finite.
pub fn seconds(h: f64) -> TimeStep {
    TimeStep::new(h).unwrap_or_else(|error| panic!("{error}"))
}

impl Run {
    /// Prepares an integrator for a system.
    ///
    /// # Panics
    /// If the method refuses the system.
    pub fn new(
        mut integrator: Box<dyn Integrator>,
        (system, state): (System, State),
        h: f64,
    ) -> Self {
        let outcome = integrator.prepare(&system, seconds(h));
        outcome.unwrap_or_else(|error| panic!("{}: {error}", integrator.method().id));
        Self { integrator, system, state, h }
    }

    /// Takes one step.
    ///
    /// # Errors
    /// If the method refuses the step.
    pub fn try_step(&mut self) -> Result<StepReport, StepError> {
        let Self { integrator, system, state, h } = self;
        integrator.step(system, state, seconds(*h), &mut PhaseClock::off())
    }

    /// Takes one step.
    ///
    /// # Panics
    /// If the method refuses the step.
    pub fn step(&mut self) -> StepReport {
        self.try_step().unwrap_or_else(|error| panic!("{}: {error}", self.integrator.method().id))
    }

    /// Takes `count` steps and returns their reports.
    pub fn steps(&mut self, count: usize) -> Vec<StepReport> {
        (0..count).map(|_| self.step()).collect()
    }

    /// Takes one step of `h` seconds, and keeps `h` as the step size.
    pub fn step_by(&mut self, h: f64) -> StepReport {
        self.h = h;
        self.step()
    }

    /// A new integrator with the same system, state and step size.
    pub fn fresh(&self, integrator: Box<dyn Integrator>) -> Self {
        Self::new(integrator, (self.system.clone(), self.state.clone()), self.h)
    }

    /// Makes the integrator forget its history.
    pub fn restart(&mut self) {
        self.integrator.restart(&self.state);
    }

    /// Total energy, J.
    pub fn energy(&self) -> f64 {
        self.system.total_energy(&self.state)
    }
}

/// The bits of a state. Two states are identical, NaN included, if their bits are equal.
pub fn bits(state: &State) -> Vec<u64> {
    let vectors = state.x.iter().chain(&state.v);
    let numbers = vectors.flat_map(|a| a.iter().copied()).chain([state.t]);
    numbers.map(f64::to_bits).collect()
}

/// Greatest distance between corresponding vectors; NaN if a coordinate is NaN.
pub fn apart(a: &[Vec3], b: &[Vec3]) -> f64 {
    greatest(a.iter().zip(b).map(|(a, b)| (a - b).norm()))
}

/// Greatest length of a vector; NaN if a coordinate is NaN.
pub fn largest(vectors: &[Vec3]) -> f64 {
    greatest(vectors.iter().map(|a| a.norm()))
}

/// [`f64::max`] drops NaN: a test that compares the result with a bound would pass.
fn greatest(lengths: impl Iterator<Item = f64>) -> f64 {
    lengths.fold(
        0.0,
        |greatest, length| {
            if length > greatest || length.is_nan() { length } else { greatest }
        },
    )
}

/// Observed order from `error(steps)`, the error after this many steps over `span` seconds.
///
/// # Errors
/// [`OrderError`] if the errors give no order.
pub fn order_of(
    span: f64,
    steps: &[u32],
    error: impl Fn(u32) -> f64,
) -> Result<ObservedOrder, OrderError> {
    let sample = |&steps: &u32| Sample { step: span / f64::from(steps), error: error(steps) };
    observed_order(&steps.iter().map(sample).collect::<Vec<_>>())
}
