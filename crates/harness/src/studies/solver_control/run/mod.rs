//! Experiment `solver-control`: measurements of what the paper names as further work.

mod runs;
#[cfg(test)]
mod tests;

use crate::facts::{Fact, fact};
use crate::methods::Choice;
use crate::record::Totals;
use crate::run::{Runner, Simulation};
use crate::schedule::Schedule;
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::studies::solver_control::facts::{Facts, History, Run, Scene, TimingRow};
use crate::studies::{Context, Measured, Start, cells, finite, prepared, timed};
use crate::{HarnessError, system_hash};
use drape_model::{DampingLaw, State, SystemSpec, TimeSpan};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::order::position_error;
use drape_oracle::reference::{Reference, reference};
use drape_report::Verdict;
use drape_report::number::median_s;
use runs::{Cell, all};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Particles along each edge of the sheet.
const SIDE: u32 = 20;
/// Simulated time, s. Errors are taken at its end.
const SPAN: f64 = 0.25;
/// Tolerance of the reference. Its error is far below those of the methods.
const REFERENCE_TOLERANCE: f64 = 1e-10;
/// Factor by which the vibrating sheet is stretched at the start.
const STRETCH: f64 = 1.02;
/// Largest effort of a run, in visits of a spring: some 10 s.
const BUDGET: f64 = 2e9;
/// Costs of operations, in sweeps over the springs of this sheet: rounded from times on one
/// machine.
const PRODUCT: u64 = 2;
/// Cost of a product with the 3×3 blocks of Newton's matrix.
const BLOCK_PRODUCT: u64 = 6;
const SET_UP: u64 = 30;
const FACTORISATION: u64 = 1000;
const FACTOR_SOLVE: u64 = 18;
/// Number of timed repetitions.
const REPETITIONS: usize = 3;

/// A scene, before its system is built.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Case {
    id: &'static str,
    stiffness: f64,
    damping: f64,
    is_stretched: bool,
}

const CASES: [Case; 4] = [
    Case { id: "hanging-1e4", stiffness: 1e4, damping: 40.0, is_stretched: false },
    Case { id: "hanging-1e6", stiffness: 1e6, damping: 40.0, is_stretched: false },
    Case { id: "hanging-1e8", stiffness: 1e8, damping: 40.0, is_stretched: false },
    Case { id: "vibrating-1e4", stiffness: 1e4, damping: 2.0, is_stretched: true },
];

/// A scene with its reference solution.
struct Setting {
    case: Case,
    simulation: Simulation,
    exact: Reference,
    hash: String,
}

impl Case {
    fn spec(&self) -> Result<SystemSpec, HarnessError> {
        let sheet = Sheet {
            side: SIDE,
            tension: self.stiffness,
            shear: 0.1 * self.stiffness,
            damping: self.damping,
            law: DampingLaw::Full,
            gravity: GRAVITY,
            is_pinned: true,
        };
        let mut spec = sheet.spec()?;
        if self.is_stretched {
            for position in spec.particles.position_m.iter_mut().flatten() {
                *position *= STRETCH;
            }
        }
        Ok(spec)
    }
}

impl Setting {
    fn new(case: &Case) -> Result<Self, HarnessError> {
        let spec = case.spec()?;
        let (system, state) = spec.build()?;
        let settings =
            AdaptiveSettings { tolerance: REFERENCE_TOLERANCE, ..AdaptiveSettings::default() };
        let exact = reference(&system, &state, &[SPAN], settings)?;
        let hash = system_hash(&spec);
        Ok(Self { case: *case, simulation: Simulation { system, state }, exact, hash })
    }

    fn scene(&self) -> Scene {
        Scene {
            id: self.case.id.to_owned(),
            stiffness_over_mass_per_s2: self.case.stiffness,
            damping_over_mass_per_s: self.case.damping,
            span_s: SPAN,
            reference_error_m: self.exact.position_error,
            portable: false,
        }
    }

    fn error(&self, state: &State) -> Option<f64> {
        let Simulation { system, state: start } = &self.simulation;
        let end = self.exact.states.last()?;
        let error = position_error(system, &start.x, &end.x, &state.x);
        Some(error).filter(|error| error.is_finite())
    }
}

