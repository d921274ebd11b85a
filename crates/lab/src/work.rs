//! Computes runs in the background: each on its own thread or, where the system has no threads, all
//! in turns.
//!
//! A [`Gate`] sets how far a run may go. The run itself only takes steps ([`Run`]).

use crate::limits;
use crate::setup::SetupError;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Part of a step by which a step may end too late, because of round-off.
pub(crate) const LATE: f64 = 1e-6;

/// Counts the runs that have not ended.
#[derive(Clone, Debug, Default)]
pub struct Runs(Arc<AtomicUsize>);

/// One of the counted runs.
#[derive(Debug)]
pub(crate) struct Ticket(Arc<AtomicUsize>);

impl Runs {
    /// Number of runs that have not ended.
    pub fn count(&self) -> usize {
        self.0.load(Ordering::SeqCst)
    }

    pub(crate) fn enter(&self) -> Option<Ticket> {
        let next = |count| (count < limits::RUNS).then_some(count + 1);
        let entered = self.0.fetch_update(Ordering::SeqCst, Ordering::SeqCst, next);
        entered.is_ok().then(|| Ticket(self.0.clone()))
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Locks a value, even after a panic elsewhere. A panic leaves these values whole, since each is
/// replaced at once.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Debug, Default)]
struct Control {
    until: f64,
    is_closed: bool,
}

/// How far a run may go.
#[derive(Debug, Default)]
pub(crate) struct Gate {
    control: Mutex<Control>,
    changed: Condvar,
}

impl Gate {
    /// Lets the run take all steps that end by this time, s.
    pub(crate) fn go_until(&self, time: f64) {
        lock(&self.control).until = time;
        self.changed.notify_all();
    }

    /// Ends the run after its present step.
    pub(crate) fn close(&self) {
        lock(&self.control).is_closed = true;
        self.changed.notify_all();
    }

    fn is_closed(&self) -> bool {
        lock(&self.control).is_closed
    }

    /// Whether the step that ends at `end` may be taken. A closed gate lets every step be taken, so
    /// that no run waits for it.
    pub(crate) fn lets(&self, end: StepEnd) -> bool {
        let control = lock(&self.control);
        control.is_closed || end.is_until(control.until)
    }

    #[cfg(not(target_family = "wasm"))]
    /// Waits until the gate [lets](Self::lets) a step be taken.
    fn wait_for(&self, end: StepEnd) {
        let mut control = lock(&self.control);
        while !control.is_closed && !end.is_until(control.until) {
            control = self.changed.wait(control).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// The time at the end of a step, s, and the length of the step, s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepEnd(pub(crate) f64, pub(crate) f64);

impl StepEnd {
    fn is_until(self, time: f64) -> bool {
        self.0 <= time + LATE * self.1
    }
}

/// A run that goes on step by step.
pub(crate) trait Run {
    /// The end of its next step; `None` after the last step.
    fn next(&self) -> Option<StepEnd>;

    /// Takes the next step.
    fn step(&mut self) -> Result<(), SetupError>;
}

/// The result of a run, or the sentence that ends it. It catches panics, because a bug in one
/// method must not end the other runs.
fn guarded<T>(run: impl FnOnce() -> Result<T, SetupError>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(done) => done.map_err(|error| error.to_string()),
        Err(_) => Err("the run failed by a bug in drape; please report it".to_owned()),
    }
}

/// Begins a run and lets it go as far as its gate allows. `end` gets the sentence that ended the
/// run, if one did. Returns `None` if the operating system refuses a thread.
pub(crate) fn start<R: Run + 'static>(
    gate: Arc<Gate>,
    begin: impl FnOnce() -> Result<R, SetupError> + Send + 'static,
    end: impl FnOnce(Option<String>) + Send + 'static,
) -> Option<()> {
    #[cfg(not(target_family = "wasm"))]
    {
        let run = move || {
            let done = guarded(|| {
                let mut run = begin()?;
                while let Some(next) = run.next() {
                    gate.wait_for(next);
                    if gate.is_closed() {
                        break;
                    }
                    run.step()?;
                }
                Ok(())
            });
            end(done.err());
        };
        std::thread::Builder::new().name("run".to_owned()).spawn(run).ok().map(drop)
    }
    #[cfg(target_family = "wasm")]
    {
        turns::add(gate, begin, end);
        Some(())
    }
}

/// Runs in turns, on one thread.
#[cfg(any(test, target_family = "wasm"))]
#[cfg_attr(test, allow(unreachable_pub, reason = "the engine of a page without a server calls it"))]
pub(crate) mod turns {
    use super::{Gate, Run, SetupError, guarded};
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::sync::Arc;
    use std::time::Instant;

    /// The result of a turn.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum Turn {
        /// A step was taken, or the run was begun.
        Taken,
        /// The gate does not let it go on.
        Waits,
        /// No turn follows.
        Over,
    }

    type Task = Box<dyn FnMut() -> Turn>;

    thread_local! {
        static TASKS: RefCell<VecDeque<Task>> = const { RefCell::new(VecDeque::new()) };
    }

    /// Adds a run to those that take turns.
    pub(crate) fn add<R: Run + 'static>(
        gate: Arc<Gate>,
        begin: impl FnOnce() -> Result<R, SetupError> + 'static,
        end: impl FnOnce(Option<String>) + 'static,
    ) {
        let (mut begin, mut end, mut run) = (Some(begin), Some(end), None);
        let mut turn = move || {
            if gate.is_closed() {
                return Ok(Turn::Over);
            }
            if let Some(begin) = begin.take() {
                run = Some(guarded(begin)?);
                return Ok(Turn::Taken);
            }
            let Some((run, next)) = run.as_mut().and_then(|run: &mut R| {
                let next = run.next()?;
                Some((run, next))
            }) else {
                return Ok(Turn::Over);
            };
            if !gate.lets(next) {
                return Ok(Turn::Waits);
            }
            guarded(|| run.step()).map(|()| Turn::Taken)
        };
        let task = move || {
            let turn: Result<Turn, String> = turn();
            let (turn, sentence) = match turn {
                Ok(turn) => (turn, None),
                Err(sentence) => (Turn::Over, Some(sentence)),
            };
            if turn == Turn::Over
                && let Some(end) = end.take()
            {
                end(sentence);
            }
            turn
        };
        TASKS.with_borrow_mut(|tasks| tasks.push_back(Box::new(task)));
    }

    /// Gives turns to all runs until none of them can go on, or until the moment `until`.
    pub fn work(until: Instant) {
        let mut waiting = 0;
        while Instant::now() < until {
            let Some(mut task) = TASKS.with_borrow_mut(VecDeque::pop_front) else { return };
            let turn = task();
            if turn != Turn::Over {
                TASKS.with_borrow_mut(|tasks| tasks.push_back(task));
            }
            waiting = if turn == Turn::Waits { waiting + 1 } else { 0 };
            if waiting >= TASKS.with_borrow(VecDeque::len) {
                return;
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use drape_model::Violation;
    use std::rc::Rc;
    use std::time::{Duration, Instant};

    /// Takes steps of 1 s, and notes them.
    struct Steps {
        name: char,
        taken: u32,
        most: u32,
        told: Rc<Mutex<String>>,
    }

    impl Run for Steps {
        fn next(&self) -> Option<StepEnd> {
            (self.taken < self.most).then(|| StepEnd(f64::from(self.taken + 1), 1.0))
        }

        fn step(&mut self) -> Result<(), SetupError> {
            self.taken += 1;
            lock(&self.told).push(self.name);
            let refusal = || Violation {
                path: "x".to_owned(),
                value: "1".to_owned(),
                expected: "2".to_owned(),
            };
            if self.name == 'e' { Err(refusal().into()) } else { Ok(()) }
        }
    }

    #[test]
    fn runs_take_turns_as_far_as_their_gates_let_them() {
        let told = Rc::new(Mutex::new(String::new()));
        let add = |name: char, most: u32, until: f64| {
            let gate = Arc::new(Gate::default());
            gate.go_until(until);
            let (first, last) = (told.clone(), told.clone());
            let begin = move || Ok(Steps { name, taken: 0, most, told: first });
            turns::add(gate.clone(), begin, move |sentence: Option<String>| {
                let end = if sentence.is_some() { '!' } else { '.' };
                lock(&last).push(end);
            });
            gate
        };
        let work = || {
            turns::work(Instant::now() + Duration::from_secs(60));
            std::mem::take(&mut *lock(&told))
        };
        let a = add('a', 3, 2.0);
        let b = add('b', 9, 1.0);
        let _e = add('e', 9, 9.0);
        // Each begins, then each takes a step; the third fails. The first may take another.
        assert_eq!(work(), "abe!a");
        assert_eq!(work(), "");
        a.go_until(9.0);
        assert_eq!(work(), "a.");
        b.go_until(3.0);
        assert_eq!(work(), "bb");
        b.close();
        assert_eq!(work(), ".");
        assert_eq!(work(), "");
    }

    #[test]
    fn turns_end_at_their_time() {
        let told = Rc::new(Mutex::new(String::new()));
        let gate = Arc::new(Gate::default());
        gate.go_until(1e9);
        let steps = Steps { name: 'a', taken: 0, most: u32::MAX, told: told.clone() };
        turns::add(gate.clone(), move || Ok(steps), |_| {});
        let begin = Instant::now();
        turns::work(begin + Duration::from_millis(20));
        assert!(begin.elapsed() >= Duration::from_millis(20) && lock(&told).len() > 1);
        gate.close();
        turns::work(Instant::now() + Duration::from_millis(20));
    }
}
