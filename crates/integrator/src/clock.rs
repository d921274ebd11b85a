//! Splits the time of a step into phases, which are the columns of the paper's tables.

use std::time::{Duration, Instant};

/// A phase of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Evaluating forces.
    Forces,
    /// Assembling matrices and factorising.
    MatrixSetup,
    /// Solving.
    Solve,
    /// Detecting and releasing contacts.
    Contact,
    /// Updating positions and velocities.
    Update,
}

/// Accumulates wall time by phase. If it is switched off, it costs one branch per phase.
#[derive(Clone, Debug, Default)]
pub struct PhaseClock {
    running: Option<(Phase, Instant)>,
    on: bool,
    totals: [Duration; 5],
}

impl PhaseClock {
    /// A clock that measures nothing.
    pub fn off() -> Self {
        Self::default()
    }

    /// A clock that measures.
    pub fn on() -> Self {
        Self { on: true, ..Self::default() }
    }

    /// Ends the running phase and begins another.
    #[inline]
    pub fn switch(&mut self, phase: Phase) {
        if self.on {
            self.stop();
            self.running = Some((phase, Instant::now()));
        }
    }

    /// Ends the running phase; no other begins.
    #[inline]
    pub fn stop(&mut self) {
        if let Some((phase, since)) = self.running.take() {
            self.totals[phase as usize] += since.elapsed();
        }
    }

    /// Time spent in a phase so far, s.
    pub fn seconds(&self, phase: Phase) -> f64 {
        self.totals[phase as usize].as_secs_f64()
    }
}
