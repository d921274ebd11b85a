//! `drape.run`.

use crate::error;
use crate::interrupt::Signals;
use crate::scene::{Scene, rows};
use drape_harness::judgement::{Judge, Rise};
use drape_harness::methods::Choice;
use drape_harness::record::{Ending, Run as Record};
use drape_harness::{HarnessError, Moment, OrderedSimulation, Team, time_span};
use drape_model::{SceneError, Violation};
use numpy::ndarray::Array3;
use numpy::{IntoPyArray as _, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::num::NonZero;
use std::sync::atomic::AtomicBool;

/// Most times whose positions are kept where the user does not set `every`.
const MOST: u64 = 1000;

/// A run: the record that `drape run --out` writes, and the positions over time.
#[pyclass(frozen, get_all, module = "drape")]
pub(crate) struct Run {
    scene: String,
    method: String,
    settings: BTreeMap<String, String>,
    dt: f64,
    steps: u64,
    ending: &'static str,
    verdict: String,
    reason: String,
    share: Option<f64>,
    expected_share: Option<f64>,
    spin_share: Option<f64>,
    warnings: Vec<String>,
    counts: BTreeMap<&'static str, u64>,
    seconds: f64,
    times: Py<PyArray1<f64>>,
    positions: Py<PyArray3<f64>>,
    velocities: Py<PyArray2<f64>>,
    energy_times: Py<PyArray1<f64>>,
    energies: BTreeMap<String, Py<PyArray1<f64>>>,
    momenta: Py<PyArray2<f64>>,
    angular_momenta: Py<PyArray2<f64>>,
    json: String,
}

#[pymethods]
impl Run {
    fn __repr__(&self) -> String {
        let Self { scene, method, steps, dt, verdict, .. } = self;
        format!("Run('{scene}', '{method}', {steps} steps of {dt} s: {verdict})")
    }
}

/// The arguments of a run, checked.
struct Asked<'a> {
    scene: &'a Scene,
    choice: Choice,
    dt: Option<f64>,
    duration: Option<f64>,
    threads: NonZero<usize>,
    every: Option<u64>,
}

/// The result of a run.
struct Done {
    record: Record,
    warnings: Vec<String>,
    times: Vec<f64>,
    /// Positions of all particles at all times, m, one after the other.
    positions: Vec<f64>,
}

static INTERRUPT: AtomicBool = AtomicBool::new(false);

fn simulate(asked: &Asked<'_>, signals: &Signals) -> Result<Done, HarnessError> {
    let Asked { scene, choice, threads, .. } = asked;
    let spec = scene.spec();
    let time = time_span(asked.dt, asked.duration, &scene.input)?;
    let in_file = |violation| SceneError::Invalid { file: scene.source.clone(), violation };
    let mut simulation = OrderedSimulation::new(spec, choice).map_err(in_file)?;
    simulation.set_threads(*threads);
    let mut judge = Judge::of(&simulation, choice, time);
    let mut warnings: Vec<String> =
        judge.expected().warning(&simulation, choice, time.step_s).into_iter().collect();
    let (whole, rest) = time.steps();
    let steps = whole + u64::from(rest.is_some());
    let every = asked.every.unwrap_or_else(|| steps.div_ceil(MOST)).max(1);
    let (mut times, mut positions) = (Vec::new(), Vec::new());
    let mut keep = |moving: drape_harness::Moving<'_>| {
        let state = moving.state();
        times.push(state.t);
        positions.extend(state.x.iter().flat_map(|x| [x.x, x.y, x.z]));
    };
    keep(simulation.moving());
    let is_driven = judge.is_driven();
    let mut team =
        Team::new(*threads, spec.particles.mass_kg.len()).map_err(|fault| Violation {
            path: "threads".to_owned(),
            value: threads.to_string(),
            expected: format!("fewer threads: the system refuses so many ({fault})"),
        })?;
    let look = |moment: &Moment<'_>| {
        signals.look();
        judge.look(moment);
        if moment.step.is_multiple_of(every) || moment.step == steps {
            keep(moment.moving());
        }
    };
    let outcome = team.run(|| {
        simulation.simulate(time, |runner| {
            let runner = runner.series().stop_at(&INTERRUPT).observe(look);
            if is_driven { runner.ledger() } else { runner }
        })
    })?;
    let gain = judge.gain(&simulation, choice, &outcome);
    let verdict = team.run(|| judge.verdict(&simulation, &outcome, gain.as_ref()));
    let record = Record::of(spec, choice, time, (&outcome, verdict), &simulation.state());
    warnings.extend(gain.and_then(Rise::warning));
    Ok(Done { record, warnings, times, positions })
}

