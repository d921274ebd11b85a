//! `drape.Scene`.

use crate::error;
use drape_harness::{HarnessError, study_scene};
use drape_model::{SceneFile, SystemSpec};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray as _, PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::Path;
use std::sync::Arc;

/// A cloth at its start, with everything that acts on it.
#[pyclass(frozen, module = "drape")]
pub(crate) struct Scene {
    /// Its name in messages: the name of the scene or of its file.
    pub(crate) source: String,
    pub(crate) input: Arc<SceneFile>,
}

/// Rows of three numbers as an array.
pub(crate) fn rows<'py>(
    py: Python<'py>,
    points: impl Iterator<Item = [f64; 3]>,
) -> Bound<'py, PyArray2<f64>> {
    let flat: Vec<f64> = points.flatten().collect();
    let shape = (flat.len() / 3, 3);
    // The shape has as many entries as the list.
    Array2::from_shape_vec(shape, flat).unwrap_or_default().into_pyarray(py)
}

impl Scene {
    pub(crate) fn spec(&self) -> &SystemSpec {
        self.input.spec()
    }
}

#[pymethods]
impl Scene {
    /// A bundled scene by its name, the start of a study (`STUDY/NAME`), or a scene or frozen
    /// system from a file.
    #[staticmethod]
    fn load(py: Python<'_>, scene: &str) -> PyResult<Self> {
        let load = || -> Result<SceneFile, HarnessError> {
            let is_file = Path::new(scene).exists();
            match if is_file { None } else { study_scene(scene)? } {
                Some(input) => Ok(input),
                None => Ok(drape_model::load(scene)?),
            }
        };
        let input = py.detach(load).map_err(|fault| error::of(fault, scene))?;
        Ok(Self { source: scene.to_owned(), input: Arc::new(input) })
    }

    /// A scene or frozen system from JSON text; messages call it `name`.
    #[staticmethod]
    #[pyo3(signature = (text, name = "scene"))]
    fn parse(text: &str, name: &str) -> PyResult<Self> {
        let input = drape_model::parse(name, text).map_err(|fault| error::of(fault, name))?;
        Ok(Self { source: name.to_owned(), input: Arc::new(input) })
    }

    /// The name in the scene.
    #[getter]
    fn name(&self) -> &str {
        &self.spec().name
    }

    /// Number of particles.
    #[getter]
    fn particles(&self) -> usize {
        self.spec().particles.mass_kg.len()
    }

    /// Number of springs.
    #[getter]
    fn springs(&self) -> usize {
        self.spec().springs.len()
    }

    /// The step that the scene suggests, s; None for a frozen system.
    #[getter]
    fn dt(&self) -> Option<f64> {
        self.input.scene().map(|scene| scene.time.step_s)
    }

    /// The simulated time that the scene suggests, s; None for a frozen system.
    #[getter]
    fn duration(&self) -> Option<f64> {
        self.input.scene().map(|scene| scene.time.duration_s)
    }

    /// Masses, kg: an array of particles.
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.spec().particles.mass_kg.clone().into_pyarray(py)
    }

    /// Positions at the start, m: an array of particles by 3.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, self.spec().particles.position_m.iter().copied())
    }

    /// The triangles as indices of particles: an array of triangles by 3.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        let flat: Vec<u32> = self.spec().triangles.iter().flatten().copied().collect();
        Array2::from_shape_vec((flat.len() / 3, 3), flat).unwrap_or_default().into_pyarray(py)
    }

    /// Indices of the pinned particles.
    #[getter]
    fn pins(&self) -> Vec<u32> {
        self.spec().pins.iter().map(|pin| pin.particle).collect()
    }

    /// The discretised system as JSON, as `drape system` prints it.
    #[getter]
    fn json(&self) -> PyResult<String> {
        let text = serde_json::to_string_pretty(self.spec());
        text.map_err(|fault| error::Error::new_err(fault.to_string()))
    }

    fn __repr__(&self) -> String {
        format!("Scene('{}', {} particles)", self.source, self.particles())
    }
}

/// Names of the bundled scenes.
#[pyfunction]
pub(crate) fn scenes() -> Vec<&'static str> {
    drape_model::bundled::names().collect()
}
