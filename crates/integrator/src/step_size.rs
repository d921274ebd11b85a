//! A checked step size.

/// A step size in seconds: positive and finite.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct TimeStep(f64);

/// An error: the step size is not positive and finite.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the step size is {0} s; expected a positive finite number of seconds")]
pub struct InvalidTimeStep(pub f64);

impl TimeStep {
    /// Checks a number of seconds.
    ///
    /// # Errors
    /// [`InvalidTimeStep`] unless `seconds` is positive and finite.
    pub fn new(seconds: f64) -> Result<Self, InvalidTimeStep> {
        if seconds > 0.0 && seconds.is_finite() {
            Ok(Self(seconds))
        } else {
            Err(InvalidTimeStep(seconds))
        }
    }

    /// A part of it, s: positive and not longer than the whole.
    pub(crate) fn part(self, seconds: f64) -> Self {
        debug_assert!(seconds > 0.0 && seconds <= self.0 * (1.0 + 1e-9), "{seconds} of {}", self.0);
        Self(seconds)
    }

    /// The length of the step, s.
    pub fn seconds(self) -> f64 {
        self.0
    }
}
