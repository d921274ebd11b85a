//! The windows of the threads that take part in sweeps.

use super::super::diagonals::Diagonals;
use super::{Pass, Window};
use drape_kernels::bands::bands_of;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

/// Numbers before each array of a window, if a system has several windows: 1 MiB that no sweep
/// touches.
///
/// If the windows of two threads lie side by side, one thread takes up to 40 % longer for a band
/// while the other works (Zen 5, 316 × 316 particles). Which one, and whether at all, depends on
/// addresses. They share no cache line and the cause is not known, but distance ends it:
///
/// | distance of two windows | time of two threads over the time of one |
/// |---|---|
/// | nothing | 0.64 |
/// | 64 KiB | 0.57 |
/// | 0.8 MiB or more | 0.53 |
const APART: usize = 1 << 17;

/// One [`Window`] for each thread that has a band, at least one. A sweep reads nothing that another
/// one left there, finished or not.
#[derive(Debug)]
pub(crate) struct Windows(Vec<Mutex<Window>>);

impl Windows {
    /// Windows for sweeps over any of these springs.
    pub(crate) fn new<'a>(
        threads: usize,
        all: impl Iterator<Item = &'a Diagonals> + Clone,
    ) -> Self {
        let particles = all.clone().map(|diagonals| diagonals.particles).max().unwrap_or(0);
        let count = bands_of(threads, particles, 0).min(threads.max(1));
        let lead = if count > 1 { APART } else { 0 };
        let window = |_| Mutex::new(Window::new(lead, all.clone()));
        Self((0..count).map(window).collect())
    }

    /// Whether these passes can share a sweep.
    pub(crate) fn fits<'a>(&self, passes: impl Iterator<Item = &'a Pass<'a>> + Clone) -> bool {
        self.free().fits(passes)
    }

    /// A window for the only thread.
    pub(crate) fn first(&mut self) -> &mut Window {
        self.0[0].get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// A window that no other thread uses: the thread's own if there is one for each thread.
    pub(in super::super) fn free(&self) -> MutexGuard<'_, Window> {
        let own = rayon::current_thread_index().unwrap_or(0) % self.0.len();
        let (before, from_own) = self.0.split_at(own);
        let mut found =
            from_own.iter().chain(before).filter_map(|window| match window.try_lock() {
                Ok(free) => Some(free),
                Err(TryLockError::Poisoned(free)) => Some(free.into_inner()),
                Err(TryLockError::WouldBlock) => None,
            });
        let wait = || self.0[own].lock().unwrap_or_else(PoisonError::into_inner);
        found.next().unwrap_or_else(wait)
    }

    /// Number of bands for so many particles. A band computes the forces of `history` particles
    /// before it once more, so bands are not short.
    pub(crate) fn bands(&self, particles: usize) -> usize {
        bands_of(self.0.len(), particles, 2 * self.free().history)
    }
}
