//! `drape.methods()`.

use drape_harness::methods as registry;
use drape_integrator::StabilityClass;
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// A time integrator with its settings.
#[pyclass(frozen, get_all, module = "drape")]
pub(crate) struct Method {
    id: &'static str,
    name: &'static str,
    source: &'static str,
    order: u32,
    stability: &'static str,
    theory: &'static str,
    supports: BTreeMap<String, &'static str>,
    settings: Vec<Py<Setting>>,
}

/// A setting of a method.
#[pyclass(frozen, get_all, module = "drape")]
pub(crate) struct Setting {
    key: &'static str,
    default: &'static str,
    values: String,
    help: &'static str,
}

#[pymethods]
impl Method {
    fn __repr__(&self) -> String {
        format!("Method('{}')", self.id)
    }
}

#[pymethods]
impl Setting {
    fn __repr__(&self) -> String {
        format!("Setting('{}={}')", self.key, self.default)
    }
}

/// All methods, in the order in which they build on each other.
#[pyfunction]
pub(crate) fn methods(py: Python<'_>) -> PyResult<Vec<Method>> {
    let setting = |setting: &drape_integrator::Setting| {
        Py::new(
            py,
            Setting {
                key: setting.key,
                default: setting.default,
                values: setting.kind.to_string(),
                help: setting.help,
            },
        )
    };
    let supports = |method: &drape_integrator::Method| {
        method.supports().map(|s| (s.effect.to_string(), s.treatment.name())).collect()
    };
    let method = |method: &'static drape_integrator::Method| {
        Ok(Method {
            id: method.id,
            name: method.name,
            source: method.source,
            order: method.order.number(),
            stability: match method.class {
                StabilityClass::Dissipative => "dissipative",
                StabilityClass::Symplectic => "symplectic",
            },
            theory: method.theory,
            supports: supports(method),
            settings: method.settings.iter().map(setting).collect::<PyResult<_>>()?,
        })
    };
    registry::all().map(method).collect()
}
