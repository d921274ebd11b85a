//! Ctrl-C in Python: the computation ends soon, and Python raises the exception of its handler.

use pyo3::{PyErr, PyResult, Python};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time between two questions to Python.
const EVERY: Duration = Duration::from_millis(50);

/// Asks Python for signals at intervals, from a computation that does not hold the interpreter.
#[derive(Debug)]
pub(crate) struct Signals {
    asked: Mutex<Instant>,
    raised: Mutex<Option<PyErr>>,
    /// Set once the handler of a signal has raised an exception.
    flag: &'static AtomicBool,
}

impl Signals {
    pub(crate) fn new(flag: &'static AtomicBool) -> Self {
        flag.store(false, Ordering::Relaxed);
        Self { asked: Mutex::new(Instant::now()), raised: Mutex::new(None), flag }
    }

    /// Asks, unless Python was asked a moment ago.
    pub(crate) fn look(&self) {
        let Ok(mut asked) = self.asked.try_lock() else { return };
        if asked.elapsed() < EVERY {
            return;
        }
        *asked = Instant::now();
        if let Err(error) = Python::attach(|py| py.check_signals())
            && let Ok(mut raised) = self.raised.lock()
        {
            *raised = Some(error);
            self.flag.store(true, Ordering::Relaxed);
        }
    }

    /// # Errors
    /// The exception that the handler of a signal has raised.
    pub(crate) fn end(self) -> PyResult<()> {
        match self.raised.into_inner() {
            Ok(Some(error)) => Err(error),
            _ => Ok(()),
        }
    }
}