/// The work of a run, in sweeps over the springs.
fn work(choice: &Choice, totals: &Totals) -> u64 {
    let settings = choice.settings();
    let is = |key: &str, value: &str| settings.iter().any(|pair| pair == (key, value));
    let Totals { cg_iterations, newton_iterations, .. } = *totals;
    let has_blocks = settings.iter().any(|(key, _)| key == "jacobian");
    // Newton's systems are solved directly or by CG, which a saved factor may precondition.
    // Multigrid cycles count as products.
    let solves = match (is("solver", "cg"), is("jacobian", "saved")) {
        (true, true) => FACTOR_SOLVE * cg_iterations,
        (true, false) => 0,
        (false, _) if is("solver", "multigrid") => 0,
        (false, false) if has_blocks && is("solver", "auto") => 0,
        (false, _) => FACTOR_SOLVE * newton_iterations,
    };
    let product = if has_blocks { BLOCK_PRODUCT } else { PRODUCT };
    totals.force_evaluations
        + product * totals.matvecs
        + SET_UP * totals.setups
        + FACTORISATION * totals.factorisations
        + solves
}

/// The result of a run: a row, and the size of its substeps over time.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Course {
    run: Run,
    time_s: Vec<f64>,
    step_s: Vec<f64>,
}

fn measure(setting: &Setting, cell: &Cell) -> Result<Course, HarnessError> {
    let choice = Choice::parse(&cell.method, &[])?;
    let mut simulation = setting.simulation.clone();
    let start = simulation.system.total_energy(&simulation.state);
    let (mut gain, mut time_s, mut step_s) = (0.0_f64, Vec::new(), Vec::new());
    let schedule = Schedule::steady(TimeSpan { step_s: cell.step_s, duration_s: SPAN });
    let runner = Runner::by(&choice, &schedule).budget(BUDGET).observe(|moment| {
        let energy = moment.system.total_energy(moment.state);
        gain = gain.max(if energy.is_nan() { f64::INFINITY } else { energy - start });
        time_s.push(schedule.elapsed(moment.step));
        step_s.push(moment.h / f64::from(moment.report.substeps.max(1)));
    });
    let outcome = runner.go(&mut simulation)?;
    let verdict = match (&outcome.divergence, outcome.is_over_budget) {
        (Some(_), _) => Verdict::Diverged,
        (None, true) => Verdict::OverBudget,
        (None, false) => Verdict::Completed,
    };
    let is_done = verdict == Verdict::Completed;
    let totals = outcome.totals;
    let run = Run {
        series: cell.series.to_owned(),
        scene: setting.case.id.to_owned(),
        label: cell.label.to_owned(),
        is_adaptive: cell.is_adaptive,
        value: cell.value,
        method: choice.full_id(),
        step_s: cell.step_s,
        error: setting.error(&simulation.state).filter(|_| is_done),
        energy_gain_j: finite(gain),
        substeps: outcome.substeps,
        rejected: outcome.rejected,
        setups: totals.setups,
        factorisations: totals.factorisations,
        newton_iterations: totals.newton_iterations,
        outer_passes: totals.outer_passes,
        cg_iterations: totals.cg_iterations,
        matvecs: totals.matvecs,
        force_evaluations: totals.force_evaluations,
        work_sweeps: work(&choice, &totals),
        unconverged_steps: outcome.unconverged,
        verdict,
        // The reference calls a library's functions.
        portable: false,
    };
    Ok(Course { run, time_s, step_s })
}

fn time(setting: &Setting, cell: &Cell) -> Result<TimingRow, HarnessError> {
    let choice = Choice::parse(&cell.method, &[])?;
    let time = TimeSpan { step_s: cell.step_s, duration_s: SPAN };
    let mut samples_ns = Vec::new();
    for _ in 0..REPETITIONS {
        let runner = Runner::new(&choice, time).budget(BUDGET);
        let outcome = runner.go(&mut setting.simulation.clone())?;
        samples_ns.push(outcome.wall.as_nanos() as u64);
    }
    Ok(TimingRow {
        series: cell.series.to_owned(),
        scene: setting.case.id.to_owned(),
        label: cell.label.to_owned(),
        is_adaptive: cell.is_adaptive,
        value: cell.value,
        median_s: median_s(&samples_ns),
        samples_ns,
    })
}

