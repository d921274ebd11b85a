//! The threads on which a run computes.

use crate::HarnessError;
use drape_solvers::bands::bands;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder, Yield};
use std::num::NonZero;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::yield_now;

/// The threads for the steps of one run, or none where the caller's thread is enough.
///
/// On Linux, a team with one thread for each processor of the process keeps each thread on its own
/// processor. Otherwise the scheduler may let two threads take turns on one processor while another
/// one is idle: for a tenth of a second after a pause, or for a whole run of short sweeps. The
/// threads of smaller teams are free to move, since other programs need processors, too. Threads
/// that the work itself starts inherit the processor of their parent.
#[derive(Debug)]
pub struct Team(Option<ThreadPool>);

impl Team {
    /// A team of `threads` threads for a cloth of so many particles. For a small cloth it has no
    /// threads of its own, and the caller does the work.
    ///
    /// # Errors
    /// [`ThreadPoolBuildError`] when the operating system refuses a thread.
    pub fn new(threads: NonZero<usize>, particles: usize) -> Result<Self, ThreadPoolBuildError> {
        if bands(threads.get(), particles) == 1 {
            return Ok(Self(None));
        }
        let threads = threads.get();
        let processors = processors::all(threads);
        let builder = ThreadPoolBuilder::new().num_threads(threads).start_handler(move |thread| {
            processors
                .get(thread)
                .into_iter()
                .for_each(|processor| processors::keep_to(*processor));
        });
        builder.build().map(Some).map(Self)
    }

    /// Does `work` with these threads. All of them stay awake until it is done. A thread without
    /// work keeps looking for some, and yields its processor in between.
    pub fn run<T: Send>(&mut self, work: impl FnOnce() -> T + Send) -> T {
        match &self.0 {
            None => work(),
            Some(pool) => pool.install(|| awake(work)),
        }
    }
}

/// Starts the threads on which studies compute: one for each processor, or as many as the variable
/// `RAYON_NUM_THREADS` says. A program calls it once, before the first study. Otherwise the threads
/// start by themselves, and the program ends where the operating system refuses one.
///
/// # Errors
/// [`HarnessError::Threads`] when the operating system refuses a thread.
pub fn start_threads() -> Result<(), HarnessError> {
    ThreadPoolBuilder::new().build_global().map_err(HarnessError::Threads)
}

/// Does `work` on the current pool while its other threads look for jobs.
///
/// All other threads start to look before the work begins. A thread that started later could do so
/// inside a job, while the work waits for that job.
fn awake<T>(work: impl FnOnce() -> T) -> T {
    /// Tells the other threads that the work is over, even if it panicked.
    struct End<'a>(&'a AtomicBool);
    impl Drop for End<'_> {
        fn drop(&mut self) {
            self.0.store(true, Ordering::Release);
        }
    }
    let (over, awake) = (AtomicBool::new(false), AtomicUsize::new(1));
    let (is_over, awake) = (&over, &awake);
    rayon::in_place_scope(|scope| {
        let _end = End(is_over);
        let own = rayon::current_thread_index();
        scope.spawn_broadcast(move |_, thread| {
            if Some(thread.index()) == own {
                return;
            }
            awake.fetch_add(1, Ordering::AcqRel);
            while !is_over.load(Ordering::Acquire) {
                if rayon::yield_now() != Some(Yield::Executed) {
                    yield_now();
                }
            }
        });
        while awake.load(Ordering::Acquire) < rayon::current_num_threads() {
            yield_now();
        }
        work()
    })
}

#[cfg(target_os = "linux")]
mod processors {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

    /// The processors that the process may use, if their number is `count`; else none.
    pub(super) fn all(count: usize) -> Vec<usize> {
        let Ok(set) = sched_getaffinity(None) else { return Vec::new() };
        let all: Vec<_> = (0..CpuSet::MAX_CPU).filter(|&processor| set.is_set(processor)).collect();
        if all.len() == count { all } else { Vec::new() }
    }

    /// Keeps the calling thread on one processor. A refusal only costs time, so it is no error.
    pub(super) fn keep_to(processor: usize) {
        let mut set = CpuSet::new();
        set.set(processor);
        let _ = sched_setaffinity(None, &set);
    }
}

#[cfg(not(target_os = "linux"))]
mod processors {
    pub(super) fn all(_count: usize) -> Vec<usize> {
        Vec::new()
    }

    pub(super) fn keep_to(_processor: usize) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_solvers::bands::in_bands;
    use rayon::current_num_threads;

    fn team(threads: usize, particles: usize) -> Team {
        Team::new(NonZero::new(threads).expect("threads"), particles).expect("a pool")
    }

    #[test]
    fn a_small_cloth_needs_no_other_thread() {
        let outside = current_num_threads();
        assert_eq!(team(3, 1000).run(current_num_threads), outside);
        assert_eq!(team(1, 100_000).run(current_num_threads), outside);
        assert_eq!(team(3, 100_000).run(current_num_threads), 3);
    }

    #[test]
    fn a_panic_ends_the_others() {
        let mut team = team(2, 100_000);
        let work = || team.run(|| panic!("of the work"));
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).is_err());
        assert_eq!(team.run(|| 7), 7);
    }

    #[test]
    fn work_ends_on_any_number_of_threads_also_where_it_has_a_team_of_its_own() {
        for threads in [2, 3, 9] {
            let mut first = team(threads, 100_000);
            for round in 0..50 {
                let sum = first.run(|| {
                    let squares = |team: &mut Team| {
                        team.run(|| {
                            let mut squares = vec![0; 3000];
                            in_bands(9, 3000, &mut squares[..], &|band, squares: &mut [usize]| {
                                squares.iter_mut().zip(band).for_each(|(s, i)| *s = i * i);
                            });
                            squares.iter().sum::<usize>()
                        })
                    };
                    (0..20).map(|_| squares(&mut Team(None))).sum::<usize>()
                        + if round == 0 { squares(&mut team(2, 100_000)) } else { 0 }
                });
                let expected: usize = (0..3000).map(|i| i * i).sum();
                assert_eq!(sum, expected * if round == 0 { 21 } else { 20 });
            }
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_team_of_all_processors_has_one_for_each_thread() {
        let processors = |team: &Team| {
            let pool = team.0.as_ref().expect("a large cloth");
            let mut sets = pool.broadcast(|_| {
                let set = rustix::thread::sched_getaffinity(None).expect("a set");
                (0..rustix::thread::CpuSet::MAX_CPU).filter(|&p| set.is_set(p)).collect::<Vec<_>>()
            });
            sets.sort();
            sets
        };
        let count = std::thread::available_parallelism().expect("a number").get();
        let all = rustix::thread::sched_getaffinity(None).expect("a set").count() as usize;
        if count < 2 || all != count {
            return; // one processor, or a limit on their total time: no thread is pinned
        }
        let kept = processors(&team(count, 100_000));
        assert!(kept.iter().all(|set| set.len() == 1));
        assert!(kept.is_sorted_by(|a, b| a < b), "one each: {kept:?}");
        assert!(processors(&team(count + 1, 100_000)).iter().all(|set| set.len() == count));
    }
}