fn told(py: Python<'_>, Done { record, warnings, times, positions }: Done) -> PyResult<Run> {
    let json = serde_json::to_string_pretty(&record)
        .map_err(|fault| error::Error::new_err(fault.to_string()))?;
    let particles = record.final_state.position_m.len();
    let shape = (times.len(), particles, 3);
    let positions = Array3::from_shape_vec(shape, positions).unwrap_or_default();
    let series = &record.series;
    let names = series.first().into_iter().flat_map(|sample| sample.energy_j.keys());
    let energy = |name: &String| {
        let of = |sample: &drape_harness::record::Sample| sample.energy_j.get(name).copied();
        let values: Vec<f64> = series.iter().map(|s| of(s).unwrap_or(f64::NAN)).collect();
        (name.clone(), values.into_pyarray(py).unbind())
    };
    let totals = record.totals;
    let counts = [
        ("cg_iterations", totals.cg_iterations),
        ("outer_passes", totals.outer_passes),
        ("newton_iterations", totals.newton_iterations),
        ("factorisations", totals.factorisations),
        ("setups", totals.setups),
        ("matvecs", totals.matvecs),
        ("force_evaluations", totals.force_evaluations),
    ];
    Ok(Run {
        ending: match record.ending {
            Ending::Completed { .. } => "completed",
            Ending::Interrupted { .. } => "interrupted",
            Ending::Diverged { .. } => "diverged",
        },
        verdict: record.verdict.kind.to_string(),
        share: record.verdict.share,
        expected_share: record.verdict.expected_share,
        spin_share: record.verdict.spin_share,
        counts: counts.into(),
        seconds: totals.seconds,
        velocities: rows(py, record.final_state.velocity_m_s.iter().copied()).unbind(),
        energy_times: series.iter().map(|s| s.time_s).collect::<Vec<_>>().into_pyarray(py).into(),
        energies: names.map(energy).collect(),
        momenta: rows(py, series.iter().map(|s| s.momentum)).unbind(),
        angular_momenta: rows(py, series.iter().map(|s| s.angular_momentum)).unbind(),
        scene: record.scene,
        method: record.method,
        settings: record.settings,
        dt: record.dt_s,
        steps: record.steps,
        reason: record.verdict.reason,
        warnings,
        times: times.into_pyarray(py).unbind(),
        positions: positions.into_pyarray(py).unbind(),
        json,
    })
}

/// Runs a scene with a method, as `drape run` does.
#[pyfunction]
#[pyo3(signature = (scene, method, *, dt = None, duration = None, settings = None, threads = 1,
                    every = None))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn run(
    py: Python<'_>,
    scene: &Scene,
    method: &str,
    dt: Option<f64>,
    duration: Option<f64>,
    settings: Option<BTreeMap<String, Bound<'_, PyAny>>>,
    threads: u16,
    every: Option<u64>,
) -> PyResult<Run> {
    let refused = |fault: HarnessError| error::of(fault, &scene.source);
    let written = |(key, value): (String, Bound<'_, PyAny>)| Ok(format!("{key}={}", value.str()?));
    let settings = settings.unwrap_or_default().into_iter().map(written);
    let settings = settings.collect::<PyResult<Vec<String>>>()?;
    let choice = Choice::parse(method, &settings).map_err(|fault| refused(fault.into()))?;
    let refuse = |path: &str, value: String, expected: &str| {
        let (path, expected) = (path.to_owned(), expected.to_owned());
        refused(Violation { path, value, expected }.into())
    };
    if every == Some(0) {
        return Err(refuse("every", "0".to_owned(), "a number of steps from 1 on"));
    }
    let threads = match NonZero::new(usize::from(threads)) {
        Some(threads) if threads.get() <= 1024 => threads,
        _ => return Err(refuse("threads", threads.to_string(), "a number from 1 to 1024")),
    };
    let asked = Asked { scene, choice, dt, duration, threads, every };
    let signals = Signals::new(&INTERRUPT);
    let done = py.detach(|| simulate(&asked, &signals));
    signals.end()?;
    told(py, done.map_err(refused)?)
}
