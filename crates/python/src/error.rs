//! The exception that Python raises, with the sentence that the command prints.

use drape_harness::HarnessError;
use pyo3::PyErr;
use pyo3::exceptions::PyException;

pyo3::create_exception!(drape, Error, PyException, "What drape refuses, in one sentence.");

/// The exception for a fault in this scene.
pub(crate) fn of(error: impl Into<HarnessError>, scene: &str) -> PyErr {
    Error::new_err(error.into().in_scene(scene).to_string())
}