/// How the timings are taken.
pub(super) fn timing() -> String {
    format!(
        "One run at a time on one thread of an otherwise idle process, {REPETITIONS} repetitions; \
         all steps of {SPAN} s together, without the first \
         set-up."
    )
}

/// How the facts are measured.
pub(super) fn method() -> String {
    "A sheet of 20 × 20 particles, 1 m × 1 m, 1 g each, falls from the horizontal for 0.25 s with \
     two corners pinned and d/m = 40 s⁻¹; shear springs have a tenth of the stiffness. In the \
     vibrating scene it starts stretched by 2 % with d/m = 2 s⁻¹. The error is the mass-weighted \
     distance between the final positions and those of DOP853 at tolerance 1e-10, over the \
     distance that the sheet has moved. A run at tolerance 1e-9 measures the error of the \
     reference. Runs for forcing terms and Jacobians take h = 0.01 s, and Newton's method \
     converges to a residual of 1e-9 of the change of velocity. imex-updated runs in its \
     safeguarded form to its default tolerance, without the switch to Newton's method. Adaptive \
     runs divide frames of 0.01 s by their tolerance, a local error of positions in mesh widths; \
     constant runs take the given step. Work is counted in sweeps over the springs, with these \
     weights: 2 for a product with the scalar matrix, 6 for a product with Newton's 3 × 3 blocks, \
     30 for a set-up of the scalar matrix, 1000 for a factorisation of Newton's matrix, and 18 \
     for a solve with its factor."
        .to_owned()
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    CASES.map(|case| Start::new(case.id, move || case.spec())).into()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let chosen: Vec<_> =
        CASES.into_iter().filter(|case| !context.quick || case.id == runs::QUICK_SCENE).collect();
    let settings = prepared(context, "references", &chosen, Setting::new)?;
    let listed: Vec<_> = settings
        .iter()
        .flat_map(|setting| all(&setting.case).into_iter().map(move |cell| (setting, cell)))
        .filter(|(_, cell)| !context.quick || cell.is_quick)
        .collect();
    let measured =
        cells(context, "runs", &listed, |(setting, cell)| measure(setting, cell))?.all()?;
    let histories = measured.iter().filter(|m| runs::has_history(&m.run)).map(|m| History {
        scene: m.run.scene.clone(),
        label: m.run.label.clone(),
        tolerance: m.run.value.unwrap_or_default(),
        time_s: m.time_s.clone(),
        step_s: m.step_s.clone(),
    });
    let facts = Facts {
        scenes: settings.iter().map(Setting::scene).collect(),
        histories: histories.collect(),
        runs: measured.iter().map(|m| m.run.clone()).collect(),
    };
    let hashes: BTreeMap<_, _> =
        settings.iter().map(|s| (s.case.id.to_owned(), s.hash.clone())).collect();
    let mut timings = None;
    if !context.quick {
        let listed: Vec<_> = listed.iter().filter(|(_, cell)| cell.is_timed).collect();
        timings =
            Some(timed(context, "timings", &listed, |(setting, cell)| time(setting, cell))?.all()?);
    }
    Ok(Measured { facts, timings, scenes: hashes, seed: None })
}

/// The study's facts in the form in which two records are compared. Step sizes over time are left
/// out, since they follow from decisions that may turn on the last digits.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let scenes = facts.scenes.iter();
    let scenes = scenes.map(|scene| fact(format!("scene {}", scene.id), scene.portable, scene));
    let runs = facts.runs.iter().map(|run| {
        let value = run.value.map_or_else(String::new, |value| format!(" {value}"));
        let adaptive = if run.is_adaptive { " adaptive" } else { "" };
        let key = format!("{} {} {}{adaptive}{value}", run.series, run.scene, run.label);
        fact(key, run.portable, run)
    });
    scenes.chain(runs).collect()
}
