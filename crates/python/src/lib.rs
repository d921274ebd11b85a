//! drape as a Python package: scenes, methods, runs and comparisons, with NumPy arrays.
//!
//! `pip install crates/python` builds and installs it. The package uses the same library as the
//! command, so a run has the same bits. `python/drape/_drape.pyi` describes the interface in
//! Python.

mod compare;
mod error;
mod interrupt;
mod methods;
mod run;
mod scene;

/// The compiled part of the package `drape`.
#[pyo3::pymodule]
mod _drape {
    #[pymodule_export]
    use crate::compare::{Comparison, compare};
    #[pymodule_export]
    use crate::error::Error;
    #[pymodule_export]
    use crate::methods::{Method, Setting, methods};
    #[pymodule_export]
    use crate::run::{Run, run};
    #[pymodule_export]
    use crate::scene::{Scene, scenes};

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "its name in Python")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
