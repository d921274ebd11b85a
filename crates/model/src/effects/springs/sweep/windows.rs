//! The windows of the threads that take part in sweeps.

use super::super::diagonals::Diagonals;
use super::{Pass, Window};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

// The same numbers as in `drape_solvers::bands`, which this crate does not know.
/// Fewest particles for which waking other threads takes less time than they save.
const LEAST_FOR_THREADS: usize = 16_384;
/// Bands for each thread, where there are particles enough: a thread that is done takes a band of another.
const BANDS_PER_THREAD: usize = 4;
/// Fewest particles of a band, if there is more than one.
const LEAST_OF_A_BAND: usize = 4096;
/// Numbers before each array of a window, where there are several windows: 1 MiB that no sweep touches.
///
/// Of two threads whose windows lie side by side, one takes up to 40 % longer for a band as long as the other is at work, and only
/// then (Zen 5, 316 × 316 particles; which of them, and whether at all, depends on addresses). No cache line is shared, and what the
/// cores take from each other is not known, but distance ends it: a sweep by two threads takes 0.64 of the time of a sweep by one where
/// the windows lie side by side, 0.57 with 64 KiB between them, and 0.53 with 0.8 MiB or more.
const APART: usize = 1 << 17;

/// One [`Window`] for each thread that has a band, at least one. A sweep asks for nothing that another one left there, finished or not.
#[derive(Debug)]
pub(crate) struct Windows(Vec<Mutex<Window>>);

impl Windows {
    /// Windows for sweeps over any of these springs.
    pub(crate) fn new<'a>(
        threads: usize,
        all: impl Iterator<Item = &'a Diagonals> + Clone,
    ) -> Self {
        let particles = all.clone().map(|diagonals| diagonals.particles).max().unwrap_or(0);
        let count = bands(threads, particles, 0).min(threads.max(1));
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

    /// A window that no other thread uses: the thread's own, where there are as many as threads.
    pub(super) fn free(&self) -> MutexGuard<'_, Window> {
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

    /// Into how many bands as many particles are cut.
    pub(crate) fn bands(&self, particles: usize) -> usize {
        bands(self.0.len(), particles, self.free().history)
    }
}

/// Into how many bands as many particles are cut for so many threads. Forces that a band remembers from before it, up to those of
/// `history` particles, are computed once more: so bands are not short.
fn bands(threads: usize, particles: usize, history: usize) -> usize {
    if threads < 2 || particles < LEAST_FOR_THREADS {
        return 1;
    }
    let most = particles / LEAST_OF_A_BAND.max(2 * history);
    (BANDS_PER_THREAD * threads).min(most).max(1)
}
