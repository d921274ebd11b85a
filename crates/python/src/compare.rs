//! `drape.compare`.

use crate::error;
use crate::interrupt::Signals;
use crate::scene::Scene;
use drape_harness::compare::facts::{Facts, Metric, Run};
use drape_harness::compare::{self as compared, Options, advise, lines};
use drape_harness::{HarnessError, time_span};
use drape_model::Violation;
use numpy::IntoPyArray as _;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// The result of a comparison: the record of `drape compare`.
#[pyclass(frozen, get_all, module = "drape")]
pub(crate) struct Comparison {
    /// The advice, at most twelve lines.
    advice: Vec<String>,
    /// The advised run; None where no run met the target.
    take: Option<Py<PyDict>>,
    /// The runs as columns.
    table: Py<PyDict>,
    /// Whether errors are measured against a true motion.
    has_reference: bool,
    /// The facts as JSON.
    json: String,
}

#[pymethods]
impl Comparison {
    fn __str__(&self) -> String {
        self.advice.join("\n")
    }

    fn __repr__(&self) -> String {
        format!("Comparison({:?})", self.advice.first().map_or("", String::as_str))
    }
}

static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// The runs of a record as columns of the same length.
fn table<'py>(py: Python<'py>, facts: &Facts) -> PyResult<Bound<'py, PyDict>> {
    let runs = &facts.runs;
    let numbers =
        |of: &dyn Fn(&Run) -> f64| runs.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
    let table = PyDict::new(py);
    let form = |run: &Run| facts.form_of(run);
    table.set_item("form", runs.iter().map(|run| form(run).label.as_str()).collect::<Vec<_>>())?;
    table
        .set_item("method", runs.iter().map(|run| form(run).method.as_str()).collect::<Vec<_>>())?;
    table.set_item("dt", numbers(&|run| facts.scene.frame_s / f64::from(run.substeps)))?;
    let steps: Vec<u32> = runs.iter().map(|run| run.substeps).collect();
    table.set_item("steps_per_frame", steps.into_pyarray(py))?;
    table.set_item("verdict", runs.iter().map(|run| run.verdict.name()).collect::<Vec<_>>())?;
    table.set_item("error", numbers(&|run| run.error_m.unwrap_or(f64::NAN)))?;
    table.set_item("kept", numbers(&|run| run.retained.unwrap_or(f64::NAN)))?;
    table.set_item("seconds_per_frame", numbers(&|run| run.frame_s))?;
    let good: Vec<bool> = runs.iter().map(|run| facts.is_met(run)).collect();
    table.set_item("meets_target", good.into_pyarray(py))?;
    Ok(table)
}

/// Compares methods on a scene and advises one, as `drape compare` does.
#[pyfunction]
#[pyo3(signature = (scene, methods = None, *, metric = "shape", target = None, frame = 1.0 / 60.0,
                    budget = 60.0, duration = None, seed = 20, exhaustive = false))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn compare(
    py: Python<'_>,
    scene: &Scene,
    methods: Option<Vec<String>>,
    metric: &str,
    target: Option<f64>,
    frame: f64,
    budget: f64,
    duration: Option<f64>,
    seed: u64,
    exhaustive: bool,
) -> PyResult<Comparison> {
    let refused = |fault: HarnessError| error::of(fault, &scene.source);
    let refuse = |path: &str, value: String, expected: &str| {
        let (path, expected) = (path.to_owned(), expected.to_owned());
        refused(Violation { path, value, expected }.into())
    };
    let metric = match metric {
        "shape" => Metric::Shape,
        "trajectory" => Metric::Trajectory,
        other => return Err(refuse("metric", format!("`{other}`"), "shape or trajectory")),
    };
    let Ok(budget) = Duration::try_from_secs_f64(budget) else {
        return Err(refuse("budget", format!("{budget} s"), "a time from 1 s to 1e6 s"));
    };
    if !(frame > 0.0 && frame.is_finite()) {
        return Err(refuse("frame", format!("{frame} s"), "a length from 1e-5 to 1000 s"));
    }
    let options = Options {
        methods: methods.map(|methods| methods.join(",")),
        metric,
        target_m: target,
        rate: 1.0 / frame,
        budget,
        seed,
        exhaustive,
        interrupt: Some(&INTERRUPT),
        ..Options::default()
    };
    let time = time_span(Some(frame), duration, &scene.input).map_err(|v| refused(v.into()))?;
    let signals = Signals::new(&INTERRUPT);
    let found = py.detach(|| {
        let look = |_: &compared::Tick<'_>| signals.look();
        compared::compare(&scene.source, scene.spec(), time.duration_s, &options, &look)
    });
    signals.end()?;
    let facts = found.map_err(refused)?.facts;
    let advice = advise(&facts);
    let take = advice.take.as_ref().map(|pick| {
        let run = &facts.runs[pick.run];
        let take = PyDict::new(py);
        take.set_item("method", &facts.form_of(run).method)?;
        take.set_item("dt", facts.scene.frame_s / f64::from(run.substeps))?;
        take.set_item("steps_per_frame", run.substeps)?;
        take.set_item("error", run.error_m)?;
        take.set_item("seconds_per_frame", run.frame_s)?;
        PyResult::Ok(take.unbind())
    });
    let json = serde_json::to_string_pretty(&facts)
        .map_err(|fault| error::Error::new_err(fault.to_string()))?;
    Ok(Comparison {
        advice: lines(&facts, &advice),
        take: take.transpose()?,
        table: table(py, &facts)?.unbind(),
        has_reference: facts.truth.is_trusted,
        json,
    })
}
